"""The two tiers: interpreted on NumPy, ready at once, or compiled by Numba, much faster.

Which one steps is decided by the numbers of force evaluations so far and to come, never by a
clock, so that a run gives the same bytes again. The constants of the cost model were measured.
"""

import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from inspect import getmembers, isfunction
from typing import Any, cast

from tissuec.engine import drive as loop
from tissuec.engine.binding import Binder
from tissuec.engine.method import Tier
from tissuec.integrators import Integrator
from tissuec.kernels import banded, iterative, scalar
from tissuec.kernels.records import Integers, Operations, Progress, Solver, Task
from tissuec.laws import LINEAR, Law, code

# Interpreted work to come for which the compiled tier is worth its start [s]. That start takes
# 0.6 s with everything from the cache. On a machine that has never compiled it, the loop of a
# method takes 8 s, forces of springs 1 s more, with contact 4 s.
WORTHWHILE, TOUCHED_WORTHWHILE, RINSED_WORTHWHILE = 2.0, 4.0, 2.0
REVIEW = 0.25  # interpreted work between two looks at how much is to come [s]
CALL_COST = 25e-6  # of one interpreted evaluation with its share of the step [s]
SPRING_COST = 30e-9  # further, per spring [s]
TOUCH_COST = 1.6e-4  # of one look at all contacts [s]
PAIR_COST = 3.5e-7  # further, per pair that is near [s]
RUBBED = 2.7  # times that with friction
FOLD_COST = 1.2e-4  # of one look at all hinges [s]
HINGE_COST = 9e-7  # further, per hinge [s]
JET_COST = 4e-3  # of one look at a jet on some hundred triangles [s]
# Of the matrix of an implicit step: of a factor in a band of width b, n b² times this, and of a
# sparse one, n^1.5 times; the same of solving, with n b and n^1.5. [s]
BAND_FACTOR_COST, BAND_SOLUTION_COST = 1e-9, 4e-9
FACTOR_COST, SOLUTION_COST = 6e-7, 1.5e-8
# Operations on nets that only some scenes need.
NEEDED = {
    "bend_of_passed": "cornered",
    "blow": "rinsed",
    "find_sides": "cornered",
    "fold": "folded",
    "kinetic": "ledger",
    "peaks": "watched",
    "press": "enclosed",
    "tension": "watched",
    "touch": "touched",
}
# Of the operations that others call.
FORCES = ("springs", "press", "fold", "touch", "blow")
LAWS = tuple(code.functions((LINEAR,)))


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
    folded: bool = False
    reeled: bool = False
    touched: bool = False
    rinsed: bool = False
    inelastic: bool = False
    cornered: bool = False
    laws: tuple[Law, ...] = ()  # the linear one and others, if there are others

    @property
    def straight(self) -> bool:
        """Return whether all springs are linear and forget everything."""
        return not (self.laws or self.inelastic)


@dataclass(frozen=True, slots=True)
class Inside:
    """Interpreted code that evaluates an accepted step inside."""

    look: Callable[..., None]
    prepare: Callable[..., None]


Drive = Callable[[Progress, Task, Any, Any, Any], tuple[int, Progress]]


@cache
def bound_drive(integrator: type[Integrator], tier: Tier) -> Drive:
    """Return the loop over steps of an integrator; compiled, it takes records as ``Native``."""
    binder = _for_method(integrator) if tier == "compiled" else Binder(_method(integrator))
    return cast(Drive, binder.bind(loop.drive))


@cache
def loop_operations(integrator: type[Integrator], features: Features) -> Operations:
    """Return where the compiled operations are that the loop calls for a net."""
    return operations(_for_method(integrator).names(loop.drive), features)


@cache
def operations(names: frozenset[str], features: Features) -> Operations:
    """Return where some compiled operations are, and those that they call, for a scene."""
    names = names & set(Operations._fields) | set(FORCES)
    needed = {name for name in names if name not in NEEDED or getattr(features, NEEDED[name])}
    if not features.straight:
        needed |= set(LAWS)
    return Operations(**{name: _operation(name, features) for name in sorted(needed)})


@cache
def _for_method(integrator: type[Integrator]) -> Binder:
    """Return what compiles the loop over steps of an integrator."""
    # On vectors those of ``scalar``, instead of ``vector``; on nets those that the net names.
    replaced = _method(integrator) | dict(getmembers(scalar, isfunction))
    return Binder(replaced | _callers(*Operations._fields), compiled=True)


def _operation(name: str, features: Features) -> int:
    """Return the address of an operation on nets, compiled for what a scene needs."""
    from tissuec.engine import native

    if name == "springs" and features.straight:
        binder = _of_springs(features.viscous, features.watched)
    else:
        binder = _on_nets()
    return native.address_of(binder.bind(implementation(name, features), "linked"), name)


def implementation(name: str, features: Features) -> Callable[..., Any]:
    """Return the function that is an operation on nets for what a scene needs."""
    if name in LAWS:
        return code.functions(features.laws or (LINEAR,))[name]
    if name == "springs" and not features.straight:
        return scalar.springs_of_laws
    if name in ("assemble", "solve"):
        return getattr(banded if features.banded else iterative, name)
    return getattr(scalar, name)


def _callers(*names: str) -> dict[str, Any]:
    """Return what calls operations of the net, in compiled code."""
    from tissuec.engine import native

    return {name: native.caller(name) for name in names}


@cache
def _on_nets() -> Binder:
    """Return what compiles operations; they call forces and laws of the net."""
    return Binder(_callers(*FORCES, *LAWS), compiled=True)


@cache
def _of_springs(viscous: bool, watched: bool) -> Binder:
    """Return what compiles the forces of linear springs."""
    return Binder({"VISCOUS": viscous, "WATCHED": watched}, compiled=True)


@cache
def bound_inside(integrator: type[Integrator]) -> Inside:
    """Return what looks into the steps of an integrator."""
    binder = Binder(_method(integrator))
    return Inside(look=binder.bind(loop.look), prepare=binder.bind(integrator.prepare))


def _method(integrator: type[Integrator]) -> dict[str, Any]:
    """Return what the names in the stepping code mean for an integrator."""
    functions = ("step", "estimate", "book", "finish", "prepare", "propose")
    numbers = ("end_row", "looks", "control_order", "safety", "implicit")
    replaced = {name: getattr(integrator, name) for name in functions}
    return replaced | {name.upper(): getattr(integrator, name) for name in numbers}


def plain_operations(features: Features) -> dict[str, Any]:
    """Return what the names of operations mean in Python, for what a scene needs."""
    names = {name: implementation(name, features) for name in Operations._fields}
    return names | {"VISCOUS": features.viscous, "WATCHED": features.watched}


def evaluation_cost(
    springs: int, pairs: int | None, rubbed: bool, jets: int, hinges: int
) -> float:
    """Return the time of one interpreted evaluation of the forces [s].

    Args:
        springs: How many there are.
        pairs: Of nodes and shapes that are near, None where nothing touches.
        rubbed: Whether there is friction.
        jets, hinges: How many there are.
    """
    contact = 0.0 if pairs is None else TOUCH_COST + PAIR_COST * pairs
    contact *= RUBBED if rubbed else 1.0
    bending = FOLD_COST + HINGE_COST * hinges if hinges else 0.0
    return CALL_COST + SPRING_COST * springs + contact + JET_COST * jets + bending


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
