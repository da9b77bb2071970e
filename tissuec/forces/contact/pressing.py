"""What a pair of a node and a shape stores; for the equations see ``forces.contact``.

A surface brakes a node by the sums over its pairs with it: with δ, on which E depends, p =
∂E/∂δ, and c = ∂E/∂x·v,

    f = -F ∂E/∂x,    F = max(0, 1 + b Σ c / s),    s = max(Σ p, max p).

Derivatives and matrices follow, see ``autodiff.pools``. By hand are, for they have no
energy: the search for pairs, the sides of surfaces, which the nearest of many triangles tells,
and friction, whose bristles have states; these need a row for each pair that touches.
"""

from collections.abc import Sequence
from functools import cache, cached_property
from typing import NamedTuple, Self

from tissuec.autodiff import (
    TINY,
    Number,
    Numbers,
    Vector,
    dot,
    gradient,
    maximum,
    minimum,
    norm,
    ruled,
    sqrt,
    square,
    where,
)
from tissuec.autodiff.graph import Inequality, Operand
from tissuec.autodiff.pools import ALIKE, Factors, Shares, TracedPool
from tissuec.autodiff.potentials import TracedItem
from tissuec.geometry.nearest import PLANE
from tissuec.model.network import Indices

#: Numbers of all pairs: stiffness k of the node, weight W, depth at distance 0, how often the
#: distance counts in it (-1 times inside of solids), layer w and its inverse.
COLUMNS: tuple[str, ...] = ("stiffness", "weight", "radius", "side", "layer", "inverse")


class PairForm(NamedTuple):
    """What pairs are.

    Attributes:
        has_planes, has_rounds: Whether shapes may be planes, and capsules or triangles; of
            both, a further number, "flat", is 1 for planes and else 0.
        is_between: Whether three nodes carry the point, with the further numbers "shares".
        is_damped: Whether surfaces brake.
    """

    has_planes: bool
    has_rounds: bool
    is_between: bool
    is_damped: bool

    @classmethod
    def of(cls, kind: Indices, *, is_between: bool = False, is_damped: bool = False) -> Self:
        """Return the form of pairs with shapes of some kinds, shape (shape,)."""
        flat = kind == PLANE
        return cls(bool(flat.any()), not bool(flat.all()), is_between, is_damped)

    @property
    def widths(self) -> dict[str, int]:
        """Return how many components each number of a pair has, by name."""
        found = dict.fromkeys(COLUMNS, 1)
        if self.has_planes and self.has_rounds:
            found["flat"] = 1
        if self.is_between:
            found["shares"] = 3
        return found

    @property
    def corners(self) -> int:
        """Return the number of nodes of a pair."""
        return 6 if self.is_between else 4


class NodeOnShape(TracedItem):
    """A node, or a point of a face, and a shape, at rest."""

    def __init__(self, form: PairForm):
        self._form = form
        super().__init__(self._stored, form.corners, form.widths)

    def _stored(self, x: Sequence[Vector], v: Sequence[Vector], p: Numbers) -> Number:
        self._depth, energy = _pressed(self._form, x, p)
        return energy

    @cached_property
    def steepness(self) -> list[Number]:
        """Return ∂²E/∂δ², and ∂δ/∂x, of which its positive part ∂²E/∂δ² ∂δ/∂x ∂δ/∂x is made."""
        (pressure,) = gradient(self.energy, [self._depth])
        return [*gradient(pressure, [self._depth]), *gradient(self._depth, self.x)]


@cache
def traced_pairs(form: PairForm) -> TracedPool:
    """Return pairs of nodes and surfaces, once for each form."""

    def parts(x: Sequence[Vector], v: Sequence[Vector], p: Numbers) -> Shares:
        corners = x[: form.corners]
        depth, energy = _pressed(form, corners, p)
        (pressure,) = gradient(energy, [depth])
        summed = [pressure, pressure]
        if form.is_damped:
            slopes = gradient(energy, [each for point in corners for each in point])
            summed.append(dot(slopes, [each for point in v[: form.corners] for each in point]))
        passed = p.weight * where(p.layer > depth, 1.0, 2.0)
        bends = where(depth > 0.0, passed, 0.0)
        return Shares([energy], summed, frozenset((1,)), depth, bends)

    widths = {"damping": 1} if form.is_damped else {}
    return TracedPool(parts, _braked, form.corners, form.widths, widths, ("stiffness",))


def _braked(sums: Vector, seen: Vector, p: Numbers) -> Factors:
    """Return F and the power that is dissipated."""
    total, most, *closing = sums
    steady = ruled(maximum(total, most), [total, most], _of_greater)
    presses, factor, lost = steady > 0.0, total.graph.number(1.0), total.graph.number(0.0)
    for each in closing:
        slowed = p.damping * each / where(presses, steady, 1.0)
        factor = maximum(1.0 + slowed, 0.0)
        lost = where(presses, (factor - 1.0) * each, 0.0)
    factor = where(presses, factor, 0.0)
    return Factors([factor], lost=lost, bends=where(factor > 0.0, 1.0, 0.0))


