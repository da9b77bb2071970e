"""Planes of symmetry: forces of a half and of its mirror image on the nodes between them."""

from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import null_space
from scipy.sparse import block_diag, coo_matrix, csr_matrix

if TYPE_CHECKING:
    from tissuec.forces.symmetry import SymmetryPlanes

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class MirroredForces:
    """Nodes on planes of symmetry as a field that comes after all others.

    Args:
        planes: Read for nodes and planes.
    """

    def __init__(self, planes: "SymmetryPlanes"):
        self._nodes = planes.nodes
        #: Directions in which each node can move, as columns.
        self._ways: list[Floats] = [null_space(np.eye(3) - one) for one in planes.projections]

    def add_forces(self, time: float, position: Floats, velocity: Floats, to: Floats) -> None:
        """Leave what forces do along the directions of each node [N], shape (node, 3)."""
        for node, ways in zip(self._nodes, self._ways, strict=True):
            to[node] = ways @ (ways.T @ to[node])

    def energy(self, time: float, position: Floats) -> float:
        """Return the stored energy [J]: none."""
        return 0.0

    def pumping(self, time: float, position: Floats, velocity: Floats) -> float:
        """Return the power supplied from outside [W]: none."""
        return 0.0

    def dissipated(self, time: float, position: Floats, velocity: Floats) -> float:
        """Return the power dissipated [W]: none."""
        return 0.0

    def matrix(self, time: float, position: Floats, number: Indices, size: int) -> coo_matrix:
        """Return nothing [N/m]; see ``ways``."""
        return coo_matrix((3 * size, 3 * size))

    def ways(self, number: Indices, size: int) -> csr_matrix:
        """Return how nodes can move, by orthonormal columns, shape (3 size, way).

        Args:
            number: Of each node among those that may move, -1 for others.
            size: Number of nodes that may move.
        """
        blocks: list[Floats] = [np.eye(3)] * size
        for node, ways in zip(number[self._nodes], self._ways, strict=True):
            if node >= 0:
                blocks[node] = ways
        return csr_matrix(cast(Any, block_diag(blocks, format="csr")))
