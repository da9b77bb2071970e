"""The side of a surface on which contact keeps points: outside of solids.

Distances from triangles have no sign, so that a point which has gone through a surface would be
pushed on. The surface of a solid is closed and faces outwards. So of its triangles, the one
nearest to a point determines on which side the point is: behind that triangle, it is inside.
There its depth in this triangle is R + |x - p| instead of R - |x - p|, with the normal turned
outwards. All other triangles, edges and corners keep their depth without a sign: in a flat
place they cancel, beyond R they vanish, and near the surface they make the energy continuous
where a point crosses it, and where another triangle becomes the nearest one, since both are
equally far away then.

Points of bodies touch solids at a distance R that may be 0, or below it where they overlap as
drawn: then the nearest triangle alone acts.

Where the nearest point is on an edge or a corner, all triangles that have it are equally near,
and the sum of their normals, weighted by their angles there, determines the side (J. A.
Bærentzen, H. Aanæs, IEEE Trans. Vis. Comput. Graph. 11:243, 2005).
"""

from typing import Self

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.arrays import cross, dot, norm
from tissuec.forces.contact.sides_kernel import NONE, TORN
from tissuec.geometry.nearest import NearestPlace, or_one
from tissuec.model.network import Floats, Indices


class Meetings(Struct, frozen=True, eq=False):
    """Which groups of nodes and points may touch which surfaces, and on which side of these.

    Attributes:
        group, of: Of each node and face, a row and a column of the tables, shapes (m,) and
            (face,).
        meets: Which nodes may touch which faces at all, shape (group, surface).
        sided: Which groups are kept outside of which surfaces, ``CLOSED`` or ``TORN``, else 0,
            shape as ``meets``.
        distances: How far from surfaces groups touch them [m], NaN where it is the radius of
            their faces, shape as ``meets``.
        closed: Triangles of the surfaces that keep points outside, with those in planes of
            symmetry, which touch nothing, by the column of ``sided``.
        depths: How far behind the other surfaces, which are open, points are still kept
            outside [m], by the column of ``sided``.
    """

    group: Indices
    of: Indices
    meets: NDArray[np.bool_]
    sided: Indices
    distances: Floats
    closed: dict[int, Indices]
    depths: dict[int, float] = {}

    @classmethod
    def of_all(cls, nodes: int, faces: int) -> Self:
        """Return the tables where every node may touch every face, from either side."""
        group, of = np.zeros(nodes, dtype=np.int64), np.zeros(faces, dtype=np.int64)
        one = np.ones((1, 1), dtype=bool)
        return cls(group, of, one, np.zeros((1, 1), np.int64), np.full((1, 1), np.nan), {})

    @property
    def is_sided(self) -> bool:
        """Return whether anything is kept outside of anything."""
        return bool(self.sided.any())


def kept_outside(
    place: NearestPlace,
    corners: Floats,
    radius: Floats,
    sided: Indices,
    group: Indices,
    alike: float,
) -> NearestPlace:
    """Return places with the signed depth of points that are inside closed surfaces.

    Args:
        place: Where points are in shapes.
        corners: Of the shapes [m], shape (pair, 3, 3).
        radius: [m], shape (pair,).
        sided: Kind of the surface of those pairs whose triangles determine the side of their
            point, else 0, shape (pair,).
        group: Number of the point and the surface of each pair, shape (pair,).
        alike: Length below which distances are equal [m].
    """
    own = np.flatnonzero(sided)
    _, of = np.unique(group[own], return_inverse=True)
    distance = radius[own] - place.depth[own]
    nearest = np.full(int(of.max()) + 1, np.inf)
    np.minimum.at(nearest, of, distance)
    near = distance <= nearest[of] + alike
    # Of equally near triangles, the first one.
    first = np.flatnonzero(near)[np.unique(of[near], return_index=True)[1]]
    alone = np.asarray((place.weights[own[first]] > NONE).all(axis=1))
    on_rim = (sided[own[first]] == TORN) & ~alone & (np.bincount(of[near]) == 1)
    near &= ~alone[of]
    near[first] = True
    facing = _facing(corners[own[near]], place.weights[own[near]])
    side, outwards = np.zeros(len(first)), np.zeros((len(first), 3))
    away = place.normal[own[near]] * distance[near, None]
    np.add.at(side, of[near], dot(facing, away))
    np.add.at(outwards, of[near], facing)
    least = distance[first]
    close = least <= alike
    changes = ((side < 0.0) | close) & ~on_rim
    outwards /= or_one(norm(outwards))[:, None]
    outwards = np.where(close[:, None], outwards, -place.normal[own[first]])
    behind, outwards = own[first[changes]], outwards[changes]
    below = np.where(side < 0.0, least, -least)[changes]
    depth, normal = place.depth.copy(), place.normal.copy()
    depth[behind] = radius[behind] + below
    normal[behind] = outwards
    return place._replace(depth=depth, normal=normal)


def _facing(corners: Floats, weights: Floats) -> Floats:
    """Return normals of triangles times their angles at the nearest points, shape (n, 3).

    Args:
        corners: [m], shape (n, 3, 3).
        weights: Of the corners in the nearest points, shape (n, 3).
    """
    row, corner = np.arange(len(corners)), weights.argmax(axis=1)
    here = corners[row, corner]
    one, other = corners[row, corner - 2] - here, corners[row, corner - 1] - here
    normal = cross(one, other)
    twice: Floats = norm(normal)
    at_corner = (weights > NONE).sum(axis=1) == 1
    angle = np.where(at_corner, np.arctan2(twice, dot(one, other)), np.pi)
    return normal * (angle / or_one(twice))[:, None]
