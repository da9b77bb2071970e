"""The shipped bundles: the functions in each of them, and how they are written."""

import json
import lzma
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from importlib import import_module
from inspect import isfunction, signature
from pathlib import Path
from pkgutil import walk_packages
from types import ModuleType
from typing import Any

import llvmlite.binding as llvm
from numba.core.typing.templates import Signature

from tissuec import forces
from tissuec.compiled.bundles import BUNDLES, FLAGS, of_field, of_method
from tissuec.compiled.export import Exported, finished, translated
from tissuec.compiled.loading import ENDING, INDEX, SHIPPED
from tissuec.compiled.numba_types import (
    NET,
    NOTHING,
    NUMBER,
    OF_LAWS,
    RecordType,
    as_compiled,
    caller,
    field_caller,
)
from tissuec.compiled.sources import digest_of_sources
from tissuec.compiled.team import CALLED_BY_THREADS
from tissuec.engine import step, step_inside
from tissuec.engine.backends import method_names, operations_of
from tissuec.engine.integrators import INTEGRATORS, banded, derivatives_kernel, iterative
from tissuec.engine.operations import FUNCTIONS, LAWS
from tissuec.engine.rate import Unknowns, rate
from tissuec.forces import accelerations_derivatives_kernel
from tissuec.forces.springs import pairs_kernel, runs_kernel
from tissuec.forces.springs.runs_kernel import springs_in_runs
from tissuec.kernels import crossing, rasterizing, spring_geometry, stages, vectors
from tissuec.kernels.records import Operations

#: Arguments that share no memory with others, by function.
UNSHARED = runs_kernel.UNSHARED | pairs_kernel.UNSHARED
#: First arguments of the loops of fields; derivatives are not shipped.
OF_LOOP = ("time", "x", "v", "f", "power")
#: What has the functions for learning.
OF_DERIVATIVES = (
    accelerations_derivatives_kernel,
    derivatives_kernel,
)
#: The operations on a net, as C calls them; fields of ``records.Operations``.
SIGNATURES: dict[str, Signature] = OF_LAWS | {
    name: as_compiled(function) for name, function in FUNCTIONS.items()
}


def _called(name: str) -> Callable[..., Any]:
    """Compiled code that calls an operation of a net."""
    return caller(name, SIGNATURES[name])


def bundles() -> dict[str, list[Exported]]:
    """Return the functions of every bundle."""
    found = {
        name: [OTHERS.get(name, _operation)(each) for each in names]
        for name, names in BUNDLES.items()
    }
    for integrator in INTEGRATORS.values():
        names = method_names(integrator) | {name: _called(name) for name in Operations._fields}
        found[of_method(integrator)] = [
            Exported(function.__name__, function, as_compiled(function), names)
            for function in (step.drive, step_inside.look, integrator.prepare)
        ]
    for kernel in _loops_of_fields():
        exported = Exported(kernel.__name__, kernel, as_compiled(kernel), {})
        found.setdefault(of_field(kernel), []).append(exported)
    return found


def _loops_of_fields() -> Iterator[Callable[..., Any]]:
    """Yield the loops of ``tissuec.forces``, recognised by their first arguments."""
    for module in walk_packages(forces.__path__, f"{forces.__name__}."):
        members = vars(import_module(module.name)).values()
        for member in filter(isfunction, members):
            arguments = tuple(signature(member).parameters)
            if arguments[: len(OF_LOOP)] == OF_LOOP and member.__module__ == module.name:
                yield member


def _derivative(name: str) -> Exported:
    """Return a function for learning."""
    function = next(vars(module)[name] for module in OF_DERIVATIVES if name in vars(module))
    called = {
        "call_force": field_caller(),
        "call_pull_back": field_caller(6),
        "call_push_forward": field_caller(7),
    }
    return Exported(name, function, as_compiled(function), called)


def _member_of(module: ModuleType) -> Callable[[str], Exported]:
    """Return a function that finds the functions of a module by name."""

    def found(name: str) -> Exported:
        function = vars(module)[name]
        return Exported(name, function, as_compiled(function), {})

    return found


#: Bundles of what is no operation on nets.
OTHERS = {
    "crossing": _member_of(crossing),
    "derivatives": _derivative,
    "raster": _member_of(rasterizing),
    "spring_geometry": _member_of(spring_geometry),
    "stages": _member_of(stages),
    "vectors": _member_of(vectors),
}


def _operation(name: str) -> Exported:
    """Return an operation on nets; it calls forces and laws of the net."""
    if name == "rate":
        called = {each: _called(each) for each in ("force", "place")}
        return Exported(name, rate, NOTHING(NUMBER, RecordType(Unknowns), NET), called)
    kind, _, form = name.partition("_")
    replaced = {each: _called(each) for each in ("springs", *LAWS)}
    replaced["add_field"] = field_caller()
    if kind in ("assemble", "solve"):
        function = getattr(banded if form == "banded" else iterative, kind)
    elif kind == "springs":
        function = springs_in_runs if form.startswith("in_runs") else FUNCTIONS[kind]
        replaced |= {flag: flag.lower() in form for flag in FLAGS}
    else:
        function, kind = FUNCTIONS[name], name
    return Exported(name, function, SIGNATURES[kind], replaced)


def export(names: Sequence[str] = ()) -> Iterator[tuple[Path, int]]:
    """Write bundles; yield their files and sizes.

    Args:
        names: Of those whose code has changed; all, if none is given.
    """
    SHIPPED.mkdir(exist_ok=True)
    wanted = {name: partial(translated, parts, UNSHARED) for name, parts in bundles().items()}
    wanted["team"] = partial(finished, llvm.parse_assembly(""), CALLED_BY_THREADS)
    for name in names or wanted:
        path, text = SHIPPED / f"{name}{ENDING}", wanted[name]
        packed = lzma.compress(text().encode(), preset=9)
        path.write_bytes(packed)
        yield path, len(packed)
    for path in SHIPPED.glob(f"*{ENDING}"):
        if path.name.removesuffix(ENDING) not in wanted:
            path.unlink()
    calls = {
        of_method(integrator): sorted(operations_of(integrator))
        for integrator in INTEGRATORS.values()
    }
    index = {"sources": digest_of_sources(), "calls": calls}
    INDEX.write_text(json.dumps(index, indent=1) + "\n", encoding="utf-8")
