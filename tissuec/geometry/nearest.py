"""The nearest points of capsules, planes and triangles, many at once."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.core.arrays import dot
from tissuec.geometry.edges import Floats, Indices

CAPSULE, PLANE, TRIANGLE = range(3)


class NearestPlace(NamedTuple):
    """Nearest places of shapes to points, for each pair of a point and a shape.

    Attributes:
        depth: [m]; positive where the shape touches, shape (pair,).
        normal: Away from the shape, shape (pair, 3).
        weights: Of the points of the shape in where it touches, shape (pair, 3).
    """

    depth: Floats
    normal: Floats
    weights: Floats

    def some(self, which: NDArray[np.bool_] | Indices) -> "NearestPlace":
        """Return the places of some pairs.

        Args:
            which: Mask of shape (pair,), or indices of shape (n,).
        """
        return NearestPlace(*(part[which] for part in self))


def places(x: Floats, kind: Indices, corners: Floats, radius: Floats) -> NearestPlace:
    """Return where points are in shapes.

    Args:
        x: The points [m], shape (pair, 3).
        kind: ``CAPSULE``, ``PLANE`` or ``TRIANGLE``, shape (pair,).
        corners: Both ends of the line of a capsule; a point of a plane and one straight in
            front of it; corners of a triangle [m], shape (pair, 3, 3).
        radius: Around the line of a capsule or the face of a triangle [m], shape (pair,).
    """
    parts = [np.zeros((len(x), *rest)) for rest in ((), (3,), (3,))]
    for which, look in ((CAPSULE, _in_capsule), (PLANE, _in_plane), (TRIANGLE, _in_triangle)):
        some = kind == which
        if some.any():
            found = look(x[some], corners[some], radius[some])
            for part, values in zip(parts, found, strict=True):
                part[some] = values
    return NearestPlace(*parts)


def or_one(values: Floats) -> Floats:
    """Return values, of any unit and shape, with those that are not positive replaced by 1."""
    return np.where(values > 0.0, values, 1.0)


def _from_point(r: Floats, radius: Floats, weights: Floats) -> NearestPlace:
    """Return places from the vectors that lead from the nearest points [m]."""
    distance = np.linalg.norm(r, axis=1)
    # On the point itself there is no direction out of it, and so no force.
    inverse = np.where(distance > 0.0, 1.0 / or_one(distance), 0.0)
    return NearestPlace(radius - distance, r * inverse[:, None], weights)


def _in_capsule(x: Floats, corners: Floats, radius: Floats) -> NearestPlace:
    p, d = corners[:, 0], corners[:, 1] - corners[:, 0]
    s = np.clip(dot(x - p, d) / or_one(dot(d, d)), 0.0, 1.0)
    weights = np.stack([1.0 - s, s, np.zeros_like(s)], axis=1)
    return _from_point(x - p - s[:, None] * d, radius, weights)


def _in_plane(x: Floats, corners: Floats, radius: Floats) -> NearestPlace:
    p, d = corners[:, 0], corners[:, 1] - corners[:, 0]
    normal = d / np.linalg.norm(d, axis=1)[:, None]
    return NearestPlace(-dot(normal, x - p), normal, np.broadcast_to([1.0, 0.0, 0.0], x.shape))


def _in_triangle(x: Floats, corners: Floats, radius: Floats) -> NearestPlace:
    """Look from the nearest of the face and the three edges."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    ab, ac, ax = b - a, c - a, x - a
    d00, d01, d11 = dot(ab, ab), dot(ab, ac), dot(ac, ac)
    d20, d21 = dot(ax, ab), dot(ax, ac)
    area = d00 * d11 - d01 * d01
    flat = or_one(area)
    v, w = (d11 * d20 - d01 * d21) / flat, (d00 * d21 - d01 * d20) / flat
    weights = np.stack([1.0 - v - w, v, w], axis=1)
    on_face = (area > 0.0) & (weights >= 0.0).all(axis=1)
    nearest = np.where(on_face, 0.0, np.inf)
    for i in range(3):
        j = (i + 1) % 3
        p, d = corners[:, i], corners[:, j] - corners[:, i]
        s = np.clip(dot(x - p, d) / or_one(dot(d, d)), 0.0, 1.0)
        apart = np.linalg.norm(x - p - s[:, None] * d, axis=1)
        takes = apart < nearest
        nearest = np.where(takes, apart, nearest)
        edge = np.zeros_like(weights)
        edge[:, i], edge[:, j] = 1.0 - s, s
        weights = np.where(takes[:, None], edge, weights)
    return _from_point(x - np.einsum("np,npk->nk", weights, corners), radius, weights)
