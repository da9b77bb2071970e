"""Springs and dashpots from nodes to where they are drawn, by area."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from tissuec.validate.forces import FORMULAS

if TYPE_CHECKING:
    from tissuec.forces.foundation import Bed

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


@FORMULAS.member("foundation")
class Winkler:
    """A bed of springs as a field of forces.

    Args:
        bed: Read for its nodes, places and constants.
    """

    def __init__(self, bed: "Bed"):
        self._nodes, self._drawn = bed.nodes, bed.home
        self._pull, self._brake = bed.stiffness[:, None], bed.damping[:, None]

    def _moved(self, position: Floats) -> Floats:
        return position[self._nodes] - self._drawn

    def add_forces(self, time: float, position: Floats, velocity: Floats, to: Floats) -> None:
        """Add the forces on all nodes [N], shape (node, 3)."""
        to[self._nodes] -= self._pull * self._moved(position)
        to[self._nodes] -= self._brake * velocity[self._nodes]

    def energy(self, time: float, position: Floats) -> float:
        """Return the stored energy [J]."""
        return 0.5 * float((self._pull * self._moved(position) ** 2).sum())

    def pumping(self, time: float, position: Floats, velocity: Floats) -> float:
        """Return the power that is put in from outside [W]: none."""
        return 0.0

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
