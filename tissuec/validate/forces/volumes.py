"""The pressure of enclosed volumes.

A face of four corners is bounded by a ruled surface, whose volume from a point is the mean of
both ways to split it into triangles; a triangle adds a sixth of the triple product of its
corners. The derivatives are those of the triangles.
"""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from tissuec.core.vectors import cross
from tissuec.validate.forces import assembled

if TYPE_CHECKING:
    from tissuec.forces.volume import Enclosure

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
SPLITS = ((0, 1, 2), (0, 2, 3), (0, 1, 3), (1, 2, 3))  # half of each counts


class VolumeField:
    """The enclosed volumes of one body as a field of forces.

    Args:
        enclosure: Read for its faces, drawn volumes, modulus and changes.
    """

    def __init__(self, enclosure: "Enclosure"):
        self._drawn, self._modulus = enclosure.drawn, enclosure.modulus
        self._swellings, self._share = enclosure.swellings, enclosure.share
        faces = np.diff(enclosure.first)
        self._cell = np.tile(np.repeat(np.arange(len(faces)), faces), len(SPLITS))
        corners = np.concatenate([enclosure.corners[:, split] for split in SPLITS])
        # Seen from a corner of their own cell, volumes keep their digits far from the origin.
        apex = enclosure.corners[enclosure.first[:-1], 0][self._cell]
        keeps = np.array([len(set(three)) == 3 for three in corners.tolist()])
        self._corners, self._apex = corners[keeps], apex[keeps]
        self._cell = self._cell[keeps]

    def _edges(self, position: Floats) -> tuple[Floats, Floats, Floats]:
        first, second, third = (position[self._corners[:, k]] for k in range(3))
        apex = position[self._apex]
        return first - apex, second - apex, third - apex

    def volumes(self, position: Floats) -> Floats:
        """Return the enclosed volumes [m³], shape (cell,)."""
        a, b, c = self._edges(position)
        each = np.einsum("tk,tk->t", a, cross(b, c)) * (self._share / 12.0)
        return np.bincount(self._cell, each, len(self._drawn))  # pyright: ignore[reportReturnType]  # floats, unlike its stub

    def _swell(self, time: float) -> tuple[float, float]:
        """Return the due relative increase over the drawn volume, and its rate [1/s]."""
        parts = [(s.amount, *s.profile.at(time)) for s in self._swellings]
        return sum(a * f for a, f, _ in parts), sum(a * r for a, _, r in parts)

    def _pressures(self, time: float, position: Floats) -> Floats:
        due = self._drawn * (1.0 + self._swell(time)[0])
        return self._modulus * (due - self.volumes(position)) / self._drawn

    def add_forces(self, time: float, position: Floats, velocity: Floats, to: Floats) -> None:
        """Add the forces on all nodes [N], shape (node, 3)."""
        a, b, c = self._edges(position)
        push = self._pressures(time, position)[self._cell, None] * (self._share / 12.0)
        slopes = push * cross(b, c), push * cross(c, a), push * cross(a, b)
        for corner, slope in zip(self._corners.T, slopes, strict=True):
            np.add.at(to, corner, slope)
        np.subtract.at(to, self._apex, sum(slopes))

    def energy(self, time: float, position: Floats) -> float:
        """Return the stored energy [J]: ½ p² V0 / K over all cells."""
        pressures = self._pressures(time, position)
        return 0.5 * float(pressures**2 @ self._drawn) / self._modulus

    def pumping(self, time: float, position: Floats, velocity: Floats) -> float:
        """Return the power that whoever changes the volumes puts in [W]."""
        return float(self._pressures(time, position) @ self._drawn) * self._swell(time)[1]

    def dissipated(self, time: float, position: Floats, velocity: Floats) -> float:
        """Return the power that is lost [W]: none."""
        return 0.0

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int
    ) -> sparse.coo_matrix:
        """Return the second derivative of the energy [N/m], shape (3 size, 3 size).

        It is Σ K/V0 ∂V/∂x ∂V/∂xᵀ - p ∂²V/∂x∂x.

        Args:
            number: Of each node among those that may move, -1 for others.
            size: How many may move.
        """
        a, b, c = self._edges(position)
        nodes = number[np.column_stack([self._corners, self._apex])]  # (triangle, 4)
        place = 3 * nodes[:, :, None] + np.arange(3)
        moves = np.broadcast_to(nodes[:, :, None] >= 0, place.shape)
        slopes = np.stack([cross(b, c), cross(c, a), cross(a, b)], axis=1)
        slopes *= self._share / 12.0
        slopes = np.concatenate([slopes, -slopes.sum(axis=1, keepdims=True)], axis=1)
        cells = np.broadcast_to(self._cell[:, None, None], place.shape)
        where = place[moves], cells[moves]
        ways = sparse.csr_matrix((slopes[moves], where), shape=(3 * size, len(self._drawn)))
        stiff = ways @ sparse.diags(self._modulus / self._drawn) @ ways.T

        turning = np.zeros((len(a), 3, 3, 3, 3))  # by edge and edge, component and component
        for one, other, edge, sign in ((0, 1, c, -1.0), (0, 2, b, 1.0), (1, 2, a, -1.0)):
            turning[:, one, other] = sign * _cross_matrix(edge)
            turning[:, other, one] = turning[:, one, other].swapaxes(1, 2)
        pressure = self._pressures(time, position)[self._cell] * (self._share / 12.0)
        bend = -np.einsum("t,ia,tijxy,jb->taxby", pressure, _ENDS, turning, _ENDS)
        return sparse.coo_matrix(stiff + assembled(bend, nodes, size))


#: How the three edges of a tetrahedron depend on its corners and its apex.
_ENDS = np.array([[1.0, 0.0, 0.0, -1.0], [0.0, 1.0, 0.0, -1.0], [0.0, 0.0, 1.0, -1.0]])


def _cross_matrix(vector: Floats) -> Floats:
    """Return the matrices M of M y = vector × y, shape (…, 3, 3)."""
    return cross(vector[..., None, :], np.eye(3)).swapaxes(-1, -2)
