"""Directions of looking, parallel projection onto paper, and the visible side of bodies."""

from collections.abc import Sequence
from math import cos, radians, sin
from typing import Any

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.geometry.edges import Edges
from tissuec.model.network import Floats, Indices, Network

FRONT = -90.0, 0.0  # azimuth and elevation [deg]
ACROSS, ABOVE = 24.0, 20.0  # [deg]: aslant, so that depth is seen
SEEN = 0.01  # of the largest side: a motion that is seen
FLAT = 1e-9  # of the largest side: what is thinner has no depth
LOW = 0.12  # of the other sides: what is lower is viewed from higher above
_STRAIGHT = ((0.0, 0.0), FRONT, (-90.0, 90.0))  # along x, y and z


class Projection(Struct, frozen=True):
    """A direction of looking.

    Attributes:
        azimuth: Direction of the viewer around z: 0 at +x, 90 at +y [deg].
        elevation: How far above the horizon [deg].
    """

    azimuth: float
    elevation: float

    @property
    def frame(self) -> Floats:
        """Return unit vectors to the right, upwards and to the eye, shape (3, 3)."""
        a, e = radians(self.azimuth), radians(self.elevation)
        eye = np.array([cos(e) * cos(a), cos(e) * sin(a), sin(e)])
        right = np.array([-sin(a), cos(a), 0.0])
        return np.array([right, np.cross(eye, right), eye])

    @property
    def towards(self) -> Floats:
        """Return the unit vector from the scene to the eye, shape (3,)."""
        return self.frame[2]

    def flat(self, points: NDArray[Any]) -> Floats:
        """Return points of shape (…, 3) on the picture, in their unit, shape (…, 2)."""
        return np.asarray(points @ self.frame[:2].T)

    def nearness(self, points: NDArray[Any]) -> Floats:
        """Return how near points of shape (…, 3) are to the eye, in their unit, shape (…)."""
        return np.asarray(points @ self.towards)

    @property
    def axes(self) -> tuple[str, str] | None:
        """Return which axes of space lead right and up, such as ("x", "z"); None if none do.

        One that leads the other way has a minus.
        """
        names: list[str] = []
        for direction in self.frame[:2]:
            axis = int(np.abs(direction).argmax())
            if abs(direction[axis]) < 1.0 - 1e-9:
                return None
            names.append("xyz"[axis] if direction[axis] > 0.0 else f"−{'xyz'[axis]}")
        return names[0], names[1]


def viewpoint(points: Floats, moved: Sequence[Floats] = ()) -> tuple[float, float]:
    """Return azimuth and elevation from which points and their motion are seen well [deg].

    Their longer side lies across the picture, a little turned; what is flat, and stays so, is
    seen from straight before it.

    Args:
        points: [m], shape (point, 3).
        moved: Displacements at some moments [m], each of shape (point, 3).
    """
    way = np.max(
        [np.abs(one).max(axis=0, initial=0.0) for one in moved] or [np.zeros(3)], axis=0
    )
    wide, deep, high = sides = np.ptp(points, axis=0) if len(points) else np.zeros(3)
    if not sides.any():
        return FRONT
    flat = int(sides.argmin())
    if sides[flat] <= FLAT * sides.max() and way[flat] < SEEN * sides.max():
        return _STRAIGHT[flat]
    azimuth = -90.0 - ACROSS if wide >= deep else -ACROSS
    return azimuth, 2.0 * ABOVE if high < LOW * min(wide, deep) else ABOVE


Mask = NDArray[np.bool_]
_ASIDE = 1e-9  # cosine to the viewer below which a triangle is seen from its edge


def solid_nodes(network: Network) -> Mask:
    """Return which nodes belong to bodies with nodes inside a closed skin, shape (node,)."""
    solid = np.zeros(network.node_count, dtype=bool)
    for body in network.bodies:
        skin, count = network.skin_of(body), body.nodes.stop - body.nodes.start
        solid[body.nodes] = len(np.unique(skin)) < count and Edges.among(skin).is_closed
    return solid


def front_nodes(position: Floats, triangles: NDArray[np.integer], view: Projection) -> Mask:
    """Return which nodes are corners of triangles that face the eye, shape (node,).

    Args:
        position: [m], shape (node, 3).
        triangles: The skin, its normals outwards, shape (triangle, 3).
    """
    corners = position[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    in_front = np.zeros(len(position), dtype=bool)
    facing = normal @ view.towards > _ASIDE * np.linalg.norm(normal, axis=1)
    in_front[triangles[facing]] = True
    return in_front


def seen_springs(
    ends: Indices,
    solid: Mask,
    position: Floats,
    triangles: NDArray[np.integer],
    view: Projection,
) -> Mask:
    """Return which springs are drawn, shape (spring,); of solid bodies those on the front side.

    A node on the front side with fewer than two springs in the skin, as in a lattice of caesium
    chloride, is drawn with all its springs.

    Args:
        ends: Nodes of each spring, shape (spring, 2).
        solid: Which nodes belong to solid bodies, shape (node,).
        position: [m], shape (node, 3).
        triangles: The skin, its normals outwards, shape (triangle, 3).
    """
    in_front = front_nodes(position, triangles, view)
    seen = np.asarray((~solid | in_front)[ends].all(axis=1))
    joins = np.bincount(ends[seen].ravel(), minlength=len(position))
    alone = solid & in_front & (joins < 2)
    return seen | alone[ends].any(axis=1)
