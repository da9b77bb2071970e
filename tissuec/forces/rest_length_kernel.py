"""Rest lengths that change in time, as scalar loops; why they do stands in ``threads``."""

from tissuec.kernels.boundary_conditions import total
from tissuec.kernels.records import BoundaryConditions, Floats, RestLengthActuators


def reel(
    time: float, rest: Floats, reels: RestLengthActuators, acts: BoundaryConditions
) -> None:
    """Set the rest lengths of the springs that are drawn in or paid out [m]."""
    for k in range(reels.spring.size):
        factor, _, _, _, _, _ = total(reels.act[k], time, acts)
        rest[reels.spring[k]] = reels.base[k] + factor * reels.change[k]


def reel_rate(
    k: int, time: float, reels: RestLengthActuators, acts: BoundaryConditions
) -> float:
    """Return how fast the rest length of one of them changes [m/s]."""
    _, _, _, rate, _, _ = total(reels.act[k], time, acts)
    return rate * reels.change[k]
