"""The side of a surface on which contact keeps points: axes and threads, outside of solids.

Distances from triangles have no sign, so that a point which has gone through a surface would be
pushed on. The surface of a solid is closed and faces outwards. So of its triangles, the one
nearest to a point determines on which side the point is: behind that triangle, it is inside.
There its depth in this triangle is R + |x - p| instead of R - |x - p|, with the normal turned
outwards. All other triangles, edges and corners keep their depth without a sign: in a flat
place they cancel, beyond R they vanish, and near the surface they make the energy continuous
where a point crosses it, and where another triangle becomes the nearest one, since both are
equally far away then.

Where the nearest point is on an edge or a corner, all triangles that have it are equally near,
and the sum of their normals, weighted by their angles there, determines the side (J. A.
Bærentzen, H. Aanæs, IEEE Trans. Vis. Comput. Graph. 11:243, 2005).
"""

import numpy as np
from numpy.typing import NDArray

from tissuec.core.vectors import cross, dot, norm
from tissuec.forces.contact_sides_kernel import ALIKE, NONE
from tissuec.geometry.nearest import NearestPlace, or_one
from tissuec.model.network import Floats, Indices


def kept_outside(
    place: NearestPlace,
    corners: Floats,
    radius: Floats,
    sided: NDArray[np.bool_],
    group: Indices,
) -> NearestPlace:
    """Return places with the signed depth of points that are inside closed surfaces.

    Args:
        place: Where points are in shapes.
        corners: Of the shapes [m], shape (pair, 3, 3).
        radius: [m], shape (pair,).
        sided: Which pairs are triangles that determine the side of their point, shape (pair,).
        group: Number of the point and the surface of each pair, shape (pair,).
    """
    own = np.flatnonzero(sided)
    _, of = np.unique(group[own], return_inverse=True)
    distance = radius[own] - place.depth[own]
    nearest = np.full(int(of.max()) + 1, np.inf)
    np.minimum.at(nearest, of, distance)
    near = distance <= nearest[of] + ALIKE * radius[own]
    # Of equally near triangles, the first one.
    first = np.flatnonzero(near)[np.unique(of[near], return_index=True)[1]]
    alone = np.asarray((place.weights[own[first]] > NONE).all(axis=1))
    near &= ~alone[of]
    near[first] = True
    facing = _facing(corners[own[near]], place.weights[own[near]])
    side, outwards = np.zeros(len(first)), np.zeros((len(first), 3))
    away = place.normal[own[near]] * distance[near, None]
    np.add.at(side, of[near], dot(facing, away))
    np.add.at(outwards, of[near], facing)
    least = distance[first]
    close = least <= ALIKE * radius[own[first]]
    changes = (side < 0.0) | close
    outwards /= or_one(norm(outwards))[:, None]
    outwards = np.where(close[:, None], outwards, -place.normal[own[first]])
    behind, outwards = own[first[changes]], outwards[changes]
    below = np.where(side < 0.0, least, -least)[changes]
    depth, normal, curvature, pressing = (
        part.copy() for part in (place.depth, place.normal, place.curvature, place.pressing)
    )
    depth[behind] = radius[behind] + below
    normal[behind] = outwards
    curvature[behind] *= np.where(below < 0.0, 1.0, -1.0)
    pressing[behind] = -place.weights[behind, :, None] * outwards[:, None, :]
    return place._replace(depth=depth, normal=normal, curvature=curvature, pressing=pressing)


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
