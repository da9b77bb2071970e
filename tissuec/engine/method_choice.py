"""The automatic choice of an integrator, by measured facts of the scene and a reason in words.

The higher the order, the finer the tolerance from which a method needs the fewest force
evaluations, and the shorter the steps that are stable: 2, 1.15 and .5 radians of the fastest
motion for each evaluation of velocity Verlet, RKN4 and DOP853. On tubes, lattices and chains
the first and the last cross near the tolerance ``COARSE``, RKN4 and DOP853 near ``FINE``, or
``FINER`` where stability limits the steps.
"""

from collections.abc import Callable, Mapping
from math import inf, sqrt

import numpy as np
from msgspec import Struct

from tissuec.core.structs import replace
from tissuec.engine.integrators import INTEGRATORS
from tissuec.engine.method import Method
from tissuec.engine.stability import (
    SumsAtNodes,
    damping_radius,
    damping_ratio,
    may_be_overdamped,
    spectral_radius,
    sums_at_nodes,
)
from tissuec.mechanics.state import State
from tissuec.script.plan import AUTOMATIC, DEFAULT_TOLERANCE

COARSE, FINE, FINER = 2e-2, 1e-5, 1e-6
# Damping ratio of the fastest motion up to which steps of RKN4 are stable for longer, and
# springs from which what a step costs beside its three evaluations hardly counts.
BRISK, LARGE = 0.5, 5000
# Radians of the fastest motion from which errors that grow in proportion to time, instead of
# faster, make up for the shorter steps of the symplectic method.
LONG = 1e4
# Radians of the fastest motion below which accuracy limits the steps of large nets even at
# coarse tolerances; in longer runs, stability does even at fine ones.
BRIEF = 1e3
CREEPING = 4.0  # damping ratio from which implicit steps are worth beginning with
MANY = 1000  # explicit steps at their limit from which they are
# Steps that overdamped motions commonly take: measured were 13 to 230, and 3900 to 44000; these
# are their geometric means.
COMMON = {"esdirk43": 55.0, "rkc2": 13000.0}


class MethodChoice(Struct, frozen=True):
    """An integrator and why.

    Attributes:
        name: A member of ``INTEGRATORS``.
        reason: One sentence.
        facts: "omega" and "damping" [1/s], "zeta", "limit" [s] of the chosen one, where they
            were needed.
    """

    name: str
    reason: str
    facts: Mapping[str, float]


def measured_facts(state: State) -> dict[str, float]:
    """Return ω̂ and λ̂ [1/s] and the damping ratio ζ̂ = λ̂ / 2ω̂ of the fastest motion."""
    omega, damping = spectral_radius(state), damping_radius(state)
    return {
        "omega": omega,
        "damping": damping,
        "zeta": damping_ratio(omega, damping),
    }


def choose(
    state: State,
    method: Method,
    is_direct: Callable[[], bool],
    implicit_step: Callable[[], float] = lambda: inf,
) -> MethodChoice:
    """Return the integrator for a scene; the one requested by name, if any.

    Args:
        state: State at the start.
        method: The method that the scene requests.
        is_direct: Returns whether the matrix of implicit steps has a factor of acceptable
            size.
        implicit_step: Returns the predicted time of a step of ``esdirk43``, over that of a
            force evaluation.
    """
    measured: dict[str, float] = {}

    def facts() -> dict[str, float]:
        if not measured:
            measured.update(measured_facts(state))
        return measured

    def creeping(sums: SumsAtNodes) -> MethodChoice | None:
        return _creeping(state, sums, method, is_direct, implicit_step, facts)

    choice = _chosen(state, method, creeping, facts)
    return choice if choice.facts else replace(choice, facts=measured)


def _chosen(
    state: State,
    method: Method,
    creeping: Callable[[SumsAtNodes], MethodChoice | None],
    facts: Callable[[], dict[str, float]],
) -> MethodChoice:
    """Return the integrator; see ``choose``.

    Args:
        creeping: Returns a method for motions that mostly creep, if this net needs one.
        facts: Returns what ``measured_facts`` does, which takes time in large nets.
    """
    if method.name != AUTOMATIC:
        return MethodChoice(method.name, f'"{method.name}" was requested', {})
    if method.step is not None:
        return _by_step(facts(), method.step)
    tolerance = DEFAULT_TOLERANCE if method.tolerance is None else method.tolerance
    sums = sums_at_nodes(state)
    if tolerance < COARSE and not state.loss and _may_sweep(state, sums, method.duration):
        swept = facts()["omega"] * method.duration
        if swept > LONG:
            reason = (
                f"nothing damps the motion, through {swept:.2g} radians: errors of a "
                "symplectic method grow in proportion to time only"
            )
            return MethodChoice("srkn11", reason, facts())
    if (found := creeping(sums)) is not None:
        return found
    is_large = np.count_nonzero(state.alive_lines) >= LARGE
    is_brief = sums.fastest * method.duration < BRIEF
    if tolerance < COARSE or (is_large and is_brief and sums.most_damped <= BRISK):
        finest = (FINE if is_brief else FINER) if is_large else inf
        return _of_higher_order(sums, tolerance, finest)
    if may_be_overdamped(state, sums, 1.0) and facts()["zeta"] > 1.0:
        reason = (
            f"the fastest motion is overdamped (ratio {facts()['zeta']:.2g}), "
            "so velocity Verlet would need very small steps"
        )
        return MethodChoice("dop853", reason, facts())
    reason = f"for a tolerance of {tolerance:g}, order 2 with one force per step is cheapest"
    return MethodChoice("velocity verlet", reason, {})


