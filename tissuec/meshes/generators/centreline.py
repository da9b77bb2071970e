"""The axis of a round mesh: a straight line, or a curve through points, with rings around it.

A smooth curve is the natural cubic spline through the points over the lengths of their chords
(C. de Boor, A Practical Guide to Splines, 1978, chapter IV). Rings are at right angles to it,
at equal distances along it. They do not twist about it: the frame of each follows from the one
before by two reflections (W. Wang, B. Jüttler, D. Zheng, Y. Liu, Computation of rotation
minimizing frames, ACM Trans. Graph. 27(1):2, 2008).

A curve with sharp bends consists of straight pieces. At a corner, the ring lies in the plane
that halves the angle, so that a tube has the same section on both sides of it.

By both ways the volume around the axis is its length times the area of the section, whose
centre is on the axis (Pappus).

Rings do not meet if the radius of curvature is nowhere less than theirs, and if parts of the
axis that are more than half a turn apart along it are further apart than both radii. (A curve
whose curvature is at most 1/r is at least 2 r away from where it was half a turn π r before: A.
Schur, Math. Ann. 83:143, 1921.)
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.core import units
from tissuec.core.arrays import cross, dot, norm
from tissuec.core.fields import UnfitEntries
from tissuec.model.network import Floats

SMOOTH, SHARP = BENDS = "smooth", "sharp"
MOST_CHECKED = 1000  # rings of a mesh that may be too large to be built
_PIECES = 256  # of each span of a spline, for its length
_LOOKED_AT = 400  # points between which distances are compared
_MOST = np.pi / 3.0  # turn of the axis from one ring to the next
_SQUARE = np.sqrt(2.0) * (1.0 - 1e-12)  # length of the sum of unit vectors at right angles


class Rings(NamedTuple):
    """Rings around an axis.

    Attributes:
        centre: [m], shape (ring, 3).
        across: The two directions in which angles around the axis are 0 and 90 degrees: unit
            vectors at right angles, except at sharp corners. Shape (ring, 2, 3).
        share: Of the length of the axis up to each ring, from 0 to 1, shape (ring,).
    """

    centre: Floats
    across: Floats
    share: Floats


class Centreline:
    """An axis.

    Args:
        points: Two ends of a straight line, or points of a curve [m], shape (point, 3).
        bends: "smooth" or "sharp".

    Raises:
        ValueError: Neighbouring points are the same.
    """

    def __init__(self, points: Sequence[Floats], bends: str = SMOOTH):
        self.points = np.asarray(points, dtype=np.float64)
        self.is_straight = len(self.points) == 2
        self.is_sharp = bends == SHARP or self.is_straight
        if not (np.diff(self.points, axis=0) != 0.0).any(axis=1).all():
            what = "two different points" if self.is_straight else "points that all differ"
            raise ValueError(f'"axis" must join {what}')
        self._table = self._sampled()

    @property
    def length(self) -> float:
        """Return its length [m]."""
        return float(self._table[0][-1])

    def rings(self, count: int, first: float, last: float) -> Rings:
        """Return rings at about equal distances; at sharp corners there is one.

        Args:
            count: At least 2.
            first: Outer radius at the first end [m].
            last: Outer radius at the last end [m].

        Raises:
            ValueError: The tube intersects itself, or there are too few rings for its bends.
        """
        if self.is_straight:
            start, end = self.points
            across = np.stack(perpendicular_frame(end - start))
            across = np.broadcast_to(across, (count, 2, 3))
            return Rings(np.linspace(start, end, count), across, np.linspace(0.0, 1.0, count))
        if self.is_sharp:  # a corner is a better reason than what follows from it
            found = self._mitred(count)
            _require_order(found, first + (last - first) * found.share)
            self._require_room(first, last)
            return found
        self._require_room(first, last)
        found = self._curved(count)
        _require_order(found, first + (last - first) * found.share)
        return found

    def require_rings(self, count: int, first: float, last: float) -> None:
        """Check that rings neither intersect nor are too few, without making very many.

        A tube of more than ``MOST_CHECKED`` rings is checked with that number of them here,
        and with all of them by ``rings``.

        Args:
            count, first, last: As of ``rings``.

        Raises:
            ValueError: As for ``rings``.
        """
        self.rings(min(count, MOST_CHECKED), first, last)

    def _require_room(self, first: float, last: float) -> None:
        """Check that a tube with two radii at its ends [m] does not intersect itself."""
        along, place, slope, bend = self._table
        radius = first + (last - first) * along / along[-1]
        if not self.is_sharp:
            curvature = norm(cross(slope, bend)) / norm(slope) ** 3
            worst = int(np.argmax(curvature * radius))
            if curvature[worst] * radius[worst] >= 1.0:
                raise UnfitEntries(
                    f'"axis" bends too sharply around {_place(place[worst])}: its radius of '
                    f"curvature is {_length(1.0 / curvature[worst])} there, and the radius "
                    f"{_length(radius[worst])}",
                    "write a smaller radius, or more points along a wider bend",
                )
        step = max(len(along) // _LOOKED_AT, 1)
        along, place, radius = along[::step], place[::step], radius[::step]
        apart = np.abs(along[:, None] - along)
        near = norm(place[:, None] - place) < (radius[:, None] + radius) * (1.0 - 1e-9)
        if (meets := near & (apart > np.pi * np.maximum(radius[:, None], radius))).any():
            one, other = np.argwhere(meets)[0].tolist()
            raise UnfitEntries(
                f'"axis" leads back to itself: the parts around {_place(place[one])} and '
                f"{_place(place[other])} intersect",
                "keep them further apart, or write a smaller radius",
            )

    # --- smooth curves ------------------------------------------------------------------------

    def _sampled(self) -> tuple[Floats, Floats, Floats, Floats]:
        """Return lengths up to points of the curve, the points, and both derivatives there."""
        chord = norm(np.diff(self.points, axis=0))
        if self.is_sharp:
            share = np.linspace(0.0, 1.0, _PIECES + 1)[:, None]
            parts = [(1.0 - share) * a + share * b for a, b in pairwise(self.points)]
            place = np.concatenate([part[1 if k else 0 :] for k, part in enumerate(parts)])
            slope = bend = np.zeros_like(place)
        else:
            knots = np.concatenate([[0.0], np.cumsum(chord)])
            place, slope, bend = natural_spline(knots, self.points, _PIECES)
        along = np.concatenate([[0.0], np.cumsum(norm(np.diff(place, axis=0)))])
        return along, place, slope, bend

    def _curved(self, count: int) -> Rings:
        along, place, slope, _ = self._table
        share = np.linspace(0.0, 1.0, count)
        at = share * along[-1]

        def there(values: Floats) -> Floats:
            found: Floats = np.empty((count, 3))
            for axis in range(3):
                found[:, axis] = np.interp(at, along, values[:, axis])
            return found

        centre, tangent = there(place), there(slope)
        tangent = tangent / norm(tangent)[:, None]
        self._require_rings(tangent)
        return Rings(centre, _without_twist(centre, tangent), share)

    def _require_rings(self, tangent: Floats) -> None:
        """Check that the axis turns little from one ring to the next.

        Args:
            tangent: Unit vectors along the axis, shape (ring, 3).
        """
        turn = np.arccos(np.clip(dot(tangent[1:], tangent[:-1]), -1.0, 1.0))
        if (most := float(turn.max())) > _MOST:
            raise UnfitEntries(
                f'"axis" turns by {np.degrees(most):.0f} deg from one ring of nodes to the '
                "next",
                "use more rings, or smaller cells",
            )

    # --- sharp bends --------------------------------------------------------------------------

    def _mitred(self, count: int) -> Rings:
        """Return rings on straight pieces, and one in each corner."""
        edges = np.diff(self.points, axis=0)
        length = norm(edges)
        if count < len(self.points):
            raise UnfitEntries(
                f'"axis" needs a ring of nodes at each of its {len(self.points)} points',
                "use more rings, or smaller cells",
            )
        ahead = edges / length[:, None]
        pieces = _shared_out(count - 1, length)
        frame = np.stack(perpendicular_frame(ahead[0]))
        centre, across = [self.points[:1]], [frame[None]]
        for k, (start, end) in enumerate(pairwise(self.points)):
            share = np.linspace(0.0, 1.0, pieces[k] + 1)[1:, None]
            centre.append((1.0 - share) * start + share * end)
            across.append(np.repeat(frame[None], pieces[k], axis=0))
            if k + 1 < len(ahead):
                between = ahead[k] + ahead[k + 1]
                if norm(between) < _SQUARE:
                    raise UnfitEntries(
                        f'"axis" turns by more than 90 deg at {_place(end)}',
                        "write bends is smooth",
                    )
                across[-1][-1] -= np.outer(
                    frame @ between / float(ahead[k] @ between), ahead[k]
                )
                frame = _reflected(frame, between)
        place = np.concatenate(centre)
        along = np.concatenate([[0.0], np.cumsum(norm(np.diff(place, axis=0)))])
        return Rings(place, np.concatenate(across), along / along[-1])


def perpendicular_frame(
    direction: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return two unit vectors that form a right-handed frame with ``direction`` as third.

    Args:
        direction: Any vector but zero, shape (3,).

    Returns:
        Two vectors, each of shape (3,).
    """
    unit = direction / np.abs(direction).max()
    unit = unit / np.linalg.norm(unit)
    # The coordinate direction least along the axis has at least sin^2 = 2/3 across it, so the
    # subtraction below never cancels.
    least = int(np.argmin(np.abs(unit)))
    across = np.eye(3)[least] - unit[least] * unit
    across /= np.linalg.norm(across)
    return across, np.cross(np.asarray(unit, dtype=float), np.asarray(across, dtype=float))


