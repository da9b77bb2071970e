"""Both faces of cuts through solids as they are now: areas, and how far they are apart.

Points of both faces that are one point as drawn are *twins*. Where ties hold the faces
together, the solid is not parted.
"""

from typing import TYPE_CHECKING, Self

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.arrays import cross, dot, norm
from tissuec.mechanics.cut_body import CutBody
from tissuec.mechanics.tying import TiedSections
from tissuec.model.cut_cells import CutCells
from tissuec.model.network import Floats, Indices, numbers_in

if TYPE_CHECKING:
    from tissuec.mechanics.state import State

Bools = NDArray[np.bool_]
#: Corners are looked up this far inside of their triangles, so that those next to them have
#: other twins.
INSET = 1e-3
ROUNDING = INSET / 30.0  # of weights, which are at least a third of ``INSET`` inside
#: Largest distance of a point from a triangle over its size: faces of four corners are warped.
NEAR = 0.2
FACING = -0.5  # largest cosine between normals of twins
#: Sizes of elements up to which faces are at the end of a cut.
AT_END = 2.0


class CutFaces(Struct, frozen=True, eq=False):
    """Faces of the cuts through a solid.

    Attributes:
        cells: Parts of cells.
        corners: Of the triangles of both faces as seen from outside, nodes and riding points
            as in ``CutCells``, shape (triangle, 3).
        drawn: Places of these as drawn [m], shape (triangle, 3, 3).
        bounds: The part that each bounds, an entity, shape (triangle,).
        body: The elements.
        ties: Sections that are still tied.
        tied: Corners of these as drawn [m], shape (tie, 3, 3).
    """

    cells: CutCells
    corners: Indices
    drawn: Floats
    bounds: Indices
    body: CutBody
    ties: TiedSections
    tied: Floats

    @classmethod
    def of(cls, state: "State", name: str) -> "Self | None":
        """Return those of a body; None before its first cut."""
        cells, phantoms = state.cut_cells, state.network.phantoms_of(name)
        body, place = state.cut_bodies.get(name), state.network.position
        if cells is None or phantoms is None or body is None:
            return None
        own = state.alive[cells.borders] & (cells.cuts != 0)
        own &= np.isin(cells.borders, numbers_in(phantoms.elements))
        corners = cells.triangles[own]
        drawn = cells.points.beside(place)[corners]
        ties = state.tied.get(name, TiedSections.none(len(place), 4)).existing(body)
        tied = ties.values(body, place)[:, 0]
        return cls(cells, corners, drawn, cells.borders[own], body, ties, tied)

    def places(self, position: Floats) -> Floats:
        """Return the places of corners [m], shape (…, triangle, 3, 3).

        Args:
            position: Of all nodes [m], shape (…, node, 3).
        """
        every = self.cells.points.beside(np.moveaxis(position, -2, 0))
        return np.moveaxis(every[self.corners], (0, 1), (-3, -2))

    @property
    def are_free(self) -> Bools:
        """Return which corners no tie holds, shape (triangle, 3)."""
        points = _inset(self.drawn)
        return (located(points.reshape(-1, 3), None, self.tied) < 0).reshape(-1, 3)

    def area(self, position: Floats) -> Floats:
        """Return the present area of both faces without what is tied [m²], shape (…).

        Args:
            position: Of all nodes [m], shape (…, node, 3).
        """
        states = position.reshape(-1, *position.shape[-2:])
        tied = [_areas(self.ties.values(self.body, one)).sum() for one in states]
        found = _areas(self.places(position)).sum(axis=-1)
        return np.asarray(found - np.reshape(tied, found.shape))

    def twins(self) -> tuple[Indices, Floats]:
        """Return the triangle with the twin of each corner, and where it is there.

        Returns:
            The triangle, -1 without one, shape (triangle, 3), and the dimensionless weights of
            its corners, shape (triangle, 3, 3).
        """
        points = _inset(self.drawn)
        normals = np.repeat(face_normals(self.drawn), 3, axis=0)
        row = located(points.reshape(-1, 3), normals, self.drawn)
        weights = _weights(self.drawn.reshape(-1, 3), self.drawn[row])
        return row.reshape(-1, 3), weights.reshape(-1, 3, 3)

    def opening(self, position: Floats) -> Floats:
        """Return the largest distance of free corners from their twins [m], shape (…).

        Args:
            position: Of all nodes [m], shape (…, node, 3).
        """
        place, (row, weights) = self.places(position), self.twins()
        found = (row >= 0) & self.are_free
        there = np.einsum("nk,...nkx->...nx", weights[found], place[..., row[found], :, :])
        apart = there - place[..., found, :]
        return np.asarray(norm(apart).max(axis=-1, initial=0.0))

    def angle(self, position: Floats) -> Floats:
        """Return the mean angle between both faces at the ends of cuts [rad], shape (…).

        Elements in which a cut ends are left out where there are others: nodes ahead, which
        both parts have, keep the faces from turning.

        Args:
            position: Of all nodes [m], shape (…, node, 3).
        """
        row, _ = self.twins()
        own = (row >= 0) & self.are_free
        if len(self.tied):
            from scipy.spatial import KDTree  # takes long to import

            away, _ = KDTree(self.tied.reshape(-1, 3)).query(self.drawn.mean(axis=1))
            behind = ~np.isin(self.bounds, self.ties.entities)
            behind &= away < AT_END * self.ties.size.mean()
            if (near := own & behind[:, None]).any():
                own = near
        area = np.repeat(_areas(self.drawn), 3).reshape(-1, 3)[own]
        if not len(area):
            return np.zeros(position.shape[:-2])
        normals = face_normals(self.places(position))
        here, there = normals[..., np.nonzero(own)[0], :], -normals[..., row[own], :]
        each = np.arctan2(norm(cross(here, there)), dot(here, there))
        return np.asarray(each @ area / area.sum())


