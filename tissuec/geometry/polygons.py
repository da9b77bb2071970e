"""Division of faces with many corners into triangles.

A face that its first corner sees whole is a fan of triangles around it. Others are divided by
ear clipping (G. H. Meisters, Polygons have ears, Amer. Math. Monthly 82(6):648, 1975), in the
plane to which its corners lie closest: that of Newell's normal.
"""

import numpy as np
from numpy.typing import NDArray

from tissuec.geometry.edges import Floats, Indices

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
