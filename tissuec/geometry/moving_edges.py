"""Edges that move through triangles: how far each place is ahead of the edge.

In the plane of an edge and its motion, a place has the coordinates p along the edge, from 0 at
one of its ends to 1 at the other, and q, how far it is ahead of it.
"""

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.geometry.blade_sections import inside_boxes
from tissuec.model.network import Floats, Indices

Bools = NDArray[np.bool_]


class EdgePlane(Struct, frozen=True, eq=False):
    """The plane of an edge and of the direction in which it moves.

    Attributes:
        edge: Its ends [m], shape (2, 3).
        ahead: Unit vector at right angles to the edge, shape (3,).
        normal: Unit vector at right angles to both, shape (3,).
    """

    edge: Floats
    ahead: Floats
    normal: Floats

    @classmethod
    def of(cls, edge: Floats, ahead: Floats, before: Floats) -> "EdgePlane":
        """Return the plane of an edge, facing as the plane before it did.

        Args:
            edge: Its ends [m], shape (2, 3).
            ahead: Unit vector, dimensionless, shape (3,).
            before: Normal of the plane before, dimensionless, shape (3,); zero without one.
        """
        along = (edge[1] - edge[0]) / np.linalg.norm(edge[1] - edge[0])
        normal = np.cross(along, ahead)
        return cls(edge, ahead, normal if normal @ before >= 0.0 else -normal)

    @property
    def length(self) -> float:
        """Return the length of the edge [m]."""
        return float(np.linalg.norm(self.edge[1] - self.edge[0]))

    @property
    def along(self) -> Floats:
        """Return the unit vector from one end of the edge to the other, shape (3,)."""
        return np.asarray((self.edge[1] - self.edge[0]) / self.length)

    def heights(self, position: Floats) -> Floats:
        """Return heights above the plane [m], shape (…,), of points of shape (…, 3)."""
        return np.asarray((position - self.edge[0]) @ self.normal)

    def plain(self, position: Floats) -> Floats:
        """Return p, dimensionless, and q [m] of points of shape (…, 3), shape (…, 2)."""
        away = position - self.edge[0]
        return np.stack([away @ self.along / self.length, away @ self.ahead], axis=-1)


class EdgeFront(Struct, frozen=True, eq=False):
    """How far a front lags behind an edge, by intervals of the edge, its stations.

    Attributes:
        place: p in the middle of each station, ascending, shape (station,).
        start: Before the front is advanced [m], shape (station,).
        lag: Afterwards [m], shape (station,).
    """

    place: Floats
    start: Floats
    lag: Floats

    def started(self, p: Floats) -> Floats:
        """Return how far it lagged at some p [m], in the shape of these."""
        return np.interp(p, self.place, self.start)

    def lags(self, p: Floats) -> Floats:
        """Return how far it lags at some p afterwards [m], in the shape of these."""
        return np.interp(p, self.place, self.lag)


class Stations(Struct, frozen=True, eq=False):
    """Triangles beside stations of an edge.

    Attributes:
        plain: p and q of the corners of all triangles, shape (triangle, 3, 2).
        count: How many stations there are, from p = 0 to 1.
        triangle, station: Of pairs that overlap in p, shape (pair,) each.
    """

    plain: Floats
    count: int
    triangle: Indices
    station: Indices

    @classmethod
    def of(cls, plain: Floats, count: int) -> "Stations":
        """Return the pairs of triangles and stations.

        Args:
            plain: p, dimensionless, and q [m] of corners, shape (triangle, 3, 2).
            count: Of stations.
        """
        bounds = np.arange(count + 1) / count
        low, high = plain[..., 0].min(axis=1), plain[..., 0].max(axis=1)
        beside = (low[:, None] < bounds[1:]) & (high[:, None] > bounds[:-1])
        return cls(plain, count, *np.nonzero(beside))

    @property
    def places(self) -> Floats:
        """Return p in the middle of each station, dimensionless, shape (station,)."""
        return (np.arange(self.count) + 0.5) / self.count

    def first_matter(self, start: Floats) -> Floats:
        """Return the least q ≥ start at which there is a triangle [m], shape (station,).

        It is infinite where there is none.

        Args:
            start: q from which on [m], shape (station,).
        """
        found, own = np.full(self.count, np.inf), self.plain[self.triangle]
        first, last = np.full(len(own), np.inf), np.full(len(own), -np.inf)
        bounds = np.stack([self.station, self.station + 1], axis=1) / self.count

        def meet(there: Bools, q: Floats) -> None:
            first[there] = np.minimum(first, q)[there]
            last[there] = np.maximum(last, q)[there]

        for k in range(3):
            one, other = own[:, k], own[:, (k + 1) % 3]
            meet((one[:, 0] >= bounds[:, 0]) & (one[:, 0] <= bounds[:, 1]), one[:, 1])
            for p in bounds.T:
                meets = (one[:, 0] < p) != (other[:, 0] < p)
                span = np.where(meets, other[:, 0] - one[:, 0], 1.0)
                meet(meets, one[:, 1] + (p - one[:, 0]) / span * (other[:, 1] - one[:, 1]))
        there = last > start[self.station]
        each = np.maximum(first, start[self.station])[there]
        np.minimum.at(found, self.station[there], each)
        return found

    def windows(self, front: Floats, length: float) -> tuple[Indices, Indices, Floats, Floats]:
        """Return the parts of triangles in windows at a front, one window for each station.

        Args:
            front: q at which the windows begin, shape (station,).
            length: Of them along q [m].

        Returns:
            Triangles and stations of parts of triangles, shape (part,); shares of their corners
            in the middle of each, shape (part, 3); and the areas of parts in units of p and q
            [m], shape (part,).
        """
        near = front[self.station]
        q = self.plain[self.triangle, :, 1]
        some = (q.min(axis=1) < near + length) & (q.max(axis=1) > near)
        triangle, station = self.triangle[some], self.station[some]
        low = np.stack([station / self.count, front[station]], axis=1)
        high = np.stack([(station + 1) / self.count, front[station] + length], axis=1)
        which, shares = inside_boxes(self.plain[triangle], low, high)
        corners = shares @ self.plain[triangle[which]]
        one, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        areas = 0.5 * np.abs(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])
        return triangle[which], station[which], shares.mean(axis=1), areas

    def drawn_widths(self, drawn: Floats) -> Floats:
        """Return the drawn length of each triangle by p, at the same q [m], shape (triangle,).

        Args:
            drawn: Corners as drawn [m], shape (triangle, 3, 3).
        """
        edges = self.plain[:, 1:] - self.plain[:, :1]
        (p1, q1), (p2, q2) = edges[:, 0].T, edges[:, 1].T
        across = p1 * q2 - p2 * q1
        shares = np.stack([q2, -q1], axis=1) / np.where(across == 0.0, np.inf, across)[:, None]
        way = np.einsum("nk,nkr->nr", shares, drawn[:, 1:] - drawn[:, :1])
        return np.linalg.norm(way, axis=1)
