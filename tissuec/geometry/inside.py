"""Inside or outside of a closed surface: winding numbers, counted along rays.

A ray from a point crosses the surface; crossings from inside out count +1, the others -1, and
their sum is the winding number. A ray through an edge or a corner must be counted once. So all
tests determine only on which side of an edge the ray passes, always of the edge in the same
direction, so that both of its triangles get the same answer; a ray exactly on it is thought to
be moved aside by an infinitesimal amount ("simulation of simplicity": Edelsbrunner and Mücke,
ACM Trans. Graph. 9:66, 1990). What rounding may still do shows where rays along x, y and z
disagree: these points are decided by the solid angle of all triangles (van Oosterom and
Strackee, IEEE Trans. Biomed. Eng. 30:125, 1983).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.core.arrays import counted_up
from tissuec.geometry.edges import Floats, Indices
from tissuec.geometry.nearest import TRIANGLE, places

_TOUCHING = 1e-6  # of the size of a patch: a corner so close to a surface lies in it
_AT_ONCE = 4_000_000  # pairs of a point and a triangle examined together


def inside(points: Floats, position: Floats, triangles: Indices) -> NDArray[np.bool_]:
    """Return which points lie inside closed triangles that face outwards.

    Args:
        points: Any points [m], shape (point, 3).
        position: Nodes of the surface [m], shape (node, 3).
        triangles: Corners, shape (triangle, 3).
    """
    middle = position[triangles[0, 0]] if len(triangles) else np.zeros(3)
    points, position = points - middle, position - middle
    along = np.stack([_winding(points, position, triangles, axis) for axis in range(3)])
    result = along[0] > 0
    doubtful = np.flatnonzero((along != along[0]).any(axis=0))
    result[doubtful] = winding_numbers(points[doubtful], position, triangles) > 0.5
    return result


class Overlap(NamedTuple):
    """A closed patch of a surface that lies partly inside another.

    Attributes:
        patch, other: Numbers of both.
        inside: How many corners of the patch lie inside the other one.
        corners: How many it has.
    """

    patch: int
    other: int
    inside: int
    corners: int


def depths(
    position: Floats, triangles: Indices, patch: Indices, which: Indices
) -> tuple[Indices, Overlap | None]:
    """Return how many other closed patches enclose each patch of a surface.

    Args:
        position: Nodes [m], shape (node, 3).
        triangles: Of closed patches that face outwards, each by itself, shape (triangle, 3).
        patch: Number of the patch of each triangle, shape (triangle,).
        which: The patches of interest, ascending, shape (patch,).

    Returns:
        The numbers, shape (patch,), and the first patch that lies partly inside another one,
        None if each lies inside or outside of others as a whole.
    """
    size = len(position)
    own, node = np.divmod(np.unique((patch[:, None] * size + triangles).ravel()), size)
    probes = position[node]
    along = [
        _winding(probes, position, triangles, axis, apart=(own, patch)) for axis in range(3)
    ]
    deep = np.median(along, axis=0).astype(np.int64)
    first, last = (np.searchsorted(own, which, side=side) for side in ("left", "right"))
    for number, start, stop in zip(which.tolist(), first, last, strict=True):
        if np.ptp(deep[start:stop]):
            overlap = _overlap(position, triangles, patch, number, node[start:stop])
            if overlap is not None:
                return deep[first], overlap
    # A corner in the surface of another patch is neither inside nor outside; most others are.
    middle = [int(np.median(deep[i:j])) for i, j in zip(first, last, strict=True)]
    return np.array(middle, dtype=np.int64), None


def _overlap(
    position: Floats, triangles: Indices, patch: Indices, number: int, corners: Indices
) -> Overlap | None:
    """Return which other patch a patch lies partly inside of; None if it only touches others.

    Args:
        position, triangles, patch: As of ``depths``.
        number: Of the patch.
        corners: Its nodes, shape (corner,).
    """
    points = position[corners]
    for other in np.unique(patch[patch != number]).tolist():
        faces = triangles[patch == other]
        within = np.flatnonzero(inside(points, position, faces))
        if not len(within) or len(within) == len(points):
            continue
        depth = [distance_from(point, position[faces]) for point in points[within]]
        deep = int(np.count_nonzero(np.array(depth) > _TOUCHING * np.ptp(points, axis=0).max()))
        if deep:
            return Overlap(number, other, deep, len(points))
    return None


def distance_from(point: Floats, corners: Floats) -> float:
    """Return the distance of a point from the nearest of some triangles [m]."""
    count = len(corners)
    kinds = np.full(count, TRIANGLE)
    found = places(np.broadcast_to(point, (count, 3)), kinds, corners, np.zeros(count))
    return float(-found.depth.max())


def winding_numbers(points: Floats, position: Floats, triangles: Indices) -> Floats:
    """Return the solid angle of triangles seen from points, divided by 4π, shape (point,).

    By A. van Oosterom and J. Strackee, IEEE Trans. Biomed. Eng. 30:125 (1983).

    Args:
        points: Any points [m], shape (point, 3).
        position: Nodes of the surface [m], shape (node, 3).
        triangles: Corners, shape (triangle, 3).
    """
    result = np.empty(len(points))
    step = max(1, _AT_ONCE // max(len(triangles), 1))
    for start in range(0, len(points), step):
        seen = position[triangles] - points[start : start + step, None, None]
        a, b, c = seen[..., 0, :], seen[..., 1, :], seen[..., 2, :]
        la, lb, lc = np.sqrt((seen * seen).sum(axis=-1)).transpose(2, 0, 1)
        above = np.einsum("...i,...i->...", a, np.cross(b, c))
        ab, bc, ca = ((u * v).sum(axis=-1) for u, v in ((a, b), (b, c), (c, a)))
        below = la * lb * lc + ab * lc + bc * la + ca * lb
        result[start : start + step] = np.arctan2(above, below).sum(axis=1) / (2.0 * np.pi)
    return result


def _winding(
    points: Floats,
    position: Floats,
    triangles: Indices,
    axis: int,
    *,
    apart: tuple[Indices, Indices] | None = None,
) -> Indices:
    """Return how often the surface winds round each point, by rays along an axis.

    Args:
        apart: Numbers of points and of triangles; those of one number do not see each other.
    """
    flat, depth = [(axis + 1) % 3, (axis + 2) % 3], axis
    plane, corners = points[:, flat], position[:, flat]
    result = np.zeros(len(points), dtype=np.int64)
    for triangle, point in _near(plane, corners[triangles]):
        if apart is not None:
            others = apart[0][point] != apart[1][triangle]
            triangle, point = triangle[others], point[others]
        turn, share = _crossings(plane[point], corners, triangles[triangle])
        hit = np.flatnonzero(turn)
        at = np.einsum("ij,ij->i", share[hit], position[triangles[triangle[hit]], depth])
        beyond = at > points[point[hit], depth]
        np.add.at(result, point[hit[beyond]], turn[hit[beyond]])
    return result


def _near(plane: Floats, corners: Floats):
    """Yield (triangles, points) such that each point is in the box around its triangle.

    Points are sorted into strips along u and, within a strip, by v, so that those in a box are
    a run in each strip that it touches.

    Args:
        plane: Points, shape (point, 2).
        corners: Corners of the triangles, shape (triangle, 3, 2).
    """
    if not len(plane) or not len(corners):
        return
    low, span = plane.min(axis=0), np.ptp(plane, axis=0)
    strips = max(1, int(np.sqrt(len(plane))))
    width = span[0] / strips or 1.0
    strip = np.minimum((plane[:, 0] - low[0]) // width, strips - 1).astype(np.int64)
    order = np.lexsort((plane[:, 1], strip))
    # One ascending key: the strip, and within it the place along v, well below 1.
    scale = 0.5 / (span[1] or 1.0)
    key = strip[order] + (plane[order, 1] - low[1]) * scale
    least, most = corners.min(axis=1), corners.max(axis=1)
    touches = ((most >= low) & (least <= low + span)).all(axis=1)
    first, last = (
        np.clip((side[:, 0] - low[0]) // width, 0, strips - 1).astype(np.int64)
        for side in (least, most)
    )
    number = np.where(touches, last - first + 1, 0)
    triangle = np.repeat(np.arange(len(corners)), number)
    at = first[triangle] + counted_up(number)
    down, up = (np.clip((side[:, 1] - low[1]) * scale, 0.0, 0.5) for side in (least, most))
    # A little wider than the box, because the key has been rounded.
    least_key: Floats = at + down[triangle] - 1e-9 * strips
    most_key: Floats = at + up[triangle] + 1e-9 * strips
    begin = np.searchsorted(key, least_key)
    end = np.searchsorted(key, most_key, side="right")
    length = np.maximum(end - begin, 0)
    for part in _portions(length):
        runs = length[part]
        yield (
            np.repeat(triangle[part], runs),
            order[np.repeat(begin[part], runs) + counted_up(runs)],
        )


def _portions(length: Indices):
    """Yield slices that together hold everything, each of about as much as fits at once."""
    total = np.cumsum(length)
    start = 0
    while start < len(length):
        before = total[start - 1] if start else 0
        stop = max(start + 1, int(np.searchsorted(total, before + _AT_ONCE, side="right")))
        yield slice(start, stop)
        start = stop


def _crossings(plane: Floats, corners: Floats, triangles: Indices) -> tuple[Indices, Floats]:
    """Return +1 or -1 where a ray goes through its triangle, else 0, and the corners' shares.

    Args:
        plane: Where the rays start, along the two other axes, shape (ray, 2).
        corners: All nodes along these axes, shape (node, 2).
        triangles: One for each ray, shape (ray, 3).
    """
    sides = np.empty((len(plane), 3), dtype=bool)
    areas = np.empty((len(plane), 3))
    for k in range(3):
        one, other = triangles[:, (k + 1) % 3], triangles[:, (k + 2) % 3]
        low, high = np.minimum(one, other), np.maximum(one, other)
        way, to = corners[high] - corners[low], plane - corners[low]
        area = way[:, 0] * to[:, 1] - way[:, 1] * to[:, 0]
        # On the line itself, the ray counts as moved by ε along u and by ε² along v.
        left = np.where(
            area != 0.0, area > 0.0, np.where(way[:, 1], way[:, 1] < 0.0, way[:, 0] > 0.0)
        )
        sides[:, k] = left == (one == low)
        areas[:, k] = np.where(one == low, area, -area)
    turn = np.where(sides.all(axis=1), 1, np.where((~sides).all(axis=1), -1, 0))
    total = areas.sum(axis=1, keepdims=True)
    share = np.divide(areas, total, out=np.full_like(areas, 1.0 / 3.0), where=total != 0.0)
    return turn, share
