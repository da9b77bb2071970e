"""Faults of one part in a hundred in the engine's forces, and whether ``validate`` sees them.

Every number and every formula in what computes forces is made 1 % larger, one at a time, and a
scene that runs through it is validated. ``python -m tests.validate.mutants`` prints a table of
all. What is compiled otherwise runs here as Python.
"""

import ast
import contextlib
import inspect
import os
import pickle
import signal
import sys
from collections import Counter
from collections.abc import Callable
from functools import cache
from importlib import import_module
from pathlib import Path
from textwrap import dedent
from types import CodeType, FunctionType, ModuleType

import click
from msgspec import Struct

from tests.validate.scenes import compiled_scene, silent
from tissuec.autodiff import TracingError
from tissuec.compiled.binding import Binder
from tissuec.compiled.bundles import FLAGS
from tissuec.compiler.compile import Compiled
from tissuec.engine import backends, kernel_inputs, operations, stepper, watching
from tissuec.engine.integrators import banded, iterative
from tissuec.forces import (
    accelerations,
    point_fields,
    pooled_fields,
    pooled_kernels,
    potential_fields,
)
from tissuec.forces.contact import contact, pressing
from tissuec.forces.enclosed import pressure
from tissuec.forces.solids import solid_point
from tissuec.forces.springs import springs_kernel
from tissuec.forces.springs.runs_kernel import springs_in_runs
from tissuec.forces.surfaces import plane_point
from tissuec.kernels.records import Net, Operations
from tissuec.laws import LINEAR, code
from tissuec.validate import validation
from tissuec.validate.engine_run import output_times, thinned
from tissuec.validate.uncertainty import EstimatedReference, known_reference

FACTOR = 1.01
PATIENCE = 60  # processor time for one mutant [s]; one that takes longer goes astray
TRACING = 20  # times as long as running is watching which lines are run, at most
FOLDER = Path(__file__).parent / "mutated"
#: The fastest first; what these do not tell from the truth, the next ones may.
SCENES = {
    name: FOLDER / f"{name}.tis"
    for name in (
        "springs",
        "memory",
        "laws",
        "foundation",
        "thread",
        "volume",
        "shell",
        "crease",
        "close",
        "jet",
        "edge",
        "turn",
        "glue",
        "cut",
        "press",
        "contact",
        "rub",
        "solid",
        "wall",
        "fluid",
        "needle",
        "collapse",
        "plain",
        "flat",
    )
}

