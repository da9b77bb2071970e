"""The two tiers: interpreted on NumPy, ready at once, or compiled by Numba, much faster.

Which one steps is decided by the numbers of force evaluations so far and to come, never by a
clock, so that a run gives the same bytes again. The constants of the cost model were measured.
"""

import os
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from functools import cache
from typing import Any, cast

from tissuec.engine import drive as loop
from tissuec.engine.binding import Binder
from tissuec.engine.method import Tier
from tissuec.integrators import Integrator
from tissuec.kernels import banded, iterative, scalar
from tissuec.kernels.records import Buffer, Integers, Progress, Solver, Task, Work
from tissuec.laws import Law, code

# Interpreted work to come for which the compiled tier is worth its start [s]. That start takes
# 0.6 s with kernels from the cache, and 5 s on a machine that has never compiled them; with
# contact 25 s, with jets 15 s.
WORTHWHILE, TOUCHED_WORTHWHILE, RINSED_WORTHWHILE = 2.0, 4.0, 2.0
REVIEW = 0.25  # interpreted work between two looks at how much is to come [s]
CALL_COST = 25e-6  # of one interpreted evaluation with its share of the step [s]
SPRING_COST = 30e-9  # further, per spring [s]
TOUCH_COST = 1.6e-4  # of one look at all contacts [s]
PAIR_COST = 3.5e-7  # further, per pair that is near [s]
RUBBED = 2.7  # times that with friction
JET_COST = 4e-3  # of one look at a jet on some hundred triangles [s]
# Of the matrix of an implicit step: of a factor in a band of width b, n b² times this, and of a
# sparse one, n^1.5 times; the same of solving, with n b and n^1.5. [s]
BAND_FACTOR_COST, BAND_SOLUTION_COST = 1e-9, 4e-9
FACTOR_COST, SOLUTION_COST = 6e-7, 1.5e-8
# Operations that the compiled tier takes from ``scalar`` instead of ``vector``.
OPERATIONS = (
    "accumulate",
    "add_rows",
    "bend_of_passed",
    "between",
    "blended_error",
    "combine",
    "copy_sample",
    "distance",
    "drift",
    "find_sides",
    "force",
    "greatest_force",
    "is_passed",
    "kick",
    "kinetic",
    "peaks",
    "place",
    "polynomials",
    "quadrature",
    "scale",
    "slack",
    "subtract",
    "tension",
)
# Parts of them that are compiled by themselves, because they are long.
PARTS = ("before", "dim", "divide", "press", "recoil", "sort", "survey", "touch", "way")
# Those that it takes from ``banded`` or ``iterative`` instead of ``linear``.
SOLVING = ("assemble", "solve")


@dataclass(frozen=True, slots=True)
class Features:
    """What a scene needs; a kernel is compiled without the rest."""

    viscous: bool
    watched: bool
    crushed: bool
    ledger: bool
    moved: bool
    loaded: bool
    banded: bool = False
    enclosed: bool = False
    reeled: bool = False
    touched: bool = False
    rinsed: bool = False
    inelastic: bool = False
    cornered: bool = False
    laws: tuple[Law, ...] = ()  # the linear one and others, if there are others


@dataclass(frozen=True, slots=True)
class Inside:
    """Interpreted code that evaluates an accepted step inside."""

    look: Callable[..., None]
    prepare: Callable[..., None]


Drive = Callable[[Progress, Task, Work, Any, Buffer], tuple[int, Progress]]


@cache
def bound_drive(integrator: type[Integrator], features: Features, tier: Tier) -> Drive:
    """Return the loop over steps of an integrator for a tier."""
    if tier == "compiled":
        features = _shared(features)
    replaced = _replaced(integrator, features)
    if tier == "interpreted":
        return cast(Drive, Binder(replaced).bind(loop.drive))
    solving = banded if features.banded else iterative
    replaced |= {name: getattr(scalar, name) for name in OPERATIONS}
    replaced |= {name: getattr(solving, name) for name in SOLVING}
    return cast(Drive, Binder(replaced, (*OPERATIONS, *SOLVING, *PARTS)).bind(loop.drive))


def _shared(features: Features) -> Features:
    """Return features with some that a scene may lack, and that hardly cost any time.

    Fewer variants are compiled, and none when something begins to move.
    """
    slow = features.touched or features.rinsed  # what springs do takes no time beside these
    viscous, watched = features.viscous or slow, features.watched or slow
    return replace(
        features, viscous=viscous, watched=watched, crushed=watched, moved=True, loaded=True
    )


@cache
def bound_inside(integrator: type[Integrator], features: Features) -> Inside:
    """Return what looks into the steps of an integrator."""
    binder = Binder(_replaced(integrator, features))
    return Inside(look=binder.bind(loop.look), prepare=binder.bind(integrator.prepare))


def _replaced(integrator: type[Integrator], features: Features) -> dict[str, Any]:
    """Return what the names in the stepping code mean for an integrator and features."""
    functions = ("step", "estimate", "book", "finish", "prepare", "propose")
    numbers = ("end_row", "looks", "control_order", "safety", "implicit")
    replaced = {name: getattr(integrator, name) for name in functions}
    replaced |= {name.upper(): getattr(integrator, name) for name in numbers}
    return replaced | constants(features)


def constants(features: Features) -> dict[str, Any]:
    """Return what the names of ``kernels`` mean where a scene has certain features."""
    flags = (entry.name for entry in fields(features) if entry.name != "laws")
    curved = code.functions(features.laws) if features.laws else {}
    return {name.upper(): getattr(features, name) for name in flags} | {
        **curved,
        "CURVED": bool(features.laws),
    }


def evaluation_cost(springs: int, pairs: int | None, rubbed: bool, jets: int) -> float:
    """Return the time of one interpreted evaluation of the forces [s].

    Args:
        springs: How many there are.
        pairs: Of nodes and shapes that are near, None where nothing touches.
        rubbed: Whether there is friction.
        jets: How many there are.
    """
    contact = 0.0 if pairs is None else TOUCH_COST + PAIR_COST * pairs
    contact *= RUBBED if rubbed else 1.0
    return CALL_COST + SPRING_COST * springs + contact + JET_COST * jets


def worthwhile(features: Features) -> float:
    """Return how much interpreted work to come is worth the start of the compiled tier [s]."""
    more = (features.touched, TOUCHED_WORTHWHILE), (features.rinsed, RINSED_WORTHWHILE)
    return WORTHWHILE + sum(each for needed, each in more if needed)


def step_cost(effort: Integers, evaluation: float, solver: Solver) -> float:
    """Return the time of interpreted steps so far [s].

    Args:
        effort: As ``Work.effort``.
        evaluation: Of one evaluation of the forces [s].
        solver: Of implicit steps.
    """
    size, width = solver.band.shape
    factor, solution = BAND_FACTOR_COST * size * width**2, BAND_SOLUTION_COST * size * width
    if solver.scratch.size:
        unknowns = 3 * float((solver.slot >= 0).sum())
        factor, solution = FACTOR_COST * unknowns**1.5, SOLUTION_COST * unknowns**1.5
    return float(effort[0] * evaluation + effort[1] * factor + effort[2] * solution)


def forced_tier() -> Tier | None:
    """Return the tier that the environment variable TISSUEC_TIER asks for, for tests."""
    asked = os.environ.get("TISSUEC_TIER", "")
    if asked not in ("", "interpreted", "compiled"):
        raise ValueError(f'TISSUEC_TIER is "{asked}", not "interpreted" or "compiled"')
    return cast(Tier, asked) if asked else None