def natural_spline(knots: Floats, points: Floats, pieces: int) -> tuple[Floats, Floats, Floats]:
    """Return points of the natural cubic spline, and its first and second derivatives there.

    With the second derivatives M at the knots, zero at both ends, and the spans h,

        h₀ M₀ + 2 (h₀ + h₁) M₁ + h₁ M₂ = 6 ((x₂ - x₁)/h₁ - (x₁ - x₀)/h₀).

    Args:
        knots: Ascending parameters of the points, shape (point,).
        points: In any unit, shape (point, 3).
        pieces: Number of pieces that each span is divided into.

    Returns:
        Shape (span * pieces + 1, 3) each.
    """
    count, span = len(knots), np.diff(knots)
    slope = np.diff(points, axis=0) / span[:, None]
    matrix, right = np.eye(count), np.zeros((count, 3))
    for k in range(1, count - 1):
        matrix[k, k - 1 : k + 2] = span[k - 1], 2.0 * (span[k - 1] + span[k]), span[k]
        right[k] = 6.0 * (slope[k] - slope[k - 1])
    bend = np.linalg.solve(matrix, right)
    at = np.arange((count - 1) * pieces + 1)
    k = np.minimum(at // pieces, count - 2)
    h = span[k][:, None]
    u = (at - k * pieces)[:, None] / pieces
    low, high, before, behind = bend[k], bend[k + 1], points[k], points[k + 1]
    v = 1.0 - u
    place = v * before + u * behind + h**2 / 6.0 * ((v**3 - v) * low + (u**3 - u) * high)
    first = (behind - before) / h + h / 6.0 * (
        (1.0 - 3.0 * v**2) * low + (3.0 * u**2 - 1.0) * high
    )
    return place, first, v * low + u * high


def _without_twist(centre: Floats, tangent: Floats) -> Floats:
    """Return the directions across a curve that turn least about it, shape (ring, 2, 3).

    Args:
        centre: Points of the curve [m], shape (ring, 3).
        tangent: Unit vectors along it there, shape (ring, 3).
    """
    frames = np.empty((len(centre), 2, 3))
    frames[0] = np.stack(perpendicular_frame(tangent[0]))
    for k in range(len(centre) - 1):
        # The chord leads to the next point; the second reflection turns the tangent there.
        chord = centre[k + 1] - centre[k]
        ahead = _reflected(tangent[k : k + 1], chord)[0]
        first = _reflected(_reflected(frames[k, :1], chord), tangent[k + 1] - ahead)[0]
        first -= (first @ tangent[k + 1]) * tangent[k + 1]
        first /= np.linalg.norm(first)
        frames[k + 1] = first, np.cross(tangent[k + 1], first)
    return frames


def _reflected(vectors: Floats, normal: Floats) -> Floats:
    """Return vectors, shape (n, 3), reflected in the plane with a normal of any length."""
    square = float(normal @ normal)
    if square == 0.0:
        return vectors
    return vectors - np.outer(vectors @ normal * (2.0 / square), normal)


def _require_order(rings: Rings, radius: Floats) -> None:
    """Check that no ring touches the next one.

    Args:
        rings: Rings around an axis.
        radius: Of each [m], shape (ring,).
    """
    chord = np.diff(rings.centre, axis=0)
    length = norm(chord)
    # How far the nodes of rings are ahead of their centres, along the chord: a cosine of the
    # angle around the axis.
    tilt = [
        np.einsum("rak,rk->ra", radius[part, None, None] * rings.across[part], chord)
        for part in (slice(1, None), slice(-1))
    ]
    closest = length**2 - np.hypot(*(tilt[0] - tilt[1]).T)
    if (closest <= 0.0).any():
        first = int(np.argmin(closest))
        raise UnfitEntries(
            f'"axis" bends too sharply around {_place(rings.centre[first])}: a ring there '
            "intersects the next one",
            "use fewer rings, a smaller radius, or a wider bend",
        )


def _shared_out(count: int, length: Floats) -> list[int]:
    """Return how many of some intervals each piece of an axis has: about by its length.

    Args:
        count: At least one for each piece.
        length: Of the pieces, shape (piece,).
    """
    pieces = np.ones(len(length), dtype=np.int64)
    for _ in range(count - len(length)):
        pieces[np.argmax(length / pieces)] += 1
    return pieces.tolist()


def _length(value: float) -> str:
    return units.show(value, units.LENGTH, digits=3)


def _place(point: Floats) -> str:
    from tissuec.meshes.repair import place  # where it is needed

    return place(point)
