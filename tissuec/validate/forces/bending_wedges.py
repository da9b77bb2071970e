"""Wedges with a mean strain and curvatures of edges, and forces by the chain rule in NumPy.

See ``forces.solids.bent_wedge`` for the equations. Here they are written by nodes, and each
number carries its derivatives by all of these along. Places may be complex, as in
``validate.forces.bending_cells``.
"""

from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.validate.forces.bending_cells import FLOOR, GUARD, TINY

Floats = NDArray[np.float64]
THIN, WARPED, TWISTED = 0.1, 0.6, 0.3
_TURN = 2.0 * np.pi * np.arange(3) / 3.0
#: Natural coordinates of corners of the triangle: squares have the mean 1/3 over its area.
TRIANGLE = np.sqrt(8.0 / 3.0) * np.column_stack([np.cos(_TURN), np.sin(_TURN)])
NODES = np.array([(*corner, z) for z in (-1.0, 1.0) for corner in TRIANGLE])
#: Points, in the order of the nodes.
PLACES = np.array([(*corner / 2.0, z / np.sqrt(3.0)) for z in (-1, 1) for corner in TRIANGLE])
WARPS = np.array([NODES[:, 1] * NODES[:, 2], NODES[:, 0] * NODES[:, 2]])
NATURAL = np.sqrt(48.0)  # volume of the reference
_where: Any = np.where


class _With(NamedTuple):
    """Numbers of cells, and their derivatives by all places of nodes, in a last axis."""

    value: Any
    by: Any

    def plus(self, other: "_With", factor: Any = 1.0) -> "_With":
        """Return a sum, with a factor of the second."""
        return _With(self.value + factor * other.value, self.by + factor * other.by)

    def times(self, other: "_With", axes: str = "e,e->e") -> "_With":
        """Return a product as ``np.einsum`` writes it."""
        ins, out = axes.split("->")
        one, two = ins.split(",")
        by = np.einsum(f"{one}z,{two}->{out}z", self.by, other.value)
        by = by + np.einsum(f"{one},{two}z->{out}z", self.value, other.by)
        return _With(np.einsum(axes, self.value, other.value), by)

    def linear(self, numbers: Any, axes: str) -> "_With":
        """Return a product with numbers as drawn."""
        ins, out = axes.split("->")
        one, two = ins.split(",")
        by = np.einsum(f"{one}z,{two}->{out}z", self.by, numbers)
        return _With(np.einsum(axes, self.value, numbers), by)

    def inverse(self, floor: Any) -> "_With":
        """Return one over numbers, which are at least a floor."""
        near = _where(self.value.real > floor, self.value, floor)
        by = _where((self.value.real > floor)[..., None], self.by, 0.0)
        return _With(1.0 / near, -by / near[..., None] ** 2)


def _cross(a: _With, b: _With) -> _With:
    by = np.cross(a.by, b.value[..., None], axis=1) + np.cross(a.value[..., None], b.by, axis=1)
    return _With(np.cross(a.value, b.value), by)


def _dot(a: _With, b: _With) -> _With:
    return a.times(b, "ex,ex->e")


class _BentWedges(NamedTuple):
    """A state of cells: numbers with ``by`` have derivatives in a last axis.

    Attributes:
        mean: F.
        bend: D_k.
        narrowing: A.
        volume: Over that as drawn.
        swelling: j_k.
        modes: g.
        dots: Of a last mode, which wedges do not have.
    """

    mean: Any
    mean_by: Any
    bend: Any
    bend_by: Any
    narrowing: Any
    narrowing_by: Any
    volume: Any
    volume_by: Any
    swelling: Any
    swelling_by: Any
    modes: Any
    modes_by: Any
    dots: Any