OF_SOLIDS = (
    "_of_volume", "_point", "in_series", "in_parallel", "_rates", "pace_of_flow",
    "carried", "_second_invariant", "_unimodular_inverse",
)  # fmt: skip
#: What computes forces: modules, and which functions of them, None for all.
FORCES: dict[str, tuple[str, ...] | None] = {
    "tissuec.forces.accelerations": ("force", "add_fields", "count_powers", "accelerate"),
    "tissuec.forces.springs.springs_kernel": (
        "springs",
        "pull_of_laws",
        "reeled",
        "pull_of",
    ),
    "tissuec.kernels.boundary_conditions": None,
    "tissuec.forces.acting.foundation": ("_held",),
    "tissuec.forces.enclosed.volume": ("_face", "_cell"),
    "tissuec.forces.springs.rest_length_kernel": None,
    "tissuec.forces.springs.branches_kernel": ("flowed", "relax", "flow"),
    "tissuec.forces.acting.jets_kernel": None,
    "tissuec.forces.springs.pairs_kernel": None,
    "tissuec.forces.springs.runs_kernel": None,
    "tissuec.forces.contact.pressing": ("_stored", "_below_plane", "_below_face", "_nearest"),
    "tissuec.forces.contact.contact_kernel": None,
    "tissuec.forces.contact.place_kernel": None,
    "tissuec.forces.contact.rows_kernel": None,
    "tissuec.forces.contact.couples_kernel": None,
    "tissuec.forces.contact.sides_kernel": ("lay_inside",),
    "tissuec.forces.contact.friction_kernel": None,
    "tissuec.forces.solids.activation": ("_pull",),
    "tissuec.forces.acting.embedding_kernel": None,
    "tissuec.autodiff.angles": ("less", "versine", "_of_cosine", "_of_sine", "_of_versine"),
    "tissuec.forces.solids.ties": ("_sums", "_tie", "_softening"),
    "tissuec.forces.solids.isochoric": ("isochoric", "falling", "folded", "paired"),
    "tissuec.forces.solids.solid_point": OF_SOLIDS,
    "tissuec.forces.surfaces.plane_point": (
        "of",
        "_point",
        "_strained",
        "_invariants",
        "_rates",
        "_ratio_of_areas",
        "_held",
        "_along",
        "_inner",
    ),
    "tissuec.forces.surfaces.bending": ("of", "weight", "speed", "_grip", "as_drawn"),
    "tissuec.forces.surfaces.plates": ("_plate",),
    "tissuec.forces.enclosed.pressure": ("_pressed",),
    "tissuec.forces.enclosed.fluids": ("_triangle", "_cavity"),
}
POWERS = ("SHARPNESS",)  # whole numbers that are part of a formula, and no index
#: What may change by 1 % without being wrong, with the reason: functions, numbers of a module,
#: texts, some of them in one function only, and what is assigned to a name in a function.
HARMLESS = {
    "TINY": "keeps a division finite where a spring has no length",
    "FLAT": "tells triangles without area from others",
    "LEAST": "keeps a rate finite where contact begins; see docs/numerics.md",
    "rest[k] >= 0.0": "what is true stays true",
    "met[BENDS]": "counts bends of laws, by which errors are weighed; no force has them",
    **{
        f"pull_pairs: each[{rows}]": "a copy serves as well as scratch that nobody else reads"
        for rows in (
            ":4 * BLOCK",
            *(f"{k} * BLOCK:" for k in (8, 9, 10)),
            "4 * BLOCK:8 * BLOCK",
        )
    },
    **dict.fromkeys(
        (
            "x[j + THREE] - x[i + THREE]",
            "v[j + THREE] - v[i + THREE]",
            "reach[i + THREE]",
            "part * reach[k + THREE]",
            "sums[i + THREE]",
            "sums[j + THREE]",
            "f3 + p3",
            "f3 - p3",
        ),
        "a fourth number, which is zero",
    ),
    "lay: 1.0": "counts bends of laws",
    "ALIKE": "tells equal distances from others",
    "NONE": "tells the inside of a triangle from its edges",
    **dict.fromkeys(
        ("lay_inside: 4.0", "lay_inside: 1.0", "4.0 * (1.0 + shape)"), "counts bends of laws"
    ),
    "touches.surface[shape]": "only which surface it is counts",
    "lay: 2.0": "counts bends of laws",
    **dict.fromkeys(
        ("NodeOnShape._stored: passed =", "NodeOnShape._stored: self.bends ="),
        "counts bends of laws",
    ),
    "NodeOnShape._stored: is_flat =": "only which shape it is counts",
    "_nearest: found[k] =": "a factor of weights and of what they are divided by",
    "_nearest: beyond =": "a factor of weights and of what they are divided by",
    "look: 3.0": "the middle of a triangle, by which it is found",
    "end_of_surface": "only which surface it is counts",
    "count": "counts bends of laws, by which errors are weighed; no force has them",
    "touches.weight[pair] * (1.0 if depth < touches.layer else 2.0)": "counts bends of laws",
    "LARGEST": "cuts off what lies far beyond sliding, where no motion comes",
    "LEFT": "tells steps in which a spring turns over",
    "STIFFEST": "keeps slopes of dashpots finite; no force has it",
    "survey": "lists the triangles that a jet may reach; a longer list changes nothing",
    "sort": "finds triangles near one another; more of them change nothing",
    "cell": "finds triangles near one another; more of them change nothing",
    "before": "lists what may shade a triangle; a longer list changes nothing",
    "stands_before": "lists what may shade a triangle; a longer list changes nothing",
    "(face[7] + face[9] + face[11]) / 3.0": "the middle of a triangle, by which it is found",
    "(face[8] + face[10] + face[12]) / 3.0": "the middle of a triangle, by which it is found",
    "(face[place] - face[13]) ** 2 + (face[place + 1] - face[14]) ** 2": "finds triangles",
    "max(reach, far)": "finds triangles near one another; more of them change nothing",
    "SLACK * sqrt(reach)": "finds triangles near one another; more of them change nothing",
    "sort(jet.found[0], jet)": "finds triangles near one another; more of them change nothing",
    "jet.side[t]": "only its sign counts",
    "count_powers: net.inverse_mass[start:stop]": "only its sign counts",
    "jet.struck[t] and (side == 0 or side * slope < 0.0)": "only whether it is true counts",
    "0.6": "any two directions across the jet do",
    "a0 / size": "any two directions across the jet do; a0 is 0",
    "FAR": "larger than any opening",
    "CUT": "beyond, a jet has 1e-9 of what it has on its axis",
    "SLACK": "finds triangles near one another; more of them change nothing",
    **{
        f"bristle_ahead: {text}": "a step of an iteration, which ends at the same root"
        for text in (
            "size / firm",
            "min(high, slips)",
            "firm * length + lag * grip * slides - size",
            "lag * grip * unbend",
            "lag * SHARPNESS * grip / length * slides",
            "length - over / steep if steep > 0.0 else high",
            "0.5 * (low + high)",
            "0.5",
            "4e-16",
        )
    },
    "isochoric: root =": "a step of an iteration, which ends at the same root",
    "share_of: 1.0": "a bound at which the share of fibres is zero, as is its slope",
    "NO_SPRING": "only its sign counts",
    "SECONDS": "estimates times of evaluations; no force has it",
    "_plate: x[0][0].graph.number(0.0)": "is zero",
    **dict.fromkeys(
        (
            "pull_groups: runs.block.size - 1",
            "pull_groups: ring + runs.width // TILE * SIZE",
            "reeled: reels.low[k]",
            "reeled: reels.high[k]",
            "touch: touches.starts.size - 1",
            "blow: survey(x, jet)",
        ),
        "a whole number, a place or a count",
    ),
    **dict.fromkeys(
        ("touch: add_up(0, end, f, power, touches)",),
        "counts bends of laws, by which errors are weighed; no force has them",
    ),
    "turned: touches.kind[shape_of(row, touches)]": "only which shape it is counts",
    **dict.fromkeys(
        tuple(
            f"_point: {name} ="
            for name in ("start", "wide", "rising", "grown", "bent", "below", "swollen")
        ),
        "from where an iteration begins, which ends at the same root",
    ),
    "in_series: 3.0": "a constant part of the energy",
    "_LARGEST": "a step of an iteration, which ends at the same root",
    "LONGEST": "a step of an iteration, which ends at the same root",
    "CLOSE": "ends an iteration; what is left is below the tolerance",
}


