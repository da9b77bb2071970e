"""Kernels in LLVM's intermediate representation, free of Numba and of this processor."""

import json
import lzma
import re
from collections.abc import Callable, Collection, Iterator
from functools import partial
from importlib import import_module
from inspect import isfunction, signature
from pathlib import Path
from pkgutil import iter_modules
from types import FunctionType, ModuleType
from typing import Any, NamedTuple

import llvmlite.binding as llvm
from numba import njit
from numba.core.typing.templates import Signature

from tissuec import forces
from tissuec.engine import step, step_inside
from tissuec.engine.backends import method_names, operations_of
from tissuec.engine.binding import Binder
from tissuec.engine.codegen.numba_types import (
    NET,
    NOTHING,
    NUMBER,
    PARTIALS,
    SIGNATURES,
    RecordType,
    as_compiled,
    caller,
    field_caller,
    partial_caller,
)
from tissuec.engine.codegen.sources import digest_of_sources
from tissuec.engine.codegen.thread_loops import CALLED_BY_THREADS, TEAM, share
from tissuec.engine.integrators import INTEGRATORS, banded, iterative
from tissuec.engine.operations import FUNCTIONS, LAWS
from tissuec.engine.rate import Unknowns, rate
from tissuec.forces import pairs_kernel, runs_kernel
from tissuec.forces.runs_kernel import springs_in_runs
from tissuec.kernels import rasterizing, sensitivity, spring_geometry, stages, stepping, vectors
from tissuec.kernels.bundles import BUNDLES, FLAGS, of_field, of_method
from tissuec.kernels.loading import CALLED, ENDING, INDEX, LEFT_ALONE, SHIPPED
from tissuec.kernels.records import Operations

#: Arguments that share no memory with others, by function.
UNSHARED = runs_kernel.UNSHARED | pairs_kernel.UNSHARED
#: First arguments of the loops of fields: forces, and derivatives backwards and forwards.
OF_LOOPS = (
    ("time", "x", "v", "f", "power"),
    ("time", "x", "v", "weight", "by_x", "by_v", "by"),
    ("time", "x", "v", "dx", "dv", "dn", "df", "room"),
)
# Attributes and marks of lifetimes change from one version of LLVM to the next; they are found
# out again.
_LEFT_OUT = re.compile(
    r"^attributes #\d+ = .*\n|^; .*\n|^target .*\n|^source_filename.*\n"
    r"|^.*@llvm\.lifetime\.(?:start|end)\..*\n",
    re.MULTILINE,
)
_OF_CALLS = re.compile(r" #\d+(?=[ ,\n])| captures\([^)]*\)| nocreateundeforpoison")
_DECLARED = re.compile(r"^declare (?:noalias )?(\S+) @([\w.]+)\((.*?)\)", re.MULTILINE)
_OF_PYTHON = ("Py", "numba_")
#: Loops over nodes and springs, which are called rather than copied to where they are called:
#: each copy takes 10 ms to be translated.
LOOP = "loop"
_LOOPS = re.compile(
    r"\d(?:accelerate|accumulate|add_rows|add_to_upper|any_above|add_drag|between|blended|clear|"
    r"combine_part|copy_sample|correct_part|distance_part|drift_part|greatest|length_part|"
    r"polynomials|pull_springs|put_together|quadrature|scale|subtract|take_apart|write_lengths)B"
)
_CALLED_LOOPS = re.compile(rf"^(define .*@{LOOP}_\d+\(.*\).*) {{$", re.MULTILINE)
_OTHERS = re.compile(rf"^(define (?!.*@{LOOP}_\d+\().*\).*) {{$", re.MULTILINE)
#: Bundles with functions of these names: of them, only such loops are optimised again where
#: they are loaded, for vector instructions. That takes half of the time.
OPTIMISED = ("drive", "force", "springs_in_runs")
#: Bundles with functions whose names begin with these are not optimised again at all: vectors
#: of two numbers, which any processor has, are all that their scalar loops gain from. Loading
#: them takes a third of the time.
FINISHED = ("springs_viscous_watched_of_laws", "fold", "press", "touch")
# As intrinsic functions they set no error number, and can be done eight at a time.
MATHEMATICS = ("ceil", "cos", "exp", "floor", "log", "pow", "sin", "sqrt")
_CALLS = re.compile(rf"@({'|'.join(MATHEMATICS)})\(")


