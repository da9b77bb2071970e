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
    return float(v[internal.slot[k]] * internal.scale[k]) if k >= 0 else 0.0


def relax(s: int, e: float, v: Floats, internal: InternalVariables) -> tuple[float, float]:
    """Set the rates at which the branches of a spring relax.

    Rates are scratch, which each evaluation of the forces sets for all springs.

    Args:
        e: Its elongation [m].

    Returns:
        Σ c1 (e - q) [N], and the power that is dissipated [W].
    """
    total, lost = 0.0, 0.0
    for k in range(internal.first[s], internal.first[s + 1]):
        q = float(v[internal.slot[k]]) * internal.scale[k]
        giving = (e - q) * internal.pace[k]
        internal.change[k] = internal.rate[k] * giving
        pull = internal.constant[k] * (e - q)
        total += pull
        lost += pull * giving
    return total, lost


def flow(s: int, pull: float, internal: InternalVariables) -> float:
    """Set the rate at which a spring flows; return the power that is dissipated [W].

    Args:
        pull: Force of spring and branches [N].
    """
    k = internal.flow[s]
    if k < 0:
        return 0.0
    flowing = copysign(max(abs(pull) - internal.limit[s], 0.0), pull) / internal.viscosity[s]
    internal.change[k] = internal.rate[k] * flowing
    return float(pull * flowing)


def remember(a: Floats, internal: InternalVariables) -> None:
    """Set the components of ``a`` that are rates of internal variables."""
    for k in range(internal.slot.size):
        a[internal.slot[k]] = internal.change[k]


def keep_still(x: Floats, rows: Integers) -> None:
    """Keep the places of internal variables at 0, whose velocities alone mean something.

    Args:
        rows: Their places, shape (m,).
    """
    for k in range(rows.size):
        i = 3 * rows[k]
        for c in range(3):
            x[i + c] = 0.0
