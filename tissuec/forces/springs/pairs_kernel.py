"""Forces of linear springs of nets without rows, a block of springs at a time.

Vectors of nodes get a fourth number first, which is zero: vector instructions then take one
node at a time. Of each block, differences of positions and velocities are gathered, from where
they are; what follows from them is then computed for many springs at once; and forces are added
where nodes are, one spring after the other.

Shared arguments:
    start: First spring of the block.
    count: Number of springs of the block.
    low: Four times the lower node of each spring, shape (spring,).
    reach: What leads from lower nodes to upper ones [m], shape (4 block,).
    speed: Differences of their velocities [m/s], shape (4 block,).
    pull: Tensions over lengths [N/m], shape (block,).
"""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from tissuec.forces.springs.runs_kernel import any_above, total
from tissuec.kernels.records import Floats, Net
from tissuec.kernels.thread_loops import part_of
from tissuec.kernels.vectors import TINY

VISCOUS = True  # springs have dashpots
WATCHED = True  # springs may break
BLOCK = 256  # springs at a time: what is between the loops stays in the nearest cache
ROOM = 11 * BLOCK  # numbers of scratch
MOST = np.uint64(BLOCK)
#: See ``runs_kernel``.
UNSHARED = {"pull_many": ("lost", "pull", "above")}
ONE, TWO, THREE, FOUR = (np.uint64(k) for k in range(1, 5))  # so that no index is tested


def pad_states(part: int, parts: int, x: Floats, v: Floats, states: Floats) -> None:
    """Copy positions and velocities of a part of the nodes, with fourth numbers.

    Args:
        part: Index of this thread's share.
        parts: Number of shares.
        x, v: Positions [m] and velocities [m/s] of all nodes, shape (3 node,).
        states: Changed, see ``Chunks``, shape (8 node,).
    """
    nodes = x.size // 3
    first, last = part_of(part, parts, nodes)
    pad(x[3 * first : 3 * last], states[4 * first :])
    if VISCOUS:
        pad(v[3 * first : 3 * last], states[4 * (nodes + first) :])


