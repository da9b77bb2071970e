"""Rest lengths that change in time, as scalar loops; see ``rest_length``.

Shared arguments:
    k: Index of the spring among those whose rest lengths change.
    rest: Rest lengths [m], shape (spring,).
    reels: Springs whose rest lengths change.
    acts: Profiles of the changes.
"""

from tissuec.kernels.boundary_conditions import total
from tissuec.kernels.records import BoundaryConditions, Floats, RestLengthActuators


def reel(
    time: float, rest: Floats, reels: RestLengthActuators, acts: BoundaryConditions
) -> None:
    """Set the rest lengths that change in time [m]."""
    for k in range(reels.spring.size):
        factor, _, _, _, _, _ = total(reels.act[k], time, acts)
        rest[reels.spring[k]] = reels.base[k] + factor * reels.change[k]


def reel_rate(
    k: int, time: float, reels: RestLengthActuators, acts: BoundaryConditions
) -> float:
    """Return the rate of the rest length of one spring [m/s]."""
    _, _, _, rate, _, _ = total(reels.act[k], time, acts)
    return rate * reels.change[k]
