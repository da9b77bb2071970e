"""Edges of surfaces that go through triangles."""

from math import nan, sqrt

from tissuec.kernels.records import IntegerRows, Integers, Rows

#: Rows of ``cells``: where the first one begins, their sizes, and those of the largest boxes.
BEGIN, SIZE, LARGEST = 0, 1, 2


#: What rounding may add to a difference of coordinates, of their size; the least size of a
#: cell, and the largest coordinates that are somewhere [m].
ROUNDING, SMALL, HUGE = 1e-15, 1e-200, 1e300
#: The most cells of a grid, for each triangle.
MOST_CELLS = 16


def place_triangles(
    x: Rows,
    triangles: IntegerRows,
    unsorted: Rows,
    cell: Integers,
    order: Integers,
    corners: IntegerRows,
    boxes: Rows,
    starts: Integers,
    cells: Rows,
    count: Integers,
    bounds: Rows,
) -> None:
    """List triangles by the cells of a grid in which their boxes begin.

    Args:
        x: Positions [m], shape (node, 3).
        triangles: Their corners, shape (triangle, 3).
        unsorted, cell: Room, shapes (triangle, 6) and (triangle,).
        order, corners, boxes, cells: Become what ``find_crossings`` takes.
        starts: Likewise; it has room for ``MOST_CELLS`` of each triangle, and one more.
        count: Likewise; 0 where there are no triangles, or they are nowhere.
        bounds: Becomes where the box around all triangles begins and ends [m], shape (2, 3);
            NaN where there is none.
    """
    number = triangles.shape[0]
    if not bound_triangles(x, triangles, unsorted, cells, bounds):
        for axis in range(3):
            count[axis] = 0
            bounds[0, axis] = bounds[1, axis] = nan
        return
    while True:
        along0 = (bounds[1, 0] - bounds[0, 0]) / cells[SIZE, 0] + 1.0
        along1 = (bounds[1, 1] - bounds[0, 1]) / cells[SIZE, 1] + 1.0
        along2 = (bounds[1, 2] - bounds[0, 2]) / cells[SIZE, 2] + 1.0
        if along0 * along1 * along2 <= MOST_CELLS * number:
            break
        for axis in range(3):
            cells[SIZE, axis] *= 2.0
    count[0], count[1], count[2] = int(along0), int(along1), int(along2)
    list_by_cells(unsorted, cell, order, starts, cells, count)
    for place in range(number):
        t = order[place]
        for axis in range(3):
            corners[place, axis] = triangles[t, axis]
        for end in range(6):
            boxes[place, end] = unsorted[t, end]


def bound_triangles(
    x: Rows, triangles: IntegerRows, unsorted: Rows, cells: Rows, bounds: Rows
) -> bool:
    """Set the boxes of triangles, and the cells that suit them.

    Args:
        x, triangles: As of ``place_triangles``.
        unsorted: Becomes the boxes [m], shape (triangle, 6).
        cells, bounds: Become those of ``place_triangles`` [m].

    Returns:
        Whether there are triangles, and all are somewhere.
    """
    is_somewhere = triangles.shape[0] > 0
    for axis in range(3):
        least, most, largest = HUGE, -HUGE, 0.0
        for t in range(triangles.shape[0]):
            one, two = x[triangles[t, 0], axis], x[triangles[t, 1], axis]
            three = x[triangles[t, 2], axis]
            low, high = min(one, min(two, three)), max(one, max(two, three))
            unsorted[t, 2 * axis], unsorted[t, 2 * axis + 1] = low, high
            is_somewhere = is_somewhere & (abs(one) + abs(two) + abs(three) < HUGE)
            least, most = min(least, low), max(most, high)
            largest = max(largest, high - low)
        largest += ROUNDING * max(abs(least), abs(most)) + SMALL
        cells[BEGIN, axis], cells[SIZE, axis] = least, 0.5 * largest
        cells[LARGEST, axis] = largest
        bounds[0, axis], bounds[1, axis] = least, most
    return is_somewhere


