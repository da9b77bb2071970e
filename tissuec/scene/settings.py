"""How the motion is computed: the simulate block."""

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, ClassVar

from msgspec import Struct

from tissuec.core import units
from tissuec.core.fields import OneOf, Real
from tissuec.core.hints import Hint, insertion, leaving_out
from tissuec.core.source import Span
from tissuec.engine.integrators import INTEGRATORS
from tissuec.lang import syntax as s
from tissuec.scene.program.declarations import Declarations
from tissuec.scene.reading import schema
from tissuec.scene.reading.entries import Entry, entries_of, with_choices
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.reading.parts import block, declare
from tissuec.script.plan import (
    AUTOMATIC,
    DEFAULT_TOLERANCE,
    EQUILIBRIUM,
    LOAD_STEPS,
    RELAXATION,
    STATIC,
    Simulation,
)
from tissuec.script.procedures import PROCEDURES, Choices

FINEST_TOLERANCE = 1e-13  # below, rounding alone is larger


class SimulateEntries(Struct, frozen=True):
    """How the motion is computed.

    Attributes:
        duration: simulated time
        integrator: automatic, or the name of a method
        tolerance: bound of the error of every position, relative to the largest displacement
            so far
        step: fixed time step, instead of a tolerance; needs a named integrator
    """

    duration: Annotated[float, Real(units.TIME, above=0.0)]
    integrator: Annotated[str, OneOf((AUTOMATIC,))] = AUTOMATIC
    tolerance: Annotated[float, Real(units.NUMBER, at_least=FINEST_TOLERANCE, at_most=0.1)] = (
        DEFAULT_TOLERANCE
    )
    step: Annotated[float | None, Real(units.TIME, above=0.0)] = None


def simulate_schema() -> dict[str, Entry]:
    """The entries of simulate with the integrators there are."""
    return with_choices(SimulateEntries, "integrator", integrators(), PROCEDURES)


class _Integrators(Mapping[str, str | type]):
    """Integrators by name; the family is imported only if one of its members is looked up."""

    _others: ClassVar = {
        AUTOMATIC: "Chosen automatically; the run shows which and why.",
        EQUILIBRIUM: "Statics: equilibria by Newton's method, without inertia.",
        RELAXATION: "The published procedure without inertia: nodes are relaxed.",
    }

    def __getitem__(self, name: str) -> str | type:
        return self._others.get(name) or INTEGRATORS[name]

    def __iter__(self) -> Iterator[str]:
        return iter((AUTOMATIC, *INTEGRATORS, EQUILIBRIUM, RELAXATION))

    def __len__(self) -> int:
        return len(self._others) + len(INTEGRATORS)


def integrators() -> Mapping[str, str | type]:
    """The integrators that can be named, with their classes or descriptions."""
    return _Integrators()


_EXAMPLE = "simulate { duration = 1 s }"
declare(
    "simulate", "Duration and numerical method of the run.", 42, "single",
    example=_EXAMPLE, block=block(simulate_schema), entries_vary=True,
)  # fmt: skip


def read_simulation(declarations: Declarations, main: s.Module, scope: Scope) -> Simulation:
    """Return the simulate block, as far as it has no errors; a scene without one is rejected.

    An erroneous duration is replaced by infinity, so that no event seems to come after it.
    """
    block = declarations.required("simulate", _EXAMPLE, main, scope.findings)
    entries = entries_of(SimulateEntries)
    failures = scope.findings.failures
    values, places = schema.read(simulate_schema(), block.items, scope, what="simulate")
    is_whole = scope.findings.failures == failures  # else what is missing may be what is wrong
    if is_whole and "duration" not in places:
        scope.findings.add(
            "TIS304",
            'simulate needs "duration"',
            block.head,
            hint=schema.missing(entries["duration"].example, block.head),
        )
    values.setdefault("duration", math.inf)
    read = SimulateEntries(**values)
    with scope.findings.item():
        _refuse_contradictions(read, places, scope, is_whole=is_whole)
    step = read.step
    if step is None and read.integrator == EQUILIBRIUM:
        step = read.duration / LOAD_STEPS
    tolerance = read.tolerance if step is None else None
    choices = None
    with scope.findings.item():
        choices = _choices(read.integrator, block, scope)
    return Simulation(read.duration, read.integrator, tolerance, step, block.head, choices)


def _choices(name: str, block: s.Block, scope: Scope) -> Choices | None:
    """Return the entries chosen for a published procedure; None for other methods."""
    written = [i for i in block.items if isinstance(i, s.Block) and i.name.key == "integrator"]
    if name in PROCEDURES:
        items = written[0].items if written else ()
        where = written[0].head if written else block.head
        return schema.build(PROCEDURES[name], items, scope, what=name, where=where)[0]
    if written:
        scope.findings.reject(
            "TIS303",
            f"{name} does not have entries",
            written[0].span,
            hint=f"only {' and '.join(PROCEDURES)} can have entries",
        )
    return None


def _refuse_contradictions(
    read: SimulateEntries, places: Mapping[str, Span], scope: Scope, *, is_whole: bool
) -> None:
    """Reject entries that do not go together; of those that are missing, if none is wrong."""
    if read.step is not None and "tolerance" in places:
        scope.findings.reject(
            "TIS306",
            "a fixed step cannot guarantee a tolerance",
            places["tolerance"],
            hint=leaving_out("remove step or tolerance", places["tolerance"], places["step"]),
        )
    if not is_whole:
        return
    if read.step is not None and read.integrator == AUTOMATIC:
        scope.findings.reject(
            "TIS306",
            "a fixed step needs a named integrator",
            places["step"],
            hint=Hint(
                "for example: integrator is velocity verlet",
                insertion("; integrator is velocity verlet", places["step"]),
            ),
        )
    if read.integrator == EQUILIBRIUM:
        if "tolerance" in places:
            scope.findings.reject(
                "TIS306",
                "equilibrium needs no tolerance: all forces balance within rounding",
                places["tolerance"],
                hint=leaving_out("remove the tolerance", places["tolerance"]),
            )
    elif read.step is None and read.integrator != AUTOMATIC:
        _refuse_tolerance(read.integrator, places["integrator"], scope)


def _refuse_tolerance(name: str, place: Span, scope: Scope) -> None:
    """Reject a method that cannot keep a tolerance."""
    if name in STATIC or not INTEGRATORS[name].promises:
        scope.findings.reject(
            "TIS306",
            f"{name} does not estimate the error, so it cannot guarantee a tolerance",
            place,
            hint="write the time between its states instead, such as step = 10 ms",
        )
