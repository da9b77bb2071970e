"""What is near points: others in balls and boxes, and triangles of a closed surface."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.core.arrays import counted_up, cross, dot, norm
from tissuec.geometry.edges import Floats, Indices
from tissuec.geometry.inside import inside
from tissuec.geometry.nearest import TRIANGLE, places

MOST_TOGETHER = 1_000_000  # pairs of a point and a triangle that are examined at once


class NearestTriangles(NamedTuple):
    """Triangles that may be the nearest ones to points.

    Attributes:
        point, triangle: Numbers of both, shape (pair,).
        distance: Of both [m], shape (pair,).
    """

    point: Indices
    triangle: Indices
    distance: Floats


def nearest_triangles(
    points: Floats,
    position: Floats,
    triangles: Indices,
    margin: float,
    closed: Indices | None = None,
) -> NearestTriangles:
    """Return the nearest triangles of points that are, or may get, into a closed surface.

    Args:
        points: [m], shape (point, 3).
        position: Nodes of the surface [m], shape (node, 3).
        triangles: Their corners, facing outwards, shape (triangle, 3).
        margin: How far points may move as seen from the surface [m]; then, too, the nearest
            triangle is among those returned.
        closed: Corners of the whole surface, of which the triangles are a part; None if they
            are all of it.
    """
    closed = triangles if closed is None else closed
    corners = position[triangles]
    low, high = corners.min(axis=(0, 1)) - margin, corners.max(axis=(0, 1)) + margin
    there = np.flatnonzero(((points >= low) & (points <= high)).all(axis=1))
    middle = corners.mean(axis=1)
    size: Floats = norm(corners - middle[:, None]).max(axis=1)
    none = np.zeros(0, dtype=np.int64)
    found = [NearestTriangles(none, none, np.zeros(0))]
    rows = max(1, MOST_TOGETHER // len(triangles))
    for some in np.split(there, range(rows, len(there), rows)):
        away: Floats = norm(points[some, None] - middle)
        near = away - size <= away.min(axis=1, keepdims=True) + 2.0 * margin
        own, triangle = np.nonzero(near)
        kind = np.full(len(own), TRIANGLE)
        x, flat = points[some[own]], np.zeros(len(own))
        distance = -places(x, kind, corners[triangle], flat).depth
        least = np.full(len(some), np.inf)
        np.minimum.at(least, own, distance)
        may = least <= margin
        far = np.flatnonzero(~may)
        may[far] = inside(points[some[far]], position, closed)
        keeps = may[own] & (distance <= least[own] + 2.0 * margin)
        found.append(NearestTriangles(some[own[keeps]], triangle[keeps], distance[keeps]))
    return NearestTriangles(*(np.concatenate(part) for part in zip(*found, strict=True)))


def triangles_within(
    points: Floats, position: Floats, triangles: Indices, depth: float, margin: float
) -> NearestTriangles:
    """Return the nearest triangles of points that are behind an open surface, or close to it.

    Args:
        points: [m], shape (point, 3).
        position: Nodes of the surface [m], shape (node, 3).
        triangles: Their corners, as seen from the front, shape (triangle, 3).
        depth: Distance from the nearest triangle up to which points behind it count [m].
        margin: As of ``nearest_triangles`` [m].
    """
    corners = position[triangles]
    middle = corners.mean(axis=1)
    size: Floats = norm(corners - middle[:, None]).max(axis=1)
    triangle, own = in_balls(middle, size + depth + margin, points)
    kind, flat = np.full(len(own), TRIANGLE), np.zeros(len(own))
    place = places(points[own], kind, corners[triangle], flat)
    distance, least = -place.depth, np.full(len(points), np.inf)
    np.minimum.at(least, own, distance)
    a, b, c = corners[triangle].swapaxes(0, 1)
    behind = (distance <= least[own]) & (dot(place.normal, cross(b - a, c - a)) < 0.0)
    reach = np.full(len(points), margin)
    reach[own[behind]] += depth
    keeps = (least <= reach)[own] & (distance <= least[own] + 2.0 * margin)
    return NearestTriangles(own[keeps], triangle[keeps], distance[keeps])


FEW = 200_000  # pairs that are compared one by one


def in_balls(middle: Floats, radius: Floats, points: Floats) -> tuple[Indices, Indices]:
    """Return all pairs of a ball and a point inside it, as two arrays of shape (pair,).

    Args:
        middle: Of balls [m], shape (ball, 3).
        radius: Of balls [m], shape (ball,).
        points: [m], shape (point, 3).
    """
    # Bodies that touch each other are near each other with few of their nodes and faces.
    widest = float(radius.max(initial=0.0))
    point = np.flatnonzero(_in_box(points, middle, widest))
    ball = np.flatnonzero(_in_box(middle, points[point], widest))
    if (few := _beside(middle[ball], radius[ball], points[point])) is not None:
        ball, point = ball[few[0]], point[few[1]]
        within = norm(middle[ball] - points[point]) <= radius[ball]
        return ball[within], point[within]
    none = np.zeros(0, dtype=np.int64)
    balls, inside = [none], [none]
    tree = _tree(points[point])
    # A search has one radius: balls are searched by size, each up to twice as large as others.
    size = np.frexp(radius[ball])[1]
    for each in np.unique(size):
        own = ball[size == each]
        found = _tree(middle[own]).sparse_distance_matrix(
            tree, radius[own].max(), output_type="ndarray"
        )
        within = found["v"] <= radius[own[found["i"]]]
        balls.append(own[found["i"][within]])
        inside.append(point[found["j"][within]])
    return np.concatenate(balls), np.concatenate(inside)


def _beside(middle: Floats, radius: Floats, points: Floats) -> tuple[Indices, Indices] | None:
    """Return pairs that are near each other along one axis; None if there are many.

    A few are compared in less time than it takes to import a library of trees.
    """
    if not len(points):
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
    axis = int(np.ptp(points, axis=0).argmax())
    order = np.argsort(points[:, axis], kind="stable")
    along, centre = points[order, axis], middle[:, axis]
    first = np.searchsorted(along, centre - radius)
    count = np.searchsorted(along, centre + radius, side="right") - first
    if count.sum() > FEW:
        return None
    ball = np.repeat(np.arange(len(middle)), count)
    return ball, order[np.repeat(first, count) + counted_up(count)]


def _tree(points: Floats) -> Any:
    """Return a tree that is built in less time than searches in a better one would save."""
    from scipy.spatial import cKDTree  # pyright: ignore[reportAttributeAccessIssue]

    return cKDTree(points, compact_nodes=False, balanced_tree=False)


def are_between(points: Floats, low: Floats, high: Floats) -> NDArray[np.bool_]:
    """Return which points are in boxes, shape (point,).

    Args:
        points: [m], shape (point, 3).
        low, high: Opposite corners of the box of each point, or of all [m], shape (…, 3).
    """
    inside = (points >= low) & (points <= high)
    return np.asarray(inside[:, 0] & inside[:, 1] & inside[:, 2])


def _in_box(points: Floats, others: Floats, margin: float) -> NDArray[np.bool_]:
    """Return which points are in the box around others, or no further from it, (point,)."""
    if not len(others):
        return np.zeros(len(points), dtype=bool)
    return are_between(points, others.min(axis=0) - margin, others.max(axis=0) + margin)
