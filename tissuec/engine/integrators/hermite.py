"""Hermite interpolation between both ends of a step.

Dense output for methods that have none of their own, and looks into a step of any method. With
a0, a1 the accelerations at the ends, mean = (v1 - v0) / h and rise = (x1 - x0) / h² - v0 / h,
positions are the quintic and velocities the cubic that have these values and rates at both
ends.
"""

import numpy as np

from tissuec.kernels.records import Floats, Net, Work
from tissuec.kernels.vectors import accumulate, between


def dense_x(rows: int, end: int) -> Floats:
    """Return positions as powers of the step's part, dimensionless weights, shape (5, row).

    Args:
        rows: Number of rows of ``Work.rows``; the last two contain mean and rise.
        end: The row of a1; that of a0 is 1.
    """
    table, mean, rise = np.zeros((5, rows)), rows - 2, rows - 1
    table[0, 0], table[1, 1] = 1.0, 0.5
    for power, weights in (
        (2, (-1.5, 10, -4, 0.5)),
        (3, (1.5, -15, 7, -1)),
        (4, (-0.5, 6, -3, 0.5)),
    ):
        table[power, [1, rise, mean, end]] = weights
    return table


def dense_v(rows: int, end: int) -> Floats:
    """Return velocities as powers of the step's part, dimensionless weights, shape (5, row).

    Args:
        rows: Number of rows of ``Work.rows``; the last two contain mean and rise.
        end: The row of a1; that of a0 is 1.
    """
    table, mean = np.zeros((5, rows)), rows - 2
    table[0, 1] = 1.0
    table[1, [1, mean, end]] = -2.0, 3.0, -1.0
    table[2, [1, mean, end]] = 1.0, -2.0, 1.0
    return table


def quintic(part: float) -> tuple[float, float, float, float, float, float]:
    """Return the weights of x0, x1, h v0, h v1, h² a0 and h² a1 in positions."""
    p, q = part, part * part
    rise = p * q * (10.0 - 15.0 * p + 6.0 * q)
    v0, v1 = p - p * q * (6.0 - 8.0 * p + 3.0 * q), -p * q * (4.0 - 7.0 * p + 3.0 * q)
    a0, a1 = 0.5 * q * (1.0 - 3.0 * p + 3.0 * q - p * q), 0.5 * p * q * (1.0 - 2.0 * p + q)
    return 1.0 - rise, rise, v0, v1, a0, a1


def cubic(part: float) -> tuple[float, float, float, float]:
    """Return the weights of v0, v1, h a0 and h a1 in velocities.

    These hold what springs remember as well, of which positions know nothing.
    """
    p, rest = part, 1.0 - part
    rise = p * p * (3.0 - 2.0 * p)
    return 1.0 - rise, rise, p * rest * rest, -p * p * rest


def prepare(time: float, end: float, current: int, work: Work, net: Net) -> None:
    """Fill the last two rows."""
    h, other = end - time, 1 - current
    last = work.rows.shape[0] - 1
    mean, rise = work.rows[last - 1], work.rows[last]
    between(work.v[current], work.v[other], 1.0 / h, mean)
    between(work.x[current], work.x[other], 1.0 / (h * h), rise)
    accumulate(-1.0 / h, work.v[current], rise)
    if net.ledger:
        for k in range(2):
            work.power[last - 1, k] = (work.ledger[other, k] - work.ledger[current, k]) / h
            work.power[last, k] = 0.0
