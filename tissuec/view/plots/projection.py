"""Directions of looking, and the parallel projection of points onto paper."""

from collections.abc import Sequence
from math import cos, radians, sin
from typing import Any

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.model.network import Floats

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
