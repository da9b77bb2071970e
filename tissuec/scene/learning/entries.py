"""The settings of a learn block, and what can be adjusted."""

from typing import Annotated

from msgspec import Struct

from tissuec.core import units
from tissuec.core.fields import OneOf, Real, Whole
from tissuec.engine.integrators import INTEGRATORS, Integrator
from tissuec.scene.reading.entries import Entry, with_choices
from tissuec.scene.tissues.quantities import (
    CUTTING_RESISTANCE,
    FIBRE_DISPERSION,
    FRICTION,
    QUANTITIES,
)
from tissuec.script.fit_problem import REST_LENGTH, START_POSITION, START_VELOCITY, WORDS
from tissuec.script.plan import AUTOMATIC

METHODS = ("automatic", "least squares", "l-bfgs-b")
SCALED, ABSOLUTE = "scaled", "absolute"


class LearnSettings(Struct, frozen=True):
    """Settings of learning.

    Attributes:
        passes: maximum number of passes of the optimiser
        bootstrap: number of fits to simulated data that give the intervals; by default,
            derivatives give them
        seed: seed of random numbers
        tolerance: relative change of the error at which learning ends
        step: fixed time step of the motion during learning; by default chosen automatically
        integrator: method of time integration during learning
        method: optimisation method; put a name with dashes in quotes
        error: error relative to the noise of the data, or absolute, as in the paper
    """

    passes: Annotated[int, Whole(at_least=1, at_most=1_000_000)] = 100
    bootstrap: Annotated[int | None, Whole(at_least=40, at_most=1_000_000)] = None
    seed: Annotated[int, Whole(at_least=0)] = 0
    tolerance: Annotated[float, Real(units.NUMBER, above=0.0, at_most=0.1)] = 1e-9
    step: Annotated[float | None, Real(units.TIME, above=0.0)] = None
    integrator: Annotated[str, OneOf((AUTOMATIC,))] = AUTOMATIC
    method: Annotated[str, OneOf(METHODS)] = METHODS[0]
    error: Annotated[str, OneOf((SCALED, ABSOLUTE))] = SCALED


def learn_schema() -> dict[str, Entry]:
    """Return the settings of a learn block with the integrators that can be differentiated.

    These are all with a tableau but those for scenes without losses, for what is learnt may be
    a viscosity.
    """
    names = (name for name in INTEGRATORS if _is_differentiated(INTEGRATORS[name]))
    return with_choices(LearnSettings, "integrator", (AUTOMATIC, *names))


def _is_differentiated(member: type[Integrator]) -> bool:
    return member.tableau is not None and not member.conservative


#: What limits forces at which springs break: there is no slope to follow.
BREAKING = ("breaking force", "crushing force", "breaking strain", "strength", "toughness")
#: What a set, body or region can have adjusted, and by what it can be divided.
PARTED: dict[str, tuple[str, ...]] = {
    "spring constant": ("spring", "region"),
    "viscosity": ("spring", "region"),
    "mass": ("node", "region"),
    REST_LENGTH: ("spring", "region"),
    START_POSITION: ("node",),
    START_VELOCITY: ("node",),
}
DIVIDED = ("spring", "node", "region")
#: Of sets alone, for tissues have none.
PLACED = (REST_LENGTH, START_POSITION, START_VELOCITY)
DIMENSIONS = {
    **{name: quantity.dimension for name, quantity in QUANTITIES.items()},
    REST_LENGTH: units.LENGTH,
    START_POSITION: units.LENGTH,
    START_VELOCITY: units.VELOCITY,
}
#: Quantities of matter that are not adjusted.
NOT_LEARNT = (*BREAKING, FIBRE_DISPERSION, FRICTION, CUTTING_RESISTANCE)
#: What can be adjusted, beside constants of laws, params and numbers of forces.
ADJUSTED = (
    *(key for key in QUANTITIES if key not in NOT_LEARNT),
    *PLACED,
    WORDS,
)
