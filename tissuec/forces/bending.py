"""Hinges: walls that resist bending, by the angles between the faces at their edges.

A hinge has four nodes: the ends i and j of its edge e = x_j - x_i, and the tips k and l of the
triangles on either side. With a = e × (x_k - x_i) and b = (x_l - x_i) × e, which are normal to
them, its fold is

    θ = atan2((b × a)·e/|e|, a·b),    ∂θ/∂x_k = |e| a/a²,    ∂θ/∂x_l = |e| b/b²,

and both ends of the edge share the opposite of these by the lever rule (R. Bridson, S. Marino,
R. Fedkiw, *Simulation of clothing with folds and wrinkles*, 2003). A hinge that is drawn with
the fold θ0 turns its triangles by the moment

    M = w (k sin(θ - θ0) + d dθ/dt),    and stores    E = w k (1 - cos(θ - θ0)),

which is k (θ - θ0) for small folds, and has no jump where faces are folded onto each other. The
weight w lets go of triangles that collapse into a line, about which nothing can turn:

    w = g(a²/a0²) g(b²/b0²),    g(u) = (1 + ε) u / (u + ε),    ε = 1/100,

a0 and b0 being the drawn ones; so w is 1 as drawn, and hardly changes while triangles stretch.
"""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Self

import numpy as np
from msgspec.structs import replace

from tissuec.core.arrays import cross, cross_matrices, dot
from tissuec.forces import Items, Resisting, WalledField
from tissuec.forces.bending_kernel import COLLAPSE, TINY, WHOLE, HingeTable, fold
from tissuec.forces.matrices import ForceDerivatives, assembled
from tissuec.kernels.records import BoundaryConditions
from tissuec.model.blocks import FieldBlock
from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:
    from scipy.sparse import coo_matrix

_COLUMNS = ("nodes", "stiffness", "damping", "drawn", "squares")


