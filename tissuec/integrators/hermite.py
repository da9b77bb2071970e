"""Dense output through both ends of a step, for methods that have none of their own.

With a0, a1 the accelerations at the ends, mean = (v1 - v0) / h and
rise = (x1 - x0) / h² - v0 / h, positions are the quintic and velocities the cubic that have
these values and rates at both ends.
"""

import numpy as np

from tissuec.kernels.records import Floats, Work
from tissuec.kernels.scalar import LEDGER
from tissuec.kernels.vector import between


def dense_x(rows: int, end: int) -> Floats:
    """Return positions as powers of the step's part, shape (5, row).

    Args:
        rows: Of ``Work.rows``; the last two hold mean and rise.
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
    """Return velocities as powers of the step's part, shape (5, row)."""
    table, mean = np.zeros((5, rows)), rows - 2
    table[0, 1] = 1.0
    table[1, [1, mean, end]] = -2.0, 3.0, -1.0
    table[2, [1, mean, end]] = 1.0, -2.0, 1.0
    return table


def prepare(time: float, end: float, current: int, work: Work, net: object) -> None:
    """Fill the last two rows."""
    h, other = end - time, 1 - current
    last = work.rows.shape[0] - 1
    mean, rise = work.rows[last - 1], work.rows[last]
    between(work.v[current], work.v[other], 1.0 / h, work.zero, mean)
    between(work.x[current], work.x[other], 1.0 / (h * h), work.rows[0], rise)
    if LEDGER:
        for k in range(2):
            work.power[last - 1, k] = (work.ledger[other, k] - work.ledger[current, k]) / h
            work.power[last, k] = 0.0
