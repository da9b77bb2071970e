"""Functions in LLVM's intermediate representation, free of Numba and of this processor."""

import re
from collections.abc import Callable, Collection, Mapping
from types import FunctionType
from typing import Any, NamedTuple, TypeAlias

import llvmlite.binding as llvm
from numba import njit
from numba.core.typing.templates import Signature

from tissuec.compiled import mathematics
from tissuec.compiled.binding import Binder
from tissuec.compiled.fusing import fused
from tissuec.compiled.loading import CALLED, LEFT_ALONE
from tissuec.compiled.team import TEAM, share

#: Names of arguments, by the name of the function.
Unshared: TypeAlias = Mapping[str, tuple[str, ...]]
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
FINISHED = ("springs_viscous_watched_of_laws", "press", "touch")
# As intrinsic functions they set no error number, and can be done eight at a time. They are
# exact, so that all processors and libraries agree.
ROUNDING = ("ceil", "floor", "sqrt")
_CALLS = re.compile(rf"@({'|'.join(ROUNDING)})\(")
_OWN = rf"@(?:llvm\.)?({'|'.join(mathematics.FUNCTIONS)})(?:\.f64)?\("
_OWN_DECLARED = re.compile(rf"^declare .*{_OWN}.*\n", re.MULTILINE)
_OWN_CALLED = re.compile(_OWN)
#: Bundles with functions whose names begin with these fuse nothing: signs count in them, and a
#: difference of equal products is zero only if both are rounded.
UNFUSED = ("find_crossings",)


class Exported(NamedTuple):
    """A function of a bundle."""

    name: str
    function: Callable[..., Any]
    signature: Signature
    replaced: dict[str, Any]


def translated(parts: list[Exported], unshared: Unshared) -> str:
    """Return the text of a bundle.

    Args:
        parts: Its functions.
        unshared: Arguments that share no memory with others.
    """
    whole = llvm.parse_assembly("")
    binders: dict[int, Binder] = {}  # parts that replace the same names share what they call
    for part in parts:
        names = {"share": share} | part.replaced
        binder = binders.setdefault(id(part.replaced), Binder(names, _compiled))
        made = _compiled(binder.bind(part.function), no_cfunc_wrapper=False)
        made.compile(part.signature)
        found = made.overloads[tuple(part.signature.args)]
        text = _OWN_DECLARED.sub("", _restricted(found.library.get_llvm_str(), unshared))
        text = _OWN_CALLED.sub(rf"@{mathematics.PREFIX}\1(", text)
        module = llvm.parse_assembly(text + mathematics.declarations())
        module.get_function(found.fndesc.llvm_cfunc_wrapper_name).name = part.name
        whole.link_in(module)
    return finished(whole, {part.name for part in parts})


def finished(whole: Any, exported: Collection[str]) -> str:
    """Return the text of a module, with all that it calls.

    Args:
        whole: A module of llvmlite.
        exported: Names of the functions that are called from outside.
    """
    whole.link_in(llvm.parse_assembly(TEAM))
    whole.link_in(llvm.parse_assembly(mathematics.defined()))
    whole.link_in(llvm.parse_assembly(_stubs(str(whole))))
    is_final = any(name.startswith(FINISHED) for name in exported)
    _simplify(whole, exported, vectors=is_final)
    text = str(whole)
    if not any(name.startswith(UNFUSED) for name in exported):
        text = fused(text)
    for name in ROUNDING:
        if f"@llvm.{name}.f64(" in text:  # LLVM has done the same somewhere
            text = re.sub(rf"^declare .*@{name}\(.*\n", "", text, flags=re.MULTILINE)
    text = _OF_CALLS.sub("", _LEFT_OUT.sub("", _CALLS.sub(r"@llvm.\1.f64(", text)))
    if is_final or any(name.startswith(OPTIMISED) for name in exported):
        text = _OTHERS.sub(rf"\1 noinline {LEFT_ALONE} {{", text)
    return _CALLED_LOOPS.sub(r"\1 noinline {", text)


def _compiled(function: FunctionType, **options: bool) -> Any:
    """Return a function as Numba compiles it when it is needed."""
    # Kernels allocate nothing, so they need no counting of references.
    return njit(
        error_model="numpy",
        _nrt=False,
        no_cpython_wrapper=True,
        **{"no_cfunc_wrapper": True} | options,
    )(function)


def _restricted(text: str, unshared: Unshared) -> str:
    """Return a module that says which arguments share no memory with others."""

    def marked(head: re.Match[str]) -> str:
        names = unshared[head[1]]
        attributes = r"(?: \w+(?:\(\w+\))?)*"
        where = rf"(\w+\*|ptr)(?={attributes} %\"?arg\.(?:{'|'.join(names)})\.4\"?[,)])"
        whole, count = re.subn(where, r"\1 noalias", head[0])
        assert count == len(names), f"arguments of {head[1]} are not where they were"
        return whole

    return re.sub(rf"^define .*?\d({'|'.join(unshared)})B.*$", marked, text, flags=re.MULTILINE)


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
        elif not name.startswith("llvm.") and name not in (*ROUNDING, *CALLED):
            raise LookupError(f"{name} is called, which is unknown to compiled.loading")
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
    llvm.initialize_native_target()  # also where Numba has translated nothing before
    machine = llvm.Target.from_default_triple().create_target_machine(opt=1)
    options = llvm.create_pipeline_tuning_options(speed_level=1)
    options.loop_vectorization = options.loop_unrolling = False
    options.slp_vectorization = vectors
    builder = llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)
