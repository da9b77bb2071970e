"""Hexahedra with one mean strain and three bendings, and forces by the chain rule in NumPy.

The strain C of a point is a function of the mean F and of three curvatures D_k, which follow
from edges and modes of a cell; see ``forces.solids.bent_cell`` for the equations. Here they are
written by products of whole arrays, and their derivatives backwards by hand, line by line. All
of it holds for complex places, whose imaginary parts then change by derivatives.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
CORNERS = np.array(
    [[a, b, z] for z in (-1, 1) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))], dtype=float
)
#: Products of two natural coordinates, by the one that is left out, and of all three.
WARPS = np.array([c.prod() / c for c in CORNERS] + 0.0 * CORNERS).T
TWISTED = CORNERS.prod(axis=1)
COUPLING, FLOOR, GUARD, TINY = 0.25, 0.16, 0.2, 1e-12


class _Bent(NamedTuple):
    """A state of cells; arrays begin with the cell.

    Attributes:
        mean: F.
        edges, modes: e and g, by number and component; modes are four.
        raw, warped: Edges and modes of the nodes themselves.
        square: Of the edges over those as drawn, at least ``FLOOR``.
        dots: e_i · g_h.
        kappa: Curvatures of each plane, and the twist behind those in its plane.
        bend: D_k.
        narrowing: A.
        volume: Over that as drawn.
        swelling: j_k.
    """

    mean: Any
    edges: Any
    modes: Any
    raw: Any
    warped: Any
    square: Any
    dots: Any
    kappa: Any
    bend: Any
    narrowing: Any
    volume: Any
    swelling: Any


class BendingCells:
    """Hexahedra as drawn.

    Args:
        corners: Places of their nodes [m], shape (cell, 8, 3).
        gradients: ∂N/∂X at points [1/m], shape (cell, point, 8, 3).
        weight: Volumes of points [m³], shape (cell, point).
        shear, bulk: Moduli [Pa], shape (cell,).
        places: Natural coordinates of the points, shape (point, 3).
    """

    def __init__(
        self, corners: Floats, gradients: Floats, weight: Floats, shear: Floats, bulk: Floats,
        places: Floats,
    ):  # fmt: skip
        self.total, self.places = weight.sum(axis=1), places
        self._shear, self._bulk = shear, bulk
        self._b = np.einsum("eq,eqax->eax", weight, gradients) / self.total[:, None, None]
        self._a = np.einsum("ak,eax->ekx", CORNERS, corners) / 8.0
        self._h = self._warps(corners)
        dual = np.asarray(np.linalg.inv(self._a.swapaxes(1, 2)), dtype=float)
        self._long = (self._a**2).sum(axis=2)
        steep = (dual**2).sum(axis=2)
        self.steep = steep.sum(axis=1)
        normal = dual / np.sqrt(steep)[..., None]
        self._skew = np.einsum("emx,ekx->emk", dual, dual) / steep[:, None, :]
        # Duals in the plane across each direction, and the tensors of its three curvatures.
        flat = (
            dual[:, None]
            - np.einsum("emx,ekx->ekm", dual, normal)[..., None] * normal[:, :, None]
        )
        self._planes = np.zeros((len(corners), 3, 3, 3, 3))
        for k in range(3):
            p, q = flat[:, k, (k + 1) % 3], flat[:, k, (k + 2) % 3]
            mixed = np.einsum("ex,ey->exy", p, q)
            self._planes[:, k, 0] = np.einsum("ex,ey->exy", p, p)
            self._planes[:, k, 1] = np.einsum("ex,ey->exy", q, q)
            self._planes[:, k, 2] = mixed + mixed.swapaxes(1, 2)
        ratio = (bulk - 2.0 * shear / 3.0) / (bulk + 4.0 * shear / 3.0)
        self._k0 = np.minimum(bulk, shear * (2.0 / 3.0 + np.maximum(ratio, 0.0)))
        lateral = np.sqrt(0.75 + 1.5 * (ratio - self._k0 / (2.0 * shear))) - 0.5
        traces = np.trace(self._planes, axis1=3, axis2=4)
        across = np.einsum("ekx,eky->ekxy", normal, normal)
        self._out = np.eye(3) / 3.0 - across
        even = self._planes - traces[..., None, None] / 2.0 * (np.eye(3) - across)[:, :, None]
        self._uneven = np.einsum("ekcxy,ekdxy->ekcd", even, even)
        own = (
            self._planes
            - (lateral[:, None, None] * traces)[..., None, None] * across[:, :, None]
        )
        third = np.trace(own, axis1=3, axis2=4)[..., None, None] / 3.0
        self._planes = own - third * np.eye(3)
        self._young = 9.0 * bulk * shear / (3.0 * bulk + shear)
        length = np.sqrt(self._long)
        both = length[:, :, None] * length[:, None, :]
        coupled = 2.0 * COUPLING * both / (self._long[:, :, None] + self._long[:, None, :])
        coupled[:, range(3), range(3)] = 1.0
        values, ways = np.linalg.eigh(coupled)
        root = (ways * np.sqrt(values)[:, None, :]) @ ways.swapaxes(1, 2)
        unit = length.prod(axis=1)[:, None] / length  # of the plane across each direction
        self._couple = root * unit[:, :, None] / unit[:, None, :]
        self._drawn = self._swells(self._a, self._h)

    @staticmethod
    def _warps(x: Any) -> Any:
        every = np.concatenate([WARPS, TWISTED[None]])
        return np.einsum("ha,eax->ehx", every, x) / 8.0

    @staticmethod
    def _swells(edges: Any, warps: Any) -> Any:
        """Return slopes of the triple product of edges along each natural coordinate."""
        found: list[Any] = []
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            found.append(
                (warps[:, j] * np.cross(edges[:, j], edges[:, k])).sum(axis=1)
                + (warps[:, i] * np.cross(edges[:, k], edges[:, i])).sum(axis=1)
            )
        return np.stack(found, axis=1)

    def bent(self, x: Any) -> _Bent:
        """Return the state of cells.

        Args:
            x: Places of their nodes [m], shape (cell, 8, 3).
        """
        mean = np.einsum("eax,eak->exk", x, self._b)
        edges = np.einsum("exk,emk->emx", mean, self._a)
        raw, warped = np.einsum("ak,eax->ekx", CORNERS, x) / 8.0, self._warps(x)
        modes = warped - np.einsum("exk,ehk->ehx", mean, self._h)
        square = (edges**2).sum(axis=2) / self._long
        square = np.where(square.real < FLOOR, FLOOR, square)
        dots = np.einsum("eix,ehx->eih", edges, modes)
        kappa = np.zeros((len(x), 3, 3), dtype=mean.dtype)
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            kappa[:, k, 0], kappa[:, k, 1] = (
                dots[:, i, j] / square[:, i], dots[:, j, i] / square[:, j],
            )  # fmt: skip
            kappa[:, k, 2] = (dots[:, i, i] + dots[:, j, j]) / (square[:, i] + square[:, j])
        kappa[:, :, 2] = np.einsum("ekm,em->ek", self._couple, kappa[:, :, 2])
        bend = np.einsum("ekc,ekcxy->ekxy", kappa, self._planes)
        uneven = np.einsum("ekc,ekcd,ekd->ek", kappa, self._uneven, kappa)
        narrowing = np.einsum("ek,ekxy->exy", uneven, self._out) / 6.0
        triple = (raw[:, 0] * np.cross(raw[:, 1], raw[:, 2])).sum(axis=1)
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            triple = (
                triple + (raw[:, k] * np.cross(warped[:, j], warped[:, i])).sum(axis=1) / 3.0
            )
        volume = 8.0 * triple / self.total
        swelling = self._swells(raw, warped) - volume[:, None] * self._drawn
        swelling = 8.0 * swelling / self.total[:, None]
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            out = 8.0 * np.cross(edges[:, i], edges[:, j]) / self.total[:, None]
            swelling[:, k] -= self._skew[:, i, k] * (out * modes[:, j]).sum(axis=1)
            swelling[:, k] -= self._skew[:, j, k] * (out * modes[:, i]).sum(axis=1)
        return _Bent(
            mean, edges, modes, raw, warped, square, dots, kappa, bend, narrowing, volume,
            swelling,
        )  # fmt: skip

    def points(self, at: _Bent) -> tuple[Any, Any, Any]:
        """Return 1 + D and D at points, and C, shape (cell, point, 3, 3) each."""
        own = np.einsum("qk,ekxy->eqxy", self.places, at.bend)
        right = np.einsum("exk,exl->ekl", at.mean, at.mean)[:, None]
        whole = np.eye(3) + own
        more = at.narrowing[:, None] @ right
        more = 0.5 * (more + more.swapaxes(-1, -2))
        return whole, own, whole @ right @ whole + own @ right @ own - more

    def alone(self, at: _Bent, of_volume: Any) -> Any:
        """Return the energy of cells beside that of points [J], shape (cell,).

        Args:
            of_volume: Of the ratio of volumes [Pa], shape (cell,).
        """
        last = at.dots[:, :, 3] ** 2 / (at.square * self._long**2)
        part, _ = self._guarded(at)
        found = of_volume + self._k0 / 6.0 * (at.swelling**2).sum(axis=1)
        found = found + self._young / 18.0 * last.sum(axis=1)
        size = (at.modes**2).sum(axis=(1, 2))
        return self.total * (found + part * self._shear * self.steep / 6.0 * size)

    def _guarded(self, at: _Bent) -> tuple[Any, Any]:
        """Return how far modes resist, and its derivative by the least ratio of volumes."""
        least, _, _ = self._least(at)
        part = 1.0 - least / GUARD
        part = np.where(part.real < 0.0, 0.0, np.where(part.real > 1.0, 1.0, part))
        return part * part * (3.0 - 2.0 * part), -6.0 / GUARD * part * (1.0 - part)

    @staticmethod
    def _least(at: _Bent) -> tuple[Any, Any, Any]:
        """Return the least ratio of volumes, where it is that of corners, and their spread."""
        of_mean: Any = np.linalg.det(at.mean)
        where: Any = np.where
        spread: Any = np.sqrt((at.swelling**2).sum(axis=1) + TINY)
        at_corners = at.volume - spread
        is_corner: Any = at_corners.real < of_mean.real
        return where(is_corner, at_corners, of_mean), is_corner, spread

    def pushes(self, at: _Bent, stress: Any, by_j: Any, slope: Any) -> Any:
        """Return the derivatives of the energy by places [N], shape (cell, 8, 3).

        Args:
            stress: 2 ∂W/∂C of the points [Pa], shape (cell, point, 3, 3).
            by_j: ∂W/∂J of the points at an unchanged C [Pa], shape (cell, point).
            slope: Derivative of the energy of the volume by the ratio of volumes [Pa].
        """
        share = (self.total / len(self.places))[:, None]
        whole, own, _ = self.points(at)
        right = np.einsum("exk,exl->ekl", at.mean, at.mean)[:, None]
        # C = (1 + D) B (1 + D) + D B D: half of the stress is the derivative by C.
        of_right = 0.5 * np.einsum(
            "eq,eqkl->ekl", share + 0.0 * by_j, whole @ stress @ whole + own @ stress @ own
        )
        turned = right @ (whole + own) @ stress
        of_own = 0.5 * (turned + turned.swapaxes(-1, -2)) * share[..., None, None]
        of_bend = np.einsum("qk,eqxy->ekxy", self.places, of_own)
        every = 0.5 * (share[..., None, None] * stress).sum(axis=1)
        more, of_narrowing = self._by_narrowing(at, right[:, 0], every)
        of_mean = 2.0 * at.mean @ (of_right - more)
        stiff = (self.total * self._young / 18.0)[:, None] / self._long**2
        of_last = 2.0 * stiff * at.dots[:, :, 3] / at.square
        of_square = -stiff * at.dots[:, :, 3] ** 2 / at.square**2
        of_edges, of_modes = self._by_bend(at, of_bend, of_last, of_square, of_narrowing)
        # What the volume, its slopes and the guard do.
        part, by_least = self._guarded(at)
        size = (at.modes**2).sum(axis=(1, 2))
        guard = self.total * self._shear * self.steep / 6.0
        of_modes = of_modes + 2.0 * (guard * part)[:, None, None] * at.modes
        _, is_corner, spread = self._least(at)
        of_least = guard * size * by_least
        of_volume = self.total * slope + np.where(is_corner, of_least, 0.0)
        of_swell = (self.total * self._k0 / 3.0)[:, None] * at.swelling
        of_swell = of_swell - np.where(is_corner, of_least / spread, 0.0)[:, None] * at.swelling
        of_j = (share * by_j).sum(axis=1) + np.where(is_corner, 0.0, of_least)
        a, b, c = (at.mean[:, k] for k in range(3))
        cofactors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
        of_mean = of_mean + of_j[:, None, None] * cofactors
        scale = (8.0 / self.total)[:, None]
        of_raw, of_warped = np.zeros_like(at.raw), np.zeros_like(at.warped)
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            out, weight = scale * np.cross(at.edges[:, i], at.edges[:, j]), of_swell[:, k, None]
            skews = self._skew[:, i, k, None], self._skew[:, j, k, None]
            of_modes[:, j] -= weight * skews[0] * out
            of_modes[:, i] -= weight * skews[1] * out
            crossed = skews[0] * at.modes[:, j] + skews[1] * at.modes[:, i]
            of_edges[:, i] -= weight * scale * np.cross(at.edges[:, j], crossed)
            of_edges[:, j] -= weight * scale * np.cross(crossed, at.edges[:, i])
            one, r, w = weight * scale, at.raw, at.warped
            of_warped[:, j] += one * np.cross(r[:, j], r[:, k])
            of_warped[:, i] += one * np.cross(r[:, k], r[:, i])
            of_raw[:, j] += one * np.cross(r[:, k], w[:, j])
            of_raw[:, k] += one * (np.cross(w[:, j], r[:, j]) + np.cross(r[:, i], w[:, i]))
            of_raw[:, i] += one * np.cross(w[:, i], r[:, k])
        of_volume = of_volume - (8.0 / self.total) * (of_swell * self._drawn).sum(axis=1)
        self._add_volume(at, of_volume, of_raw, of_warped)
        return self._by_nodes(of_mean, of_edges, of_modes, of_raw, of_warped)

    def _add_volume(self, at: _Bent, of_volume: Any, of_raw: Any, of_warped: Any) -> None:
        """Add what the ratio of volumes does to derivatives by the edges and modes of nodes."""
        once = (8.0 / self.total)[:, None] * of_volume[:, None]
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            of_raw[:, k] += once * np.cross(at.raw[:, i], at.raw[:, j])
            of_raw[:, k] += once / 3.0 * np.cross(at.warped[:, j], at.warped[:, i])
            of_warped[:, j] += once / 3.0 * np.cross(at.warped[:, i], at.raw[:, k])
            of_warped[:, i] += once / 3.0 * np.cross(at.raw[:, k], at.warped[:, j])

    def _by_narrowing(self, at: _Bent, right: Any, stress: Any) -> tuple[Any, Any]:
        """Return minus derivatives of -sym(A B) by B, and those by what A is made of."""
        more = at.narrowing @ stress
        by = np.einsum("exy,ekxy->ek", -right @ stress, self._out) / 6.0
        return 0.5 * (more + more.swapaxes(-1, -2)), by

    def resisting(self, at: _Bent, rates: Floats, viscosity: Floats) -> Floats:
        """Return the forces that brake the last mode, shape (cell, 3).

        Args:
            rates: Of ``_Bent.dots``.
            viscosity: [Pa s], shape (cell,).
        """
        weight = (self.total * viscosity / 3.0)[:, None] / (at.square * self._long**2)
        return weight * rates[:, :, 3]

    def turned(self, at: _Bent, piola: Floats, resisting: Floats) -> Floats:
        """Return the derivatives of Σ w P : F (1 + D) by places [N], shape (cell, 8, 3).

        Args:
            piola: w P of the points [J], shape (cell, point, 3, 3).
            resisting: Derivatives by the dots of the last mode, shape (cell, 3).
        """
        whole, _, _ = self.points(at)
        of_mean = (piola @ whole).sum(axis=1)
        of_own = at.mean[:, None].swapaxes(-1, -2) @ piola
        of_own = 0.5 * (of_own + of_own.swapaxes(-1, -2))
        of_bend = np.einsum("qk,eqxy->ekxy", self.places, of_own)
        of_edges, of_modes = self._by_bend(at, of_bend, resisting, np.zeros_like(at.square))
        none = np.zeros_like(at.raw), np.zeros_like(at.warped)
        return self._by_nodes(of_mean, of_edges, of_modes, *none)

    def _by_bend(
        self, at: _Bent, of_bend: Any, of_last: Any, of_square: Any, of_narrowing: Any = None
    ) -> tuple[Any, Any]:
        """Return derivatives by edges and modes from those by D, last dots, squares and A."""
        of_kappa = np.einsum("ekxy,ekcxy->ekc", of_bend, self._planes)
        if of_narrowing is not None:
            rising = np.einsum("ekcd,ekd->ekc", self._uneven, at.kappa)
            of_kappa = of_kappa + 2.0 * of_narrowing[..., None] * rising
        of_kappa[:, :, 2] = np.einsum("ekm,ek->em", self._couple, of_kappa[:, :, 2])
        of_dots, of_square = np.zeros_like(of_bend[:, :, :1, 0] + at.dots), of_square + 0.0
        of_dots[:, :, 3] = of_last
        s = at.square
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            of_dots[:, i, j] += of_kappa[:, k, 0] / s[:, i]
            of_dots[:, j, i] += of_kappa[:, k, 1] / s[:, j]
            of_square[:, i] -= of_kappa[:, k, 0] * at.dots[:, i, j] / s[:, i] ** 2
            of_square[:, j] -= of_kappa[:, k, 1] * at.dots[:, j, i] / s[:, j] ** 2
            both = of_kappa[:, k, 2] / (s[:, i] + s[:, j])
            of_dots[:, i, i] += both
            of_dots[:, j, j] += both
            sheared = (at.dots[:, i, i] + at.dots[:, j, j]) / (s[:, i] + s[:, j])
            of_square[:, i] -= both * sheared
            of_square[:, j] -= both * sheared
        of_square = np.where(s.real > FLOOR, of_square, 0.0)
        of_edges = 2.0 * at.edges * (of_square / self._long)[..., None]
        of_edges = of_edges + np.einsum("eih,ehx->eix", of_dots, at.modes)
        return of_edges, np.einsum("eih,eix->ehx", of_dots, at.edges)

    def _by_nodes(
        self, of_mean: Any, of_edges: Any, of_modes: Any, of_raw: Any, of_warped: Any
    ) -> Any:
        """Return derivatives by places of nodes, shape (cell, 8, 3)."""
        of_warped = of_warped + of_modes
        of_mean = of_mean - np.einsum("ehx,ehk->exk", of_modes, self._h)
        of_mean = of_mean + np.einsum("emx,emk->exk", of_edges, self._a)
        every = np.concatenate([WARPS, TWISTED[None]])
        found = np.einsum("exk,eak->eax", of_mean, self._b)
        found = found + np.einsum("ak,ekx->eax", CORNERS, of_raw) / 8.0
        return found + np.einsum("ha,ehx->eax", every, of_warped) / 8.0