#: What keeps what was traced.
TRACED = (
    potential_fields.traced_item, pooled_fields._traced, pooled_kernels.kernels_of,
    pressure.traced_triangle, solid_point.traced_point, plane_point.traced_point,
    point_fields.kernel_of, point_fields.record_kernel,
    pressing.traced_pairs, contact._of_pairs_at_rest,
)  # fmt: skip


class Mutant(Struct, frozen=True):
    """One number or formula that is made larger.

    Attributes:
        module: Full name.
        function: Qualified name, or that of a number of the module.
        line: Where it stands.
        place: Which of what can be changed in the function.
        text: What is made larger.
        target: What it is part of the new value of; empty if of nothing.
    """

    module: str
    function: str
    line: int
    place: int
    text: str
    target: str = ""


class _Enlarge(ast.NodeTransformer):
    """Makes one of the numbers and formulas of a function larger, or lists all of them."""

    def __init__(self, place: int | None = None):
        self.found: list[ast.expr] = []
        self.targets: list[str] = []
        self._place, self._target = place, ""

    def _larger(self, node: ast.expr) -> ast.expr:
        if isinstance(node, ast.Tuple | ast.List):
            node.elts = [self._larger(each) for each in node.elts]
            return node
        if isinstance(node, (ast.Name, ast.Attribute)):
            return node  # a formula stands where it was set
        if isinstance(node, ast.Constant) and not (
            isinstance(node.value, float) and node.value
        ):
            return node
        self.found.append(node)
        self.targets.append(self._target)
        if self._place != len(self.found) - 1:
            return node
        return ast.BinOp(node, ast.Mult(), ast.Constant(FACTOR))

    def visit_Constant(self, node: ast.Constant) -> ast.expr:
        return self._larger(node)

    def visit_Assign(self, node: ast.Assign | ast.AugAssign | ast.Return) -> ast.AST:
        if isinstance(node, ast.AugAssign):
            self._target = ast.unparse(node.target)
        elif isinstance(node, ast.Assign):
            self._target = ", ".join(map(ast.unparse, node.targets))
        counts = "BENDS" in self._target  # bends of laws, by which errors are weighed
        if node.value is not None and not counts:
            value = self.visit(node.value)
            node.value = value if isinstance(value, ast.Constant) else self._larger(value)
        self._target = ""
        return node

    visit_AugAssign = visit_Return = visit_Assign


def mutants_of(
    name: str, lines: dict[str, set[int]], only: tuple[str, ...] | None
) -> list[Mutant]:
    """Return what can be changed in the lines of a module that were run, by function."""
    module, found = import_module(name), []
    for function in functions_of(module):
        if only is not None and function.__name__ not in only:
            continue
        tree, first = _parsed(function)
        enlarge = _Enlarge()
        enlarge.visit(tree)
        for place, (node, target) in enumerate(
            zip(enlarge.found, enlarge.targets, strict=True)
        ):
            line = first + node.lineno - 1
            if line in lines.get(function.__code__.co_filename, set()):
                found.append(
                    Mutant(name, function.__qualname__, line, place, ast.unparse(node), target)
                )
    if lines.get(str(module.__file__)):
        for constant, value in vars(module).items():
            if constant.isupper() and (isinstance(value, float) or constant in POWERS):
                found.append(Mutant(name, constant, 0, 0, repr(value)))
    return found