class BendingWedges:
    """Wedges as drawn.

    Args:
        corners: Places of their nodes [m], shape (cell, 6, 3).
        gradients: ∂N/∂X at points [1/m], shape (cell, point, 6, 3).
        weight: Volumes of points [m³], shape (cell, point).
        shear, bulk: Moduli [Pa], shape (cell,).
    """

    def __init__(
        self, corners: Floats, gradients: Floats, weight: Floats, shear: Floats, bulk: Floats
    ):
        self.total, self.places = weight.sum(axis=1), PLACES
        self._shear = shear
        self._b = np.einsum("eq,eqax->eax", weight, gradients) / self.total[:, None, None]
        self._a = np.einsum("ka,eax->ekx", _shares(NODES.T), corners)
        self._h = np.einsum("ha,eax->ehx", _shares(WARPS), corners)
        dual = np.asarray(np.linalg.inv(self._a.swapaxes(1, 2)), dtype=float)
        self._long = (self._a**2).sum(axis=2)
        self.steep = (dual**2).sum(axis=(1, 2))
        up = dual[:, 2]
        normal = up / np.linalg.norm(up, axis=1)[:, None]
        lame = bulk - 2.0 * shear / 3.0
        ratio = lame / (lame + 2.0 * shear)
        self._k0 = np.minimum(bulk, shear * (2.0 / 3.0 + np.maximum(ratio, 0.0)))
        lateral = np.sqrt(0.75 + 1.5 * (ratio - self._k0 / (2.0 * shear))) - 0.5
        young = 9.0 * bulk * shear / (3.0 * bulk + shear)
        axial = np.sqrt(0.75 * (young - self._k0) / shear)
        # The strain of the plane that stretches one edge alone solves three equations.
        flat = np.eye(3) - np.einsum("ex,ey->exy", normal, normal)
        inside = np.einsum("exy,eky->ekx", flat, self._a[:, :2])
        edges = np.stack(
            [TRIANGLE[(k + 2) % 3] - TRIANGLE[(k + 1) % 3] for k in range(3)]
        )  # in natural coordinates
        squares = np.stack(
            [edges[:, 0] ** 2, edges[:, 1] ** 2, 2.0 * edges.prod(axis=1)], axis=1
        )
        parts = np.linalg.inv(squares)  # rows: 11, 22 and 12, by edge
        away = np.asarray(np.linalg.pinv(inside.swapaxes(1, 2)), dtype=float)
        self._planes = np.zeros((len(corners), 3, 3, 3))
        for k in range(3):
            plane = np.array([[parts[0, k], parts[2, k]], [parts[2, k], parts[1, k]]])
            self._planes[:, k] = np.einsum("emx,mn,eny->exy", away, plane, away)
        traces = np.trace(self._planes, axis1=2, axis2=3)
        even = self._planes - 0.5 * traces[..., None, None] * flat[:, None]
        self._uneven = np.einsum("ekxy,elxy->ekl", even, even) / 6.0
        self._out = np.eye(3) / 3.0 - np.einsum("ex,ey->exy", normal, normal)
        across = lateral[:, None, None, None] * traces[..., None, None]
        across = across * np.einsum("ex,ey->exy", normal, normal)[:, None]
        self._planes = _even(self._planes - across)
        self._axial = _even(axial[:, None, None] * np.einsum("ex,ey->exy", up, up))
        slender = self._long[:, :2].sum(axis=1) / self._long[:, 2]
        warped = 0.5 * np.sqrt(WARPED / (1.0 + THIN * slender))[:, None, None]
        turns = [np.einsum("ex,ey->exy", dual[:, k], up) for k in (1, 0)]
        self._torsion = [
            _even(sign * warped * (each + each.swapaxes(1, 2)))
            for sign, each in zip((1.0, -1.0), turns, strict=True)
        ]
        over = (up**2).sum(axis=1)
        self._skew = [(dual[:, m] * up).sum(axis=1) / over for m in (0, 1)]
        self._sides = [self._side(corners, k) for k in range(3)]
        still = _With(corners, np.zeros((*corners.shape, 18)))
        self._drawn = _slopes(*_natural(still)).value

    def _side(self, corners: Floats, k: int) -> dict[str, Floats]:
        """Return the numbers of a side as drawn."""
        edge, height, turn = (np.einsum("a,eax->ex", w, corners) for w in _weights(k))
        area = np.cross(edge, height)
        unit = area / np.linalg.norm(area, axis=1)[:, None]
        high, long = (height**2).sum(axis=1), (edge**2).sum(axis=1)
        frame = np.stack([edge, height, unit], axis=2)
        own = np.asarray(np.linalg.solve(frame, turn[..., None]), dtype=float)[..., 0]
        fading = 1.0 / (1.0 + (own[:, 2] / TWISTED) ** 2 / high)
        bows = fading / (1.0 + (long / (4.0 * high)) ** 2)
        out = area / (6.0 * self.total)[:, None]
        return {
            "along": own[:, 0], "up": own[:, 1], "beyond": own[:, 2, None] * unit,
            "long": long, "high": high, "out": out, "far": (out**2).sum(axis=1),
            "leans": (fading - bows)[:, None] / high[:, None] * height,
            "bows": bows[:, None] / high[:, None] * out,
        }  # fmt: skip

    def bent(self, x: Any) -> _BentWedges:
        """Return the state of cells.

        Args:
            x: Places of their nodes [m], shape (cell, 6, 3).
        """
        count = len(x)
        every = np.broadcast_to(np.eye(18).reshape(6, 3, 18), (count, 6, 3, 18))
        nodes = _With(x, every)
        mean = nodes.linear(self._b, "eax,eak->exk")
        edges = mean.linear(self._a, "exk,emk->emx")
        raw, warped = _natural(nodes)
        modes = warped.plus(mean.linear(self._h, "exk,ehk->ehx"), -1.0)
        part, kappa, inverses = self._sheared(nodes, mean)
        curved = [kappa[k].linear(self._planes[:, k], "e,exy->exy") for k in range(3)]
        narrow = _With(np.zeros(count), np.zeros((count, 18)))
        for k, m in product(range(3), repeat=2):
            both = kappa[k].times(kappa[m])
            narrow = narrow.plus(both.linear(self._uneven[:, k, m], "e,e->e"))
        bends = [
            *self._along(edges, modes, inverses),
            curved[0].plus(curved[1]).plus(curved[2]),
        ]
        bent = _With(*(np.stack(each, axis=1) for each in zip(*bends, strict=True)))
        narrowing = narrow.linear(self._out, "e,exy->exy")
        swelled = self._swelled(raw, warped, edges, modes)
        none = np.zeros((count, 3, 4), dtype=part.value.dtype)
        return _BentWedges(*part, *bent, *narrowing, *swelled[0], *swelled[1], *modes, none)

    def _sheared(self, nodes: _With, mean: _With) -> tuple[_With, list[_With], list[_With]]:
        """Return F with what sides add, their curvatures, and 1/s_k."""
        part, kappa, inverses = mean, list[_With](), list[_With]()
        for k, side in enumerate(self._sides):
            edge, height, turn = (nodes.linear(w, "eax,a->ex") for w in _weights(k))
            for vector, share in ((edge, "along"), (height, "up")):
                turn = turn.plus(vector.linear(side[share], "ex,e->ex"), -1.0)
            turn = turn.plus(mean.linear(side["beyond"], "exk,ek->ex"), -1.0)
            turned = _dot(edge, turn)
            inverse = _dot(edge, edge).linear(1.0 / side["long"], "e,e->e").inverse(FLOOR)
            kappa.append(turned.times(inverse))
            inverses.append(inverse)
            out = mean.linear(side["out"], "exk,ek->ex")
            beside = _dot(edge, out).times(inverse).linear(1.0 / side["long"], "e,e->e")
            out = out.plus(edge.times(beside, "ex,e->ex"), -1.0)
            for vector, long, by in ((out, "far", "leans"), (height, "high", "bows")):
                scale = _dot(vector, vector).linear(1.0 / side[long], "e,e->e")
                moved = vector.times(turned.times(scale.inverse(FLOOR)), "ex,e->ex")
                part = part.plus(moved.linear(side[by], "ex,ek->exk"))
        return part, kappa, inverses

    def _along(self, edges: _With, modes: _With, inverses: list[_With]) -> list[_With]:
        """Return D_1 and D_2: strain along ζ, and torsion."""
        first, second, third = (_at(edges, k) for k in range(3))
        one, other = _at(modes, 0), _at(modes, 1)
        along = _dot(third, third).linear(1.0 / self._long[:, 2], "e,e->e").inverse(FLOOR)
        theta = _dot(second, other).plus(_dot(first, one), -1.0)
        sizes = [_With(1.0 / s.value, -s.by / s.value[..., None] ** 2) for s in inverses]
        wide = sizes[0].plus(sizes[1]).plus(sizes[2]).inverse(0.0)
        theta = theta.times(wide)
        theta = theta.plus(theta, 0.5)
        return [
            _dot(third, mode).times(along).linear(self._axial, "e,exy->exy")
            .plus(theta.linear(self._torsion[k], "e,exy->exy"))
            for k, mode in enumerate((other, one))
        ]  # fmt: skip

    def _swelled(
        self, raw: _With, warped: _With, edges: _With, modes: _With
    ) -> tuple[_With, _With]:
        """Return the ratio of volumes, and j_k."""
        a, b, c = (_at(raw, k) for k in range(3))
        p, q = _at(warped, 0), _at(warped, 1)
        volume = _dot(c, _cross(a, b)).plus(_dot(c, _cross(q, p)), 1.0 / 3.0)
        volume = volume.linear(NATURAL / self.total, "e,e->e")
        slopes = _slopes(raw, warped).plus(volume.linear(self._drawn, "e,ek->ek"), -1.0)
        up = _cross(_at(edges, 0), _at(edges, 1))
        skewed = _dot(up, _at(modes, 1)).linear(self._skew[0], "e,e->e")
        skewed = skewed.plus(_dot(up, _at(modes, 0)).linear(self._skew[1], "e,e->e"))
        last = np.broadcast_to(np.array([0.0, 0.0, 1.0]), (len(self.total), 3))
        slopes = slopes.plus(skewed.linear(last, "e,ek->ek"), -1.0)
        return volume, slopes.linear(NATURAL / self.total, "ek,e->ek")

    def points(self, at: _BentWedges) -> tuple[Any, Any, Any]:
        """Return 1 + D and D at points, and C, shape (cell, point, 3, 3) each."""
        own = np.einsum("qk,ekxy->eqxy", self.places, at.bend)
        right = np.einsum("exk,exl->ekl", at.mean, at.mean)[:, None]
        whole, more = np.eye(3) + own, at.narrowing[:, None] @ right
        more = 0.5 * (more + more.swapaxes(-1, -2))
        return whole, own, whole @ right @ whole + own @ right @ own - more

    def alone(self, at: _BentWedges, of_volume: Any) -> Any:
        """Return the energy of cells beside that of points [J], shape (cell,).

        Args:
            of_volume: Of the ratio of volumes [Pa], shape (cell,).
        """
        part, _, _, size = self._guarded(at)
        found = of_volume + self._k0 / 6.0 * (at.swelling**2).sum(axis=1)
        return self.total * (found + part * self._shear * self.steep / 6.0 * size)

    def _guarded(self, at: _BentWedges) -> tuple[Any, Any, Any, Any]:
        """Return how far modes resist, its derivatives by places, the spread, and Σ g²."""
        of_mean: Any = np.linalg.det(at.mean)
        spread: Any = np.sqrt((at.swelling**2).sum(axis=1) + TINY)
        is_corner = (at.volume - spread).real < of_mean.real
        least = _where(is_corner, at.volume - spread, of_mean)
        by_corner = at.volume_by - np.einsum(
            "ek,ekz->ez", at.swelling / spread[:, None], at.swelling_by
        )
        by_mean = np.einsum("exk,exkz->ez", _cofactors(at.mean), at.mean_by)
        part: Any = 1.0 - least / GUARD
        part = _where(part.real < 0.0, 0.0, _where(part.real > 1.0, 1.0, part))
        by = _where(is_corner[:, None], by_corner, by_mean)
        by = -6.0 / GUARD * (part * (1.0 - part))[:, None] * by
        return part * part * (3.0 - 2.0 * part), by, spread, (at.modes**2).sum(axis=(1, 2))

    def pushes(self, at: _BentWedges, stress: Any, by_j: Any, slope: Any) -> Any:
        """Return the derivatives of the energy by places [N], shape (cell, 6, 3).

        Args:
            stress: 2 ∂W/∂C of the points [Pa], shape (cell, point, 3, 3).
            by_j: ∂W/∂J of the points at an unchanged C [Pa], shape (cell, point).
            slope: Derivative of the energy of the volume by the ratio of volumes [Pa].
        """
        share = (self.total / len(self.places))[:, None]
        whole, own, _ = self.points(at)
        right = np.einsum("exk,exl->ekl", at.mean, at.mean)
        every = 0.5 * (share[..., None, None] * stress).sum(axis=1)
        of_right = (whole @ stress @ whole + own @ stress @ own).sum(axis=1)
        of_right = 0.5 * share[..., None] * of_right - _symmetric(at.narrowing @ every)
        turned = right[:, None] @ (whole + own) @ stress * share[..., None, None]
        of_bend = np.einsum("qk,eqxy->ekxy", self.places, _symmetric(turned))
        of_mean = 2.0 * at.mean @ of_right
        of_j = (share * by_j).sum(axis=1)
        of_mean = of_mean + of_j[:, None, None] * _cofactors(at.mean)
        found = np.einsum("exk,exkz->ez", of_mean, at.mean_by)
        found = found + np.einsum("ekxy,ekxyz->ez", of_bend, at.bend_by)
        found = found - np.einsum("exy,exyz->ez", _symmetric(right @ every), at.narrowing_by)
        part, part_by, _, size = self._guarded(at)
        of_swell = (self.total * self._k0 / 3.0)[:, None] * at.swelling
        found = found + np.einsum("ek,ekz->ez", of_swell, at.swelling_by)
        found = found + (self.total * slope)[:, None] * at.volume_by
        guard = self.total * self._shear * self.steep / 6.0
        found = found + (guard * size)[:, None] * part_by
        of_modes = 2.0 * (guard * part)[:, None, None] * at.modes
        found = found + np.einsum("ehx,ehxz->ez", of_modes, at.modes_by)
        return found.reshape(-1, 6, 3)

    def resisting(self, at: _BentWedges, rates: Floats, viscosity: Floats) -> Floats:
        """Return no forces [N]: there is no last mode to brake, shape (cell, 3)."""
        return np.zeros_like(rates[:, :, 3])

    def turned(self, at: _BentWedges, piola: Floats, resisting: Floats) -> Floats:
        """Return the forces of a stress P on nodes [N], shape (cell, 6, 3).

        Args:
            piola: w P of the points [J], shape (cell, point, 3, 3).
            resisting: See ``BendingCells``.
        """
        whole, _, _ = self.points(at)
        of_mean = (piola @ whole).sum(axis=1)
        of_own = _symmetric(at.mean[:, None].swapaxes(-1, -2) @ piola)
        of_bend = np.einsum("qk,eqxy->ekxy", self.places, of_own)
        found = np.einsum("exk,exkz->ez", of_mean, at.mean_by)
        found = found + np.einsum("ekxy,ekxyz->ez", of_bend, at.bend_by)
        return found.reshape(-1, 6, 3)


