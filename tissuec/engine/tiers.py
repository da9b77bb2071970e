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
from tissuec.kernels.records import Buffer, Progress, Task, Work
from tissuec.laws import Law, code

# Interpreted work to come for which the compiled tier is worth its start [s]. That start takes
# 0.6 s with kernels from the cache, and 5 s on a machine that has never compiled them.
WORTHWHILE = 2.0
REVIEW = 0.25  # interpreted work between two looks at how much is to come [s]
CALL_COST = 25e-6  # of one interpreted evaluation with its share of the step [s]
SPRING_COST = 30e-9  # further, per spring [s]
TOUCH_COST = 3e-4  # of one look at all contacts [s]
PAIR_COST = 1e-6  # further, per node and shape [s]
JET_COST = 4e-3  # of one look at a jet on some hundred triangles [s]
# Operations that the compiled tier takes from ``scalar`` instead of ``vector``.
OPERATIONS = (
    "accumulate",
    "add_rows",
    "between",
    "blended_error",
    "combine",
    "copy_sample",
    "bend_of_passed",
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
    "quintic",
    "recall",
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
        # Hardly slower, and a second variant is not compiled when something begins to move.
        features = replace(features, moved=True, loaded=True)
    replaced = _replaced(integrator, features)
    if tier == "interpreted":
        return cast(Drive, Binder(replaced).bind(loop.drive))
    solving = banded if features.banded else iterative
    replaced |= {name: getattr(scalar, name) for name in OPERATIONS}
    replaced |= {name: getattr(solving, name) for name in SOLVING}
    return cast(Drive, Binder(replaced, (*OPERATIONS, *SOLVING, *PARTS)).bind(loop.drive))


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


def evaluation_cost(spring_count: int, pairs: int, jets: int) -> float:
    """Return the time of one interpreted evaluation of the forces [s].

    Args:
        pairs: Of nodes and shapes that may touch.
        jets: How many there are.
    """
    contact = TOUCH_COST + PAIR_COST * pairs if pairs else 0.0
    return CALL_COST + SPRING_COST * spring_count + contact + JET_COST * jets


def forced_tier() -> Tier | None:
    """Return the tier that the environment variable TISSUEC_TIER asks for, for tests."""
    asked = os.environ.get("TISSUEC_TIER", "")
    if asked not in ("", "interpreted", "compiled"):
        raise ValueError(f'TISSUEC_TIER is "{asked}", not "interpreted" or "compiled"')
    return cast(Tier, asked) if asked else None
