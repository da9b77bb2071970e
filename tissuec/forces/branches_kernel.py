"""Springs with memory, as scalar loops; for the equations see ``branches``.

Shared arguments:
    s: Index of the spring.
    e: Elongation of the spring [m].
    internal: Branches and flow of all springs.
"""

from math import copysign

from tissuec.kernels.records import Floats, Integers, InternalVariables


def flowed(s: int, v: Floats, internal: InternalVariables) -> float:
    """Return the flow of the rest length of a spring [m]."""
    k = internal.flow[s]
    if k < 0:
        return 0.0
    return float(v[internal.slot[k]] / internal.rate[k])


def pull_of_branches(s: int, e: float, v: Floats, internal: InternalVariables) -> float:
    """Return Σ c1 (e - q) of a spring of elongation e [N]."""
    total = 0.0
    for k in range(internal.first[s], internal.first[s + 1]):
        q = float(v[internal.slot[k]]) / internal.rate[k]
        total += internal.constant[k] * (e - q)
    return total


def give_way(s: int, e: float, pull: float, v: Floats, internal: InternalVariables) -> float:
    """Set the rates at which a spring relaxes and flows; return the power dissipated [W].

    Args:
        e: Its elongation [m].
        pull: Force of spring and branches [N].
    """
    lost = 0.0
    for k in range(internal.first[s], internal.first[s + 1]):
        q = float(v[internal.slot[k]]) / internal.rate[k]
        giving = (e - q) / internal.time[k]
        internal.change[k] = internal.rate[k] * giving
        lost += internal.constant[k] * (e - q) * giving
    k = internal.flow[s]
    if k >= 0:
        flowing = copysign(max(abs(pull) - internal.limit[s], 0.0), pull)
        flowing = flowing / internal.viscosity[s]
        internal.change[k] = internal.rate[k] * flowing
        lost += pull * flowing
    return lost


def remember(a: Floats, internal: InternalVariables) -> None:
    """Set the components of ``a`` that are rates of internal variables."""
    for k in range(internal.slot.size):
        a[internal.slot[k]] = internal.change[k]


def put_home(x: Floats, nodes: Integers, home: Floats) -> None:
    """Set the nodes that store internal variables to their fixed positions.

    Args:
        x: Positions of all nodes [m], flat, shape (3 node,).
        nodes: These nodes, shape (m,).
        home: Their positions [m], shape (m, 3).
    """
    for k in range(nodes.size):
        i = 3 * nodes[k]
        for c in range(3):
            x[i + c] = home[k, c]
