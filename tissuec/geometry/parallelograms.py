"""Parallelograms that pairs of triangles form.

Thirds of triangles depend on which diagonal divides a parallelogram; quarters of it do not.
"""

import numpy as np

from tissuec.geometry.edges import Floats, Indices

NEAR = 1e-6  # of a length: what is shorter than this is rounding


def parallelograms(position: Floats, triangles: Indices) -> tuple[Indices, Indices]:
    """Return the parallelograms that lie across the longest edge of both their triangles.

    Args:
        position: [m], shape (node, 3).
        triangles: Of a surface, all facing the same side, shape (triangle, 3).

    Returns:
        Corners in turn as their triangles have them, divided between the second and the last,
        and the numbers of these triangles; shapes (parallelogram, 4) and (parallelogram, 2).
    """
    corners = position[triangles]
    opposite = np.linalg.norm(
        np.roll(corners, -1, axis=1) - np.roll(corners, 1, axis=1), axis=2
    )
    apex = np.argmax(opposite, axis=1)
    length = np.sort(opposite, axis=1)
    number = np.flatnonzero(length[:, 1] < (1.0 - NEAR) * length[:, 2])
    turned = (apex[number, None] + np.arange(3)) % 3
    rows = np.take_along_axis(triangles[number], turned, axis=1)  # the apex first
    diagonal = np.sort(rows[:, 1:], axis=1).T
    order = np.lexsort(diagonal)
    first, second = order[:-1], order[1:]
    is_pair = (diagonal[:, first] == diagonal[:, second]).all(axis=0)
    first, second = first[is_pair], second[is_pair]
    found = np.stack([rows[first, 0], rows[first, 1], rows[second, 0], rows[first, 2]], axis=1)
    a, b, c, d = position[found].swapaxes(0, 1)
    flat = np.linalg.norm(a + c - b - d, axis=1) < NEAR * length[number[first], 2]
    return found[flat], np.stack([number[first], number[second]], axis=1)[flat]