def _of_greater(_: Number, total: Number, most: Number) -> list[Operand]:
    """Return the derivatives of the greater one; of equal ones, the first one changes."""
    is_most = (1.0 - ALIKE) * most > total
    return [where(is_most, 0.0, 1.0), where(is_most, 1.0, 0.0)]


def _pressed(form: PairForm, x: Sequence[Vector], p: Numbers) -> tuple[Number, Number]:
    """Return δ, or 0 outside, and E."""
    node, (a, b, c) = x[0], x[-3:]
    if form.is_between:
        node = p.shares[0] * x[0] + p.shares[1] * x[1] + p.shares[2] * x[2]
    if not form.has_planes:
        depth = _below_face(node, a, b, c, p)
    elif not form.has_rounds:
        depth = _below_plane(node, a, b)
    else:
        is_flat = p.flat > 0.5
        depth = where(is_flat, _below_plane(node, a, b), _below_face(node, a, b, c, p))
    d = maximum(depth, 0.0)
    soft = minimum(d, p.layer)
    stored = soft**3 * (p.inverse * (1.0 / 6.0)) + 0.5 * d * (d - soft)
    return d, p.stiffness * (p.weight * stored)


def _below_plane(x: Vector, a: Vector, b: Vector) -> Number:
    return -dot(x - a, b - a) / (norm(b - a) + TINY)


def _below_face(x: Vector, a: Vector, b: Vector, c: Vector, p: Numbers) -> Number:
    """Return the depth in a triangle, or in a capsule, whose c is a."""
    d, e, r = b - a, c - a, x - a
    weights = _nearest(square(d), dot(d, e), square(e), dot(r, d), dot(r, e))
    apart = r - weights[0] * d - weights[1] * e
    gap = square(apart)
    size = sqrt(_or_one(gap))
    # On the point itself there is no direction out of it, and so no force.
    normal = where(gap > 0.0, 1.0 / size, 0.0) * apart
    corners = [each for point in (x, a, b, c) for each in point]
    distance = where(gap > 0.0, size, 0.0)
    distance = ruled(distance, corners + list(normal) + weights, _straight_away)
    return p.radius - p.side * distance


def _straight_away(_: Number, *values: Number) -> list[Operand]:
    """Return the derivatives of a distance: where the nearest point slides does not count."""
    n, (b, c) = values[12:15], values[15:]
    parts: tuple[Operand, ...] = (1.0, b + c - 1.0, -b, -c)
    return [part * each for part in parts for each in n] + [0.0] * 5


def _nearest(bb: Number, bc: Number, cc: Number, xb: Number, xc: Number) -> list[Number]:
    """Return the weights of the corners b and c in the nearest point of a triangle.

    As in ``place_kernel.nearest``, with the same arguments; all regions are computed.
    """
    xb_b, xc_b, xb_c, xc_c = xb - bb, xc - bc, xb - bc, xc - cc
    of_c = xb * xc_b - xb_b * xc
    of_b = xb_c * xc - xb * xc_c
    of_a = xb_b * xc_c - xb_c * xc_b
    whole = of_a + of_b + of_c
    to_c, to_b = xc_b - xb_b, xb_c - xc_c
    # Regions, from the first one on: where none of some conditions holds, the weights are these
    # two by the third.
    regions: list[tuple[list[Inequality], tuple[Operand, ...]]] = [
        ([xb > 0.0, xc > 0.0], (0.0, 0.0, whole)),
        ([xb_b < 0.0, xc_b > xb_b], (1.0, 0.0, 1.0)),
        ([of_c > 0.0, xb < 0.0, xb_b > 0.0], (xb, 0.0, xb - xb_b)),
        ([xc_c < 0.0, xb_c > xc_c], (0.0, 1.0, 1.0)),
        ([of_b > 0.0, xc < 0.0, xc_c > 0.0], (0.0, xc, xc - xc_c)),
        ([of_a > 0.0, to_c < 0.0, to_b < 0.0], (to_b, to_c, to_b + to_c)),
    ]
    found = [of_b, of_c, whole]
    for conditions, values in reversed(regions):
        for k, value in enumerate(values):
            beyond = found[k]
            found[k] = beyond.graph.number(value)
            for condition in conditions:
                found[k] = where(condition, beyond, found[k])
    divisor = _or_one(found[2])
    return [found[0] / divisor, found[1] / divisor]


def _or_one(size: Number) -> Number:
    """Return a size by which one divides, or 1 in place of 0."""
    return where(size > 0.0, size, 1.0)
