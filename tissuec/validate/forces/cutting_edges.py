"""Edges that part tissue, by sparse maps from nodes to how far edges are ahead."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from tissuec.validate.forces import FORMULAS, ForceFormula

if TYPE_CHECKING:
    from tissuec.forces.acting.cutting_edges import CuttingEdge

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


@FORMULAS.member("cutting edge")
class PushingEdge(ForceFormula):
    """The pieces of an edge as a field of forces.

    Args:
        edge: Read for its nodes, weights, directions, forces and lags.
    """

    def __init__(self, edge: "CuttingEdge"):
        self._edge = edge

    def _ahead(self, nodes: int) -> sparse.csr_matrix:
        """Return the map from coordinates of nodes to lags, shape (piece, 3 nodes)."""
        edge, counts = self._edge, np.diff(self._edge.first)
        row = np.repeat(np.arange(len(counts)), counts)
        values = edge.weights[:, None] * edge.direction[row]
        place = 3 * edge.nodes[:, None] + np.arange(3)
        entries = values.ravel(), (np.repeat(row, 3), place.ravel())
        return sparse.csr_matrix(entries, shape=(len(counts), 3 * nodes))

    def _strain(self, position: Floats) -> Floats:
        """Return how far each piece is ahead over its lag, dimensionless, shape (piece,)."""
        return np.asarray(self._ahead(len(position)) @ position.ravel() / self._edge.lag)

    def add_forces(self, time: float, position: Floats, velocity: Floats, to: Floats) -> None:
        push = self._edge.force * np.clip(self._strain(position), 0.0, 1.0)
        to -= (self._ahead(len(position)).T @ push).reshape(-1, 3)

    def energy(self, time: float, position: Floats) -> float:
        most = self._edge.force * self._edge.lag
        strain = np.maximum(self._strain(position), 0.0)
        bent = np.minimum(strain, 1.0)
        return float(most @ (bent * (strain - 0.5 * bent)))

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int
    ) -> sparse.coo_matrix:
        """Return the second derivative of the energy [N/m], shape (3 size, 3 size)."""
        strain = self._strain(position)
        steep = np.where(
            (strain > 0.0) & (strain < 1.0), self._edge.force / self._edge.lag, 0.0
        )
        ahead = sparse.csc_matrix(self._ahead(len(position)))
        free = np.flatnonzero(number >= 0)
        column = (3 * free[:, None] + np.arange(3)).ravel()
        place = (3 * number[free][:, None] + np.arange(3)).ravel()
        order = np.argsort(place)
        own = ahead[:, column[order]]
        return sparse.coo_matrix(own.T @ sparse.diags(steep) @ own)
