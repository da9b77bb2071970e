"""The triangles of a closed surface that are nearest to points inside of it."""

from typing import NamedTuple

import numpy as np

from tissuec.core.vectors import norm
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
    points: Floats, position: Floats, triangles: Indices, margin: float
) -> NearestTriangles:
    """Return the nearest triangles of points that are, or may get, into a closed surface.

    Args:
        points: [m], shape (point, 3).
        position: Nodes of the surface [m], shape (node, 3).
        triangles: Their corners, facing outwards, shape (triangle, 3).
        margin: How far points may move as seen from the surface [m]; then, too, the nearest
            triangle is among those returned.
    """
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
        may[far] = inside(points[some[far]], position, triangles)
        keeps = may[own] & (distance <= least[own] + 2.0 * margin)
        found.append(NearestTriangles(some[own[keeps]], triangle[keeps], distance[keeps]))
    return NearestTriangles(*(np.concatenate(part) for part in zip(*found, strict=True)))
