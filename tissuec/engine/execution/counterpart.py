"""The method of a companion run: one of another kind than those of the run.

A fault of a method, such as a force that its steps lose, shows in no finer step of the same
method. So an explicit method is compared with one of another order or with an implicit one, and
an implicit method with an explicit one.
"""

from collections.abc import Collection

import numpy as np

from tissuec.engine.integrators import INTEGRATORS
from tissuec.engine.method import Statistics
from tissuec.model.network import Network
from tissuec.script.plan import STATIC, Plan, Simulation

IMPLICIT = "implicit"
COARSE = 1e-6  # tolerance down to which steps of order 2 are not too many
#: How many times the predicted cost of the run its companion may have, and what it may always
#: cost [s]. That is less than what starting a process takes.
MOST, LEAST = 4.0, 0.1


def kind_of(method: str) -> str:
    """Return the kind of a method: methods of one kind share code."""
    if method in STATIC:
        return method
    return IMPLICIT if INTEGRATORS[method].implicit else method


def is_another(method: str, used: Collection[str]) -> bool:
    """Return whether a method, if there is one, is of another kind than those of a run."""
    return method != "" and kind_of(method) not in map(kind_of, used)


def counterpart(ran: Statistics, network: Network, plan: Plan) -> str:
    """Return a method of another kind than all that stepped a run.

    Args:
        ran: What the run did.
        network: Of the run.
        plan: Likewise.

    Returns:
        A member of ``INTEGRATORS``; "" if there is none, and where the steps of the run are
        fixed: these promise nothing.
    """
    if plan.simulation.step is not None:
        return ""
    used = {change.method for change in ran.changes}
    longest = _longest(ran, plan)
    candidates = _candidates(longest, network, plan.simulation) if longest else ()
    return next((name for name in candidates if is_another(name, used)), "")


def _longest(ran: Statistics, plan: Plan) -> str:
    """Return the method that stepped the largest part of a run."""
    times = [change.time for change in ran.changes] + [plan.simulation.duration]
    share: dict[str, float] = {}
    for change, lasted in zip(ran.changes, np.diff(times), strict=True):
        if change.method not in STATIC:
            share[change.method] = share.get(change.method, 0.0) + float(lasted)
    return max(share, key=lambda name: share[name], default="")


def _candidates(method: str, network: Network, simulation: Simulation) -> tuple[str, ...]:
    """Return the methods that one may be compared with, the cheapest first."""
    others = "dop853", "rkn4", "velocity verlet", "rkc2"
    if INTEGRATORS[method].implicit:
        is_coarse = (simulation.tolerance or 1.0) >= COARSE
        return ("rkc2", *others) if is_coarse and _is_overdamped(network) else others
    if method == "rkc2":
        # For elements, other explicit methods need the short steps that this one avoids.
        return ("esdirk43",) if network.elements else ("esdirk43", *others)
    return ("rkn4", *others) if method == "dop853" else others


def _is_overdamped(network: Network) -> bool:
    """Return whether dashpots and not springs set the fastest rate, at the worst node.

    Elements with viscosity are assumed to be overdamped: the smallest ones usually are.
    """
    if any(each.viscosity.any() for each in network.elements):
        return True
    stiff, viscous = (
        np.bincount(network.springs.ends.ravel(), np.repeat(of, 2), network.node_count)
        for of in (network.springs.stiffness, network.springs.damping)
    )
    return bool((viscous**2 > 4.0 * stiff * network.mass).any())


def foreseen(method: str, ran: Statistics, tolerance: float, finer: float) -> float:
    """Return how many times as long as a run a method takes, by orders; 1 if unknown.

    The number of steps grows as the tolerance to the power of minus one over the order. Where
    stability limits the steps, it grows less.

    Args:
        method: Of the companion.
        ran: What the run did.
        tolerance: Of the run.
        finer: How many times as fine the tolerance of the companion is.
    """
    one, two = INTEGRATORS[ran.method], INTEGRATORS[method]
    if one.implicit or two.implicit or one.stabilised or two.stabilised:
        return 1.0
    theirs = two.evaluations * (tolerance / finer) ** (-1.0 / two.order)
    return theirs / (one.evaluations * tolerance ** (-1.0 / one.order))