def _of_higher_order(sums: SumsAtNodes, tolerance: float, finest: float) -> MethodChoice:
    """Return order 4 down to the finest tolerance for it, else order 8."""
    if tolerance < finest:
        reason = (
            f"a tolerance of {tolerance:g} is finer than {COARSE:g}, "
            "where order 8 needs fewer force evaluations than order 2"
        )
        return MethodChoice("dop853", reason, {})
    if sums.most_damped > BRISK:
        reason = (
            f"damping limits the steps (ratio about {sums.most_damped:.2g}), "
            "and those of DOP853 may be the longest"
        )
        return MethodChoice("dop853", reason, {})
    reason = (
        f"for a large net and a tolerance of {tolerance:g}, "
        "order 4 with long stable steps needs the fewest force evaluations"
    )
    return MethodChoice("rkn4", reason, {})


def _may_sweep(state: State, sums: SumsAtNodes, duration: float) -> bool:
    """Return whether the fastest motion may turn by more than ``LONG`` in a time [s]."""
    only_springs = not state.fields and not state.springs.law.any()
    return not only_springs or sums.fastest * duration > LONG


def _creeping(
    state: State,
    sums: SumsAtNodes,
    method: Method,
    is_direct: Callable[[], bool],
    implicit_step: Callable[[], float],
    measure: Callable[[], dict[str, float]],
) -> MethodChoice | None:
    """Return a method for a net so damped that it mostly creeps, else None.

    It is an implicit one if its matrix has a factor; for nets of springs without further tests,
    whereas with viscous elements a stabilised method may cost less. The rates are measured only
    where sums at the nodes allow it.
    """
    in_springs = sums.most_damped >= CREEPING
    in_effects = any(effect.braking(state.position) is not None for effect in state.effects)
    if not (in_springs or in_effects):
        return None
    facts = measure()
    limit = INTEGRATORS["dop853"].stability_limit(facts["omega"], facts["zeta"])
    if facts["zeta"] < CREEPING or method.duration < MANY * limit:
        return None
    ratio = f"the fastest motion is overdamped (ratio {facts['zeta']:.2g})"
    if is_direct() and (in_springs or _is_cheaper(facts, method.duration, implicit_step())):
        reason = (
            f"{ratio}, and explicit steps of at most {limit:.2g} s would be needed for slow "
            "motions"
        )
        return MethodChoice("esdirk43", reason, facts)
    if not in_effects:
        return None
    reason = f"{ratio}; steps of other explicit methods are at most {limit:.2g} s"
    return MethodChoice("rkc2", reason, facts)


def _is_cheaper(facts: Mapping[str, float], duration: float, implicit_step: float) -> bool:
    """Return whether implicit steps are expected to cost less than those of ``rkc2``.

    Both are assumed to take the number of steps that such motions commonly need, ``rkc2`` at
    least that of its longest stable steps; s stages of it are stable for 0.65 s² over the
    fastest rate.

    Args:
        facts: Of ``measured_facts``.
        duration: Of the run [s].
        implicit_step: Predicted time of a step of ``esdirk43``, over that of an evaluation.
    """
    fastest = 2.0 * facts["zeta"] * facts["omega"]
    longest = INTEGRATORS["rkc2"].stability_limit(facts["omega"], facts["zeta"])
    steps = max(COMMON["rkc2"], duration / longest)
    stages = sqrt(steps * duration * fastest / 0.65)
    return COMMON["esdirk43"] * implicit_step < stages


def _by_step(facts: Mapping[str, float], step: float) -> MethodChoice:
    """Return an integrator that is stable at a given step, the cheapest of several."""
    limit = INTEGRATORS["velocity verlet"].stability_limit(facts["omega"], facts["zeta"])
    if step <= 0.9 * limit:
        reason = f"a step of {step:g} s is well below its stability limit of {limit:.3g} s"
        return MethodChoice("velocity verlet", reason, {**facts, "limit": limit})
    wider = INTEGRATORS["dop853"].stability_limit(facts["omega"], facts["zeta"])
    reason = (
        f"a step of {step:g} s is near or above the stability limit of velocity Verlet "
        f"({limit:.3g} s); that of DOP853 is {wider:.3g} s"
    )
    return MethodChoice("dop853", reason, {**facts, "limit": wider})
