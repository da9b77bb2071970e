"""The two backends: the loop over steps as compiled code that is shipped, or interpreted.

Methods that are not shipped, such as those of users, are interpreted. Operations on nets are
compiled for both: an interpreted loop calls them by their addresses.
"""

import ctypes
from collections.abc import Callable
from functools import cache
from typing import Any

from msgspec import Struct

from tissuec.compiled.binding import Binder
from tissuec.engine import step, step_inside
from tissuec.engine.integrators import Integrator
from tissuec.engine.method import Backend
from tissuec.engine.operations import OPERATIONS, Features, operations
from tissuec.kernels.records import Operations, Progress, Task


class Inside(Struct, frozen=True):
    """Evaluates states inside an accepted step; takes arrays of run and net as tables."""

    look: Callable[..., None]
    prepare: Callable[..., None]


#: Steps in place, and returns why it came back.
Drive = Callable[[Progress, Task, Any, Any, Any], int]


@cache
def bound_drive(integrator: type[Integrator], backend: Backend) -> Drive:
    """Return the loop over steps of an integrator.

    It takes the net as a table; if it is compiled, all records.
    """
    return (_compiled_drive if backend == "compiled" else _interpreted_drive)(integrator)


def _compiled_drive(integrator: type[Integrator]) -> Drive:
    """Return the shipped loop over steps."""
    from tissuec.compiled.bundles import of_method
    from tissuec.compiled.loading import address
    from tissuec.compiled.record_tables import RecordTable

    function = ctypes.CFUNCTYPE(ctypes.c_int64, *(ctypes.c_void_p for _ in range(5)))
    enter = function(address(of_method(integrator), "drive"))

    def drive(now: Progress, task: Task, work: Any, net: Any, buffer: Any) -> int:
        table = RecordTable(now)
        tables = table, RecordTable(task), work, net, buffer
        reason = int(enter(*(each.address for each in tables)))
        table.read_back()
        return reason

    return drive


def _interpreted_drive(integrator: type[Integrator]) -> Drive:
    """Return the loop over steps as Python."""
    from tissuec.compiled.record_tables import RecordTable

    bound = interpreter(integrator).bind(step.drive)

    def drive(now: Progress, task: Task, work: Any, net: Any, buffer: Any) -> int:
        # Records that are passed on, as tables: they are not made anew for each call.
        work = work._replace(solver=RecordTable(work.solver), team=RecordTable(work.team))
        return int(bound(now, task, RecordTable(work), net, RecordTable(buffer)))

    return drive


@cache
def interpreter(integrator: type[Integrator]) -> Binder:
    """Return what binds the stepping code of an integrator, to run as Python."""
    return Binder(names_in_python(integrator))


def names_in_python(integrator: type[Integrator]) -> dict[str, Any]:
    """Return what names in stepping code mean where it runs as Python."""
    from tissuec.compiled.calls import VECTORS

    return method_names(integrator) | VECTORS | OPERATIONS


def operations_of(integrator: type[Integrator]) -> frozenset[str]:
    """Return the operations on nets that the loop over steps of an integrator calls."""
    return interpreter(integrator).names(step.drive) & set(Operations._fields)


@cache
def loop_operations(integrator: type[Integrator], features: Features) -> Operations:
    """Return where the compiled operations are that the loop calls for a net."""
    from tissuec.compiled.bundles import of_method
    from tissuec.compiled.loading import called_by, is_shipped

    bundle = of_method(integrator)
    names = called_by(bundle) if is_shipped(bundle) else operations_of(integrator)
    return operations(names, features)


@cache
def bound_inside(integrator: type[Integrator]) -> Inside:
    """Return what looks into the steps of an integrator."""
    from tissuec.compiled.bundles import of_method
    from tissuec.compiled.calls import Shipped
    from tissuec.compiled.loading import is_shipped

    bundle = of_method(integrator)
    if is_shipped(bundle):
        return Inside(Shipped(step_inside.look, bundle), Shipped(integrator.prepare, bundle))
    bind = interpreter(integrator).bind
    return Inside(bind(step_inside.look), bind(integrator.prepare))


def method_names(integrator: type[Integrator]) -> dict[str, Any]:
    """Return the bindings of names in the stepping code for an integrator."""
    functions = ("step", "estimate", "book", "finish", "prepare", "propose")
    numbers = ("looks", "control_order", "safety", "implicit")
    replaced = {name: getattr(integrator, name) for name in functions}
    replaced |= {name.upper(): getattr(integrator, name) for name in numbers}
    return replaced | {"REFINES": len(integrator.embedded_x) > 0}


def default_backend(integrator: type[Integrator]) -> Backend:
    """Return the backend of an integrator: compiled, unless it is not shipped with tissuec."""
    from tissuec.compiled.bundles import of_method
    from tissuec.compiled.loading import is_shipped

    return "compiled" if is_shipped(of_method(integrator)) else "interpreted"
