"""The camera: an orbit about a target, z upwards, in perspective.

With azimuth α and elevation ε the eye is in the direction d = (cos ε cos α, cos ε sin α, sin ε)
from the target; r = (-sin α, cos α, 0) points to the right and d × r upwards. A point q (from
the target) is seen at (q·r, q·(d × r)) / (D - q·d) from the distance D. The page computes the
same (``web/camera.js``).
"""

from math import radians, tan
from typing import Any

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.arrays import directions
from tissuec.model.network import Floats
from tissuec.view.player.film import PlayerData
from tissuec.view.plots.projection import Projection

ANGLE = 36.0  # of the longer side of the picture [deg]
MARGIN = 0.86  # of the picture, that the motion fills
_FAR = 4.0  # sizes of a usual frame: what moves further is followed
_SHOWN = 5.2  # units of instruments that belong to the picture
_AHEAD = 0.6  # sizes of the nets around them, within which tools belong to the picture


class Framing(Struct, frozen=True, eq=False):
    """The contents of a picture.

    Attributes:
        points: [m], shape (point, 3); about the middle of each frame if it is followed.
        middle: Of the nodes in each frame [m], shape (frame, 3).
        follows: Whether the middle of each frame stays in the middle of the picture.
    """

    points: Floats
    middle: Floats
    follows: bool

    @property
    def size(self) -> float:
        """Return the diagonal of the box around it [m]."""
        return float(np.linalg.norm(np.ptp(self.points, axis=0))) or 1.0


def framing(film: PlayerData) -> Framing:
    """Return the points that a picture of all frames must include, the outermost ones."""
    nodes = film.position[:, film.matter]
    middle = nodes.mean(axis=1)
    sizes = np.linalg.norm(nodes.max(axis=1) - nodes.min(axis=1), axis=1)
    whole = float(np.linalg.norm(nodes.max(axis=(0, 1)) - nodes.min(axis=(0, 1))))
    follows = whole > _FAR * float(np.median(sizes)) > 0.0
    found = [outermost(frame - middle[row] * follows) for row, frame in enumerate(nodes)]
    if follows:  # what flew apart at the end does not count
        found = [points for points, size in zip(found, sizes, strict=True)
                 if size <= _FAR * np.median(sizes)]  # fmt: skip
    points = outermost(np.concatenate(found))
    return Framing(np.concatenate([points, _near(film, points)]), middle, follows)


def _near(film: PlayerData, points: Floats) -> Floats:
    """Return the outermost points of tools that come close enough."""
    low, high = points.min(axis=0), points.max(axis=0)
    reach = _AHEAD * float(np.linalg.norm(high - low))
    found = [np.zeros((0, 3))]
    for solid in film.solids:
        ends = film.position[:, [*solid.points[: 1 if solid.kind != "capsule" else 2]]]
        ends = ends.reshape(-1, 3)
        near = ((ends > low - reach) & (ends < high + reach)).all(axis=1)
        sides = solid.radius * np.concatenate([np.eye(3), -np.eye(3)])
        found.append((outermost(ends[near])[:, None] + sides).reshape(-1, 3))
    for instrument in film.instruments:
        begin, end = (int(min(at, len(film.times) - 1)) for at in instrument.life)
        origin, along = film.position[begin : end + 1, instrument.points[:2]].swapaxes(0, 1)
        there = ((origin > low - reach) & (origin < high + reach)).all(axis=1)
        found += [outermost((origin + _SHOWN * (along - origin))[there])]
    return np.concatenate(found)


def outermost(points: NDArray[Any]) -> Floats:
    """Return the points that are furthest in some direction [m], shape (n, 3)."""
    if len(points) <= len(_DIRECTIONS):
        return np.asarray(points, dtype=float)
    return points[np.unique((points @ _DIRECTIONS.T).argmax(axis=0))].astype(float)


_DIRECTIONS = directions(96)


class Camera(Struct, frozen=True, eq=False):
    """A view.

    Attributes:
        target: What it turns about [m], shape (3,).
        distance: Of the eye from there [m].
        azimuth, elevation: [deg].
        aspect: Width over height of the picture.
    """

    target: Floats
    distance: float
    azimuth: float
    elevation: float
    aspect: float

    @property
    def axes(self) -> Floats:
        """Return unit vectors to the right, upwards and to the eye, shape (3, 3)."""
        return Projection(self.azimuth, self.elevation).frame

    def seen(self, points: NDArray[Any]) -> tuple[Floats, Floats]:
        """Return where points are in the picture, and how far from the eye [m].

        Returns:
            From -1 to 1 to the right and upwards, shape (point, 2), and shape (point,).
        """
        across, up, near = self.axes @ (points - self.target).T
        depth = self.distance - near
        half = half_height(self.aspect)
        return np.stack([across / (half * self.aspect), up / half], axis=1) / depth[
            :, None
        ], depth


def half_height(aspect: float) -> float:
    """Return half of the height that is seen, at a distance of one."""
    return tan(radians(ANGLE / 2.0)) / max(1.0, aspect)


def fitted(points: Floats, azimuth: float, elevation: float, aspect: float) -> Camera:
    """Return the camera in this direction that sees all points, as near as possible."""
    half = half_height(aspect) * np.array([aspect, 1.0]) * MARGIN
    frame = Projection(azimuth, elevation).frame
    seen = points @ frame.T
    middle, distance = (seen.max(axis=0) + seen.min(axis=0)) / 2.0, 0.0
    least = 1e-6 * float(np.abs(points).max()) if np.ptp(points, axis=0).any() else 1.0
    for _ in range(6):
        flat, near = seen[:, :2] - middle[:2], seen[:, 2] - middle[2]
        distance = max(float((np.abs(flat) / half + near[:, None]).max()), least)
        places = flat / (distance - near)[:, None]
        shift = (places.max(axis=0) + places.min(axis=0)) / 2.0 * distance
        middle = middle + np.append(shift, 0.0)
    return Camera(middle @ frame, distance, azimuth, elevation, aspect)
