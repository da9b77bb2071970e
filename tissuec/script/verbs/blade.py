"""Blades of cuts: a plane, or a part of one.

A spring is crossed where its ends lie on different sides of the plane and the point in between
lies within the part. A node on the plane, to within a billionth of the size of the scene,
counts as in front of it, so that a plane through a ring of nodes cuts the springs behind the
ring and no others, whatever rounding did to the nodes.
"""

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.model.network import Floats

ON_PLANE = 1e-9


class Blade(Struct, frozen=True, eq=False):
    """The points origin + p first + q second.

    Attributes:
        origin: [m], shape (3,).
        normal: Unit vector, the front of the blade, shape (3,).
        spans: Two vectors in the plane [m], shape (2, 3).
        limited: Whether p and q are confined to 0…1.
    """

    origin: Floats
    normal: Floats
    spans: Floats
    limited: tuple[bool, bool]

    def crosses(
        self, first: Floats, second: Floats, size: float
    ) -> tuple[NDArray[np.bool_], Floats]:
        """Return which segments the blade goes through, and p there, each of shape (segment,).

        Args:
            first, second: Ends of the segments [m], each of shape (segment, 3).
            size: Largest side of the scene [m].
        """
        ahead, behind = ((ends - self.origin) @ self.normal for ends in (first, second))
        is_across = (ahead >= -ON_PLANE * size) != (behind >= -ON_PLANE * size)
        step = np.where(is_across, ahead - behind, 1.0)
        fraction = np.clip(ahead / step, 0.0, 1.0)[:, None]
        point = first + fraction * (second - first) - self.origin
        share = point @ np.linalg.pinv(self.spans)
        for axis, is_limited in enumerate(self.limited):
            if is_limited:
                is_across &= np.abs(share[:, axis] - 0.5) <= 0.5 + ON_PLANE
        return is_across, share[:, 0]


def plane(through: Floats, facing: Floats) -> Blade:
    """Return a whole plane.

    Args:
        through: A point of it [m], shape (3,).
        facing: Its normal, a unit vector, shape (3,).
    """
    return Blade(through, facing, np.zeros((2, 3)), (False, False))


def stroke(start: Floats, stop: Floats, by: Floats) -> Blade | None:
    """Return the parallelogram that an edge sweeps; None if it has no area.

    Args:
        start: One end of the edge [m], shape (3,).
        stop: The other end [m], shape (3,).
        by: Displacement of the edge [m], shape (3,).
    """
    spans = np.array([stop - start, by])
    normal = np.cross(*spans)
    area = np.linalg.norm(normal)
    if area <= ON_PLANE * np.prod(np.linalg.norm(spans, axis=1)):
        return None
    return Blade(start, normal / area, spans, (True, True))


def strip(start: Floats, stop: Floats, facing: Floats) -> Blade | None:
    """Return the endless strip in the plane facing a direction, between the ends of a line.

    Args:
        start: One end of the line [m], shape (3,).
        stop: The other end [m], shape (3,).
        facing: Normal of the plane, of any length and unit, shape (3,).

    Returns:
        The strip; None where the line has no length or does not lie in such a plane.
    """
    along = stop - start
    length = np.linalg.norm(along)
    if length == 0.0 or abs(along @ facing) > 1e-6 * length:
        return None
    # The line counts exactly; what is left of a slant in the direction is taken out of it.
    facing = facing - (facing @ along) / length**2 * along
    facing = facing / np.linalg.norm(facing)
    return Blade(start, facing, np.array([along, np.cross(facing, along)]), (True, False))