def functions_of(module: ModuleType) -> list[FunctionType]:
    """Return the functions and methods that a module defines, each once."""
    found = {}
    for value in vars(module).values():
        members = vars(value).values() if inspect.isclass(value) else [value]
        for member in members:
            member = getattr(member, "fget", getattr(member, "__func__", member))
            if inspect.isfunction(member) and member.__module__ == module.__name__:
                found[member.__qualname__] = member
    return list(found.values())


def _parsed(function: FunctionType) -> tuple[ast.Module, int]:
    source, first = inspect.getsourcelines(function)
    return ast.parse(dedent("".join(source))), first


def apply(mutant: Mutant) -> None:
    """Change the running program."""
    module = import_module(mutant.module)
    if not mutant.line:
        setattr(module, mutant.function, getattr(module, mutant.function) * FACTOR)
        return
    (function,) = (f for f in functions_of(module) if f.__qualname__ == mutant.function)
    tree, _ = _parsed(function)
    changed = ast.fix_missing_locations(_Enlarge(mutant.place).visit(tree))
    codes = [compile(changed, function.__code__.co_filename, "exec")]
    while codes[0].co_name != function.__name__:
        codes = [c for c in codes[0].co_consts if isinstance(c, CodeType)] + codes[1:]
    function.__code__ = codes[0]


def implementation(name: str, features: operations.Features) -> Callable[..., object]:
    """Return the function that is an operation on nets for what a scene needs."""
    if name in operations.LAWS:
        return code.functions(features.laws or (LINEAR,))[name]
    if name == "springs" and features.in_runs:
        return springs_in_runs
    if name in ("assemble", "solve"):
        return getattr(banded if features.banded else iterative, name)
    return operations.FUNCTIONS[name]


def plain_operations(features: operations.Features) -> dict[str, object]:
    """Return what the names of operations mean in Python, for what a scene needs."""
    names = {name: implementation(name, features) for name in Operations._fields}
    has = features.viscous, features.watched, not features.straight
    return names | dict(zip(FLAGS, has, strict=True))


def as_python() -> None:
    """Let what would be compiled run as it stands, and what is traced be traced anew."""
    for each in TRACED:
        each.cache_clear()
    seen = list[operations.Features]()

    def found(integrator, features):
        seen.append(features)
        return Operations(force=len(seen) - 1)

    @cache
    def binder(integrator, features):
        names = {
            name: each
            for module in (accelerations, springs_kernel)
            for name, each in inspect.getmembers(module, inspect.isfunction)
        }
        return Binder(names | backends.method_names(integrator) | plain_operations(features))

    def bound(integrator, function):
        def call(*arguments):
            (net,) = (each for each in arguments if isinstance(getattr(each, "record", 0), Net))
            return binder(integrator, seen[net.operations.force]).bind(function)(*arguments)

        return call

    tables = {}

    def kernel_address(kernel, table):
        tables[table.address] = kernel, table
        return 0

    def add_field(address, table, time, x, v, f, power):
        kernel, given = tables[table]
        kernel(time, x, v, f, power, given.record)

    kernel_inputs.kernel_address, accelerations.add_field = kernel_address, add_field
    stepper.loop_operations = found
    stepper.bound_drive = lambda integrator, backend: bound(integrator, backends.step.drive)
    watching.bound_inside = lambda integrator: backends.Inside(
        bound(integrator, backends.step_inside.look), bound(integrator, integrator.prepare)
    )
    stepper.Stepper.table = lambda self, record: record


def lines_run(work: Callable[[], object], modules: list[str]) -> dict[str, set[int]]:
    """Return which lines of modules some work runs through, by file."""
    files = {str(import_module(name).__file__) for name in modules}
    lines: dict[str, set[int]] = {file: set() for file in files}

    def local(frame, event, argument):
        lines[frame.f_code.co_filename].add(frame.f_lineno)
        return local

    def begin(frame, event, argument):
        return local if frame.f_code.co_filename in files else None

    sys.settrace(begin)
    try:
        work()
    finally:
        sys.settrace(None)
    return lines


def compiled(name: str) -> Compiled:
    return compiled_scene(SCENES[name].read_text(encoding="utf-8"))