class Exported(NamedTuple):
    """A function of a bundle."""

    name: str
    function: Callable[..., Any]
    signature: Signature
    replaced: dict[str, Any]


def bundles() -> dict[str, list[Exported]]:
    """Return the functions of every bundle."""
    found = {
        name: [OTHERS.get(name, _operation)(each) for each in names]
        for name, names in BUNDLES.items()
    }
    for integrator in INTEGRATORS.values():
        names = method_names(integrator) | {name: caller(name) for name in Operations._fields}
        found[of_method(integrator)] = [
            Exported(function.__name__, function, as_compiled(function), names)
            for function in (step.drive, step_inside.look, integrator.prepare)
        ]
    for kernel in _loops_of_fields():
        exported = Exported(kernel.__name__, kernel, as_compiled(kernel), {})
        found.setdefault(of_field(kernel), []).append(exported)
    return found


def _loops_of_fields() -> Iterator[Callable[..., Any]]:
    """Yield the loops of ``tissuec.forces``, which their arguments tell from others."""
    for module in iter_modules(forces.__path__):
        members = vars(import_module(f"{forces.__name__}.{module.name}")).values()
        for member in filter(isfunction, members):
            arguments = tuple(signature(member).parameters)
            if any(
                arguments[: len(own)] == own for own in OF_LOOPS
            ) and member.__module__.endswith(f".{module.name}"):
                yield member


def _derivative(name: str) -> Exported:
    """Return a function for learning."""
    function = vars(sensitivity).get(name) or vars(stepping)[name]
    called = {each: partial_caller(each) for each in PARTIALS} | {
        "call_force": field_caller(),
        "call_pull_back": field_caller(6),
        "call_push_forward": field_caller(7),
    }
    return Exported(name, function, as_compiled(function), called)


def _member_of(module: ModuleType) -> Callable[[str], Exported]:
    """Return what finds a function of a module by its name."""

    def found(name: str) -> Exported:
        function = vars(module)[name]
        return Exported(name, function, as_compiled(function), {})

    return found


#: Bundles of what is no operation on nets.
OTHERS = {
    "derivatives": _derivative,
    "raster": _member_of(rasterizing),
    "spring_geometry": _member_of(spring_geometry),
    "stages": _member_of(stages),
    "vectors": _member_of(vectors),
}


def _operation(name: str) -> Exported:
    """Return an operation on nets; it calls forces and laws of the net."""
    if name == "rate":
        called = {each: caller(each) for each in ("force", "place")}
        return Exported(name, rate, NOTHING(NUMBER, RecordType(Unknowns), NET), called)
    kind, _, form = name.partition("_")
    replaced = {each: caller(each) for each in ("springs", *LAWS)}
    replaced["add_field"] = field_caller()
    if kind in ("assemble", "solve"):
        function = getattr(banded if form == "banded" else iterative, kind)
    elif kind == "springs":
        function = springs_in_runs if form.startswith("in_runs") else FUNCTIONS[kind]
        replaced |= {flag: flag.lower() in form for flag in FLAGS}
    else:
        function, kind = FUNCTIONS[name], name
    return Exported(name, function, SIGNATURES[kind], replaced)


def translated(parts: list[Exported]) -> str:
    """Return the text of a bundle."""
    whole = llvm.parse_assembly("")
    binders: dict[int, Binder] = {}  # parts that replace the same names share what they call
    for part in parts:
        names = {"share": share} | part.replaced
        binder = binders.setdefault(id(part.replaced), Binder(names, _compiled))
        made = _compiled(binder.bind(part.function), no_cfunc_wrapper=False)
        made.compile(part.signature)
        found = made.overloads[tuple(part.signature.args)]
        module = llvm.parse_assembly(_restricted(found.library.get_llvm_str()))
        module.get_function(found.fndesc.llvm_cfunc_wrapper_name).name = part.name
        whole.link_in(module)
    return _finished(whole, {part.name for part in parts})


