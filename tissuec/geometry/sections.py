"""Polygons in which a plane meets tetrahedra.

The plane is n·p = d. A corner with n·p ≥ d is in front of it, as for blades. Between a corner
in front, at the height h = n·p - d, and one behind at -k, the plane meets the edge at the part
h / (h + k). One corner against three gives a triangle, two against two a quadrilateral.
"""

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.geometry.edges import Floats, Indices


class SectionPolygons(Struct, frozen=True, eq=False):
    """Triangles and quadrilaterals in a plane, in turn to the left as seen from its front.

    The last corner of a triangle is there twice.

    Attributes:
        ends: The edge on which each corner lies, lower node first, shape (polygon, 4, 2).
        part: How far along it, from 0 to 1, shape (polygon, 4).
        cell: The tetrahedron of each, shape (polygon,).
    """

    ends: Indices
    part: Floats
    cell: Indices

    def mixed(self, values: NDArray[np.floating]) -> Floats:
        """Return values at the corners, in their unit, shape (polygon, 4, …).

        Args:
            values: At nodes, shape (node, …).
        """
        first, second = np.moveaxis(values[self.ends], 2, 0)
        part = self.part.reshape(*self.part.shape, *[1] * (first.ndim - 2))
        return np.asarray(first + part * (second - first))

    def areas(self, position: Floats) -> Floats:
        """Return the areas of the polygons [m²], shape (polygon,).

        Args:
            position: Of nodes [m], shape (node, 3).
        """
        a, b, c, d = self.mixed(position).swapaxes(0, 1)
        return np.linalg.norm(np.cross(c - a, d - b), axis=1) / 2.0


def plane_section(
    position: Floats, tetrahedra: Indices, normal: Floats, offset: float
) -> SectionPolygons:
    """Return where a plane meets tetrahedra.

    Args:
        position: Nodes [m], shape (node, 3).
        tetrahedra: Corners, shape (tetrahedron, 4).
        normal: Of the plane, a unit vector, shape (3,).
        offset: Of the plane from the origin along its normal [m].
    """
    height = position @ normal - offset
    front = height[tetrahedra] >= 0.0
    count = front.sum(axis=1)
    cell = np.flatnonzero((count > 0) & (count < 4))
    # Corners in front first; the sort keeps the order within both sides.
    order = np.argsort(~front[cell], axis=1, kind="stable")
    corners, count = np.take_along_axis(tetrahedra[cell], order, axis=1), count[cell]
    a, b, c, d = corners.T
    ends = np.empty((len(cell), 4, 2), dtype=np.int64)
    for number, pairs in (
        (1, [(a, b), (a, c), (a, d), (a, d)]),
        (2, [(a, c), (a, d), (b, d), (b, c)]),
        (3, [(a, d), (b, d), (c, d), (c, d)]),
    ):
        chosen = count == number
        for k, pair in enumerate(pairs):
            ends[chosen, k] = np.stack(pair, axis=1)[chosen]
    ends.sort(axis=2)
    first, second = np.moveaxis(height[ends], 2, 0)
    part = np.asarray(first / (first - second))
    found = SectionPolygons(ends, part, cell)
    p, q, r, s = found.mixed(position).swapaxes(0, 1)
    turned = np.cross(r - p, s - q) @ normal < 0.0
    ends[turned], part[turned] = ends[turned, ::-1], part[turned, ::-1]
    return found
