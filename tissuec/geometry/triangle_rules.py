"""Rules of quadrature for triangles: barycentric points, and weights whose sum is 1."""

from typing import NamedTuple

import numpy as np

from tissuec.model.network import Floats


class TriangleRule(NamedTuple):
    """Points of a triangle.

    Attributes:
        points: Shares of the corners, shape (point, 3).
        weights: Parts of the area, shape (point,).
    """

    points: Floats
    weights: Floats


def fourth_degree() -> TriangleRule:
    """Return six points that integrate polynomials up to the degree 4.

    (D. A. Dunavant, Int. J. Numer. Meth. Eng. 21:1129, 1985.) Their coordinates solve the
    equations of the moments; see ``tests``.
    """
    found = ((0.445948490915965, 0.223381589678011), (0.091576213509771, 0.109951743655322))
    points = [np.roll([1.0 - 2.0 * a, a, a], k) for a, _ in found for k in range(3)]
    return TriangleRule(np.array(points), np.repeat([weight for _, weight in found], 3))


def even(count: int) -> TriangleRule:
    """Return the middles of equal triangles, ``count`` of them along a side.

    For an integrand that is discontinuous within, they are better than points of a high degree.
    """
    points: list[tuple[float, float, float]] = []
    for i in range(count):
        for j in range(count - i):
            for third in (1, 2) if i + j < count - 1 else (1,):
                a, b = (i + third / 3.0) / count, (j + third / 3.0) / count
                points.append((1.0 - a - b, a, b))
    return TriangleRule(np.array(points), np.full(len(points), 1.0 / len(points)))
