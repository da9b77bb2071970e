"""Rows of contact: one of ``met``, and of ``at``, for each pair of node and shape that touches.

Rows of a node are in succession, those with one surface, too.

Shared arguments:
    row: Index of the row of ``met``.
    start: First row of the node with one surface.
    end: All rows of the node are before it.
    touches: Record of the contact; its fields give the shapes and units.
"""

from tissuec.kernels.records import ContactTable

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
