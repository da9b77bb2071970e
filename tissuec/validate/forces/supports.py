"""Forces on nodes from what surrounds a body: foundations, and planes of symmetry."""

from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import null_space
from scipy.sparse import block_diag, coo_matrix, csr_matrix

from tissuec.validate.forces import FORMULAS, ForceFormula

if TYPE_CHECKING:
    from tissuec.forces.acting.foundation import Bed
    from tissuec.forces.acting.symmetry import SymmetryPlanes

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


@FORMULAS.member("foundation")
class Winkler(ForceFormula):
    """A bed of springs as a field of forces.

    Args:
        bed: Read for its nodes, places and constants.
    """

    def __init__(self, bed: "Bed"):
        self._nodes, self._drawn = bed.nodes[:, 0], bed.home
        self._pull, self._brake = bed.stiffness[:, None], bed.damping[:, None]

    def _moved(self, position: Floats) -> Floats:
        return position[self._nodes] - self._drawn

    def add_forces(self, time: float, position: Floats, velocity: Floats, to: Floats) -> None:
        to[self._nodes] -= self._pull * self._moved(position)
        to[self._nodes] -= self._brake * velocity[self._nodes]

    def energy(self, time: float, position: Floats) -> float:
        return 0.5 * float((self._pull * self._moved(position) ** 2).sum())

    def dissipated(self, time: float, position: Floats, velocity: Floats) -> float:
        """Return the power that dashpots lose [W]."""
        return float((self._brake * velocity[self._nodes] ** 2).sum())

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int
    ) -> sparse.coo_matrix:
        """Return the second derivative of the energy [N/m], shape (3 size, 3 size)."""
        total = np.zeros((size, 3))
        moves = number[self._nodes] >= 0
        total[number[self._nodes[moves]]] = self._pull[moves]
        return sparse.coo_matrix(sparse.diags(total.ravel()))


class MirroredForces(ForceFormula):
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
