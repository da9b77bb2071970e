"""A prescribed pressure on faces.

With the tensor ε of Levi-Civita, a triangle of the weight w has the force p w/6 ε x_j x_k,
summed over its three sides, on each corner. A cap is a fan of triangles to the mean of its rim,
each of whose nodes takes an equal share of what acts on that middle.
"""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

if TYPE_CHECKING:
    from tissuec.forces.pressed_faces import Rims
    from tissuec.forces.pressure import SurfacePressure

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

EPSILON = np.zeros((3, 3, 3))
for _i, _j, _k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
    EPSILON[_i, _j, _k], EPSILON[_i, _k, _j] = 1.0, -1.0


class PressedSkin:
    """A pressure on faces as a field of forces.

    Args:
        pressed: Read for its triangles, weights, rims, pressure and profile.
    """

    def __init__(self, pressed: "SurfacePressure"):
        triples = pressed.faces.triples
        self._amount, self._profile = pressed.amount, pressed.profile
        self._corners, self._weight = triples.corners, triples.weight
        self._caps, self._openings = pressed.caps, pressed.openings
        self._known: dict[tuple[int, ...], tuple[sparse.csr_matrix, Indices, Floats]] = {}

    def _wider(self, nodes: int, *rims: "Rims") -> tuple[sparse.csr_matrix, Indices, Floats]:
        """Return the map from nodes to nodes and middles, with triangles and weights.

        Args:
            nodes: Number of nodes.
            rims: Those whose fans are included.
        """
        key = nodes, *map(id, rims)
        if key in self._known:
            return self._known[key]
        corners, weight = [self._corners], [self._weight]
        parts: list[sparse.spmatrix] = [sparse.identity(nodes)]
        middle = nodes
        for rim in rims:
            for number in range(rim.count):
                own = rim.nodes_of(number)
                share = np.full(len(own), 1.0 / len(own))
                where = np.zeros(len(own), dtype=int), own
                parts.append(sparse.csr_matrix((share, where), shape=(1, nodes)))
                edges = rim.edges[rim.first[number] : rim.first[number + 1]]
                apex = np.full(len(edges), middle)
                corners.append(np.column_stack([apex, edges[:, 1], edges[:, 0]]))
                weight.append(rim.weight[rim.first[number] : rim.first[number + 1]])
                middle += 1
        follow = sparse.csr_matrix(sparse.vstack(parts))
        self._known[key] = follow, np.concatenate(corners), np.concatenate(weight)
        return self._known[key]

    def _pressure(self, time: float) -> float:
        return self._amount * float(self._profile.at(time)[0])

    def _pushes(self, time: float, position: Floats, *rims: "Rims") -> Floats:
        """Return the forces on all nodes [N], shape (node, 3)."""
        follow, corners, weight = self._wider(len(position), *rims)
        places = np.asarray(follow @ position)
        found = np.zeros_like(places)
        x = places[corners]
        x = x - x[:, :1]
        push = np.einsum("abc,tb,tc->ta", EPSILON, x[:, 1], x[:, 2])
        push *= self._pressure(time) / 6.0 * weight[:, None]
        for corner in range(3):
            np.add.at(found, corners[:, corner], push)
        return np.asarray(follow.T @ found)

    def add_forces(self, time: float, position: Floats, velocity: Floats, to: Floats) -> None:
        """Add the forces on all nodes [N], shape (node, 3)."""
        to += self._pushes(time, position, self._caps)

    def energy(self, time: float, position: Floats) -> float:
        """Return the stored energy [J]: none."""
        return 0.0

    def potential(self, time: float, position: Floats) -> float:
        """Return -p V, with caps on all rims [J].

        Args:
            time: [s].
            position: Of all nodes [m], shape (node, 3).
        """
        rims = self._caps, self._openings
        follow, corners, weight = self._wider(len(position), *rims)
        places = np.asarray(follow @ (position - position[self._corners[0, 0]]))[corners]
        return -self._pressure(time) * float(weight @ np.linalg.det(places)) / 6.0

    def wayward(self, time: float, position: Floats) -> Floats:
        """Return the difference of the forces from those of the potential [N], shape (node, 3).

        Args:
            time: [s].
            position: Of all nodes [m], shape (node, 3).
        """
        own = self._pushes(time, position, self._caps)
        return own - self._pushes(time, position, self._caps, self._openings)

    def pumping(self, time: float, position: Floats, velocity: Floats) -> float:
        """Return the power of the source of the pressure [W]."""
        return float(np.vdot(self._pushes(time, position, self._caps), velocity))

    def dissipated(self, time: float, position: Floats, velocity: Floats) -> float:
        """Return the power that is lost [W]: none."""
        return 0.0

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int
    ) -> sparse.coo_matrix:
        """Return the symmetric part of minus the derivative of the forces [N/m].

        Args:
            number: Of each node among those that may move, -1 for others.
            size: How many may move.
        """
        follow, corners, weight = self._wider(len(position), self._caps)
        x = np.asarray(follow @ position)[corners]
        count = follow.shape[0]
        by = np.einsum(
            "t,abc,tjc->tjab", -self._pressure(time) / 6.0 * weight, EPSILON,
            np.roll(x, -1, axis=1) - np.roll(x, 1, axis=1),
        )  # fmt: skip
        rows = 3 * corners[:, :, None, None, None] + np.arange(3)[:, None]
        columns = 3 * corners[:, None, :, None, None] + np.arange(3)
        shape = (len(corners), 3, 3, 3, 3)
        values = np.broadcast_to(by[:, None], shape)
        places = (np.broadcast_to(each, shape).ravel() for each in (rows, columns))
        whole = sparse.csr_matrix((values.ravel(), tuple(places)), shape=(3 * count, 3 * count))
        spread = sparse.kron(follow, sparse.identity(3))
        moves = np.flatnonzero(number >= 0)
        order = moves[np.argsort(number[moves])]
        kept = (3 * order[:, None] + np.arange(3)).ravel()
        free = sparse.csr_matrix(spread.T @ whole @ spread)[kept][:, kept]
        return sparse.coo_matrix(0.5 * (free + free.T))