class Hinges(WalledField, frozen=True):
    """Hinges of walls that resist bending; a hinge that loses a spring gives way.

    Attributes:
        nodes: i, j, k and l of each, shape (hinge, 4).
        stiffness: k [N m], shape (hinge,).
        damping: d [N m s], shape (hinge,).
        drawn: θ0 [rad], shape (hinge,).
        squares: a0² and b0² [m⁴], shape (hinge, 2).
    """

    nodes: Indices
    stiffness: Floats
    damping: Floats
    drawn: Floats
    squares: Floats

    @classmethod
    def joined(cls, parts: Sequence["Hinges"]) -> "Hinges":
        """Return the hinges of several bodies in one numbering."""
        first = np.cumsum([0, *(part.item_count for part in parts)])
        walled = [part.walled + start for part, start in zip(parts, first, strict=False)]
        arrays = {
            name: np.concatenate([getattr(part, name) for part in parts])
            for name in (*_COLUMNS, "walls")
        }
        return cls(**arrays, walled=np.concatenate(walled))

    def behind(self, nodes: int, springs: int) -> "Hinges":
        """Return these with the numbers that they have after other nodes and springs."""
        return replace(self, nodes=self.nodes + nodes, walls=self.walls + springs)

    @property
    def block(self) -> FieldBlock:
        """Return these as a block of a net."""
        return FieldBlock("bending", "bending", self, None)

    @property
    def item_count(self) -> int:
        """Return the number of hinges."""
        return len(self.nodes)

    def only(self, items: Indices) -> Self:
        """Return some hinges, by indices of shape (n,), with the walls of all."""
        return replace(self, **{name: getattr(self, name)[items] for name in _COLUMNS})

    def folded(self, position: Floats) -> Floats:
        """Return θ - θ0 [rad], shape (…, hinge).

        Args:
            position: Of all nodes [m], shape (…, node, 3).
        """
        return folds(position[..., self.nodes, :]) - self.drawn

    def gradient(self, position: Floats) -> Floats:
        """Return ∂θ/∂x [1/m], shape (…, hinge, 4, 3); ``position`` is that of ``folded``."""
        return _slopes(*_normals(position[..., self.nodes, :]))

    def first_derivatives(self, position: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Return θ - θ0, w, ∂θ/∂x and ∂w/∂x, shape (hinge,) and (hinge, 4, 3), in [1/m].

        Args:
            position: Of all nodes [m], shape (node, 3).
        """
        parts = _normals(position[self.nodes])
        weight, by_a, by_b = self._weight(*parts[3:])
        swelling = _swelling(*parts[:3], by_a, by_b)
        return _angle(*parts) - self.drawn, weight, _slopes(*parts), swelling

    def second_derivatives(self, position: Floats) -> tuple[Floats, Floats]:
        """Return ∂²θ/∂x∂x and ∂²w/∂x∂x [1/m²], shape (hinge, 4, 3, 4, 3).

        Args:
            position: Of all nodes [m], shape (node, 3).
        """
        parts = _normals(position[self.nodes])
        _, by_a, by_b = self._weight(*parts[3:])
        bent, grown = (
            _by_nodes(each) for each in (_second(*parts), self._bent(*parts, by_a, by_b))
        )
        return bent, grown

    def _weight(self, a: Floats, b: Floats) -> tuple[Floats, Floats, Floats]:
        """Return w, and its derivatives by a² and b² [1/m⁴], shape (…, hinge) each."""
        first, second = self.squares.T
        u, v = dot(a, a) / first, dot(b, b) / second
        upper, lower = (WHOLE * each / (each + COLLAPSE) for each in (u, v))
        rise = WHOLE * COLLAPSE
        by_a = lower * rise / ((u + COLLAPSE) ** 2 * first)
        by_b = upper * rise / ((v + COLLAPSE) ** 2 * second)
        return upper * lower, by_a, by_b

    def energy(self, time: Floats | float, position: Floats) -> Floats:
        """Return the stored energy [J], shape (…)."""
        *_, a, b = parts = _normals(position[..., self.nodes, :])
        half = np.sin(0.5 * (_angle(*parts) - self.drawn))
        weight, _, _ = self._weight(a, b)
        return np.asarray((2.0 * weight * self.stiffness * half**2).sum(axis=-1))

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "coo_matrix":
        """Return ∂²E/∂x∂x [N/m], shape (3 size, 3 size).

        Without ``exact``, only Σ w k cos(θ - θ0) ∂θ/∂x ∂θ/∂xᵀ where that is positive.
        """
        parts = _normals(position[self.nodes])
        more, (weight, by_a, by_b) = _angle(*parts) - self.drawn, self._weight(*parts[3:])
        slopes = _slopes(*parts)
        steep = weight * self.stiffness * np.cos(more)
        if not exact:
            steep = np.maximum(steep, 0.0)
        values = np.einsum("h,hix,hjy->hixjy", steep, slopes, slopes)
        if exact:
            moment, held = self.stiffness * np.sin(more), 2.0 * np.sin(0.5 * more) ** 2
            mixed = np.einsum(
                "h,hix,hjy->hixjy", moment, slopes, _swelling(*parts[:3], by_a, by_b)
            )
            values += mixed + np.einsum("hixjy->hjyix", mixed)
            second = (weight * moment)[:, None, None, None, None] * _second(*parts)
            second += (held * self.stiffness)[:, None, None, None, None] * self._bent(
                *parts, by_a, by_b
            )
            values += _by_nodes(second)
        return assembled(values, number[self.nodes], size)

    def damping_matrices(
        self, position: Floats, velocity: Floats, number: Indices, size: int
    ) -> "tuple[coo_matrix, coo_matrix] | None":
        """Return minus the derivatives of -d w (g·v) g with g = ∂θ/∂x; see ``Field``."""
        if not self.damping.any():
            return None
        parts, moved = _normals(position[self.nodes]), velocity[self.nodes]
        slopes, (weight, by_a, by_b) = _slopes(*parts), self._weight(*parts[3:])
        second = _by_nodes(_second(*parts))
        speed = np.einsum("hix,hix->h", slopes, moved)
        swelling = _swelling(*parts[:3], by_a, by_b)
        faster = np.einsum("hixjy,hjy->hix", second, moved)
        faster = weight[:, None, None] * faster + speed[:, None, None] * swelling
        by_x = np.einsum("h,hix,hjy->hixjy", self.damping, slopes, faster)
        by_x += (self.damping * weight * speed)[:, None, None, None, None] * second
        by_v = np.einsum("h,hix,hjy->hixjy", self.damping * weight, slopes, slopes)
        nodes = number[self.nodes]
        return assembled(by_x, nodes, size), assembled(by_v, nodes, size)

    def _bent(
        self, e: Floats, q: Floats, r: Floats, a: Floats, b: Floats, by_a: Floats, by_b: Floats
    ) -> Floats:
        """Return ∂²w by e, x_k - x_i and x_l - x_i, shape (hinge, 3, 3, 3, 3)."""
        found = np.zeros((len(e), 3, 3, 3, 3))
        first, second = self.squares.T
        u, v = dot(a, a) / first + COLLAPSE, dot(b, b) / second + COLLAPSE
        slopes = np.zeros((2, len(e), 3, 3))
        for tip, span, by, which in ((1, q, by_a, 0), (2, r, by_b, 1)):
            slopes[which, :, 0], slopes[which, :, tip] = (
                _of_square(e, span),
                _of_square(span, e),
            )
            by = by[:, None, None]
            along = dot(e, span)[:, None, None] * np.eye(3)
            outer = e[:, :, None] * span[:, None, :]
            mixed = 2.0 * by * (2.0 * outer - along - outer.swapaxes(1, 2))
            found[:, 0, :, 0] += 2.0 * by * _across(span)
            found[:, tip, :, tip] += 2.0 * by * _across(e)
            found[:, 0, :, tip], found[:, tip, :, 0] = mixed, mixed.swapaxes(1, 2)
        twice = by_a * by_b / self._weight(a, b)[0]
        for one, other, value in (
            (0, 0, -2.0 * by_a / (u * first)), (1, 1, -2.0 * by_b / (v * second)),
            (0, 1, twice), (1, 0, twice),
        ):  # fmt: skip
            found += np.einsum("h,hpx,hqy->hpxqy", value, slopes[one], slopes[other])
        return found

    def spread(self, time: float, position: Floats) -> float:
        """Return the sum of what energies are made of, whose digits rounding spoils [J]."""
        moments = np.abs(self.stiffness * np.sin(self.folded(position)))
        return float((moments * (1.0 + np.abs(self.drawn))).sum())

    def noise(self, time: float, position: Floats) -> float:
        """Return a force whose digits rounding spoils [N]."""
        slopes = np.abs(self.gradient(position)).max(axis=(-2, -1))
        return float((self.stiffness * slopes).max(initial=0.0))

    def stiffening(self, time: float, position: Floats) -> Resisting:
        """Return the stiffness against folding, Σ k ∂θ/∂x ∂θ/∂xᵀ [N/m]; see ``Field``."""
        return self._turning(self.stiffness, position)

    def braking(self, position: Floats) -> Resisting | None:
        """Return the damping of folding, Σ d ∂θ/∂x ∂θ/∂xᵀ [N s/m]."""
        return self._turning(self.damping, position) if self.damping.any() else None

    def _turning(self, part: Floats, position: Floats) -> Resisting:
        slopes = self.gradient(position)

        def resist(moved: Floats, to: Floats) -> None:
            moment = part * np.einsum("hkc,hkc->h", slopes, moved[self.nodes])
            np.add.at(to, self.nodes, moment[:, None, None] * slopes)

        return resist

    # --- for the engine ---------------------------------------------------------------------

    @property
    def kernel(self) -> Callable[..., None]:
        """Return the scalar loops."""
        return fold

    def items(self, place: Indices) -> Items:
        """Return the nodes of the hinges."""
        return Items(place[self.nodes].ravel(), 4 * np.arange(len(self.nodes) + 1))

    def table(self, place: Indices, acts: BoundaryConditions, position: Floats) -> HingeTable:
        """Return the hinges with other numbers of nodes."""
        return HingeTable(
            np.ascontiguousarray(place[self.nodes]),
            self.stiffness,
            self.damping,
            np.cos(self.drawn),
            np.sin(self.drawn),
            self.squares,
        )

    @property
    def derivatives(self) -> ForceDerivatives:
        """Return the derivatives, also by stiffness, damping and drawn folds."""
        from tissuec.forces.bending_derivatives_kernel import pull_folds, push_folds

        return ForceDerivatives(("stiffness", "damping", "drawn"), pull_folds, push_folds)


def hinges_at(
    position: Floats,
    nodes: Indices,
    stiffness: Floats,
    damping: Floats,
    walls: Indices,
    walled: Indices,
) -> Hinges:
    """Return hinges whose angles at rest are those of given positions.

    Args:
        position: Of all nodes at rest [m], shape (node, 3).
        nodes: i, j, k and l of each hinge, shape (hinge, 4).
        stiffness: k [N m], shape (hinge,).
        damping: d [N m s], shape (hinge,).
        walls: Springs between nodes of one hinge, shape (wall,).
        walled: The hinge of each of them, shape (wall,).
    """
    e, q, r, a, b = _normals(position[nodes])
    squares = np.stack([dot(a, a), dot(b, b)], axis=1)
    return Hinges(walls, walled, nodes, stiffness, damping, _angle(e, q, r, a, b), squares)


def folds(corners: Floats) -> Floats:
    """Return θ of hinges [rad], from -π to π, shape (…, hinge).

    Args:
        corners: Where their nodes are [m], shape (…, hinge, 4, 3).
    """
    return _angle(*_normals(corners))


def _normals(corners: Floats) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """Return e, x_k - x_i, x_l - x_i, a and b, shape (…, hinge, 3) each."""
    i, j, k, x = (corners[..., corner, :] for corner in range(4))
    e, q, r = j - i, k - i, x - i
    return e, q, r, cross(e, q), cross(r, e)


def _angle(e: Floats, q: Floats, r: Floats, a: Floats, b: Floats) -> Floats:
    along = dot(cross(b, a), e) / np.sqrt(dot(e, e))
    return np.arctan2(along, dot(a, b))


def _levers(
    e: Floats, q: Floats, r: Floats, a: Floats, b: Floats
) -> tuple[Floats, Floats, Floats, Floats]:
    """Return ∂θ/∂x_k and ∂θ/∂x_l, and where both are along the edge (0 to 1)."""
    square = dot(e, e)[..., None]
    by_k, by_l = (np.sqrt(square) * n / (dot(n, n)[..., None] + TINY) for n in (a, b))
    at_k, at_l = (dot(s, e)[..., None] / square for s in (q, r))
    return by_k, by_l, at_k, at_l


def _slopes(e: Floats, q: Floats, r: Floats, a: Floats, b: Floats) -> Floats:
    by_k, by_l, at_k, at_l = _levers(e, q, r, a, b)
    by_j = -at_k * by_k - at_l * by_l
    return np.stack([-by_j - by_k - by_l, by_j, by_k, by_l], axis=-2)


def _of_square(one: Floats, other: Floats) -> Floats:
    """Return the derivative of |one × other|² by the first, shape (…, 3)."""
    along, square = dot(one, other)[..., None], dot(other, other)[..., None]
    return 2.0 * (square * one - along * other)


def _across(c: Floats) -> Floats:
    """Return c² 1 - c cᵀ, shape (…, 3, 3)."""
    return dot(c, c)[..., None, None] * np.eye(3) - c[..., :, None] * c[..., None, :]


def _swelling(e: Floats, q: Floats, r: Floats, by_a: Floats, by_b: Floats) -> Floats:
    """Return the sum of the numbers times ∂a²/∂x and ∂b²/∂x, shape (…, hinge, 4, 3)."""
    upper, lower = by_a[..., None], by_b[..., None]
    by_k, by_l = upper * _of_square(q, e), lower * _of_square(r, e)
    by_j = upper * _of_square(e, q) + lower * _of_square(e, r)
    return np.stack([-by_j - by_k - by_l, by_j, by_k, by_l], axis=-2)


def _by_nodes(second: Floats) -> Floats:
    """Return derivatives by the nodes, shape (hinge, 4, 3, 4, 3), from those of ``_second``."""
    found = np.zeros((len(second), 4, 3, 4, 3))
    found[:, 1:, :, 1:] = second
    # All three vectors start at the first node.
    found[:, 1:, :, 0] = -second.sum(axis=3)
    found[:, 0] = -found[:, 1:].sum(axis=1)
    return found


def _second(e: Floats, q: Floats, r: Floats, a: Floats, b: Floats) -> Floats:
    """Return ∂²θ by e, x_k - x_i and x_l - x_i, shape (hinge, 3, 3, 3, 3).

    The axes are: by which of the three and by which component of it, twice.
    """
    by_k, by_l, at_k, at_l = _levers(e, q, r, a, b)
    length = np.linalg.norm(e, axis=-1)[:, None, None]
    unit = e[:, None, :] / length
    found = np.zeros((len(e), 3, 3, 3, 3))
    by_e = np.zeros((len(e), 3, 3))
    for tip, by, at, normal, span, sign in (
        (1, by_k, at_k, a, q, 1.0),
        (2, by_l, at_l, b, r, -1.0),
    ):
        square = dot(normal, normal)[:, None, None] + TINY
        outer = normal[:, :, None] * normal[:, None, :] / square
        turned = sign * length * (np.eye(3) - 2.0 * outer) / square
        own, mixed = turned @ cross_matrices(e), -turned @ cross_matrices(span)
        mixed = mixed + by[:, :, None] * unit / length
        found[:, tip, :, tip] = own
        found[:, tip, :, 0], found[:, 0, :, tip] = mixed, mixed.swapaxes(1, 2)
        shift = (span - 2.0 * at * e)[:, None, :] / length**2
        by_e -= by[:, :, None] * shift + at[:, :, None] * mixed
    found[:, 0, :, 0] = by_e
    return found
