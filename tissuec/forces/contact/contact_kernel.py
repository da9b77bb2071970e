"""Contact as scalar loops; for the equations see ``forces.contact``.

Each pair that touches has a row of ``met``. Rows of a node are in succession, those with one
surface, too. They are filled for each node by itself, in parts of the nodes if threads share
the loop, and then added to the forces in the order of nodes.

Shared arguments:
    k: Index of the node among those of the contact.
    start, stop: Rows of the node with one surface: from ``start`` up to before ``stop``.
    begin, end: All rows of the node: from ``begin`` up to before ``end``.
    factor: Pressure with damping divided by pressure without it, dimensionless.
    touches: Record of the contact; its fields give the shapes and units.
    rough: Coefficients of friction.
"""

from tissuec.forces.contact.friction_kernel import rub, rub_past
from tissuec.forces.contact.place_kernel import Meeting, corners, meet
from tissuec.forces.contact.rows_kernel import (
    BENDS,
    FORCE,
    GAP,
    LEVER,
    LOST,
    NORMAL,
    PAIR,
    RATE,
    SLIDE,
    STEADY,
    SURFACE,
    WEIGHT,
    end_of_surface,
)
from tissuec.kernels.records import ContactNodeTable, ContactTable, Floats, Roughness
from tissuec.kernels.thread_loops import UNDIVIDED


def touch(
    time: float, x: Floats, v: Floats, f: Floats, power: Floats, table: ContactNodeTable
) -> None:
    """Add the forces of shapes to those on nodes, and the power of damping and friction.

    The rates of bristles are stored in ``touches.bent``. With a ``touches.lag``, velocities
    give bristles without their own rates in an implicit stage, and those are solved for.

    A table of a part of the nodes only fills their rows; the table after the last part adds all
    of them.

    Args:
        table: Shapes, the nodes near them, and their friction.
    """
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
        end = press_node(k, row, x, v, touches, table.rough)
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


def press_node(
    k: int, begin: int, x: Floats, v: Floats, touches: ContactTable, rough: Roughness
) -> int:
    """Fill the rows of a node, and set the rate of its bristle; return the end of the rows."""
    end = look(k, begin, x, v, touches)
    # Pressure with and without damping, its rate; largest friction, and that times velocity.
    total = rest = growth = grip = u0 = u1 = u2 = 0.0
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
            most, s0, s1, s2 = rub_past(k, start, stop, factor, x, v, touches, rough)
            grip, u0, u1, u2 = grip + most, u0 + s0, u1 + s1, u2 + s2
        start = stop
    if touches.memory.size:
        rub(k, begin, end, total, rest, growth, grip, u0, u1, u2, x, v, touches)
    return end


def look(k: int, begin: int, x: Floats, v: Floats, touches: ContactTable) -> int:
    """Set rows for the pairs of a node that touch, without forces; return their end."""
    row, i = begin, 3 * touches.nodes[k]
    for pair in range(touches.first[k], touches.first[k + 1]):
        met = meet(i, pair, x, touches)
        if met[0] > 0.0:
            lay(k, row, pair, met, v, touches)
            row += 1
    return row


def lay(k: int, row: int, pair: int, place: Meeting, v: Floats, touches: ContactTable) -> None:
    """Set a row for a pair of a node that touches, without forces.

    Args:
        row: Index of the row.
        pair: Index of the pair.
        place: Where the node is in the shape.
        v: Velocities of all nodes [m/s], flat, shape (3 node,).
    """
    depth, n0, n1, n2, wa, wb, wc, l0, l1, l2 = place
    i, met, at, shape = (
        3 * touches.nodes[k],
        touches.met[row],
        touches.at[row],
        touches.shape[pair],
    )
    a, b, c = corners(shape, touches)
    at[0], at[1], at[2], at[3] = i, a, b, c
    at[PAIR], at[SURFACE] = pair, touches.surface[shape]
    met[BENDS] = touches.weight[pair] * (1.0 if depth < touches.layer else 2.0)
    met[STEADY] = touches.weight[pair] * press_at(depth, touches.stiffness[k], touches.layer)
    met[NORMAL], met[NORMAL + 1], met[NORMAL + 2] = n0, n1, n2
    met[WEIGHT], met[WEIGHT + 1], met[WEIGHT + 2] = wa, wb, wc
    met[LEVER], met[LEVER + 1], met[LEVER + 2] = l0, l1, l2
    met[GAP] = touches.radius[pair] - depth
    s0 = v[i] - wa * v[a] - wb * v[b] - wc * v[c]
    s1 = v[i + 1] - wa * v[a + 1] - wb * v[b + 1] - wc * v[c + 1]
    s2 = v[i + 2] - wa * v[a + 2] - wb * v[b + 2] - wc * v[c + 2]
    turning = l0 * (v[b] - v[a]) + l1 * (v[b + 1] - v[a + 1]) + l2 * (v[b + 2] - v[a + 2])
    s0, s1, s2 = s0 + turning * n0, s1 + turning * n1, s2 + turning * n2
    met[RATE] = s0 * n0 + s1 * n1 + s2 * n2
    met[SLIDE], met[SLIDE + 1], met[SLIDE + 2] = s0, s1, s2


def press_surface(
    k: int, start: int, stop: int, touches: ContactTable
) -> tuple[float, float, float]:
    """Return the pressure of a surface on a node, without damping.

    Returns:
        Its pressure [N], that times the rate of the depth [W], and its rate [N/s].
    """
    stiffness = touches.stiffness[k]
    steady = nearest_face = closing = steeper = 0.0
    for row in range(start, stop):
        met, pair = touches.met[row], touches.at[row, PAIR]
        depth = touches.radius[pair] - met[GAP]
        steep = stiffness * min(depth / touches.layer, 1.0)
        steady += met[STEADY]
        nearest_face = max(nearest_face, met[STEADY])
        closing -= met[STEADY] * met[RATE]
        steeper -= touches.weight[pair] * steep * met[RATE]
    return max(steady, nearest_face), closing, steeper


def push_back(start: int, stop: int, factor: float, touches: ContactTable) -> None:
    """Set the forces of the pressure of a surface, and the power that damping dissipates."""
    for row in range(start, stop):
        met = touches.met[row]
        pressure = factor * met[STEADY]
        met[LOST] = (met[STEADY] - pressure) * met[RATE]
        wa, wb, wc = met[WEIGHT], met[WEIGHT + 1], met[WEIGHT + 2]
        for axis in range(3):
            g, lever = pressure * met[NORMAL + axis], pressure * met[LEVER + axis]
            met[FORCE + axis] = g
            met[FORCE + 3 + axis] = -wa * g - lever
            met[FORCE + 6 + axis] = -wb * g + lever
            met[FORCE + 9 + axis] = -wc * g


def press_at(depth: float, stiffness: float, layer: float) -> float:
    """Return the pressure at a depth, without damping [N].

    Args:
        depth: Depth of the node below the surface [m].
        stiffness: Stiffness of the contact [N/m].
        layer: Depth w below which the law is linear [m].
    """
    if depth < layer:
        return stiffness * depth * depth / (2.0 * layer)
    return stiffness * (depth - 0.5 * layer)
