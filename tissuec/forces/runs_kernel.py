"""Forces of linear springs in runs, many at a time; see ``engine.spring_runs``.

Coordinates are taken apart first, as vector instructions want them, and put together again
after all springs. What is summed up, or only looked for, is stored for each spring before:
loops that do both would not be vectorised, because sums of numbers depend on their order.

Shared arguments:
    apart: Components of positions [m], velocities [m/s] and forces [N], shape (9, node).
    values: In any unit, shape (n,).
    to, out: Changed in place, unit and shape of ``values``.
    low, high: First lower and first upper node of this part of a run.
    at: First spring of this part.
    count: Number of springs of this part.
    each: Scratch: forces, losses and excess of springs, shape (5, block).
    parity: 0 for the even blocks of runs, 1 for the odd ones.
    runs: The springs in runs.
"""

from math import sqrt

from tissuec.kernels.records import Floats, Net, Rows, Runs
from tissuec.kernels.thread_loops import part_of, share
from tissuec.kernels.vectors import TINY

VISCOUS = True  # springs have dashpots
WATCHED = True  # springs may break
BLOCK = 512  # springs at a time


def springs_in_runs(x: Floats, v: Floats, f: Floats, power: Floats, net: Net) -> bool:
    """Add the forces of springs; return whether one is near to breaking.

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
    apart, each = runs.apart, team.each[part]
    for block in range(2 * part + parity, runs.block.size - 1, 2 * parts):
        lost, near = 0.0, False
        for run in range(runs.block[block], runs.block[block + 1]):
            done = 0
            while done < runs.length[run]:
                count = min(BLOCK, runs.length[run] - done)
                low = runs.first[run] + done
                high, at = low + runs.offset[run], runs.at[run] + done
                pull_each(low, high, at, count, each, runs)
                for k in range(3):
                    add_to(each[k, :count], apart[6 + k, low : low + count])
                    take_from(each[k, :count], apart[6 + k, high : high + count])
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
    """Add components of forces to a vector of all nodes."""
    first, last = part_of(part, parts, apart.shape[1])
    f0, f1, f2 = apart[6, first:last], apart[7, first:last], apart[8, first:last]
    vector = f[3 * first : 3 * last]
    for node in range(f0.size):
        i = 3 * node
        vector[i] += f0[node]
        vector[i + 1] += f1[node]
        vector[i + 2] += f2[node]


def clear(values: Floats) -> None:
    """Set all values to zero."""
    for i in range(values.size):
        values[i] = 0.0


def pull_each(low: int, high: int, at: int, count: int, each: Rows, runs: Runs) -> None:
    """Set forces, losses and excess over the limits for a part of a run.

    Args:
        each: Forces [N], losses [W] and excess [N] of springs, shape (5, block).
    """
    apart = runs.apart
    here, there = slice(low, low + count), slice(high, high + count)
    x, y, z = apart[0, here], apart[1, here], apart[2, here]
    u, v, w = apart[3, here], apart[4, here], apart[5, here]
    x_high, y_high, z_high = apart[0, there], apart[1, there], apart[2, there]
    u_high, v_high, w_high = apart[3, there], apart[4, there], apart[5, there]
    stiffness, rest = runs.stiffness[at : at + count], runs.rest[at : at + count]
    damping = runs.damping[at : at + count]
    limit, limit_pressed = runs.near[at : at + count], runs.near_crush[at : at + count]
    f0, f1, f2 = each[0, :count], each[1, :count], each[2, :count]
    lost, above = each[3, :count], each[4, :count]
    for s in range(count):
        r0, r1, r2 = x_high[s] - x[s], y_high[s] - y[s], z_high[s] - z[s]
        length = sqrt(r0 * r0 + r1 * r1 + r2 * r2)
        inverse = 1.0 / (length + TINY)
        tension = stiffness[s] * (length - rest[s])
        if VISCOUS:
            closing = (
                r0 * (u_high[s] - u[s]) + r1 * (v_high[s] - v[s]) + r2 * (w_high[s] - w[s])
            ) * inverse
            braking = damping[s] * closing
            tension += braking
            lost[s] = braking * closing
        if WATCHED:
            above[s] = max(tension - limit[s], -tension - limit_pressed[s])
        tension *= inverse
        f0[s], f1[s], f2[s] = tension * r0, tension * r1, tension * r2


def add_to(values: Floats, to: Floats) -> None:
    """Add ``values`` to ``to``."""
    for i in range(values.size):
        to[i] += values[i]


def take_from(values: Floats, out: Floats) -> None:
    """Subtract ``values`` from ``out``."""
    for i in range(values.size):
        out[i] -= values[i]


def total(values: Floats) -> float:
    """Return the sum of values."""
    found = 0.0
    for i in range(values.size):
        found += values[i]
    return found


def any_above(values: Floats) -> bool:
    """Return whether any value is above zero."""
    found = False
    for i in range(values.size):
        found |= values[i] > 0.0
    return found
