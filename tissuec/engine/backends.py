"""Backends: the loop over steps as compiled code that is shipped, or interpreted.

Methods that are not shipped, such as those of users, are interpreted. Operations on nets are
compiled for both: an interpreted loop calls them by their addresses. A further backend, as an
experiment has it, is an entry of ``BACKENDS``: a loop, and operations in Python.
"""

import ctypes
from collections.abc import Callable, Mapping
from functools import cache
from types import MappingProxyType
from typing import Any

from msgspec import Struct

from tissuec.compiled.binding import Binder
from tissuec.compiled.record_tables import RecordTable
from tissuec.engine import step, step_inside
from tissuec.engine.integrators import Integrator
from tissuec.engine.operations import OPERATIONS, Features, operations
from tissuec.kernels.records import Net, Operations, Progress, Task


class Inside(Struct, frozen=True):
    """Evaluates states inside an accepted step; takes arrays of run and net as tables."""

    look: Callable[..., None]
    prepare: Callable[..., None]


#: Steps in place, and returns why it stopped.
Drive = Callable[[Progress, Task, Any, Any, Any], int]


@cache
def bound_drive(integrator: type[Integrator], backend: str) -> Drive:
    """Return the loop over steps of an integrator, of a member of ``BACKENDS``."""
    return BACKENDS[backend].drive(integrator)


def _compiled_drive(integrator: type[Integrator]) -> Drive:
    """Return the shipped loop over steps."""
    from tissuec.compiled.bundles import of_method
    from tissuec.compiled.loading import address

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
    bound = interpreter(integrator).bind(step.drive)

    def drive(now: Progress, task: Task, work: Any, net: Any, buffer: Any) -> int:
        # Records that are passed on, as tables: they are not made anew for each call.
        work = work._replace(solver=RecordTable(work.solver), team=RecordTable(work.team))
        return int(bound(now, task, RecordTable(work), net, RecordTable(buffer)))

    return drive


class LoopBackend(Struct, frozen=True):
    """How the loop over steps runs, and what it calls.

    Attributes:
        drive: Returns the loop of an integrator. It takes the net as a table.
        takes_tables: Whether it takes the other records as tables, too.
        operations: Functions in Python that replace compiled operations, by name; see
            ``with_python``.
    """

    drive: Callable[[type[Integrator]], Drive]
    takes_tables: bool
    operations: Mapping[str, Callable[..., Any]] = MappingProxyType({})


BACKENDS = {
    "compiled": LoopBackend(_compiled_drive, takes_tables=True),
    "interpreted": LoopBackend(_interpreted_drive, takes_tables=False),
}


def with_python(
    net: Net, replaced: Mapping[str, Callable[..., Any]], *others: Any
) -> RecordTable:
    """Return the table of a net, with Python functions in place of some operations.

    Args:
        net: With the addresses of all operations.
        replaced: Functions by the names of the operations that they replace. They take the same
            arguments, arrays and numbers as they are, and records.
        others: The records that they take besides the net.
    """
    records = net, *others
    called = {
        name: OPERATIONS[name].by(function, *records) for name, function in replaced.items()
    }
    addresses = {name: each.address for name, each in called.items()}
    table = RecordTable(net._replace(operations=net.operations._replace(**addresses)))
    table.called = tuple(called.values())
    return table


@cache
def interpreter(integrator: type[Integrator]) -> Binder:
    """Return a binder of the stepping code of an integrator, which then runs as Python."""
    return Binder(names_in_python(integrator))


def names_in_python(integrator: type[Integrator]) -> dict[str, Any]:
    """Return the meanings of names in stepping code that runs as Python."""
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
    """Return the interpolation within steps of an integrator."""
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


def default_backend(integrator: type[Integrator]) -> str:
    """Return the backend of an integrator: compiled, unless it is not shipped with tissuec."""
    from tissuec.compiled.bundles import of_method
    from tissuec.compiled.loading import is_shipped

    return "compiled" if is_shipped(of_method(integrator)) else "interpreted"
