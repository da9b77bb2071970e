"""Forces of linear springs in runs, many at a time; see ``engine.spring_runs``.

Coordinates are taken apart first, as vector instructions want them, and put together again
after all springs. What is summed up, or only looked for, is stored for each spring before:
loops that do both would not be vectorised, because sums of numbers depend on their order.
Gaps in runs, and dead springs, have a negative length at rest.

Shared arguments:
    apart: Components of positions [m], velocities [m/s] and forces [N], shape (9, node).
    values: In any unit, shape (n,).
    to: Changed in place [N], shape (node,).
    low, high: First lower and first upper node of this part of a run.
    at: First spring of this part.
    same: Where numbers begin that all springs may share: ``at``, or 0.
    count: Number of springs of this part.
    each: Scratch: forces, losses and excess of springs, shape (5 or more, block).
    each0, each1, each2: Components of forces of springs [N], shape (block,).
    f0, f1, f2: Components of forces on all nodes [N], shape (node,).
    parity: 0 for the even blocks of runs, 1 for the odd ones.
    runs: The springs in runs.
"""

from math import sqrt

import numpy as np

from tissuec.kernels.records import Floats, Net, Rows, Runs
from tissuec.kernels.thread_loops import part_of, share
from tissuec.kernels.vectors import TINY

VISCOUS = True  # springs have dashpots
WATCHED = True  # springs may break
BLOCK = 512  # springs at a time
#: Arguments that share no memory with the others of a function, as "restrict" says in C: no
#: loop has to test for that before each run.
UNSHARED = {
    "pull_springs": ("each0", "each1", "each2", "lost", "above", "f0", "f1", "f2"),
    "take_from": ("to",),
}


def springs_in_runs(x: Floats, v: Floats, f: Floats, power: Floats, net: Net) -> bool:
    """Set the forces of springs; return whether one is near to breaking.

    This does the same as ``springs_kernel.springs``.
    """
    team, runs = net.team, net.runs
    share(team, take_parts, (x, v, runs.apart))
    # Blocks that are no neighbours have no nodes in common.
    share(team, pull_blocks, (0, net))
    share(team, pull_blocks, (1, net))
    near = False
    for block in range(runs.block.size - 1):
        if VISCOUS and net.ledger:
            power[1] += team.lost[block]
        if WATCHED:
            near |= team.near[block] > 0
    share(team, put_together, (runs.apart, f))
    return near


def take_parts(part: int, parts: int, x: Floats, v: Floats, apart: Rows) -> None:
    """Copy positions and velocities into separate components, and set forces to zero."""
    first, last = part_of(part, parts, apart.shape[1])
    where = slice(first, last)
    take_apart(x[3 * first : 3 * last], apart[0, where], apart[1, where], apart[2, where])
    if VISCOUS:
        take_apart(v[3 * first : 3 * last], apart[3, where], apart[4, where], apart[5, where])
    for k in range(6, 9):
        clear(apart[k, where])


def pull_blocks(part: int, parts: int, parity: int, net: Net) -> None:
    """Add the forces of the springs of every other block to components."""
    team, runs = net.team, net.runs
    each = team.each[part]
    for block in range(2 * part + parity, runs.block.size - 1, 2 * parts):
        lost, near = 0.0, False
        for run in range(runs.block[block], runs.block[block + 1]):
            done = 0
            while done < runs.length[run]:
                count = min(BLOCK, runs.length[run] - done)
                low = runs.first[run] + done
                high, at = low + runs.offset[run], runs.at[run] + done
                pull_part(low, high, at, count, each, runs)
                if VISCOUS and net.ledger:
                    lost += total(each[3, :count])
                if WATCHED:
                    near |= any_above(each[4, :count])
                done += count
        team.lost[block] = lost
        team.near[block] = near


def take_apart(vector: Floats, first: Floats, second: Floats, third: Floats) -> None:
    """Split a vector of all nodes into components.

    Args:
        vector: In any unit, shape (3 node,).
        first, second, third: Set to the components, shape (node,) each.
    """
    for node in range(first.size):
        i = 3 * node
        first[node], second[node], third[node] = vector[i], vector[i + 1], vector[i + 2]