def _finished(whole: Any, exported: Collection[str]) -> str:
    """Return the text of a module, with all that it calls."""
    whole.link_in(llvm.parse_assembly(TEAM))
    whole.link_in(llvm.parse_assembly(_stubs(str(whole))))
    finished = any(name.startswith(FINISHED) for name in exported)
    _simplify(whole, exported, vectors=finished)
    text = str(whole)
    for name in MATHEMATICS:
        if f"@llvm.{name}.f64(" in text:  # LLVM has done the same somewhere
            text = re.sub(rf"^declare .*@{name}\(.*\n", "", text, flags=re.MULTILINE)
    text = _OF_CALLS.sub("", _LEFT_OUT.sub("", _CALLS.sub(r"@llvm.\1.f64(", text)))
    if finished or any(name.startswith(OPTIMISED) for name in exported):
        text = _OTHERS.sub(rf"\1 noinline {LEFT_ALONE} {{", text)
    return _CALLED_LOOPS.sub(r"\1 noinline {", text)


def _compiled(function: FunctionType, **options: bool) -> Any:
    """Return a function as Numba compiles it when it is needed."""
    # Only contraction of a b + c: anything more would break the tests for NaN. Kernels allocate
    # nothing, so they need no counting of references.
    return njit(
        error_model="numpy",
        fastmath={"contract"},
        _nrt=False,
        no_cpython_wrapper=True,
        **{"no_cfunc_wrapper": True} | options,
    )(function)


def _restricted(text: str) -> str:
    """Return a module that says which arguments share no memory with others."""

    def marked(head: re.Match[str]) -> str:
        names = UNSHARED[head[1]]
        attributes = r"(?: \w+(?:\(\w+\))?)*"
        where = rf"(\w+\*|ptr)(?={attributes} %\"?arg\.(?:{'|'.join(names)})\.4\"?[,)])"
        whole, count = re.subn(where, r"\1 noalias", head[0])
        assert count == len(names), f"arguments of {head[1]} are not where they were"
        return whole

    return re.sub(rf"^define .*?\d({'|'.join(UNSHARED)})B.*$", marked, text, flags=re.MULTILINE)


def _stubs(text: str) -> str:
    """Return functions of Python in a form that ends the process.

    Numba calls them where an index of a tuple is wrong, for example, which cannot be here.

    Raises:
        LookupError: Another function is called that is not known when code is loaded.
    """
    stubs = ["declare void @llvm.trap()"]
    for result, name, arguments in _DECLARED.findall(text):
        if name.startswith(_OF_PYTHON):
            kinds = ", ".join(part.split()[0] for part in arguments.split(", ") if part)
            body = "{ call void @llvm.trap() unreachable }"
            stubs.append(f"define {result} @{name}({kinds}) {body}")
        elif not name.startswith("llvm.") and name not in (*MATHEMATICS, *CALLED):
            raise LookupError(f"{name} is called, which compiled.loading has not")
    return "\n".join(stubs)


def _simplify(module: Any, exported: Collection[str], *, vectors: bool) -> None:
    """Leave out what nothing calls, and give the rest short names.

    Args:
        module: A bundle.
        exported: Functions that are called from outside.
        vectors: Whether neighbouring operations become vector instructions.
    """
    defined = [each for each in module.functions if not each.is_declaration]
    for each in (*defined, *(g for g in module.global_variables if not g.is_declaration)):
        each.linkage = "external" if each.name in exported else "internal"
    for number, each in enumerate(defined):
        if each.name not in exported:
            loops = _LOOPS.search(each.name) is not None
            each.name = f"{LOOP if loops else 'part'}_{number}"
            if loops:
                each.add_function_attribute("noinline")
    machine = llvm.Target.from_default_triple().create_target_machine(opt=1)
    options = llvm.create_pipeline_tuning_options(speed_level=1)
    options.loop_vectorization = options.loop_unrolling = False
    options.slp_vectorization = vectors
    builder = llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)


def export() -> Iterator[tuple[Path, int]]:
    """Write all bundles; yield their files and sizes."""
    SHIPPED.mkdir(exist_ok=True)
    wanted = {name: partial(translated, parts) for name, parts in bundles().items()}
    wanted["team"] = partial(_finished, llvm.parse_assembly(""), CALLED_BY_THREADS)
    for name, text in wanted.items():
        path = SHIPPED / f"{name}{ENDING}"
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
