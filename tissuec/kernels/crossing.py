"""Edges of surfaces that go through triangles."""

from math import sqrt

from tissuec.kernels.records import IntegerRows, Integers, Rows

#: Rows of ``cells``: where the first one begins, their sizes, and those of the largest boxes.
BEGIN, SIZE, LARGEST = 0, 1, 2


def find_crossings(
    x: Rows,
    edges: IntegerRows,
    order: Integers,
    corners: IntegerRows,
    boxes: Rows,
    starts: Integers,
    cells: Rows,
    count: Integers,
    flat: float,
    found: Integers,
) -> None:
    """Count the pairs of an edge and a triangle that it goes through.

    Pairs with a node in common and what only touches do not count. Triangles lie in the cells
    of a grid in which their boxes begin.

    Args:
        x: Positions [m], shape (node, 3).
        edges: Their ends, shape (edge, 2).
        order: Triangles by cells.
        corners: Their corners, shape (triangle, 3).
        boxes: Where their boxes begin and end along each axis [m], in this order, shape
            (triangle, 6).
        starts: Where each cell begins in this order, and the end of the last one.
        cells: See ``BEGIN`` [m], shape (3, 3).
        count: Number of cells along each axis; those along the last one follow each other.
        flat: Ends as near to a plane as this lie in it [m].
        found: Becomes the number of pairs and the least number of their triangles, shape (2,).
    """
    pairs, least = 0, order.shape[0]
    for e in range(edges.shape[0]):
        p, q = edges[e, 0], edges[e, 1]
        low0, high0 = min(x[p, 0], x[q, 0]), max(x[p, 0], x[q, 0])
        low1, high1 = min(x[p, 1], x[q, 1]), max(x[p, 1], x[q, 1])
        low2, high2 = min(x[p, 2], x[q, 2]), max(x[p, 2], x[q, 2])
        first = cell_of(low2 - cells[LARGEST, 2], 2, cells, count)
        last = cell_of(high2, 2, cells, count)
        for i in range(
            cell_of(low0 - cells[LARGEST, 0], 0, cells, count),
            cell_of(high0, 0, cells, count) + 1,
        ):
            for j in range(
                cell_of(low1 - cells[LARGEST, 1], 1, cells, count),
                cell_of(high1, 1, cells, count) + 1,
            ):
                row = (i * count[1] + j) * count[2]
                for place in range(starts[row + first], starts[row + last + 1]):
                    # Without branches, as nobody can guess which of these is false.
                    meet = (
                        (boxes[place, 0] <= high0)
                        & (boxes[place, 1] >= low0)
                        & (boxes[place, 2] <= high1)
                        & (boxes[place, 3] >= low1)
                        & (boxes[place, 4] <= high2)
                        & (boxes[place, 5] >= low2)
                    )
                    if not meet:
                        continue
                    a, b, c = corners[place, 0], corners[place, 1], corners[place, 2]
                    if (p == a) | (p == b) | (p == c) | (q == a) | (q == b) | (q == c):
                        continue
                    if goes_through(x, p, q, a, b, c, flat):
                        pairs += 1
                        least = min(least, order[place])
    found[0], found[1] = pairs, least


def cell_of(place: float, axis: int, cells: Rows, count: Integers) -> int:
    """Return the cell of a place along an axis; the nearest one, if it is outside."""
    along = (place - cells[BEGIN, axis]) / cells[SIZE, axis]
    if not along > 0.0:
        return 0
    if along >= count[axis]:
        return int(count[axis]) - 1
    return int(along)


def goes_through(x: Rows, p: int, q: int, a: int, b: int, c: int, flat: float) -> bool:
    """Return whether the edge between nodes p and q goes through the triangle of a, b and c.

    Its ends are on different sides of the plane, and it passes all three sides of the triangle
    on the same side of them, by the signs of the volumes that it spans with them.
    """
    n0, n1, n2 = normal(x, a, b, c)
    above = n0 * (x[p, 0] - x[a, 0]) + n1 * (x[p, 1] - x[a, 1]) + n2 * (x[p, 2] - x[a, 2])
    below = n0 * (x[q, 0] - x[a, 0]) + n1 * (x[q, 1] - x[a, 1]) + n2 * (x[q, 2] - x[a, 2])
    if not above * below < 0.0:
        return False
    # Within flat parts of a surface, rounding would decide.
    if min(abs(above), abs(below)) <= flat * sqrt(n0 * n0 + n1 * n1 + n2 * n2):
        return False
    one, two, three = side(x, p, q, a, b), side(x, p, q, b, c), side(x, p, q, c, a)
    return (one > 0.0 and two > 0.0 and three > 0.0) or (
        one < 0.0 and two < 0.0 and three < 0.0
    )


def normal(x: Rows, a: int, b: int, c: int) -> tuple[float, float, float]:
    """Return (x_b - x_a) × (x_c - x_a) [m²]."""
    u0, u1, u2 = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
    w0, w1, w2 = x[c, 0] - x[a, 0], x[c, 1] - x[a, 1], x[c, 2] - x[a, 2]
    return u1 * w2 - u2 * w1, u2 * w0 - u0 * w2, u0 * w1 - u1 * w0


def side(x: Rows, p: int, q: int, a: int, b: int) -> float:
    """Return six times the signed volume that two edges span [m³]."""
    n0, n1, n2 = normal(x, p, q, a)
    return float(n0 * (x[b, 0] - x[p, 0]) + n1 * (x[b, 1] - x[p, 1]) + n2 * (x[b, 2] - x[p, 2]))
