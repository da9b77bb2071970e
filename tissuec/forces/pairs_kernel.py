"""Forces of linear springs of nets without rows, a block of springs at a time.

Of each block, differences of positions and velocities are gathered first, from where they are;
what follows from them is then computed for many springs at once; and forces are added where
nodes are, one spring after the other. So only memory is accessed here and there, while roots
and quotients, which take longest, are done by vector instructions.

Shared arguments:
    start: First spring of the block.
    count: Number of springs of the block.
    x, v: Positions [m] and velocities [m/s] of all nodes, shape (3 node,).
    low, other: Three times the lower and the upper node of each spring, shape (spring,).
    reach0, reach1, reach2: Components of what leads from the lower node to the upper one [m],
        shape (block,).
    closing: Their product with the difference of velocities [m²/s], shape (block,).
    pull: Tensions over lengths [N/m], shape (block,).
"""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from tissuec.forces.runs_kernel import any_above, total
from tissuec.kernels.records import Floats, Net, Rows
from tissuec.kernels.vectors import TINY

VISCOUS = True  # springs have dashpots
WATCHED = True  # springs may break
BLOCK = 256  # springs at a time: what is between the loops stays in the nearest cache
#: See ``runs_kernel``. Of the other loops, LLVM would make gathering instructions, which most
#: processors do one number after the other.
UNSHARED = {"pull_many": ("closing", "pull", "above")}
ONE, TWO = np.uint64(1), np.uint64(2)  # unsigned, so that no index is tested


def pull_pairs(
    start: int, stop: int, x: Floats, v: Floats, f: Floats, each: Rows, net: Net
) -> tuple[float, bool]:
    """Add the forces of some springs.

    Args:
        start, stop: Range of springs, ``stop`` excluded.
        f: Forces on nodes, or slots of them, added to [N], shape (3 node,) or more.
        each: Scratch, shape (6 or more, block).

    Returns:
        The power that they dissipate [W], and whether one is near to breaking.
    """
    lost, near = 0.0, False
    reach0, reach1, reach2, closing = each[0], each[1], each[2], each[3]
    pull, above, low = each[4], each[5], net.chunks.low
    begin = start
    while begin < stop:
        size = min(BLOCK, stop - begin)
        first, count = np.uint64(begin), np.uint64(size)
        gather(first, count, x, v, low, net.other, reach0, reach1, reach2, closing)
        pull_many(
            first, count, net.stiffness, net.damping, net.rest, net.near, net.near_crush,
            reach0, reach1, reach2, closing, pull, above,
        )  # fmt: skip
        scatter(first, count, low, net.chunks.to, reach0, reach1, reach2, pull, f)
        if VISCOUS and net.ledger:
            lost += total(closing[:size])
        if WATCHED:
            near |= any_above(above[:size])
        begin += size
    return lost, near


def gather(
    start: np.uint64,
    count: np.uint64,
    x: Floats,
    v: Floats,
    low: NDArray[np.uint32],
    other: NDArray[np.uint32],
    reach0: Floats,
    reach1: Floats,
    reach2: Floats,
    closing: Floats,
) -> None:
    """Set what leads from the lower node of each spring to the upper one, and its closing."""
    for s in range(count):
        i, j = np.uint64(low[start + s]), np.uint64(other[start + s])
        r0, r1, r2 = x[j] - x[i], x[j + ONE] - x[i + ONE], x[j + TWO] - x[i + TWO]
        reach0[s], reach1[s], reach2[s] = r0, r1, r2
        if VISCOUS:
            closing[s] = (
                r0 * (v[j] - v[i])
                + r1 * (v[j + ONE] - v[i + ONE])
                + r2 * (v[j + TWO] - v[i + TWO])
            )


def pull_many(
    start: np.uint64,
    count: np.uint64,
    stiffness: Floats,
    damping: Floats,
    rest: Floats,
    near: Floats,
    near_crush: Floats,
    reach0: Floats,
    reach1: Floats,
    reach2: Floats,
    closing: Floats,
    pull: Floats,
    above: Floats,
) -> None:
    """Set what each spring pulls with, loses and exceeds.

    Args:
        stiffness, damping, rest: Of all springs [N/m], [N s/m], [m], shape (spring,).
        near, near_crush: Tension and compression that are near to breaking [N], shape
            (spring,).
        closing: Changed to the losses [W].
        above: Set to the excess over the limits [N], shape (block,).
    """
    for s in range(count):
        k = start + s
        length = sqrt(reach0[s] * reach0[s] + reach1[s] * reach1[s] + reach2[s] * reach2[s])
        inverse = 1.0 / (length + TINY)
        tension = stiffness[k] * (length - rest[k])
        if VISCOUS:
            speed = closing[s] * inverse
            braking = damping[k] * speed
            tension += braking
            closing[s] = braking * speed
        if WATCHED:
            above[s] = max(tension - near[k], -tension - near_crush[k])
        pull[s] = tension * inverse


def scatter(
    start: np.uint64,
    count: np.uint64,
    low: NDArray[np.uint32],
    to: NDArray[np.uint32],
    reach0: Floats,
    reach1: Floats,
    reach2: Floats,
    pull: Floats,
    f: Floats,
) -> None:
    """Add the forces of springs at their ends.

    Args:
        to: Three times the upper node of each spring, or its slot, shape (spring,).
        f: Forces [N], added to, shape (3 node,) or more.
    """
    for s in range(count):
        i, j = np.uint64(low[start + s]), np.uint64(to[start + s])
        p0, p1, p2 = pull[s] * reach0[s], pull[s] * reach1[s], pull[s] * reach2[s]
        f[i] += p0
        f[i + ONE] += p1
        f[i + TWO] += p2
        f[j] -= p0
        f[j + ONE] -= p1
        f[j + TWO] -= p2
