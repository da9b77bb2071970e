"""Divisions of polygons into triangles, and of closed surfaces into tetrahedra.

They are the regular triangulation of the nodes (F. Aurenhammer, SIAM J. Comput. 16:78, 1987):
the lower side of the convex hull of (p, |p|² - w), with the weight w of each node. With equal
weights these are Delaunay's tetrahedra. Nodes of crystals lie on common spheres, where anything
would be one of many triangulations; small weights decide so that faces on the surface are its
triangles:

    w = a (n·p)² + b k,  in units of the usual edge of the surface,

n being (1, 1, 1), which divides squares along their diagonal (1, 1), and k the number of
triangles around a node, which joins the corners of centred squares and not their centres.
Triangulations of this kind match face by face, so that no gap is left between tetrahedra.

Division of faces with many corners into triangles.

A face that its first corner sees whole is a fan of triangles around it. Others are divided by
ear clipping (G. H. Meisters, Polygons have ears, Amer. Math. Monthly 82(6):648, 1975), in the
plane to which its corners lie closest: that of Newell's normal.
"""

import numpy as np
from numpy.typing import NDArray

from tissuec.geometry.edges import Edges, Floats, Indices
from tissuec.geometry.inside import inside

_ALONG, _AROUND, _AT_RANDOM = 1e-3, 1e-5, 1e-7  # of squares of the usual edge
_UPRIGHT = 1e-9  # part of a normal along the lift: what has less is a sliver in the surface
#: Corners of the face opposite each corner of a tetrahedron, in turn as seen from outside.
OPPOSITE = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]])


def filling_tetrahedra(position: Floats, triangles: Indices) -> Indices:
    """Return tetrahedra that fill a closed surface, shape (tetrahedron, 4).

    They know nothing of the surface: where it is hollow and its triangles are large, some cross
    it, or leave gaps. Those whose centre lies outside are left out. Volumes are positive; those
    of tetrahedra between two triangles of the surface and another diagonal of their
    quadrilateral, which is usually flat, may have any sign.

    Args:
        position: Nodes of the surface and inside [m], shape (node, 3).
        triangles: Of the surface, facing outwards, shape (triangle, 3).
    """
    if len(position) < 4 or not len(triangles):
        return np.zeros((0, 4), dtype=np.int64)
    cells = oriented(position, regular_triangulation(position, triangles))
    cells = cells[inside(position[cells].mean(axis=1), position, triangles)]
    return np.concatenate([cells, _between(cells, triangles)])


def volumes(position: Floats, tetrahedra: Indices) -> Floats:
    """Return the signed volumes of tetrahedra [m³], shape (tetrahedron,).

    Args:
        position: Nodes [m], shape (node, 3).
        tetrahedra: Corners, shape (tetrahedron, 4).
    """
    a, b, c, d = position[tetrahedra].swapaxes(0, 1)
    return np.asarray(np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6.0)


def oriented(position: Floats, tetrahedra: Indices) -> Indices:
    """Return tetrahedra with their corners in an order of a positive volume.

    Args:
        position: Nodes [m], shape (node, 3).
        tetrahedra: Corners in any order, shape (tetrahedron, 4); also of the result.
    """
    turned = volumes(position, tetrahedra) < 0.0
    return np.where(turned[:, None], tetrahedra[:, [0, 2, 1, 3]], tetrahedra)


def _between(cells: Indices, triangles: Indices) -> Indices:
    """Return tetrahedra between two triangles of the surface and two faces inside.

    Args:
        cells: All others, shape (tetrahedron, 4).
        triangles: The surface, shape (triangle, 3).
    """
    size = int(max(cells.max(initial=0), triangles.max())) + 1
    powers = np.array([size * size, size, 1])
    keys, count = np.unique(
        np.sort(cells[:, OPPOSITE].reshape(-1, 3), axis=1) @ powers, return_counts=True
    )
    own = np.sort(triangles, axis=1) @ powers
    outer = keys[(count == 1) & ~np.isin(keys, own)]
    left = triangles[~np.isin(own, keys)]
    if not len(left) or not len(outer):
        return cells[:0]
    one, other, alike = Edges.among(left).pairs
    found: list[Indices] = []
    for first, second in zip(left[one[alike]], left[other[alike]], strict=True):
        (b,) = first[~np.isin(first, second)]
        (d,) = second[~np.isin(second, first)]
        turn = int(np.flatnonzero(first == b)[0])
        c, a = first[(turn + 1) % 3], first[(turn + 2) % 3]
        flipped = np.sort([[a, b, d], [b, c, d]], axis=1) @ powers
        if np.isin(flipped, outer).all():
            found.append(np.array([d, a, b, c]))
            outer = np.setdiff1d(outer, flipped)
    return np.array(found, dtype=np.int64).reshape(-1, 4)