@cache
def known(name: str) -> EstimatedReference:
    """Return the reference of a scene, which shares nothing with what mutants change."""
    scene = compiled(name)
    network, plan = scene.network, scene.plan
    times = thinned(output_times(network, plan), network.node_count)
    return known_reference(network, plan, times, method="DOP853", rtol=None, progress=silent)


def verdict(name: str) -> str:
    """Return what ``validate`` says of a scene."""
    reference = known(name)
    validation.known_reference = lambda *arguments, **options: reference
    found = validation.validate(compiled(name), method="DOP853", rtol=None, progress=silent)
    return found.verdict


def in_child(work: Callable[[], object], patience: float = PATIENCE) -> object:
    """Return the result of some work that a process of its own does, or how that ended."""
    read, write = os.pipe()
    child = os.fork()
    if not child:
        with contextlib.suppress(BaseException):
            os.close(read)
            signal.setitimer(signal.ITIMER_PROF, patience)
            try:
                answer = work()
            except (TypeError, IndexError, AttributeError, NameError, TracingError) as error:
                answer = f"no number: {type(error).__name__}"
            except BaseException as error:
                answer = f"failed: {type(error).__name__}"
            with os.fdopen(write, "wb") as stream:
                pickle.dump(answer, stream)
        os._exit(0)
    os.close(write)
    with os.fdopen(read, "rb") as stream:
        data = stream.read()
    os.waitpid(child, 0)
    return pickle.loads(data) if data else "failed: took too long"


def tried(scene: str, mutant: Mutant) -> str:
    """Return what ``validate`` says with a mutant: "kept" is a fault that is not seen."""
    known(scene)  # once, before the processes of mutants begin with it

    def work() -> str:
        as_python()
        apply(mutant)
        return verdict(scene)

    return str(in_child(work))


def found_in(scene: str) -> list[Mutant]:
    """Return the mutants that a scene runs through."""

    def work() -> dict[str, set[int]]:
        as_python()
        return lines_run(lambda: verdict(scene), list(FORCES))

    known(scene)
    lines = in_child(work, TRACING * PATIENCE)
    assert isinstance(lines, dict), (scene, lines)
    return [m for name, only in FORCES.items() for m in mutants_of(name, lines, only)]


def is_harmless(mutant: Mutant) -> bool:
    """Return whether a mutant is known to be none that is wrong."""
    function, text, target = mutant.function, mutant.text, mutant.target
    return not HARMLESS.keys().isdisjoint(
        {function, text, f"{function}: {text}", f"{function}: {target} ="}
    )


class Table(Struct, frozen=True):
    """What became of mutants.

    Attributes:
        counts: By module: how many were found, are harmless, were no number of a formula.
        left: Those that no scene tells from the truth, with the last that tried.
    """

    counts: dict[str, Counter[str]]
    left: dict[Mutant, str]


def survey(scenes: list[str], *, every: int = 1, verbose: bool = False) -> Table:
    """Try the mutants, each with scene after scene until one finds it out."""
    counts: dict[str, Counter[str]] = {name: Counter() for name in FORCES}
    left: dict[Mutant, str] = {}
    done: set[Mutant] = set()
    for scene in scenes:
        for mutant in found_in(scene)[::every]:
            if mutant in done:
                continue
            said = "harmless" if is_harmless(mutant) else tried(scene, mutant)
            if verbose:
                print(scene, mutant, said, flush=True)
            if said == "kept":
                left[mutant] = scene
                continue
            left.pop(mutant, None)
            done.add(mutant)
            known = said.partition(":")[0]
            counts[mutant.module][known if known in ("harmless", "no number") else "found"] += 1
    return Table(counts, left)


@click.command()
@click.option("--scene", type=click.Choice(list(SCENES)), multiple=True, default=list(SCENES))
@click.option("--every", default=1, help="Try each so manieth mutant only.")
@click.option("-v", "verbose", is_flag=True, help="Show each mutant.")
def main(scene, every, verbose):
    """Print how many mutants of each module are found out, and those that are not."""
    table = survey(list(scene), every=every, verbose=verbose)
    lost = Counter(mutant.module for mutant in table.left)
    print(f"\n{'':33}     found not found  harmless no number")
    for module, counts in table.counts.items():
        row = counts["found"], lost[module], counts["harmless"], counts["no number"]
        print(f"{module:33}" + "".join(f"{count:10}" for count in row))
    for mutant, name in table.left.items():
        where = f"{mutant.module}:{mutant.line} {mutant.function}"
        print(f"  {where}: {mutant.text}  ({name})")


if __name__ == "__main__":
    main()
