"""Forces of linear springs in runs, many at a time; see ``engine.spring_runs``.

Coordinates are taken apart first, as vector instructions want them, and put together again
after all springs of a node. They lie in tiles, each with nine rows: components of positions,
velocities and forces of ``TILE`` nodes. A run has all its lower nodes in one tile, and all
upper ones in one tile; both stay in the nearest cache while all runs between them are done.
Rows are a fixed distance apart, so that compiled loops need one address for all of them.

Springs are done block by block. Upper nodes are in the same block or in the next one, so that
the tiles of two blocks suffice, which take turns: large nets are limited by memory bandwidth.
Threads take groups of blocks. What springs of a group do to the first block of the next one is
its halo, and added at the end.

Lengths at rest are most of what is read for each spring. In a regular mesh, those of a run
differ by roundings only: they are kept as steps of two bytes, and written out run by run, in
the cache.

What is summed up, or only looked for, is stored for each spring before: loops that do both
would not be vectorised, because sums of numbers depend on their order.
Gaps in runs, and dead springs, have a negative length at rest.

Shared arguments:
    part: Index of this thread's share.
    parts: Number of shares.
    x, v, f: Positions [m], velocities [m/s] and forces [N] of all nodes, shape (3 node,).
    tiles: Those of two blocks and one of scratch, for each part of a loop, flat: positions [m],
        velocities [m/s] and forces [N], shape (part, tile SIZE).
    low, high: Places of the first lower and of the first upper node of a run in ``tiles``.
    at: First spring of a run.
    same: Where numbers begin that all springs may share: ``at``, or 0.
    count: Number of springs of a run, or of nodes of a tile.
    block: Index of a block of nodes.
    ring: Where the tiles of a part begin.
    scratch: Place of the scratch of a part in ``tiles``.
    runs: The springs in runs.
    values: In any unit, shape (n,).
"""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from tissuec.kernels.records import Floats, Net, Runs
from tissuec.kernels.thread_loops import PIECE, items_of, share
from tissuec.kernels.vectors import TINY, accumulate

VISCOUS = True  # springs have dashpots
WATCHED = True  # springs may break
TILE = PIECE // 2  # nodes
# From one row to the next. With powers of two, addresses of a node in all rows would end in the
# same bits, by which processors tell what is stored from what is read.
ROW = TILE + 8
FORCES, ROWS = 6, 9  # the first row of forces, and how many there are in all
LENGTHS = 2 * ROW  # where those of a run are written out in scratch, after losses and excesses
NO_SPRING = -1.0  # length at rest of what is none [m]
NO_STEP = -(2**15)  # the step to it
NO_BITS = np.int64(np.array(NO_SPRING).view(np.int64))
SIZE = ROWS * ROW
#: Runs have a multiple of as many springs: those left over by vector instructions would take as
#: long as a whole run of this length. Loops say so, which spares the code for what is left.
LANES = 4
LANE, ONE, TWO, THREE = np.uint64(LANES), np.uint64(1), np.uint64(2), np.uint64(3)
ROW_1, ROW_2, ROW_3, ROW_4, ROW_5, ROW_6, ROW_7, ROW_8 = (
    np.uint64(ROW * k) for k in range(1, 9)
)
#: Arguments that share no memory with the others of a function, as "restrict" says in C: no
#: loop has to test for that before each run. Of ``tiles``, forces are other rows than what is
#: read, and those on upper nodes are others than those on lower ones.
UNSHARED = {
    "pull_springs": ("lower", "upper", "lost", "above"),
    "take_apart": ("rows",),
    "put_together": ("whole",),
    "add_to_upper": ("own",),
}


def springs_in_runs(x: Floats, v: Floats, f: Floats, power: Floats, net: Net) -> bool:
    """Set the forces of springs; return whether one is near to breaking.

    This does the same as ``springs_kernel.springs``.
    """
    team, runs = net.team, net.runs
    share(team, pull_groups, (x, v, f, net))
    share(team, add_halos, (f, runs))
    near = False
    for block in range(runs.block.size - 1):
        if VISCOUS and net.ledger:
            power[1] += team.lost[block]
        if WATCHED:
            near |= team.near[block] > 0
    return near


