"""Which line segments go through which triangles."""

import numpy as np
from numpy.typing import NDArray

from tissuec.geometry.edges import Floats, Indices

MOST_PAIRS = 1 << 20  # examined together


def crossings(segments: Floats, triangles: Floats) -> Indices:
    """Return the pairs of a segment and a triangle that it goes through, shape (pair, 2).

    A segment through the plane of a triangle goes through the triangle where it passes all
    three sides on the same side of them, by the signs of the volumes that it spans with them.
    What only touches is not counted.

    Args:
        segments: Both ends of each [m], shape (segment, 2, 3).
        triangles: Corners of each [m], shape (triangle, 3, 3).
    """
    found = [np.zeros((0, 2), dtype=np.int64)]
    rows = max(1, MOST_PAIRS // max(1, len(triangles)))
    for first in range(0, len(segments), rows):
        some = segments[first : first + rows]
        pairs = np.argwhere(_boxes_overlap(some, triangles))
        through = go_through(some[pairs[:, 0]], triangles[pairs[:, 1]])
        found.append(pairs[through] + [first, 0])
    return np.concatenate(found)


def _boxes_overlap(segments: Floats, triangles: Floats) -> NDArray[np.bool_]:
    """Return whether boxes around both have a point in common, shape (segment, triangle)."""
    low, high = segments.min(axis=1)[:, None], segments.max(axis=1)[:, None]
    return ((low <= triangles.max(axis=1)) & (triangles.min(axis=1) <= high)).all(axis=-1)


def go_through(segments: Floats, triangles: Floats) -> NDArray[np.bool_]:
    """Return whether each segment goes through the triangle of the same row, shape (row,)."""
    start, end = segments[:, None, 0], segments[:, None, 1]
    corners, following = triangles, np.roll(triangles, -1, axis=1)
    sides = _volumes(start, end, corners, following)
    ends = _volumes(corners[:, :1], corners[:, 1:2], corners[:, 2:], segments)
    one_side = (sides > 0.0).all(axis=1) | (sides < 0.0).all(axis=1)
    return one_side & (ends[:, 0] * ends[:, 1] < 0.0)


def _volumes(a: Floats, b: Floats, c: Floats, d: Floats) -> Floats:
    """Return six times the signed volumes of tetrahedra."""
    return np.einsum("...k,...k->...", np.cross(b - a, c - a), d - a)
