"""Pressure on faces: a prescribed one, and that of enclosed volumes.

With the tensor ε of Levi-Civita, a triangle of the weight w has the force p w/6 ε x_j x_k,
summed over its three sides, on each corner. A cap is a fan of triangles to the mean of its rim,
each of whose nodes takes its share of what acts on that middle. Beside planes of symmetry, that
is the mean of a rim with all of its mirror images.

A face of four corners is bounded by a ruled surface, whose volume from a point is the mean of
both ways to split it into triangles; a triangle adds a sixth of the triple product of its
corners. The derivatives are those of the triangles.
"""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from tissuec.core.arrays import cross
from tissuec.validate.forces import ForceFormula, assembled

if TYPE_CHECKING:
    from tissuec.forces.enclosed.pressure import SurfacePressure
    from tissuec.forces.enclosed.rims import Rims
    from tissuec.forces.enclosed.volume import Enclosure

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

EPSILON = np.zeros((3, 3, 3))
for _i, _j, _k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
    EPSILON[_i, _j, _k], EPSILON[_i, _k, _j] = 1.0, -1.0


class _Wider(NamedTuple):
    """Nodes and middles of caps.

    Attributes:
        follow: The map from coordinates of nodes, shape (3 (node + cap), 3 node).
        fixed: Added to these [m], shape (3 (node + cap),).
        corners: Of triangles, shape (triangle, 3).
        weight: Of these, shape (triangle,).
    """

    follow: sparse.csr_matrix
    fixed: Floats
    corners: Indices
    weight: Floats

    def places(self, position: Floats) -> Floats:
        """Return where nodes and middles are [m], shape (node + cap, 3)."""
        return np.asarray(self.follow @ position.ravel() + self.fixed).reshape(-1, 3)


def middle_of(rims: "Rims", number: int, nodes: int) -> sparse.csr_matrix:
    """Return the map from coordinates of nodes to the middle of a rim, less a constant.

    Args:
        rims: To which it belongs.
        number: Of the rim.
        nodes: How many nodes there are.

    Returns:
        Shape (3, 3 node).
    """
    own = slice(rims.node_first[number], rims.node_first[number + 1])
    found = np.zeros((3, nodes, 3))
    found[:, rims.nodes[own]] = np.einsum("n,ij->inj", rims.shares[own], rims.within[number])
    return sparse.csr_matrix(found.reshape(3, -1))