def _shares(functions: Floats) -> Floats:
    """Return the shares of nodes in what multiplies functions, shape (function, node)."""
    return functions / (functions**2).sum(axis=1)[:, None]


def _weights(k: int) -> tuple[Floats, Floats, Floats]:
    """Return the nodes' shares in the edge, half the height, and the turn of side k."""
    i, j = (k + 1) % 3, (k + 2) % 3
    edge, height, turn = np.zeros(6), np.zeros(6), np.zeros(6)
    edge[[j, j + 3]], edge[[i, i + 3]] = 0.5, -0.5
    height[[i + 3, j + 3]], height[[i, j]] = 0.25, -0.25
    turn[[j + 3, i]], turn[[j, i + 3]] = 0.5, -0.5
    return edge, height, turn


def _natural(nodes: _With) -> tuple[_With, _With]:
    """Return edges and modes of nodes."""
    raw, warped = (
        nodes.linear(_shares(functions), "eax,ka->ekx") for functions in (NODES.T, WARPS)
    )
    return raw, warped


def _at(vectors: _With, k: int) -> _With:
    return _With(vectors.value[:, k], vectors.by[:, k])


def _slopes(raw: _With, warped: _With) -> _With:
    """Return slopes of the triple product of edges along each natural coordinate."""
    a, b, c = (_at(raw, k) for k in range(3))
    p, q = _at(warped, 0), _at(warped, 1)
    area = _cross(a, b)
    rising = _dot(q, _cross(b, c)).plus(_dot(p, _cross(c, a)))
    each = _dot(q, area), _dot(p, area), rising
    return _With(*(np.stack(part, axis=1) for part in zip(*each, strict=True)))


def _even(tensors: Any) -> Any:
    """Return tensors without their trace."""
    third = np.trace(tensors, axis1=-2, axis2=-1)[..., None, None] / 3.0
    return tensors - third * np.eye(3)


def _symmetric(tensors: Any) -> Any:
    return 0.5 * (tensors + tensors.swapaxes(-1, -2))


def _cofactors(f: Any) -> Any:
    a, b, c = (f[:, k] for k in range(3))
    return np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
