"""Embedded nodes of the reference: places P x, forces Pᵀ F, matrices Tᵀ K T.

P has the row of the identity for each node that is not embedded, and the weights of its hosts
for each that is; T is the part of P from free nodes to nodes that move with these.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

if TYPE_CHECKING:
    from tissuec.forces.acting.embedding import EmbeddedNodes

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class EmbeddedPoints:
    """Which nodes are embedded, and in which.

    Args:
        fields: One, read for nodes, hosts and weights, or none.
        count: Number of all nodes.
        held: Which nodes are held or follow a path, shape (node,).

    Attributes:
        nodes: The embedded nodes, ascending, shape (n,).
        free: The nodes that are neither held nor embedded, ascending, shape (free,).
        moving: These and, behind them, embedded ones, shape (moving,).
    """

    def __init__(self, fields: "Sequence[EmbeddedNodes]", count: int, held: NDArray[np.bool_]):
        self.nodes = np.concatenate([np.zeros(0, dtype=np.int64), *(f.nodes for f in fields)])
        is_free = ~held
        is_free[self.nodes] = False
        self.free = np.flatnonzero(is_free)
        self.moving = np.concatenate([self.free, self.nodes])
        if not len(self.nodes):
            return
        (field,) = fields
        rows = np.repeat(self.nodes, np.diff(field.first))
        stays = np.setdiff1d(np.arange(count), self.nodes)
        at = np.concatenate([stays, rows]), np.concatenate([stays, field.hosts])
        self._whole, self._lumping = (
            sparse.csr_matrix((np.append(np.ones(len(stays)), parts), at), shape=(count, count))
            for parts in (field.weights, field.shares)
        )
        self._reduction = sparse.csr_matrix(
            sparse.kron(self._whole[self.moving][:, self.free], sparse.identity(3))
        )

    def follow(self, vectors: Floats) -> None:
        """Set vectors of embedded nodes by those of their hosts.

        Args:
            vectors: Of all nodes, which internal variables may follow, in any unit, shape
                (node + row, 3); changed in place.
        """
        if len(self.nodes):
            vectors[self.nodes] = self._whole[self.nodes] @ vectors[: self._whole.shape[1]]

    def shared(self, forces: Floats) -> Floats:
        """Return forces, with those of embedded nodes on their hosts.

        Args:
            forces: Of all nodes in any unit, shape (node, …), as that of the result.
        """
        return self._whole.T @ forces if len(self.nodes) else forces

    def lumped(self, masses: Floats) -> Floats:
        """Return masses, drag and the like, with those of embedded nodes at their hosts.

        Args:
            masses: Of all nodes in any unit, shape (node,), as that of the result.
        """
        return self._lumping.T @ masses if len(self.nodes) else masses

    def reduced(self, matrix: Any) -> Any:
        """Return the matrix of free nodes of one of moving nodes, in any unit."""
        return self._reduction.T @ matrix @ self._reduction if len(self.nodes) else matrix

    def spread(self, matrix: Any) -> Any:
        """Return the columns of free nodes of a matrix with columns of all nodes."""
        if len(self.nodes):
            matrix = matrix @ self._whole
        return matrix[:, self.free]