def regular_triangulation(position: Floats, triangles: Indices) -> Indices:
    """Return the regular triangulation of some nodes, shape (tetrahedron, 4).

    Tetrahedra are in any orientation, and match face by face.

    Args:
        position: Of the nodes [m], shape (node, 3).
        triangles: Some between them, shape (triangle, 3), whose usual edge scales the weights.
    """
    from scipy.spatial import ConvexHull, QhullError

    if len(position) == 4:
        return np.arange(4)[None]
    ends = position[Edges.among(triangles).ends]
    edge = float(np.median(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)))
    place = (position - position.mean(axis=0)) / (edge or 1.0)
    around = np.bincount(triangles.ravel(), minlength=len(place))
    noise = np.random.default_rng(0).random(len(place))  # the same in each run
    weight = _ALONG * place.sum(axis=1) ** 2 + _AROUND * around + _AT_RANDOM * noise
    lifted = np.column_stack([place, (place**2).sum(axis=1) - weight])
    try:
        hull = ConvexHull(lifted)
    except QhullError:  # all in a plane
        return np.zeros((0, 4), dtype=np.int64)
    return hull.simplices[hull.equations[:, 3] < -_UPRIGHT].astype(np.int64)


_FLAT = 1e-9  # of the area of a face: what less area than that is, has none


class CrossingError(ValueError):
    """A face crosses itself; ``row`` is its number."""

    def __init__(self, row: int):
        self.row = row
        super().__init__(row)


def triangles_of(position: Floats, polygons: Indices) -> Indices:
    """Return faces as triangles that face the same way.

    Args:
        position: Of the nodes, shape (node, 3).
        polygons: Corners, shape (face, corner), five or more.

    Returns:
        Corners, shape (face × (corner - 2), 3), those of a face one after the other.

    Raises:
        CrossingError: The corners of a face are on a line that crosses itself.
    """
    count = polygons.shape[1]
    points = position[polygons] - position[polygons[:, :1]]
    # Triangles of the fan; their sum is Newell's normal.
    parts = np.cross(points[:, 1:-1], points[:, 2:])
    normal = parts.sum(axis=1)
    size = np.einsum("ij,ij->i", normal, normal)
    areas = np.linalg.norm(parts, axis=2).sum(axis=1)
    if (cancelled := size < (_FLAT * areas) ** 2).any():
        raise CrossingError(int(np.argmax(cancelled)))
    seen = np.einsum("ikj,ij->ik", parts, normal)
    fan = np.array([(0, k, k + 1) for k in range(1, count - 1)], dtype=np.int64)
    local = np.tile(fan, (len(polygons), 1, 1))
    for row in np.flatnonzero((seen < -_FLAT * size[:, None]).any(axis=1)).tolist():
        ears = _ears(_in_plane(points[row], normal[row]))
        if ears is None:
            raise CrossingError(row)
        local[row] = ears
    found = np.take_along_axis(polygons[:, :, None], local.reshape(len(local), -1, 1), axis=1)
    return found.reshape(-1, 3)


def _in_plane(points: Floats, normal: Floats) -> Floats:
    """Return points along two axes that turn the normal towards the viewer, shape (n, 2)."""
    axis = np.eye(3)[int(np.argmin(np.abs(normal)))]
    first = np.cross(axis, normal)
    first /= np.linalg.norm(first)
    second = np.cross(normal / np.linalg.norm(normal), first)
    return points @ np.stack([first, second], axis=1)


def _ears(flat: Floats) -> Indices | None:
    """Return a polygon in a plane, anticlockwise, as triangles; None if it crosses itself."""
    left = list(range(len(flat)))
    found: list[list[int]] = []
    least = _FLAT * float(np.ptp(flat, axis=0).max()) ** 2
    while len(left) > 3:
        for place in range(len(left)):
            ear = [left[place - 1], left[place], left[(place + 1) % len(left)]]
            area = _twice_area(*flat[ear])
            # A corner on a straight line has no area, and nothing lies in it.
            if (area > least and not _holds(flat, ear, left)) or abs(area) <= least:
                found.append(ear)
                del left[place]
                break
        else:
            return None
    if _twice_area(*flat[left]) < -least:
        return None
    return np.array([*found, left], dtype=np.int64)


def _twice_area(a: Floats, b: Floats, c: Floats) -> float:
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


def _holds(flat: Floats, ear: list[int], left: list[int]) -> bool:
    """Return whether another corner lies in an ear, or on its border."""
    corners = flat[ear]
    others = flat[left]
    apart = (others[:, None] != corners[None]).any(axis=2).all(axis=1)
    inside: NDArray[np.bool_] = apart
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        side = (b[0] - a[0]) * (others[:, 1] - a[1]) - (b[1] - a[1]) * (others[:, 0] - a[0])
        inside = inside & (side >= 0.0)
    return bool(inside.any())
