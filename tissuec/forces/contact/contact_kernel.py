"""Contact with friction or sides of surfaces, as scalar loops; see ``forces.contact``.

What has neither follows from ``contact.pressing``. Each pair that touches has a row of ``met``.
Rows are filled for each node by itself, in parts of the nodes if threads share the loop, and
then added to the forces in the order of nodes.

Points between nodes follow the nodes in arrays of their own. There, contact acts on points as
on nodes; then their forces are distributed to their corners.

Shared arguments:
    x, v: Positions [m] and velocities [m/s], flat.
    f: Forces [N], flat, that are added to.
    table: Record of the contact; its fields give the shapes and units.
"""

from tissuec.forces.contact.bristle_kernel import SLIDES, bend
from tissuec.forces.contact.friction_kernel import rub, rub_past
from tissuec.forces.contact.rows_kernel import (
    BENDS,
    FORCE,
    LOST,
    STEADY,
    end_of_surface,
    look,
    press_surface,
    push_back,
)
from tissuec.forces.contact.sides_kernel import push_outside
from tissuec.kernels.records import ContactRecord, ContactTable, Floats
from tissuec.kernels.thread_loops import UNDIVIDED

PLACING = -2  # the part in which points are placed


def touch(
    time: float, x: Floats, v: Floats, f: Floats, power: Floats, table: ContactRecord
) -> None:
    """Add the forces of shapes to those on nodes, and the power of damping and friction.

    The rates of bristles are stored in ``touches.bent``. With a ``touches.lag``, velocities
    give bristles without their own rates in an implicit stage, and those are solved for.

    In parts, points are placed first; a part of the nodes only fills their rows; the one after
    the last adds all of them.
    """
    part, parts = table.touches.part, table.touches.starts.size - 1
    if table.at.size == 0:
        press_part(x, v, f, power, table)
        return
    if part in (PLACING, UNDIVIDED):
        place(x, table.x, table)
        place(v, table.v, table)
    if part == PLACING:
        return
    press_part(table.x, table.v, table.f, power, table)
    if part in (UNDIVIDED, parts):
        hand_over(f, table)


def press_part(x: Floats, v: Floats, f: Floats, power: Floats, table: ContactRecord) -> None:
    """Fill the rows of the nodes and points of a part, or add all rows, or both."""
    touches = table.touches
    bends, row, part, parts = 0.0, 0, touches.part, touches.starts.size - 1
    start, stop = 0, touches.nodes.size
    if part == parts:
        for each in range(parts):
            begin = int(touches.first[touches.starts[each]])
            bends += add_up(begin, int(touches.stops[each]), f, power, touches)
        stop = 0
    elif part != UNDIVIDED:
        start, stop = int(touches.starts[part]), int(touches.starts[part + 1])
        row = int(touches.first[start])
    for k in range(start, stop):
        end = press_node(k, row, x, v, table)
        if part == UNDIVIDED:
            bends += add_up(0, end, f, power, touches)
        else:
            row = end
    if 0 <= part < parts:
        touches.stops[part] = row
    else:
        count(round(bends), touches)


def add_up(begin: int, end: int, f: Floats, power: Floats, touches: ContactTable) -> float:
    """Add the forces and powers of rows; return the number of bends passed."""
    bends = 0.0
    for row in range(begin, end):
        met = touches.met[row]
        bends += met[BENDS]
        power[1] += met[LOST]
        for point in range(4):
            i, column = touches.at[row, point], FORCE + 3 * point
            f[i] += met[column]
            f[i + 1] += met[column + 1]
            f[i + 2] += met[column + 2]
    return bends


def count(bends: int, touches: ContactTable) -> None:
    """Add up the bends that are passed: points where the law of contact changes its formula.

    These are two depths, the speed of separation at which damping cancels the pressure, and the
    length from which on the force of a bristle no longer grows.
    """
    touches.bends[0] = bends
    touches.bends[1] = min(touches.bends[1], bends)
    touches.bends[2] = max(touches.bends[2], bends)


def press_node(k: int, begin: int, x: Floats, v: Floats, table: ContactRecord) -> int:
    """Fill the rows of a node or point, and set its bristle; return the end of the rows.

    Args:
        k: Its index among those of the contact.
        begin: First of its rows.
    """
    touches = table.touches
    end = look(k, begin, x, v, touches)
    if table.sided.size:
        end = push_outside(k, begin, end, x, v, touches, table.sided, table.alike)
    # Pressure with and without damping, its rate; largest friction, its rate, and that times
    # velocity.
    total = rest = growth = grip = firmer = u0 = u1 = u2 = 0.0
    start = begin
    while start < end:
        stop = end_of_surface(start, end, touches)
        factor, (steady, closing, steeper) = 0.0, press_surface(k, start, stop, touches)
        if steady > 0.0:
            factor = max(1.0 + touches.damping * closing / steady, 0.0)
            touches.met[start, BENDS] += 1.0 if factor > 0.0 else 0.0
            total, rest, growth = total + factor * steady, rest + steady, growth + steeper
        else:
            for row in range(start, stop):
                touches.met[row, STEADY] = 0.0
        push_back(start, stop, factor, touches)
        if touches.memory.size:
            most, s0, s1, s2 = rub_past(k, start, stop, factor, x, v, touches, table.rough)
            grip, u0, u1, u2 = grip + most, u0 + s0, u1 + s1, u2 + s2
            firmer += most / steady * steeper if steady > 0.0 else 0.0
        start = stop
    if touches.memory.size:
        if touches.bent.shape[1] > SLIDES:
            bend(k, begin, end, total, grip, firmer, u0, u1, u2, x, v, touches)
        else:
            rub(k, begin, end, total, rest, growth, grip, u0, u1, u2, x, v, touches)
    return end


def place(vector: Floats, to: Floats, table: ContactRecord) -> None:
    """Set the vectors of nodes and points.

    Args:
        vector: Of nodes, in any unit, flat, shape (3 node,).
        to: Of nodes and points, in the same unit, flat.
    """
    for i in range(vector.size):
        to[i] = vector[i]
    for p in range(table.at.size):
        i, corners, shares = table.at[p], table.corners[p], table.shares[p]
        a, b, c = corners[0], corners[1], corners[2]
        for k in range(3):
            of_a, of_b, of_c = vector[a + k], vector[b + k], vector[c + k]
            to[i + k] = shares[0] * of_a + shares[1] * of_b + shares[2] * of_c


def hand_over(f: Floats, table: ContactRecord) -> None:
    """Add the forces on nodes and points to those on nodes, and set them to zero.

    Args:
        f: Forces on nodes [N], flat, shape (3 node,).
    """
    own = table.f
    for i in range(f.size):
        f[i] += own[i]
        own[i] = 0.0
    for p in range(table.at.size):
        i, corners, shares = table.at[p], table.corners[p], table.shares[p]
        for a in range(3):
            j, share = corners[a], shares[a]
            for k in range(3):
                f[j + k] += share * own[i + k]
        for k in range(3):
            own[i + k] = 0.0