class PressedSkin(ForceFormula):
    """A pressure on faces as a field of forces.

    Args:
        pressed: Read for its triangles, weights, rims, pressure and profile.
    """

    def __init__(self, pressed: "SurfacePressure"):
        triples = pressed.faces.triples
        self._amount, self._profile = pressed.amount, pressed.profile
        self._corners, self._weight = triples.corners, triples.weight
        self._caps, self._openings = pressed.caps, pressed.openings
        self._crossing = pressed.faces.crossing
        self._known: dict[tuple[int, ...], _Wider] = {}

    def _wider(self, nodes: int, *rims: "Rims") -> "_Wider":
        """Return the map from nodes to nodes and middles, with triangles and weights.

        Args:
            nodes: Number of nodes.
            rims: Those whose fans are included.
        """
        key = nodes, *map(id, rims)
        if key in self._known:
            return self._known[key]
        corners, weight = [self._corners], [self._weight]
        parts: list[sparse.spmatrix] = [sparse.identity(3 * nodes)]
        fixed = [np.zeros(3 * nodes)]
        middle = nodes
        for rim in rims:
            for number in range(rim.count):
                parts.append(middle_of(rim, number, nodes))
                fixed.append(rim.fixed[number])
                edges = rim.edges[rim.first[number] : rim.first[number + 1]]
                apex = np.full(len(edges), middle)
                corners.append(np.column_stack([apex, edges[:, 1], edges[:, 0]]))
                weight.append(rim.weight[rim.first[number] : rim.first[number + 1]])
                middle += 1
        self._known[key] = _Wider(
            sparse.csr_matrix(sparse.vstack(parts)), np.concatenate(fixed),
            np.concatenate(corners), np.concatenate(weight),
        )  # fmt: skip
        return self._known[key]

    def _pressure(self, time: float) -> float:
        return self._amount * float(self._profile.at(time)[0])

    def _pushes(self, time: float, position: Floats, *rims: "Rims") -> Floats:
        """Return the forces on all nodes [N], shape (node, 3)."""
        wider = self._wider(len(position), *rims)
        places, corners, weight = wider.places(position), wider.corners, wider.weight
        found = np.zeros_like(places)
        x = places[corners]
        x = x - x[:, :1]
        push = np.einsum("abc,tb,tc->ta", EPSILON, x[:, 1], x[:, 2])
        push *= self._pressure(time) / 6.0 * weight[:, None]
        for corner in range(3):
            np.add.at(found, corners[:, corner], push)
        return np.asarray(wider.follow.T @ found.ravel()).reshape(-1, 3)

    def add_forces(self, time: float, position: Floats, velocity: Floats, to: Floats) -> None:
        to += self._pushes(time, position, self._caps)

    def potential(self, time: float, position: Floats) -> float:
        """Return -p V, with caps on all rims [J]."""
        rims = self._caps, self._openings
        wider = self._wider(len(position), *rims)
        from_here = self._crossing.at(position[self._corners[0, 0]])
        places = (wider.places(position) - from_here)[wider.corners]
        return -self._pressure(time) * float(wider.weight @ np.linalg.det(places)) / 6.0

    def wayward(self, time: float, position: Floats) -> Floats:
        """Return the forces at rest without a potential [N], shape (node, 3)."""
        own = self._pushes(time, position, self._caps)
        return own - self._pushes(time, position, self._caps, self._openings)

    def pumping(self, time: float, position: Floats, velocity: Floats) -> float:
        """Return the power of the source of the pressure [W]."""
        return float(np.vdot(self._pushes(time, position, self._caps), velocity))

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int
    ) -> sparse.coo_matrix:
        """Return the symmetric part of minus the derivative of the forces [N/m]."""
        wider = self._wider(len(position), self._caps)
        corners, weight = wider.corners, wider.weight
        x = wider.places(position)[corners]
        count = wider.follow.shape[0] // 3
        by = np.einsum(
            "t,abc,tjc->tjab", -self._pressure(time) / 6.0 * weight, EPSILON,
            np.roll(x, -1, axis=1) - np.roll(x, 1, axis=1),
        )  # fmt: skip
        rows = 3 * corners[:, :, None, None, None] + np.arange(3)[:, None]
        columns = 3 * corners[:, None, :, None, None] + np.arange(3)
        shape = (len(corners), 3, 3, 3, 3)
        values = np.broadcast_to(by[:, None], shape)
        row, column = (np.broadcast_to(each, shape).ravel() for each in (rows, columns))
        whole = sparse.csr_matrix((values.ravel(), (row, column)), shape=(3 * count, 3 * count))
        spread = wider.follow
        moves = np.flatnonzero(number >= 0)
        order = moves[np.argsort(number[moves])]
        kept = (3 * order[:, None] + np.arange(3)).ravel()
        free = sparse.csr_matrix(spread.T @ whole @ spread)[kept][:, kept]
        return sparse.coo_matrix(0.5 * (free + free.T))


SPLITS = ((0, 1, 2), (0, 2, 3), (0, 1, 3), (1, 2, 3))  # half of each counts


