"""Rows of contact: one of ``met``, and of ``at``, for each pair of node and shape that touches.

Rows of a node are in succession, those with one surface, too.

Shared arguments:
    k: Index of the node among those of the contact.
    row: Index of the row of ``met``.
    start, stop: Rows of the node with one surface: from ``start`` up to before ``stop``.
    end: All rows of the node are before it.
    factor: Pressure with damping divided by pressure without it, dimensionless.
    touches: Record of the contact; its fields give the shapes and units.
"""

from tissuec.forces.contact.place_kernel import Meeting, corners, meet
from tissuec.kernels.records import ContactTable, Floats

# Columns of ``met``.
STEADY = 0  # pressure at rest, with the sign of the weight
NORMAL = 1
WEIGHT = 4  # of the three points of a shape
LEVER = 7  # on a plane
GAP = 10  # distance of the node from the nearest point
RATE = 11  # velocity along the normal
SLIDE = 12  # velocity against the nearest point
BENDS = 15  # of the law that are passed, those of the depth times the weight
SHARE = 16  # of the couple of its surface
LOST = 17  # power that damping dissipates; in the first row, with that of friction
FORCE = 18  # on the node, and on the three points of the shape
GRIP = 30  # largest friction, with the sign of the weight
COLUMNS = 31
# Columns of ``at``, after the places of the coordinates of the node and of the three points.
PAIR, SURFACE, PLACES = 4, 5, 6


def end_of_surface(start: int, end: int, touches: ContactTable) -> int:
    """Return the index after the rows that have the same surface as the first of them."""
    stop, surface = start + 1, touches.at[start, SURFACE]
    while stop < end and touches.at[stop, SURFACE] == surface:
        stop += 1
    return stop


def shape_of(row: int, touches: ContactTable) -> int:
    """Return the index of the shape of a row."""
    return int(touches.shape[touches.at[row, PAIR]])


def points(row: int, touches: ContactTable) -> tuple[int, int, int]:
    """Return where the coordinates of the points of the shape of a row begin."""
    return int(touches.at[row, 1]), int(touches.at[row, 2]), int(touches.at[row, 3])


def push(row: int, point: int, f0: float, f1: float, f2: float, touches: ContactTable) -> None:
    """Add a force to those of a row.

    Args:
        point: 0 for its node, 1 to 3 for a point of its shape.
        f0, f1, f2: Components of the force [N].
    """
    met, column = touches.met[row], FORCE + 3 * point
    met[column] += f0
    met[column + 1] += f1
    met[column + 2] += f2


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
