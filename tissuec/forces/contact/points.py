"""Points of contact between nodes: on faces of bodies, on threads and axes of thin tools.

Each is x_q = Σ N_a x_a with fixed shares N_a ≥ 0 whose sum is 1. So a force f on it is N_a f on
its corners, and contact of points has the energy, power and second derivative of contact of
nodes, through a linear map.
"""

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.arrays import cross, norm
from tissuec.geometry.edge_supports import SupportedTriangles
from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

NO_FACE = -1  # of a point on an axis


class ContactPoints(Struct, frozen=True, eq=False, dict=True):
    """Points between nodes, numbered after all nodes.

    Attributes:
        corners: Nodes that carry each point, shape (point, 3); on an axis its ends, the second
            one twice.
        shares: N_a, shape (point, 3).
        areas: Drawn area that each represents, 0 on an axis [m²], shape (point,).
        face: Triangle of ``triangles`` that each is on, or ``NO_FACE``, shape (point,).
        bonds: Springs of which one must be there for a point to touch, -1 for none, shape
            (point, 2).
        triangles: Nodes of the triangles that have points, shape (triangle, 3).
        drawn: Their areas as drawn [m²], shape (triangle,).
        elements: Those that these belong to, see ``SupportedTriangles``.
        ends: Nodes of all springs, shape (spring, 2).
        rows: Of the triangles among those of the skin as drawn, shape (drawn triangle,).
        bounds: Entities of the parts of solids that the last triangles bound, shape (n,); empty
            before a cut.
    """

    corners: Indices
    shares: Floats
    areas: Floats
    face: Indices
    bonds: Indices
    triangles: Indices
    drawn: Floats
    elements: Indices | None
    ends: NDArray[np.int32]
    rows: Indices
    bounds: Indices = np.zeros(0, dtype=np.int64)

    def behind(self, values: Floats) -> Floats:
        """Return the vectors of nodes, followed by those of the points.

        Args:
            values: Of all nodes, in any unit, shape (…, node, 3).

        Returns:
            Shape (…, node + point, 3).
        """
        own = np.einsum("pa,...pak->...pk", self.shares, values[..., self.corners, :])
        return np.concatenate([values, own], axis=-2)

    def sums(self, values: Floats, nodes: int) -> Floats:
        """Return, for each node, its value plus its shares of the values of the points.

        Args:
            values: Of nodes and points, in any unit, shape (node + point,).
            nodes: Number of all nodes.
        """
        own = self.shares * values[nodes:, None]
        return values[:nodes] + np.bincount(self.corners.ravel(), own.ravel(), nodes)

    def map(self, number: Indices, size: int) -> "csr_matrix":
        """Return the matrix from coordinates of nodes that may move to those of all and points.

        Returns:
            Shape (3 (node + point), 3 size).
        """
        from scipy.sparse import csr_matrix, kron

        nodes, points = len(number), len(self.corners)
        row = np.concatenate([np.arange(nodes), nodes + np.repeat(np.arange(points), 3)])
        column = np.concatenate([number, number[self.corners].ravel()])
        share = np.concatenate([np.ones(nodes), self.shares.ravel()])
        moves = column >= 0
        entries = share[moves], (row[moves], column[moves])
        each = csr_matrix(entries, shape=(nodes + points, size))
        return csr_matrix(kron(each, np.eye(3)))

    def on(self, nodes: slice) -> Indices:
        """Return the points on faces between some nodes, shape (n,)."""
        corner = self.corners[:, 0]
        within = (corner >= nodes.start) & (corner < nodes.stop)
        return np.flatnonzero(within & (self.face != NO_FACE))

    def whole(self, alive: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return which points are on pieces and triangles that are whole, shape (point,).

        Args:
            alive: Springs that are there, shape (spring,).
        """
        there, bound = self._supported.whole(alive), self.bonds >= 0
        there = np.append(there, alive[self.bounds])
        holds = (alive[self.bonds] & bound).any(axis=1) | ~bound.any(axis=1)
        return np.where(self.face == NO_FACE, holds, there[self.face])

    def stretch(self, position: Floats) -> Floats:
        """Return the area of each triangle over its drawn one, shape (triangle,)."""
        a, b, c = np.moveaxis(position[self.triangles], 1, 0)
        return 0.5 * norm(cross(b - a, c - a)) / self.drawn

    @cached_property
    def _supported(self) -> SupportedTriangles:
        return SupportedTriangles(self.ends, self.triangles[: len(self.rows)], self.elements)
