"""Lengths and resultants of springs in many states at once, for what is observed of a run.

Shared arguments:
    ends: Node pair of each spring, shape (spring, 2).
    x: Positions [m], shape (state, 3 node).
    length: Lengths of the springs [m], shape (state, spring).
"""

from math import sqrt

from tissuec.kernels.records import Pairs, Rows
from tissuec.kernels.vectors import TINY


def measure(ends: Pairs, x: Rows, v: Rows, length: Rows, closing: Rows) -> None:
    """Set the lengths of springs, and the rates at which they lengthen.

    Args:
        v: Velocities [m/s], shape as ``x``.
        closing: Rates [m/s], shape as ``length``; of shape (state, 0), nothing is set.
    """
    moves = closing.shape[1] > 0
    for state in range(x.shape[0]):
        for s in range(ends.shape[0]):
            i, j = 3 * int(ends[s, 0]), 3 * int(ends[s, 1])
            r0 = x[state, j] - x[state, i]
            r1 = x[state, j + 1] - x[state, i + 1]
            r2 = x[state, j + 2] - x[state, i + 2]
            long = sqrt(r0 * r0 + r1 * r1 + r2 * r2)
            length[state, s] = long
            if moves:
                closing[state, s] = (
                    r0 * (v[state, j] - v[state, i])
                    + r1 * (v[state, j + 1] - v[state, i + 1])
                    + r2 * (v[state, j + 2] - v[state, i + 2])
                ) / (long + TINY)


def add_pulls(ends: Pairs, x: Rows, length: Rows, tension: Rows, force: Rows) -> None:
    """Add what springs pull at their ends, one spring after the other.

    Args:
        tension: Tensions, zero where a spring has no length [N], shape as ``length``.
        force: Forces on the nodes, added to [N], shape as ``x``.
    """
    for state in range(x.shape[0]):
        for s in range(ends.shape[0]):
            i, j = 3 * int(ends[s, 0]), 3 * int(ends[s, 1])
            part = tension[state, s] / (length[state, s] + TINY)
            for k in range(3):
                pull = part * (x[state, j + k] - x[state, i + k])
                force[state, i + k] += pull
                force[state, j + k] -= pull
