"""Contact of points between nodes, as scalar loops; see ``contact.points``.

Separate arrays hold the nodes, followed by the points. There, contact acts on points as on
nodes; then their forces are distributed to their corners.

Shared arguments:
    x, v: Positions [m] and velocities [m/s] of all nodes, flat, shape (3 node,).
    table: Record of the points and of the contact.
"""

from tissuec.forces.contact.bristle_kernel import bend
from tissuec.forces.contact.contact_kernel import add_up, count, look, press_surface, push_back
from tissuec.forces.contact.friction_kernel import rub_past
from tissuec.forces.contact.rows_kernel import BENDS, STEADY, end_of_surface
from tissuec.forces.contact.sides_kernel import push_outside
from tissuec.kernels.records import ContactPointTable, Floats
from tissuec.kernels.thread_loops import UNDIVIDED

PLACING = -2  # the part in which points are placed


def touch_points(
    time: float, x: Floats, v: Floats, f: Floats, power: Floats, table: ContactPointTable
) -> None:
    """Add the forces of contact to those on nodes, and its powers; see ``touch``.

    In parts, points are placed first, and forces are added after the last part.
    """
    touches, part = table.touches, table.part
    if part in (PLACING, UNDIVIDED):
        place(x, table.x, table)
        place(v, table.v, table)
    if part == PLACING:
        return
    press_part(power, table)
    if part in (UNDIVIDED, touches.starts.size - 1):
        hand_over(f, table)


def press_part(power: Floats, table: ContactPointTable) -> None:
    """Add the forces on nodes and points of a part, as ``contact_kernel.touch`` does."""
    touches, part = table.touches, table.part
    parts, bends, row = touches.starts.size - 1, 0.0, 0
    start, stop = 0, touches.nodes.size
    if part == parts:
        for each in range(parts):
            begin = int(touches.first[touches.starts[each]])
            bends += add_up(begin, int(touches.stops[each]), table.f, power, touches)
        stop = 0
    elif part != UNDIVIDED:
        start, stop = int(touches.starts[part]), int(touches.starts[part + 1])
        row = int(touches.first[start])
    for k in range(start, stop):
        end = press_point(k, row, table)
        if part == UNDIVIDED:
            bends += add_up(0, end, table.f, power, touches)
        else:
            row = end
    if 0 <= part < parts:
        touches.stops[part] = row
    else:
        count(round(bends), touches)


def press_point(k: int, begin: int, table: ContactPointTable) -> int:
    """Fill the rows of a node or point, and set its bristle; return the end of the rows.

    Args:
        k: Its index among those of the contact.
        begin: First of its rows.
    """
    x, v, touches, rough = table.x, table.v, table.touches, table.rough
    end = look(k, begin, x, v, touches)
    if table.sided.size:
        end = push_outside(k, begin, end, x, v, touches, table.sided, table.alike)
    # Pressure with damping, largest friction, its rate, and it times sliding velocity.
    total = grip = growth = u0 = u1 = u2 = 0.0
    start = begin
    while start < end:
        stop = end_of_surface(start, end, touches)
        factor, (steady, closing, steeper) = 0.0, press_surface(k, start, stop, touches)
        if steady > 0.0:
            factor = max(1.0 + touches.damping * closing / steady, 0.0)
            touches.met[start, BENDS] += 1.0 if factor > 0.0 else 0.0
            total += factor * steady
        else:
            for row in range(start, stop):
                touches.met[row, STEADY] = 0.0
        push_back(start, stop, factor, touches)
        if touches.memory.size:
            most, s0, s1, s2 = rub_past(k, start, stop, factor, x, v, touches, rough)
            grip, u0, u1, u2 = grip + most, u0 + s0, u1 + s1, u2 + s2
            growth += most / steady * steeper if steady > 0.0 else 0.0
        start = stop
    if touches.memory.size:
        bend(k, begin, end, total, grip, growth, u0, u1, u2, x, v, touches)
    return end


def place(vector: Floats, to: Floats, table: ContactPointTable) -> None:
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


def hand_over(f: Floats, table: ContactPointTable) -> None:
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
