"""Fluids in cavities, whose weight acts on the wall.

The volume and the first moment of a fluid are sums over tetrahedra between triangles and one
point. Forces are those of the hydrostatic pressure, as the slopes of both sums by the corners.
"""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from tissuec.core.arrays import cross
from tissuec.validate.forces import ForceFormula, assembled
from tissuec.validate.forces.pressure import middle_of

if TYPE_CHECKING:
    from tissuec.forces.enclosed.fluids import FluidCavities

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class FluidField(ForceFormula):
    """The fluids of a body as a field of forces.

    Args:
        fluids: Read for their triangles, caps, drawn volumes, modulus, density and changes.
    """

    def __init__(self, fluids: "FluidCavities"):
        self._fluids = fluids
        self._known: sparse.csr_matrix | None = None
        caps = fluids.caps
        fans = np.column_stack([-1 - caps.of_edge, caps.edges[:, 1], caps.edges[:, 0]])
        self._corners = np.concatenate([fluids.triples.corners, fans])
        self._weight = np.concatenate([fluids.triples.weight, caps.weight])
        of_cap = np.repeat(np.arange(len(fluids.drawn)), np.diff(fluids.cap_first))
        self._cavity = np.concatenate([fluids.triples.face, of_cap[caps.of_edge]])

    def _follow(self, nodes: int) -> sparse.csr_matrix:
        """Return the map from coordinates of nodes to these and those of middles of caps."""
        if self._known is not None and self._known.shape[1] == 3 * nodes:
            return self._known
        caps = self._fluids.caps
        parts: list[sparse.spmatrix] = [sparse.identity(3 * nodes)]
        parts += [middle_of(caps, cap, nodes) for cap in range(caps.count)]
        self._known = sparse.csr_matrix(sparse.vstack(parts))
        return self._known

    def _due(self, time: float) -> tuple[Floats, Floats]:
        """Return target volumes [m³] and their rates [m³/s], shape (cavity,) each."""
        parts = [(s.amount, *s.profile.at(time)) for s in self._fluids.swellings]
        drawn = self._fluids.drawn
        return (
            drawn * (1.0 + sum(a * f for a, f, _ in parts)),
            drawn * sum(a * r for a, _, r in parts),
        )

    def _sums(self, position: Floats) -> tuple[Floats, Floats, Floats, Indices]:
        """Return volumes, centroids, corners, and the numbers of these after the nodes."""
        nodes = len(position)
        places = np.where(self._corners < 0, nodes - 1 - self._corners, self._corners)
        wider = np.asarray(self._follow(nodes) @ position.ravel()).reshape(-1, 3)
        wider[nodes:] += self._fluids.caps.fixed
        x, crossing = wider[places], self._fluids.crossing
        count = len(self._fluids.drawn)
        apex = x[np.searchsorted(self._cavity[: len(self._fluids.triples.weight)],
                                 np.arange(count)), 0]  # fmt: skip
        apex = crossing.at(apex)
        seen = x - apex[self._cavity][:, None]
        parts = self._weight * np.linalg.det(seen) / 6.0
        volume = np.bincount(self._cavity, parts, count)
        moment = np.zeros((count, 3))
        # The centroid of a tetrahedron is the mean of its corners, one of which is the apex.
        np.add.at(moment, self._cavity, parts[:, None] * seen.sum(axis=1) / 4.0)
        # That of the fluid with its mirror images, which is on the planes of symmetry.
        centre: Floats = apex + (moment / volume[:, None]) @ crossing.within
        return np.asarray(volume, dtype=np.float64), centre, x, places

    def volumes(self, position: Floats) -> Floats:
        """Return the volumes [m³], shape (cavity,)."""
        return self._sums(position)[0]

    def _pressures(self, time: float, volume: Floats) -> Floats:
        fluids = self._fluids
        return fluids.modulus * (self._due(time)[0] - volume) / fluids.drawn

    def add_forces(self, time: float, position: Floats, velocity: Floats, to: Floats) -> None:
        fluids = self._fluids
        volume, centre, x, places = self._sums(position)
        x = x - centre[self._cavity][:, None]
        thin = (fluids.density * self._due(time)[0] / volume)[self._cavity]
        pressure = self._pressures(time, volume)[self._cavity]
        heights = x @ fluids.gravity
        found = np.zeros((len(position) + fluids.caps.count, 3))
        triple = np.linalg.det(x)
        for corner in range(3):
            normal = cross(x[:, corner - 2], x[:, corner - 1])
            push = (pressure / 6.0 + thin * heights.sum(axis=1) / 24.0)[:, None] * normal
            push += (thin * triple / 24.0)[:, None] * fluids.gravity
            np.add.at(found, places[:, corner], self._weight[:, None] * push)
        to += np.asarray(self._follow(len(position)).T @ found.ravel()).reshape(-1, 3)

    def energy(self, time: float, position: Floats) -> float:
        """Return the stored energy [J]: ½ K (V - Vt)²/V0 - ρ Vt g · c over all cavities."""
        fluids = self._fluids
        volume, centre, _, _ = self._sums(position)
        pressures, due = self._pressures(time, volume), self._due(time)[0]
        stored = 0.5 * float(pressures**2 @ fluids.drawn) / fluids.modulus
        return stored - fluids.density * float(due @ (centre @ fluids.gravity))

    def pumping(self, time: float, position: Floats, velocity: Floats) -> float:
        """Return the power of the pumps that change the volumes [W]."""
        fluids = self._fluids
        volume, centre, _, _ = self._sums(position)
        heights = fluids.density * (centre @ fluids.gravity)
        return float((self._pressures(time, volume) - heights) @ self._due(time)[1])

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int
    ) -> sparse.coo_matrix:
        """Return the second derivative of the energy [N/m], shape (3 size, 3 size).

        With E = e(V, A) and A = g · ∫ x dV as seen from the centroid, where A = 0, it is
        e_VV ∂V∂Vᵀ + e_VA (∂V∂Aᵀ + ∂A∂Vᵀ) + e_V ∂²V + e_A ∂²A.
        """
        fluids, gravity = self._fluids, self._fluids.gravity
        nodes = len(position)
        volume, centre, x, places = self._sums(position)
        x = x - centre[self._cavity][:, None]
        mass = fluids.density * self._due(time)[0]
        by_v, by_a = -self._pressures(time, volume), -mass / volume
        wider = nodes + fluids.caps.count
        normal = np.stack([cross(x[:, k - 2], x[:, k - 1]) for k in range(3)], axis=1)
        fall, triple = (x @ gravity).sum(axis=1), np.linalg.det(x)
        lean = fall[:, None, None] * normal + triple[:, None, None] * gravity
        rows = 3 * places[:, :, None] + np.arange(3)
        columns = np.broadcast_to(self._cavity[:, None, None], rows.shape)

        def ways(slopes: Floats) -> sparse.csr_matrix:
            values = (self._weight[:, None, None] * slopes).ravel()
            where = rows.ravel(), columns.ravel()
            return sparse.csr_matrix((values, where), shape=(3 * wider, len(volume)))

        grows, leans = ways(normal / 6.0), ways(lean / 24.0)
        mixed = grows @ sparse.diags(mass / volume**2) @ leans.T
        total = grows @ sparse.diags(fluids.modulus / fluids.drawn) @ grows.T + mixed + mixed.T
        turning = np.zeros((len(x), 3, 3, 3, 3))
        for one in range(3):
            third = np.einsum("tx,xyz->tzy", x[:, one - 1], -_EPSILON)
            turning[:, one, :, one - 2] += third
            turning[:, one - 2, :, one] += third.swapaxes(1, 2)
        steep = by_v[self._cavity] / 6.0 + by_a[self._cavity] * fall / 24.0
        steep = (self._weight * steep)[:, None, None, None, None]
        mix = np.einsum("tix,y->tixy", normal, gravity)[:, :, :, None, :]
        mix = np.broadcast_to(mix, turning.shape)
        mix = mix + mix.transpose(0, 3, 4, 1, 2)
        tilt = (self._weight * by_a[self._cavity] / 24.0)[:, None, None, None, None]
        total = total + assembled(steep * turning + tilt * mix, places, wider)
        spread = self._follow(nodes)
        moves = np.flatnonzero(number >= 0)
        order = moves[np.argsort(number[moves])]
        kept = (3 * order[:, None] + np.arange(3)).ravel()
        return sparse.coo_matrix(sparse.csr_matrix(spread.T @ total @ spread)[kept][:, kept])


_EPSILON = np.zeros((3, 3, 3))
for _i, _j, _k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
    _EPSILON[_i, _j, _k], _EPSILON[_i, _k, _j] = 1.0, -1.0