def pull_groups(part: int, parts: int, x: Floats, v: Floats, f: Floats, net: Net) -> None:
    """Set the forces on the nodes of some groups of blocks, but for their halos."""
    runs = net.runs
    begin, end = items_of(part, parts, runs.group.size - 1)
    # There are no more tiles than groups; a part without any does not count.
    blocks, ring = runs.block.size - 1, min(part, begin) * runs.ring
    for group in range(begin, end):
        first, last = runs.group[group], runs.group[group + 1]
        here, then = ring, ring + runs.width // TILE * SIZE
        take_block(first, here, x, v, runs)
        for block in range(first, last):
            if block + 1 < blocks:
                take_block(block + 1, then, x, v, runs)
            pull_block(block, ring, net)
            start, stop = nodes_of(block, f.size // 3, runs)
            put_block(here, runs.tiles, f[3 * start : 3 * stop])
            here, then = then, here
        if last < blocks:
            start, stop = nodes_of(last, f.size // 3, runs)
            halo = 3 * group * runs.width
            put_block(here, runs.tiles, runs.halos[halo : halo + 3 * (stop - start)])


def add_halos(part: int, parts: int, f: Floats, runs: Runs) -> None:
    """Add to forces what springs of one group do to nodes of the next one."""
    begin, end = items_of(part, parts, runs.group.size - 1)
    for group in range(max(begin, 1), end):
        start, stop = nodes_of(runs.group[group], f.size // 3, runs)
        halo = 3 * (group - 1) * runs.width
        accumulate(1.0, runs.halos[halo : halo + 3 * (stop - start)], f[3 * start : 3 * stop])


def nodes_of(block: int, nodes: int, runs: Runs) -> tuple[int, int]:
    """Return the first node of a block, and the first one after it.

    Args:
        nodes: Number of nodes.
    """
    return block * runs.width, min((block + 1) * runs.width, nodes)


def take_block(block: int, place: int, x: Floats, v: Floats, runs: Runs) -> None:
    """Copy positions and velocities of a block to tiles; set forces to zero.

    Args:
        place: Where its first tile begins.
    """
    first, last = nodes_of(block, x.size // 3, runs)
    for start in range(first, last, TILE):
        count, tile = np.uint64(min(TILE, last - start)), runs.tiles[place : place + SIZE]
        take_apart(x[3 * start :], count, tile)
        if VISCOUS:
            take_apart(v[3 * start :], count, tile[3 * ROW :])
        clear(tile[FORCES * ROW :])
        place += SIZE


def put_block(place: int, tiles: Floats, f: Floats) -> None:
    """Set the forces on the nodes of a block to those in tiles.

    Args:
        place: Where its first tile begins.
    """
    for start in range(0, f.size // 3, TILE):
        count = np.uint64(min(TILE, f.size // 3 - start))
        put_together(tiles[place + FORCES * ROW :], count, f[3 * start :])
        place += SIZE


def pull_block(block: int, ring: int, net: Net) -> None:
    """Add the forces of the springs of a block."""
    team, runs = net.team, net.runs
    scratch = ring + runs.ring - SIZE  # forces in scratch are zero between runs
    lost, near = 0.0, False
    for run in range(runs.block[block], runs.block[block + 1]):
        pull_run(run, ring, scratch, runs)
        if VISCOUS and net.ledger:
            lost += total(runs.tiles[scratch : scratch + runs.length[run]])
        if WATCHED:
            above = scratch + ROW
            near |= any_above(runs.tiles[above : above + runs.length[run]])
    team.lost[block] = lost
    team.near[block] = near


def take_apart(vector: Floats, count: np.uint64, rows: Floats) -> None:
    """Copy a vector of nodes to three rows.

    Args:
        vector: In any unit, shape (3 count,) or more.
        rows: The first row, and those that follow; changed.
    """
    for node in range(count):
        i = THREE * node
        rows[node], rows[node + ROW_1] = vector[i], vector[i + ONE]
        rows[node + ROW_2] = vector[i + TWO]


def put_together(apart: Floats, count: np.uint64, whole: Floats) -> None:
    """Copy three rows to a vector of nodes; the reverse of ``take_apart``.

    Args:
        apart: The first row, and those that follow, in any unit.
        whole: Changed, in any unit, shape (3 count,) or more.
    """
    for node in range(count):
        i = THREE * node
        whole[i], whole[i + ONE] = apart[node], apart[node + ROW_1]
        whole[i + TWO] = apart[node + ROW_2]


def clear(values: Floats) -> None:
    """Set all values to zero."""
    for i in range(values.size):
        values[i] = 0.0


def pull_run(run: int, ring: int, scratch: int, runs: Runs) -> None:
    """Add the forces of a run [N]; set losses and excess over the limits in scratch."""
    low, high = np.uint64(ring + runs.low[run]), np.uint64(ring + runs.high[run])
    at, count, own = np.uint64(runs.at[run]), np.uint64(runs.length[run]), np.uint64(scratch)
    # What is both a lower and an upper node must not be added to twice in one loop.
    to = high if high < low or high - low >= count else own
    tiles, rest, first = runs.tiles, runs.rest, at
    if runs.steps.size:
        rest, first = tiles[scratch + LENGTHS :], np.uint64(0)
        write_lengths(at, count, runs.base[run], runs.steps, rest)
    pull_springs(
        low, high, to, first, np.uint64(0) if runs.alike else at, count, tiles, runs.stiffness,
        runs.damping, rest, runs.near, runs.near_crush, tiles, tiles, tiles[scratch:],
        tiles[scratch + ROW :],
    )  # fmt: skip
    if to == own:
        for row in (ROW_6, ROW_7, ROW_8):
            add_to_upper(high + row, own + row, count, tiles, tiles)


def write_lengths(
    at: np.uint64, count: np.uint64, base: int, steps: NDArray[np.int16], rest: Floats
) -> None:
    """Set lengths at rest from their steps.

    Args:
        base: Bits of the length that steps begin at.
        steps: Of all springs, shape (spring,).
        rest: Changed, [m], shape (count,) or more.
    """
    bits = rest.view(np.int64)
    for s in range(count // LANE * LANE):
        step = np.int64(steps[at + s])
        bits[s] = base + step if step != NO_STEP else NO_BITS


def pull_springs(
    low: np.uint64,
    high: np.uint64,
    to: np.uint64,
    at: np.uint64,
    same: np.uint64,
    count: np.uint64,
    tiles: Floats,
    stiffness: Floats,
    damping: Floats,
    rest: Floats,
    near: Floats,
    near_crush: Floats,
    lower: Floats,
    upper: Floats,
    lost: Floats,
    above: Floats,
) -> None:
    """Add the force of each spring to its lower node, and subtract it from its upper one.

    Indices are unsigned, so that none has to be tested for being negative.

    Args:
        to: Place from which on forces on upper nodes are: ``high``, or ``scratch``.
        stiffness, damping: Of all springs, or of each [N/m], [N s/m], as in ``Runs``.
        rest: Lengths at rest [m], from the place ``at`` on.
        near, near_crush: Tension and compression that are near to breaking [N], as in ``Runs``.
        lower, upper: The tiles, of which forces on lower and on upper nodes change.
        lost: Set to the losses [W], shape (count,) or more.
        above: Set to the excess over the limits [N], shape (count,) or more.
    """
    for s in range(count // LANE * LANE):
        i, j, k, n, m = low + s, high + s, at + s, same + s, to + s
        r0 = tiles[j] - tiles[i]
        r1 = tiles[j + ROW_1] - tiles[i + ROW_1]
        r2 = tiles[j + ROW_2] - tiles[i + ROW_2]
        length = sqrt(r0 * r0 + r1 * r1 + r2 * r2)
        is_spring = rest[k] >= 0.0
        inverse = 1.0 / (length + TINY) if is_spring else 0.0
        tension = stiffness[n] * (length - rest[k])
        if VISCOUS:
            u0 = tiles[j + ROW_3] - tiles[i + ROW_3]
            u1 = tiles[j + ROW_4] - tiles[i + ROW_4]
            u2 = tiles[j + ROW_5] - tiles[i + ROW_5]
            closing = (r0 * u0 + r1 * u1 + r2 * u2) * inverse
            braking = damping[n] * closing
            tension += braking
            lost[s] = braking * closing
        if WATCHED:
            above[s] = max(tension - near[n], -tension - near_crush[n]) if is_spring else -1.0
        tension *= inverse
        p0, p1, p2 = tension * r0, tension * r1, tension * r2
        lower[i + ROW_6] += p0
        lower[i + ROW_7] += p1
        lower[i + ROW_8] += p2
        upper[m + ROW_6] -= p0
        upper[m + ROW_7] -= p1
        upper[m + ROW_8] -= p2


def add_to_upper(
    high: np.uint64, scratch: np.uint64, count: np.uint64, tiles: Floats, own: Floats
) -> None:
    """Add one component of forces from scratch to those on upper nodes; leave zeros there.

    Args:
        high, scratch: Where the row of this component begins.
        own: The tiles, of which those of scratch change.
    """
    for s in range(count // LANE * LANE):
        tiles[high + s] += own[scratch + s]
        own[scratch + s] = 0.0


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