def list_by_cells(
    unsorted: Rows,
    cell: Integers,
    order: Integers,
    starts: Integers,
    cells: Rows,
    count: Integers,
) -> None:
    """List triangles by the cells in which their boxes begin.

    Args:
        unsorted: Boxes [m], shape (triangle, 6).
        cell: Becomes the cells of triangles, shape (triangle,).
        order, starts: Become those of ``place_triangles``.
        cells, count: As of ``find_crossings`` [m], shapes (3, 3) and (3,).
    """
    total = count[0] * count[1] * count[2]
    for k in range(total + 1):
        starts[k] = 0
    for t in range(cell.shape[0]):
        i = cell_of(unsorted[t, 0], 0, cells, count)
        j = cell_of(unsorted[t, 2], 1, cells, count)
        k = cell_of(unsorted[t, 4], 2, cells, count)
        cell[t] = (i * count[1] + j) * count[2] + k
        starts[cell[t]] += 1
    for k in range(total):
        starts[k + 1] += starts[k]
    # From the last to the first, so that the ends of cells become their beginnings.
    for back in range(1, cell.shape[0] + 1):
        t = cell.shape[0] - back
        starts[cell[t]] -= 1
        order[starts[cell[t]]] = t


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

    Pairs with a node in common and what only touches do not count. Triangles are listed by the
    cells of a grid in which their boxes begin, for edges that these may reach.

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
        i0, i1 = cells_of(low0, high0, 0, cells, count)
        j0, j1 = cells_of(low1, high1, 1, cells, count)
        k0, k1 = cells_of(low2, high2, 2, cells, count)
        for i in range(i0, i1 + 1):
            for j in range(j0, j1 + 1):
                cell = (i * count[1] + j) * count[2]
                for place in range(starts[cell + k0], starts[cell + k1 + 1]):
                    # Counted, and not joined by "and" or "&", of which branches would be made:
                    # nobody can guess which of these is false, but hardly ever all are true.
                    true = (
                        meets(boxes, place, 0, low0, high0)
                        + meets(boxes, place, 1, low1, high1)
                        + meets(boxes, place, 2, low2, high2)
                        + is_apart(corners, place, p)
                        + is_apart(corners, place, q)
                    )
                    if true == 5 and goes_through(x, p, q, corners, place, flat):
                        pairs += 1
                        least = min(least, order[place])
    found[0], found[1] = pairs, least


def meets(boxes: Rows, place: int, axis: int, low: float, high: float) -> bool:
    """Return whether a box and an interval of an axis have a place in common.

    Args:
        boxes: As of ``find_crossings`` [m], shape (triangle, 6).
        place: Number of the box.
        low, high: Ends of the interval [m].
    """
    return (boxes[place, 2 * axis] <= high) + (boxes[place, 2 * axis + 1] >= low) == 2


def is_apart(corners: IntegerRows, place: int, node: int) -> bool:
    """Return whether a node is none of the corners of a triangle.

    Args:
        corners: Of triangles, shape (triangle, 3).
        place: Number of the triangle.
        node: Number of the node.
    """
    a, b, c = corners[place, 0], corners[place, 1], corners[place, 2]
    return (a != node) + (b != node) + (c != node) == 3


def cells_of(
    low: float, high: float, axis: int, cells: Rows, count: Integers
) -> tuple[int, int]:
    """Return the first and the last cell in which boxes begin that may reach an interval.

    Args:
        low, high: Ends of the interval [m].
        cells, count: As of ``find_crossings`` [m], shapes (3, 3) and (3,).
    """
    first = cell_of(low - cells[LARGEST, axis], axis, cells, count)
    return first, cell_of(high, axis, cells, count)


def cell_of(place: float, axis: int, cells: Rows, count: Integers) -> int:
    """Return the cell of a place along an axis; the nearest one, if it is outside.

    Args:
        place: Coordinate [m].
        cells: As of ``find_crossings`` [m], shape (3, 3).
        count: Number of cells along each axis, shape (3,).
    """
    along = (place - cells[BEGIN, axis]) / cells[SIZE, axis]
    if not along > 0.0:
        return 0
    if along >= count[axis]:
        return int(count[axis]) - 1
    return int(along)


def goes_through(
    x: Rows, p: int, q: int, corners: IntegerRows, place: int, flat: float
) -> bool:
    """Return whether an edge goes through a triangle with which it has no node in common.

    Its ends are on different sides of the plane, and it passes all three sides of the triangle
    on the same side of them, by the signs of the volumes that it spans with them.

    Args:
        x: Positions [m], shape (node, 3).
        p, q: Ends of the edge.
        corners: Of triangles, shape (triangle, 3).
        place: Number of the triangle.
        flat: Ends as near to the plane as this lie in it [m].
    """
    a, b, c = corners[place, 0], corners[place, 1], corners[place, 2]
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
