"""Lengths and resultants of springs, for what is observed of a run and for linear operators.

Shared arguments:
    ends: Node pair of each spring, shape (spring, 2).
    x: Positions [m], shape (state, 3 node).
    length: Lengths of the springs [m], shape (state, spring).
"""

from math import sqrt

from tissuec.kernels.records import Floats, Pairs, Rows
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


def add_resistance(
    ends: Pairs, direction: Rows, along: Floats, across: Floats, moved: Rows, force: Rows
) -> None:
    """Add a linear operator of springs on nodes, which resist along and across themselves.

    Args:
        direction: Unit vectors of the springs, shape (spring, 3).
        along: Per displacement along each, in any unit, shape (spring,).
        across: The same for all directions across it, shape (spring,), or (0,) for none.
        moved: Displacements of nodes, in any unit, shape (node, 3).
        force: Their images, added to, shape (node, 3).
    """
    for s in range(ends.shape[0]):
        i, j = int(ends[s, 0]), int(ends[s, 1])
        r0, r1, r2 = (
            moved[j, 0] - moved[i, 0],
            moved[j, 1] - moved[i, 1],
            moved[j, 2] - moved[i, 2],
        )
        u0, u1, u2 = direction[s, 0], direction[s, 1], direction[s, 2]
        part = r0 * u0 + r1 * u1 + r2 * u2
        pull, sideways = along[s] * part, 0.0
        if across.size > 0:
            sideways = across[s]
            pull -= sideways * part
        f0, f1, f2 = (
            pull * u0 + sideways * r0,
            pull * u1 + sideways * r1,
            pull * u2 + sideways * r2,
        )
        force[j, 0] += f0
        force[j, 1] += f1
        force[j, 2] += f2
        force[i, 0] -= f0
        force[i, 1] -= f1
        force[i, 2] -= f2
