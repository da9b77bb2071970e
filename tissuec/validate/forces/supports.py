"""What surrounds a body: forces of foundations, and guides that nodes cannot leave."""

from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import null_space
from scipy.sparse import block_diag, csr_matrix

from tissuec.validate.forces import FORMULAS, ForceFormula

if TYPE_CHECKING:
    from tissuec.forces.acting.foundation import Bed
    from tissuec.model.guides import Guides

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


class GuidedMotion:
    """Directions in which nodes are free, on planes of symmetry or by the script.

    Args:
        guides: Read for nodes and directions; None without any.
    """

    def __init__(self, guides: "Guides | None"):
        self._nodes = [] if guides is None else guides.nodes.tolist()
        free = [] if guides is None else [np.eye(3) - one for one in guides.projections]
        #: Directions in which each node can move, as columns.
        self._ways: list[Floats] = [null_space(one) for one in free]

    def keep(self, vectors: Floats) -> None:
        """Leave the part of vectors along the free directions of each node.

        Args:
            vectors: Of all nodes in any unit, shape (node, 3); changed in place.
        """
        for node, ways in zip(self._nodes, self._ways, strict=True):
            vectors[node] = ways @ (ways.T @ vectors[node])

    def ways(self, number: Indices, size: int) -> csr_matrix | None:
        """Return how nodes can move, by orthonormal columns, shape (3 size, way).

        Args:
            number: Of each node among those that may move, -1 for others.
            size: Number of nodes that may move.

        Returns:
            None where all can move in all directions.
        """
        if not self._nodes:
            return None
        blocks: list[Floats] = [np.eye(3)] * size
        for node, ways in zip(self._nodes, self._ways, strict=True):
            if number[node] >= 0:
                blocks[number[node]] = ways
        return csr_matrix(cast(Any, block_diag(blocks, format="csr")))
