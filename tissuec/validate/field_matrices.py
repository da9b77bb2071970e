"""Derivatives of the forces of fields, for Newton's iteration in SciPy's implicit methods.

Derivatives by positions are the exact matrices of the fields. Viscous forces are linear in
velocities, so that differences give their derivatives exactly: those of many nodes at once,
where no force depends on two of them. (A. R. Curtis, M. J. D. Powell, J. K. Reid, IMA J. Appl.
Math. 13:117, 1974.) How viscous forces change with positions is left out, and so is contact.

Shared arguments:
    time: Time [s].
    position: Of all nodes [m], shape (node, 3).
    velocity: Of all nodes [m/s], shape (node, 3).
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from tissuec.validate.embedded import EmbeddedPoints
from tissuec.validate.forces import ForceFormula
from tissuec.validate.forces.bending import PlateBending
from tissuec.validate.forces.elements import ElementSolid
from tissuec.validate.forces.membranes import MembraneWall
from tissuec.validate.forces.supports import GuidedMotion
from tissuec.validate.forces.ties import TiedPoints

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
VISCOUS = (ElementSolid, MembraneWall, PlateBending, TiedPoints)
FASTEST = 1e-3  # of the velocities by which viscous forces are differenced [m/s]


class FieldMatrices:
    """The matrices of the fields of a net.

    Args:
        fields: All of them but contact.
        embedded: Of the net, with the nodes that are free and those that move.
        count: Number of all nodes.
        guided: Directions in which nodes are free.
    """

    def __init__(
        self,
        fields: Sequence[ForceFormula],
        embedded: EmbeddedPoints,
        count: int,
        guided: GuidedMotion,
    ):
        self._fields, self._embedded, free = fields, embedded, embedded.moving
        self._free = free
        self._viscous = [one for one in fields if isinstance(one, VISCOUS)]
        self._guided = guided
        self._number = np.full(count, -1)
        self._number[free] = np.arange(len(free))
        self._coupling: tuple[tuple[Indices, Indices], list[Indices]] | None = None

    def by_place(self, time: float, position: Floats) -> sparse.csr_matrix:
        """Return minus the derivative of forces by positions [N/m], (3 free, 3 free)."""
        return self._embedded.reduced(self._sum(self._fields, time, position))

    def by_speed(self, time: float, position: Floats, velocity: Floats) -> sparse.csr_matrix:
        """Return minus the derivative of forces by velocities [N s/m], (3 free, 3 free)."""
        size = 3 * len(self._free)
        if not self._viscous:
            return self._embedded.reduced(sparse.csr_matrix((size, size)))
        (rows, columns), groups = self.coupled(time, position)
        still, found = self._forces(time, position, velocity), sparse.csr_matrix((size, size))
        for group in groups:
            own = np.isin(columns, group)
            for axis in range(3):
                faster = velocity.copy()
                faster[self._free[group], axis] += FASTEST
                change = (still - self._forces(time, position, faster))[rows[own]] / FASTEST
                at = 3 * rows[own, None] + np.arange(3)
                along = np.broadcast_to(3 * columns[own, None] + axis, at.shape)
                found += sparse.csr_matrix(
                    (change.ravel(), (at.ravel(), along.ravel())), (size, size)
                )
        return self._embedded.reduced(found)

    def kept(self, matrix: Any) -> Any:
        """Return rows of a matrix, in any unit, in the directions in which nodes are free."""
        count = len(self._embedded.free)
        ways = self._guided.ways(np.where(self._number < count, self._number, -1), count)
        return matrix if ways is None else ways @ (ways.T @ matrix)

    def _forces(self, time: float, position: Floats, velocity: Floats) -> Floats:
        """Return the forces of all that is viscous on nodes that move [N]."""
        forces = np.zeros_like(position)
        for one in self._viscous:
            one.add_forces(time, position, velocity, forces)
        return forces[self._free]

    def _sum(
        self, fields: Sequence[ForceFormula], time: float, position: Floats
    ) -> sparse.csr_matrix:
        size = len(self._free)
        total = sparse.csr_matrix((3 * size, 3 * size))
        for one in fields:
            total = (total + one.matrix(time, position, self._number, size)).tocsr()
        return total

    def coupled(
        self, time: float, position: Floats
    ) -> tuple[tuple[Indices, Indices], list[Indices]]:
        """Return pairs of nodes that viscous forces join, and groups of nodes without any.

        Both number nodes that move. No force on a node depends on two nodes of a group.
        """
        if self._coupling is None:
            whole, size = self._sum(self._viscous, time, position).tocoo(), len(self._free)
            joined = sparse.csr_matrix(
                (np.ones(whole.nnz), (whole.row // 3, whole.col // 3)), (size, size)
            )
            near = (joined.T @ joined).tocsr()
            colour = np.full(size, -1)
            for node in range(size):
                used = colour[near.indices[near.indptr[node] : near.indptr[node + 1]]]
                colour[node] = np.setdiff1d(np.arange(len(used) + 1), used)[0]
            pairs, last = joined.tocoo(), colour.max(initial=-1)
            groups = [np.flatnonzero(colour == one) for one in range(last + 1)]
            ends = pairs.row.astype(np.int64), pairs.col.astype(np.int64)
            self._coupling = ends, groups
        return self._coupling
