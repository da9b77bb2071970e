"""The blocks that stand once: environment and simulate; and the tools."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tissuec.core import units
from tissuec.core.fields import Measure, OneOf, Point
from tissuec.core.source import Span
from tissuec.integrators import INTEGRATORS
from tissuec.lang import syntax as s
from tissuec.network import Floats
from tissuec.plan import RELAXATION, Simulation
from tissuec.scene import schema
from tissuec.scene.declarations import Declarations
from tissuec.scene.expressions import Scope
from tissuec.scene.findings import Findings
from tissuec.scene.imports import whole
from tissuec.scene.model import Environment, Tool

DEFAULT_TOLERANCE = 1e-4
FINEST_TOLERANCE = 1e-13  # below, rounding alone is larger
AUTOMATIC = "automatic"
TOOL_KINDS = ("forceps", "scissors")
HOLDING = "forceps"  # the kind that holds nodes, and so can move them


@dataclass(frozen=True, slots=True, eq=False)
class EnvironmentEntries:
    """What acts everywhere.

    Attributes:
        gravity: acceleration of free fall; write (0, 0, 0) m/s^2 for none
        contact: whether bodies touch one another; only off so far
        damping: ambient damping: each node is braked by this times its velocity
    """

    gravity: Annotated[Floats, Point(units.ACCELERATION)]
    contact: Annotated[str, OneOf(("off",))] = "off"
    damping: Annotated[float, Measure(units.VISCOSITY, at_least=0.0)] = 0.0


@dataclass(frozen=True, slots=True)
class SimulateEntries:
    """How the motion is computed.

    Attributes:
        duration: simulated time
        integrator: automatic, or the name of a method
        tolerance: bound of the error of every position, relative to the largest displacement
            so far
        step: fixed time step, instead of a tolerance; needs a named integrator
    """

    duration: Annotated[float, Measure(units.TIME, above=0.0)]
    integrator: Annotated[str, OneOf((AUTOMATIC,))] = AUTOMATIC
    tolerance: Annotated[
        float, Measure(units.NUMBER, at_least=FINEST_TOLERANCE, at_most=0.1)
    ] = DEFAULT_TOLERANCE
    step: Annotated[float | None, Measure(units.TIME, above=0.0)] = None


@dataclass(frozen=True, slots=True)
class ToolEntries:
    """An instrument.

    Attributes:
        kind: what it is: forceps grasp, scissors cut
    """

    kind: Annotated[str, OneOf(TOOL_KINDS)]


def read_environment(declarations: Declarations, main: s.Module, scope: Scope) -> Environment:
    """Return the environment; rejects a scene without one, for gravity must be written."""
    block = _single(
        "environment",
        "environment { gravity = (0, 0, -9.81) m/s^2 }",
        declarations,
        main,
        scope.findings,
    )
    entries, _ = schema.build(
        EnvironmentEntries, block.items, scope, what="environment", where=block.head
    )
    return Environment(np.asarray(entries.gravity, dtype=float), entries.damping)


def read_simulation(declarations: Declarations, main: s.Module, scope: Scope) -> Simulation:
    """Return the simulate block, as far as it is right; rejects a scene without one.

    A duration that is wrong is taken to be endless, so that nothing seems to come after it.
    """
    block = _single(
        "simulate", "simulate { duration = 1 s }", declarations, main, scope.findings
    )
    entries = dict(schema.entries_of(SimulateEntries))
    failures = scope.findings.failures
    values, places = schema.read(simulate_schema(), block.items, scope, what="simulate")
    is_whole = scope.findings.failures == failures  # else what is missing may be what is wrong
    if is_whole and "duration" not in places:
        scope.findings.add(
            "TIS304",
            'simulate needs "duration"',
            block.head,
            hint=f"for example: {entries['duration'].example}",
        )
    values.setdefault("duration", math.inf)
    read = SimulateEntries(**values)
    with scope.findings.item():
        _refuse_contradictions(read, places, scope, is_whole=is_whole)
    tolerance = read.tolerance if read.step is None else None
    return Simulation(read.duration, read.integrator, tolerance, read.step, block.head)


def _refuse_contradictions(
    read: SimulateEntries, places: Mapping[str, Span], scope: Scope, *, is_whole: bool
) -> None:
    """Reject entries that do not go together; of those that are missing, if none is wrong."""
    if read.step is not None and "tolerance" in places:
        scope.findings.reject(
            "TIS306",
            "a fixed step cannot promise a tolerance",
            places["tolerance"],
            hint="write step or tolerance, not both",
        )
    if not is_whole:
        return
    if read.step is not None and read.integrator == AUTOMATIC:
        scope.findings.reject(
            "TIS306",
            "a fixed step needs a named integrator",
            places["step"],
            hint="for example: integrator is velocity verlet",
        )
    if read.step is None and read.integrator != AUTOMATIC:
        _refuse_tolerance(read.integrator, places["integrator"], scope)


def _refuse_tolerance(name: str, place: Span, scope: Scope) -> None:
    """Reject a method that cannot keep a tolerance."""
    if name == RELAXATION or not INTEGRATORS[name].promises:
        scope.findings.reject(
            "TIS306",
            f"{name} estimates no error, so that it cannot keep a tolerance",
            place,
            hint="write instead how far apart its states are, such as step = 10 ms",
        )


def simulate_schema() -> dict[str, schema.Entry]:
    """Return the entries of simulate with the integrators there are."""
    entries = schema.entries_of(SimulateEntries)
    old = entries["integrator"]
    names = OneOf((AUTOMATIC, *INTEGRATORS, RELAXATION))
    entries["integrator"] = schema.Entry(old.name, old.field, names, old.default, old.about)
    return entries


def read_tool(name: s.Name, item: s.Item, scope: Scope) -> Tool:
    """Return a tool from its block; one that is wrong is still known by its name."""
    assert isinstance(item, s.Block)
    kind = ""
    with scope.findings.item():
        entries, _ = schema.build(
            ToolEntries, item.items, scope, what=f"tool {name.text}", where=item.head
        )
        kind = entries.kind
    return Tool(name.text, kind, item.head)


def _single(
    kind: str, example: str, declarations: Declarations, main: s.Module, findings: Findings
) -> s.Block:
    if kind not in declarations.single:
        if findings.may_be_misspelt(kind):
            findings.stop()
        findings.reject(
            "TIS304",
            f"the scene has no {kind} block",
            whole(main),
            hint=f"for example: {example}",
        )
    return declarations.single[kind]