def pad(vector: Floats, out: Floats) -> None:
    """Copy a vector of nodes, with fourth numbers.

    Args:
        vector: In any unit, shape (3 node,).
        out: Changed, shape (4 node,) or more.
    """
    for node in range(vector.size // 3):
        i, k = THREE * np.uint64(node), FOUR * np.uint64(node)
        out[k], out[k + ONE], out[k + TWO] = vector[i], vector[i + ONE], vector[i + TWO]
        out[k + THREE] = 0.0


def pull_pairs(start: np.uint64, stop: np.uint64, each: Floats, net: Net) -> tuple[float, bool]:
    """Add the forces of some springs to the sums of their chunk.

    Args:
        start, stop: Range of springs, ``stop`` excluded.
        each: Scratch, shape (ROOM,).

    Returns:
        The power that they dissipate [W], and whether one is near to breaking.
    """
    chunks, all_lost, near = net.chunks, 0.0, False
    reach, speed, pull = each[: 4 * BLOCK], each[4 * BLOCK : 8 * BLOCK], each[8 * BLOCK :]
    lost, above = each[9 * BLOCK :], each[10 * BLOCK :]
    begin, half = start, chunks.states.size // 2
    x, v = chunks.states[:half], chunks.states[half:]
    while begin < stop:
        count = min(MOST, stop - begin)
        gather(begin, count, chunks.low, chunks.high, x, v, reach, speed)
        pull_many(
            begin, count, net.stiffness, net.damping, net.rest, net.near, net.near_crush,
            reach, speed, pull, lost, above,
        )  # fmt: skip
        scatter(begin, count, chunks.low, chunks.to, reach, pull, chunks.sums)
        if VISCOUS and net.ledger:
            all_lost += total(lost[:count])
        if WATCHED:
            near |= any_above(above[:count])
        begin += count
    return all_lost, near


def gather(
    start: np.uint64,
    count: np.uint64,
    low: NDArray[np.uint32],
    high: NDArray[np.uint32],
    x: Floats,
    v: Floats,
    reach: Floats,
    speed: Floats,
) -> None:
    """Set what leads from the lower node of each spring to the upper one, and its rate.

    Args:
        high: Four times the upper node of each spring, shape (spring,).
        x, v: Positions [m] and velocities [m/s] with fourth numbers, shape (4 node,).
    """
    for s in range(count):
        # All is read before anything is set, which lets the compiler use vector instructions.
        i, j, k = np.uint64(low[start + s]), np.uint64(high[start + s]), FOUR * s
        r0, r1 = x[j] - x[i], x[j + ONE] - x[i + ONE]
        r2, r3 = x[j + TWO] - x[i + TWO], x[j + THREE] - x[i + THREE]
        if VISCOUS:
            w0, w1 = v[j] - v[i], v[j + ONE] - v[i + ONE]
            w2, w3 = v[j + TWO] - v[i + TWO], v[j + THREE] - v[i + THREE]
            speed[k], speed[k + ONE], speed[k + TWO], speed[k + THREE] = w0, w1, w2, w3
        reach[k], reach[k + ONE], reach[k + TWO], reach[k + THREE] = r0, r1, r2, r3


def pull_many(
    start: np.uint64,
    count: np.uint64,
    stiffness: Floats,
    damping: Floats,
    rest: Floats,
    near: Floats,
    near_crush: Floats,
    reach: Floats,
    speed: Floats,
    pull: Floats,
    lost: Floats,
    above: Floats,
) -> None:
    """Set what each spring pulls with, loses and exceeds.

    Args:
        stiffness, damping, rest: Of all springs [N/m], [N s/m], [m], shape (spring,).
        near, near_crush: Tension and compression that are near to breaking [N], shape
            (spring,).
        lost: Set to the losses [W], shape (block,).
        above: Set to the excess over the limits [N], shape (block,).
    """
    for s in range(count):
        # With the fourth numbers, four springs at a time are a transposed matrix.
        i, k = FOUR * s, start + s
        r0, r1, r2, r3 = reach[i], reach[i + ONE], reach[i + TWO], reach[i + THREE]
        length = sqrt((r0 * r0 + r1 * r1) + (r2 * r2 + r3 * r3))
        inverse = 1.0 / (length + TINY)
        tension = stiffness[k] * (length - rest[k])
        if VISCOUS:
            part = (r0 * speed[i] + r1 * speed[i + ONE]) + (
                r2 * speed[i + TWO] + r3 * speed[i + THREE]
            )
            closing = part * inverse
            braking = damping[k] * closing
            tension += braking
            lost[s] = braking * closing
        if WATCHED:
            above[s] = max(tension - near[k], -tension - near_crush[k])
        pull[s] = tension * inverse


def scatter(
    start: np.uint64,
    count: np.uint64,
    low: NDArray[np.uint32],
    to: NDArray[np.uint32],
    reach: Floats,
    pull: Floats,
    sums: Floats,
) -> None:
    """Add the forces of springs at their ends.

    Args:
        to: Four times the upper node of each spring, or its slot, shape (spring,).
        sums: Forces [N], added to, shape (4 (node + slot),).
    """
    for s in range(count):
        i, j, k, part = np.uint64(low[start + s]), np.uint64(to[start + s]), FOUR * s, pull[s]
        p0, p1 = part * reach[k], part * reach[k + ONE]
        p2, p3 = part * reach[k + TWO], part * reach[k + THREE]
        f0, f1, f2, f3 = sums[i], sums[i + ONE], sums[i + TWO], sums[i + THREE]
        sums[i], sums[i + ONE] = f0 + p0, f1 + p1
        sums[i + TWO], sums[i + THREE] = f2 + p2, f3 + p3
        f0, f1, f2, f3 = sums[j], sums[j + ONE], sums[j + TWO], sums[j + THREE]
        sums[j], sums[j + ONE] = f0 - p0, f1 - p1
        sums[j + TWO], sums[j + THREE] = f2 - p2, f3 - p3