class VolumeField(ForceFormula):
    """The enclosed volumes of one body as a field of forces.

    Args:
        enclosure: Read for its faces, drawn volumes, modulus and changes.
    """

    def __init__(self, enclosure: "Enclosure"):
        self._drawn, self._modulus = enclosure.drawn, enclosure.modulus
        self._swellings = enclosure.swellings
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
        each = np.einsum("tk,tk->t", a, cross(b, c)) / 12.0
        return np.bincount(self._cell, each, len(self._drawn))  # pyright: ignore[reportReturnType]  # floats, unlike its stub

    def _swell(self, time: float) -> tuple[float, float]:
        """Return the due relative increase over the drawn volume, and its rate [1/s]."""
        parts = [(s.amount, *s.profile.at(time)) for s in self._swellings]
        return sum(a * f for a, f, _ in parts), sum(a * r for a, _, r in parts)

    def _pressures(self, time: float, position: Floats) -> Floats:
        due = self._drawn * (1.0 + self._swell(time)[0])
        return self._modulus * (due - self.volumes(position)) / self._drawn

    def add_forces(self, time: float, position: Floats, velocity: Floats, to: Floats) -> None:
        a, b, c = self._edges(position)
        push = self._pressures(time, position)[self._cell, None] / 12.0
        slopes = push * cross(b, c), push * cross(c, a), push * cross(a, b)
        for corner, slope in zip(self._corners.T, slopes, strict=True):
            np.add.at(to, corner, slope)
        np.subtract.at(to, self._apex, sum(slopes))

    def energy(self, time: float, position: Floats) -> float:
        """Return the stored energy [J]: ½ p² V0 / K over all cells."""
        pressures = self._pressures(time, position)
        return 0.5 * float(pressures**2 @ self._drawn) / self._modulus

    def pumping(self, time: float, position: Floats, velocity: Floats) -> float:
        """Return the power with which volumes are changed from outside [W]."""
        return float(self._pressures(time, position) @ self._drawn) * self._swell(time)[1]

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int
    ) -> sparse.coo_matrix:
        """Return the second derivative of the energy [N/m], shape (3 size, 3 size).

        It is Σ K/V0 ∂V/∂x ∂V/∂xᵀ - p ∂²V/∂x∂x.
        """
        a, b, c = self._edges(position)
        nodes = number[np.column_stack([self._corners, self._apex])]  # (triangle, 4)
        place = 3 * nodes[:, :, None] + np.arange(3)
        moves = np.broadcast_to(nodes[:, :, None] >= 0, place.shape)
        slopes = np.stack([cross(b, c), cross(c, a), cross(a, b)], axis=1)
        slopes /= 12.0
        slopes = np.concatenate([slopes, -slopes.sum(axis=1, keepdims=True)], axis=1)
        cells = np.broadcast_to(self._cell[:, None, None], place.shape)
        where = place[moves], cells[moves]
        ways = sparse.csr_matrix((slopes[moves], where), shape=(3 * size, len(self._drawn)))
        stiff = ways @ sparse.diags(self._modulus / self._drawn) @ ways.T

        turning = np.zeros((len(a), 3, 3, 3, 3))  # by edge and edge, component and component
        for one, other, edge, sign in ((0, 1, c, -1.0), (0, 2, b, 1.0), (1, 2, a, -1.0)):
            turning[:, one, other] = sign * _cross_matrix(edge)
            turning[:, other, one] = turning[:, one, other].swapaxes(1, 2)
        pressure = self._pressures(time, position)[self._cell] / 12.0
        bend = -np.einsum("t,ia,tijxy,jb->taxby", pressure, _ENDS, turning, _ENDS)
        return sparse.coo_matrix(stiff + assembled(bend, nodes, size))


#: How the three edges of a tetrahedron depend on its corners and its apex.
_ENDS = np.array([[1.0, 0.0, 0.0, -1.0], [0.0, 1.0, 0.0, -1.0], [0.0, 0.0, 1.0, -1.0]])


def _cross_matrix(vector: Floats) -> Floats:
    """Return the matrices M of M y = vector × y, shape (…, 3, 3)."""
    return cross(vector[..., None, :], np.eye(3)).swapaxes(-1, -2)
