"""Enclosed volumes: surfaces that keep what they hold, by pressure.

A cell of drawn volume V0 that encloses V and should enclose Vt stores

    E = ½ K (V - Vt)² / V0,

K being its bulk modulus. Its pressure is p = -dE/dV = K (Vt - V) / V0, and the force on a node
is p ∂V/∂x. With corners a, b, c of the triangles as seen from one of them, facing outwards,

    V = Σ a · (b × c) / 6,        ∂V/∂a = Σ (b × c) / 6.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tissuec.core.source import Span
from tissuec.courses import Course
from tissuec.network import Floats, Indices, Network

if TYPE_CHECKING:
    from scipy.sparse import coo_matrix


@dataclass(frozen=True, slots=True, eq=False)
class Swelling:
    """A change of the volumes that should be enclosed, relative to the drawn ones."""

    amount: float
    course: Course


@dataclass(frozen=True, slots=True, eq=False)
class Enclosure:
    """The enclosed volumes of one body.

    Attributes:
        name: Of the body.
        corners: Nodes of the triangles, cell by cell, shape (triangle, 3).
        first: Where each cell begins among them and, last, where all end, shape (cell + 1,).
        drawn: Drawn volumes [m³], shape (cell,); positive.
        modulus: Bulk modulus K [Pa].
        swellings: Changes that were ordered so far.
        edges: Springs along edges of the triangles: where one is missing, it leaks.
        span: The sentence.
    """

    name: str
    corners: Indices
    first: Indices
    drawn: Floats
    modulus: float
    swellings: tuple[Swelling, ...]
    edges: Indices
    span: Span

    @classmethod
    def of(cls, network: Network, name: str, modulus: float, span: Span) -> "Enclosure":
        """Return what the surface of a body encloses.

        Raises:
            ValueError: It has no surface, or one that is open or encloses nothing.
        """
        part = next((b for b in network.bodies if b.name.lower() == name.lower()), None)
        if part is None:
            raise ValueError(f"{name} is not a body")
        inside = (network.skin >= part.nodes.start) & (network.skin < part.nodes.stop)
        corners = network.skin[inside.all(axis=1)].astype(np.int64)
        loose = open_edges(corners)
        if not len(corners):
            raise ValueError(f"{part.name} has no surface")
        if len(loose):
            raise ValueError(f"the surface of {part.name} is open: {len(loose)} edges are free")
        first = np.array([0, len(corners)])
        drawn = _volumes(network.position, corners, first)
        if drawn[0] < 0.0:
            corners, drawn = corners[:, ::-1].copy(), -drawn
        if not drawn[0] > 0.0:
            raise ValueError(f"the surface of {part.name} encloses nothing")
        return cls(
            part.name, corners, first, drawn, modulus, (), _edge_springs(network, corners), span
        )

    def swollen(self, amount: float, course: Course) -> "Enclosure":
        """Return this enclosure with a further change of what it should enclose."""
        return replace(self, swellings=(*self.swellings, Swelling(amount, course)))

    def swell(self, time: float) -> tuple[float, float]:
        """Return how much more than drawn should be enclosed, as a part of it, and its rate."""
        value = rate = 0.0
        for swelling in self.swellings:
            factor, slope = swelling.course.at(time)
            value += swelling.amount * factor
            rate += swelling.amount * slope
        return value, rate

    def volumes(self, position: Floats) -> Floats:
        """Return the enclosed volumes [m³], shape (…, cell).

        Args:
            position: Of all nodes [m], shape (…, node, 3).
        """
        return _volumes(position, self.corners, self.first)

    def pressures(self, time: Floats | float, position: Floats) -> Floats:
        """Return the pressures [Pa], shape (…, cell).

        Args:
            time: [s], shape (…).
            position: Of all nodes [m], shape (…, node, 3).
        """
        times = np.asarray(time, dtype=float)
        swell = np.array([self.swell(float(t))[0] for t in times.ravel()]).reshape(times.shape)
        due = self.drawn * (1.0 + swell[..., None])
        return self.modulus * (due - self.volumes(position)) / self.drawn

    def energy(self, time: Floats | float, position: Floats) -> Floats:
        """Return the stored energy [J], shape (…)."""
        pressure = self.pressures(time, position)
        return (0.5 * pressure * pressure * self.drawn / self.modulus).sum(axis=-1)

    def gradient(self, position: Floats) -> Floats:
        """Return ∂V/∂x of each cell by its corners [m²], shape (…, triangle, 3, 3)."""
        a, b, c = _seen(position, self.corners, self.first)
        parts = (np.cross(b, c), np.cross(c, a), np.cross(a, b))
        return np.stack(parts, axis=-2) / 6.0

    def add_forces(
        self, time: Floats | float, position: Floats, velocity: Floats, to: Floats
    ) -> None:
        """Add the forces on all nodes [N], shape (…, node, 3)."""
        each = np.repeat(self.pressures(time, position), np.diff(self.first), axis=-1)
        forces = each[..., None, None] * self.gradient(position)
        for corner in range(3):
            where: Any = (..., self.corners[:, corner], slice(None))
            np.add.at(to, where, forces[..., corner, :])

    def stiffness(self, position: Floats) -> Floats:
        """Return what resists a change of volume, Σ K/V0 ∂V/∂x ∂V/∂xᵀ [N/m].

        Returns:
            Shape (3 m, 3 m), m being the ``nodes`` of the surface.
        """
        place, size = self._places, len(self.nodes)
        sides, total = self.gradient(position), np.zeros((3 * size, 3 * size))
        for cell, drawn in enumerate(self.drawn):
            part = slice(self.first[cell], self.first[cell + 1])
            way = np.zeros((size, 3))
            np.add.at(way, place[part], sides[part])
            total += self.modulus / drawn * np.outer(way, way)
        return total

    def bending(self, time: float, position: Floats) -> Floats:
        """Return what pressure adds where the surface turns, -Σ p ∂²V/∂x∂x [N/m].

        Of a triangle, ∂²V/∂a∂b = -[c]/6 with [c] d = c × d; the others follow in turn. Shape
        as that of ``stiffness``.
        """
        size, place = len(self.nodes), self._places
        each = np.repeat(self.pressures(time, position), np.diff(self.first))
        seen = _seen(position, self.corners, self.first)
        total = np.zeros((size, 3, size, 3))
        for k in range(3):
            turned = np.cross(np.eye(3)[None], seen[(k + 2) % 3][:, None])  # [c] by rows
            block = each[:, None, None] / 6.0 * turned.transpose(0, 2, 1)
            one, two = place[:, k], place[:, (k + 1) % 3]
            there: Any = (one, slice(None), two)
            back: Any = (two, slice(None), one)
            np.add.at(total, there, -block)
            np.add.at(total, back, -block.transpose(0, 2, 1))
        return total.reshape(3 * size, 3 * size)

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "coo_matrix":
        """Return ``stiffness``, and ``bending`` if ``exact``, among the nodes that may move.

        Args:
            number: Of each node of the scene among those that may move, -1 for others.
            size: How many may move; the matrix is of shape (3 size, 3 size).
        """
        from scipy.sparse import coo_matrix

        block = self.stiffness(position)
        if exact:
            block += self.bending(time, position)
        place = (3 * number[self.nodes][:, None] + np.arange(3)).ravel()
        moves = np.flatnonzero(place >= 0)
        row, column = np.meshgrid(place[moves], place[moves], indexing="ij")
        values = block[np.ix_(moves, moves)].ravel()
        return coo_matrix((values, (row.ravel(), column.ravel())), shape=(3 * size, 3 * size))

    @property
    def nodes(self) -> Indices:
        """Return the nodes of the surface, ascending, shape (m,)."""
        return np.unique(self.corners)

    @property
    def _places(self) -> Indices:
        return np.searchsorted(self.nodes, self.corners)

    def spread(self, time: float, position: Floats) -> float:
        """Return the sum of what energies are made of, whose digits rounding spoils [J]."""
        return float((np.abs(self.pressures(time, position)) * self.drawn).sum())

    def noise(self, position: Floats) -> float:
        """Return a force whose digits rounding spoils [N]."""
        return self.modulus * float(np.abs(self.gradient(position)).max())

    def weakening(self, time: float, position: Floats) -> float:
        """Return how far below zero ``bending`` may bring an eigenvalue [N/m]."""
        return float(np.abs(self.bending(time, position)).sum(axis=1).max())

    def dissipated(self, time: float, position: Floats, velocity: Floats) -> float:
        """Return the power that is lost [W]: none."""
        return 0.0

    def pumping(self, time: float, position: Floats) -> float:
        """Return the power that whoever changes the volumes puts in [W]."""
        rate = self.swell(time)[1]
        return float((self.pressures(time, position) * self.drawn).sum()) * rate


def open_edges(corners: Indices) -> Indices:
    """Return the edges that do not belong to exactly two triangles in opposite directions."""
    edges = corners[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    if not len(edges):
        return edges
    size = int(edges.max()) + 1
    there, back = edges[:, 0] * size + edges[:, 1], edges[:, 1] * size + edges[:, 0]
    found, count = np.unique(there, return_counts=True)
    single = np.isin(there, found[count == 1])
    return edges[~(single & np.isin(back, there))]


def _edge_springs(network: Network, corners: Indices) -> Indices:
    size = network.node_count
    pairs = np.sort(corners[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    ends = np.sort(network.ends, axis=1).astype(np.int64)
    return np.flatnonzero(
        np.isin(ends[:, 0] * size + ends[:, 1], pairs[:, 0] * size + pairs[:, 1])
    )


def _seen(position: Floats, corners: Indices, first: Indices) -> tuple[Floats, Floats, Floats]:
    """Return the corners of triangles as seen from the first one of their cell."""
    origin = np.repeat(corners[first[:-1], 0], np.diff(first))
    a, b, c = (position[..., corners[:, k], :] - position[..., origin, :] for k in range(3))
    return a, b, c


def _volumes(position: Floats, corners: Indices, first: NDArray[np.int64]) -> Floats:
    a, b, c = _seen(position, corners, first)
    parts = np.einsum("...k,...k->...", a, np.cross(b, c)) / 6.0
    return np.add.reduceat(parts, first[:-1], axis=-1)
