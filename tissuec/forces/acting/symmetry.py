"""Planes of symmetry: what is on them is pulled alike from both sides.

A scene holds one half of a symmetric problem, or a quarter or an eighth. Its mirror image pulls
nodes on the plane with the mirrored force, so that of the sum F + (1 - 2 n nᵀ) F, shared by
both halves, (1 - n nᵀ) F is left to each: nodes on the plane, at rest at right angles to it,
stay on it. The planes act last, on the sum of all other inner forces, which they project: as no
force of its own is added, there is no potential, and the loop is written by hand.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tissuec.forces.acting.symmetry_kernel import SymmetryTable, mirror
from tissuec.forces.fields import Field
from tissuec.forces.matrices import diagonal
from tissuec.kernels.records import BoundaryConditions
from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix, csr_matrix


class SymmetryPlanes(Field, frozen=True):
    """Nodes on planes of symmetry.

    Attributes:
        nodes: Ascending, shape (n,).
        projections: Projection into the planes that each is on, shape (n, 3, 3).
    """

    nodes: Indices
    projections: Floats

    @property
    def share(self) -> Floats:
        """The part of each node within the drawn half, dimensionless, shape (node,)."""
        return 0.5 ** np.rint(3.0 - np.trace(self.projections, axis1=1, axis2=2))

    @property
    def kernel(self) -> Callable[..., None]:
        """Return the scalar loops."""
        return mirror

    def table(
        self, place: Indices, acts: BoundaryConditions, position: Floats
    ) -> SymmetryTable:
        """Return the constraint, which is the same at any position."""
        return SymmetryTable(place[self.nodes], self.projections.reshape(-1, 9))

    def add_forces(
        self, time: Floats | float, position: Floats, velocity: Floats, to: Floats
    ) -> None:
        """Leave of the forces that are there their part within the planes [N].

        Args:
            time, position, velocity: Without effect.
            to: Sums of all other inner forces, shape (…, node, 3); changed in place.
        """
        to[..., self.nodes, :] = np.einsum(
            "nij,...nj->...ni", self.projections, to[..., self.nodes, :]
        )

    def energy(self, time: Floats | float, position: Floats) -> Floats:
        """Return the stored energy [J], shape (…): none."""
        return np.zeros(position.shape[:-2])

    def powers(self, time: Floats | float, position: Floats, velocity: Floats) -> Floats:
        """Return the powers that are put in from outside and lost [W], shape (…, 2): none."""
        return np.zeros((*position.shape[:-2], 2))

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "csc_matrix":
        """Return nothing [N/m]: what all else has in it is projected; see ``projection``."""
        from scipy.sparse import csc_matrix

        return csc_matrix((3 * size, 3 * size))

    def projection(self, number: Indices, size: int) -> "csr_matrix":
        """Return the projection into the planes, shape (3 size, 3 size)."""
        from scipy.sparse import csr_matrix, identity

        across = diagonal(np.eye(3) - self.projections, number[self.nodes], size)
        return csr_matrix(identity(3 * size, format="csr") - across)

    def touched(self, position: Floats) -> NDArray[np.bool_]:
        """Return the nodes on planes, shape (node,)."""
        found = np.zeros(len(position), dtype=bool)
        found[self.nodes] = True
        return found

    @property
    def derivatives(self) -> str:
        """Return why there are no exact derivatives for learning."""
        return "have no exact derivatives"