def put_together(part: int, parts: int, apart: Rows, f: Floats) -> None:
    """Set a vector of all nodes from components of forces."""
    first, last = part_of(part, parts, apart.shape[1])
    f0, f1, f2 = apart[6, first:last], apart[7, first:last], apart[8, first:last]
    vector = f[3 * first : 3 * last]
    for node in range(f0.size):
        i = 3 * node
        vector[i], vector[i + 1], vector[i + 2] = f0[node], f1[node], f2[node]


def clear(values: Floats) -> None:
    """Set all values to zero."""
    for i in range(values.size):
        values[i] = 0.0


def pull_part(low: int, high: int, at: int, count: int, each: Rows, runs: Runs) -> None:
    """Add the forces of a part of a run [N]; set losses and excess over the limits."""
    apart, size = runs.apart, np.uint64(count)
    same = np.uint64(0 if runs.alike else at)
    pull_springs(
        np.uint64(low), np.uint64(high), np.uint64(at), same, size, apart[0], apart[1],
        apart[2], apart[3], apart[4], apart[5], runs.stiffness, runs.damping, runs.rest,
        runs.near, runs.near_crush, each[0], each[1], each[2], each[3], each[4], apart[6],
        apart[7], apart[8],
    )  # fmt: skip
    for k in range(3):
        take_from(np.uint64(high), size, each[k], apart[6 + k])


def pull_springs(
    low: np.uint64,
    high: np.uint64,
    at: np.uint64,
    same: np.uint64,
    count: np.uint64,
    x: Floats,
    y: Floats,
    z: Floats,
    u: Floats,
    v: Floats,
    w: Floats,
    stiffness: Floats,
    damping: Floats,
    rest: Floats,
    near: Floats,
    near_crush: Floats,
    each0: Floats,
    each1: Floats,
    each2: Floats,
    lost: Floats,
    above: Floats,
    f0: Floats,
    f1: Floats,
    f2: Floats,
) -> None:
    """Set what each spring does, and add its force to its lower node.

    Indices are unsigned, so that none has to be tested for being negative.

    Args:
        x, y, z: Components of positions [m], shape (node,).
        u, v, w: Components of velocities [m/s], shape (node,).
        stiffness, damping: Of all springs, or of each [N/m], [N s/m], as in ``Runs``.
        rest: Lengths at rest [m], shape (spring,).
        near, near_crush: Tension and compression that are near to breaking [N], as in ``Runs``.
        lost: Set to the losses [W], shape (block,).
        above: Set to the excess over the limits [N], shape (block,).
    """
    for s in range(count):
        i, j, k, n = low + s, high + s, at + s, same + s
        r0, r1, r2 = x[j] - x[i], y[j] - y[i], z[j] - z[i]
        length = sqrt(r0 * r0 + r1 * r1 + r2 * r2)
        is_spring = rest[k] >= 0.0
        inverse = 1.0 / (length + TINY) if is_spring else 0.0
        tension = stiffness[n] * (length - rest[k])
        if VISCOUS:
            closing = (r0 * (u[j] - u[i]) + r1 * (v[j] - v[i]) + r2 * (w[j] - w[i])) * inverse
            braking = damping[n] * closing
            tension += braking
            lost[s] = braking * closing
        if WATCHED:
            above[s] = max(tension - near[n], -tension - near_crush[n]) if is_spring else -1.0
        tension *= inverse
        p0, p1, p2 = tension * r0, tension * r1, tension * r2
        each0[s], each1[s], each2[s] = p0, p1, p2
        f0[i] += p0
        f1[i] += p1
        f2[i] += p2


def take_from(high: np.uint64, count: np.uint64, each: Floats, to: Floats) -> None:
    """Subtract one component of the forces of springs from those on their upper nodes.

    Args:
        each: Of springs [N], shape (block,).
        to: Of all nodes [N], shape (node,).
    """
    for s in range(count):
        to[high + s] -= each[s]


def total(values: Floats) -> float:
    """Return the sum of values, of which an addition need not wait for the last one."""
    one = two = three = four = 0.0
    whole = values.size // 4
    for k in range(whole):
        i = 4 * k
        one += values[i]
        two += values[i + 1]
        three += values[i + 2]
        four += values[i + 3]
    for i in range(4 * whole, values.size):
        one += values[i]
    return (one + two) + (three + four)


def any_above(values: Floats) -> bool:
    """Return whether any value is above zero."""
    found = False
    for i in range(values.size):
        found |= values[i] > 0.0
    return found