def _areas(corners: Floats) -> Floats:
    """Return areas of triangles [m²], shape (…); corners of shape (…, 3, 3)."""
    return 0.5 * np.asarray(norm(face_normals(corners)))


def face_normals(corners: Floats) -> Floats:
    """Return normals of triangles, twice as long as their areas [m²], shape (…, 3)."""
    a, b, c = np.moveaxis(corners, -2, 0)
    return np.asarray(cross(b - a, c - a))


def _inset(corners: Floats) -> Floats:
    """Return points close to the corners of triangles, inside of them."""
    return corners + INSET * (corners.mean(axis=1, keepdims=True) - corners)


def _weights(points: Floats, corners: Floats) -> Floats:
    """Return weights of corners at points above triangles, shape (n, 3).

    Args:
        points: [m], shape (n, 3).
        corners: [m], shape (n, 3, 3).
    """
    normal = face_normals(corners)
    a, b, c = corners.swapaxes(0, 1)
    over = dot(normal, normal)
    one, two = (dot(cross(q - p, points - p), normal) / over for p, q in ((b, c), (c, a)))
    return np.stack([one, two, 1.0 - one - two], axis=1)


def located(points: Floats, normals: Floats | None, triangles: Floats) -> Indices:
    """Return the nearest triangle in which each point lies, -1 without any, shape (point,).

    Args:
        points: [m], shape (point, 3).
        normals: Those that triangles must face, shape (point, 3); None for any.
        triangles: Their corners [m], shape (triangle, 3, 3).
    """
    from scipy.spatial import KDTree  # takes long to import

    found = np.full(len(points), -1)
    if not len(triangles):
        return found
    middle = triangles.mean(axis=1)
    reach = float(norm(triangles - middle[:, None]).max()) * (1.0 + NEAR)
    near = KDTree(middle).query_ball_point(points, reach)
    of = np.repeat(np.arange(len(points)), [len(one) for one in near])
    row = np.concatenate([np.asarray(one, dtype=np.int64) for one in near])
    normal = face_normals(triangles)
    size = norm(normal)
    unit = normal / np.where(size > 0.0, size, 1.0)[:, None]
    away = np.abs(dot(points[of] - middle[row], unit[row]))
    own = (size[row] > 0.0) & (away < NEAR * np.sqrt(size[row]))
    if normals is not None:
        own &= dot(normals[of], unit[row]) < FACING * norm(normals)[of]
    of, row, away = of[own], row[own], away[own]
    inside = _weights(points[of], triangles[row]).min(axis=1) >= -ROUNDING
    of, row, away = of[inside], row[inside], away[inside]
    order = np.argsort(-away, kind="stable")  # the nearest one remains
    found[of[order]] = row[order]
    return found
