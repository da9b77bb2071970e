"""What a point of a wall stores in plane stress, how it relaxes and yields.

It is that of a solid (``solids.solid_point``) whose thickness minimises the energy. For the
equations without memory see ``surfaces.membranes``.

A branch is that of a solid in plane stress. Its tensor Ci keeps the volume 1 and has no shear
across the wall, where it is 1 / det P with the part P in the plane; so three numbers determine
it. With C and the stretch λ of the thickness, it stores per volume

    E = μk/2 (g (tr(C P⁻¹) + λ² det P) - 3),    g = J^(-2/3),

and gives way by

    dP/dt = (g C - T/3 P)/τ,    T = g (tr(C P⁻¹) + λ² det P).

The thickness minimises the energy of the wall with all of its branches, so that the stresses of
the branches and of the law across the wall always balance. The dissipation,

    -∂E/∂P : dP/dt = μk/2τ (tr X² - T²/3),    X = diag(g C P⁻¹, g λ² det P),

is never negative, as X has real eigenvalues with the sum T.

P is an internal variable; see ``solids.element_memory``.

Walls yield at von Mises' limit of stress in plane stress, and flow above it as solids do. The
tensor Cp keeps the volume 1, and has no shear across the wall: its part P in the plane
determines it by three numbers, as it is 1 / π across, with π = det P. With C, D = det C and the
stretch λ of the thickness, the law stores the energy of the invariants

    I1 = tr(C P⁻¹) + π λ²,    I2 = D/π + π λ² tr(C P⁻¹),    J = λ √D.

The thickness minimises the energy of the wall with all that it remembers. Branches are in
series with the flow; fibres and viscosity are in parallel with it. With the stress S of law and
branches at a fixed volume, in the plane and across it,

    N = S C - t 1,    N3 = S33 λ² - t,    t = (tr S C + S33 λ²)/3,
    σ = √(3/2 (tr N² + N3²)),    ε' = max(0, σ - Y)/η,    ν = 3 ε'/2σ,
    dP/dt = ν (P N + Nᵀ P),    and likewise for branches.

The dissipation is ν (tr N² + N3²) = σ ε', and never negative. Bending stays elastic.
"""

from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

from tissuec import autodiff
from tissuec.autodiff import Number, Numbers, Tensor, Vector
from tissuec.autodiff.points import PointState, TracedPoint
from tissuec.autodiff.tensors import PLACES
from tissuec.forces.solids.element_memory import FLAT
from tissuec.forces.solids.solid_point import (
    SolidKind,
    carried,
    in_parallel,
    in_series,
    one_of,
    pace_of_flow,
    paces,
)

#: Square of the ratio of areas below which its root is continued by a parabola, so that
#: triangles that are pressed flat have finite forces.
LEAST_SQUARE = 0.04


@cache
def traced_point(kind: SolidKind) -> TracedPoint:
    """Return a point of walls; tensors are Pp where any yields, and then P of branches."""

    def point(f: Tensor, rate: Tensor, tensors: Sequence[Tensor], p: Numbers) -> PointState:
        if not kind.is_stretched:
            return _point(kind, f, rate, tensors, p)
        *flat, volume = p.stretch
        stretch = Tensor((flat[:2], flat[2:]))
        state = _point(kind, f @ stretch, rate @ stretch, tensors, p)
        lost = volume * state.dissipation
        return state._replace(energy=volume * state.energy, dissipation=lost)

    return TracedPoint(point, None, kind.widths, kind.tensors, kind.directions)


class _Kept(NamedTuple):
    """A plane tensor P that is kept.

    Attributes:
        tensor: P.
        inverse: P⁻¹, by its components 11, 22 and 12.
        part: det P.
    """

    tensor: Tensor
    inverse: Vector
    part: Number

    @classmethod
    def of(cls, tensor: Tensor) -> "_Kept":
        (a, c), (_, b) = tensor.rows
        part = autodiff.maximum(a * b - c * c, FLAT)
        return cls(tensor, Vector((b / part, a / part, -c / part)), part)


class _Plane(NamedTuple):
    """The strain of a wall, but for its thickness.

    Attributes:
        right: C, by its components 11, 22 and 12.
        square: D = det C.
        narrow: One over √D, or over its parabola.
        squares: Of the stretches along families of fibres.
        plastic: Pp; none where nothing yields.
        branches: P of each.
    """

    right: Vector
    square: Number
    narrow: Number
    squares: Sequence[Number]
    plastic: Sequence[_Kept]
    branches: Sequence[_Kept]


class _Strained(NamedTuple):
    """A wall of a certain thickness.

    Attributes:
        isochoric: g C, by its components 11, 22 and 12.
        square: g² D.
        across: g λ².
        invariants: Of the elastic strain, isochoric.
        held: tr(C' A) of branches.
        flows: What is stored in series with the plastic flow [Pa].
        stored: All that is stored [Pa].
    """

    isochoric: Vector
    square: Number
    across: Number
    invariants: tuple[Number, Number]
    held: Sequence[Number]
    flows: Number
    stored: Number


def _point(
    kind: SolidKind, f: Tensor, rate: Tensor, tensors: Sequence[Tensor], p: Numbers
) -> PointState:
    right = _numbers(f.transposed @ f)
    near, square, area = _ratio_of_areas(right)
    families = range(0, 2 * kind.families, 2)
    squares = [_along(right, p.along[k], p.along[k + 1]) for k in families]
    kept = [_Kept.of(tensor) for tensor in tensors]
    count = int(kind.is_yielding)
    plane = _Plane(right, square, 1.0 / area, squares, kept[:count], kept[count:])
    wide = area
    for each in plane.plastic:
        wide = area / autodiff.sqrt(each.part)  # without what is plastic
    # The change of thickness per one of area at small strain, to whose second order the start
    # is exact where the wall is stretched alike in all directions and has no fibres.
    thinning = -(p.local - 2.0 / 3.0 * p.shear) / (p.local + 4.0 / 3.0 * p.shear)
    rising = 1.0 + thinning
    grown = wide - 1.0
    bent = autodiff.maximum(1.0 + rising / 3.0 - 7.0 / 9.0 * rising * rising, 0.0)
    below = 1.0 + bent * autodiff.maximum(grown, 0.0)
    swollen = rising * grown / 3.0
    start = (below + 2.0 * swollen) / (below + swollen)
    found = autodiff.least(lambda root: _strained(kind, plane, root, p).stored, start)
    here, j = _strained(kind, plane, found.at, p), found.at**3
    loss: Number | float = 0.0
    if kind.is_viscous:
        whole = autodiff.symmetric_part(f.transposed @ rate)
        first, second, mixed = right
        turned = Tensor(((second, -mixed), (-mixed, first))) @ whole
        trace = turned.rows[0][0] + turned.rows[1][1]
        part = thinning**2 - (1.0 + thinning) ** 2 / 3.0
        both = autodiff.dot(turned.flat, turned.transposed.flat) + part * trace * trace
        loss = p.viscosity * j / (near * near) * both
    seen = {
        "invariants": here.invariants,
        "ratio": [j],
        "paces": paces(kind, here.flows, here.invariants, here.held, p),
        "isochoric": here.isochoric,
        "thickness": [j * plane.narrow],
        "across": [found.slope, found.bend],
    }
    rates = _rates(kind, plane, here, p)
    return PointState(found.energy, loss, rates=rates, seen=seen)


def _strained(kind: SolidKind, plane: _Plane, root: Number, p: Numbers) -> _Strained:
    """Return a wall of a thickness.

    Args:
        root: The cube root of J, in which the energy of the volume has no part in the plane.
    """
    g, over = 1.0 / (root * root), root * root * plane.narrow
    across, isochoric, square = over * over, g * plane.right, g * g * plane.square
    invariants = _invariants(plane, isochoric, square, across)
    held = [_held(each, isochoric, across) for each in plane.branches]
    flows = in_series(kind, (g, g), invariants, held, p)
    whole = isochoric[0] + isochoric[1] + across
    stored = in_parallel(kind, flows, whole, root**3, plane.squares, p)
    return _Strained(isochoric, square, across, invariants, held, flows, stored)


def _invariants(
    plane: _Plane, isochoric: Vector, square: Number, across: Number
) -> tuple[Number, Number]:
    """Return both invariants of the elastic strain; arguments are those of ``_Strained``."""
    trace = isochoric[0] + isochoric[1]
    for each in plane.plastic:
        trace, across = _inner(isochoric, each.inverse), each.part * across
        square = square / each.part
    return trace + across, square + across * trace


def _rates(kind: SolidKind, plane: _Plane, here: _Strained, p: Numbers) -> list[Tensor]:
    """Return the rates of all tensors [1/s]."""
    right = _tensor(here.isochoric)
    relaxing = [
        one_of(p.branch_pace, k) * (right - held / 3.0 * each.tensor)
        for k, (held, each) in enumerate(zip(here.held, plane.branches, strict=True))
    ]
    if not plane.plastic:
        return relaxing
    # S C at a fixed volume, in the plane and across it, by the parts of what is stored.
    by = [*here.isochoric, here.square, here.across]
    *inner, by_square, by_across = autodiff.gradient(here.flows, by, by)
    first, second, mixed = inner
    within = 2.0 * (_tensor(Vector((first, second, 0.5 * mixed))) @ right)
    of_square, of_across = 2.0 * by_square * here.square, 2.0 * by_across * here.across
    (n0, n1), (n2, n3) = within.rows
    third = (n0 + n3 + 2.0 * of_square + of_across) / 3.0
    n0, n3, outside = n0 + of_square - third, n3 + of_square - third, of_across - third
    square = n0 * n0 + n3 * n3 + 2.0 * n1 * n2 + outside * outside
    tensors = [each.tensor for each in (*plane.plastic, *plane.branches)]
    return carried(pace_of_flow(square, p), Tensor(((n0, n1), (n2, n3))), tensors, relaxing)


def _ratio_of_areas(right: Vector) -> tuple[Number, Number, Number]:
    """Return det C with a lower bound, det C, and its root, continued by a parabola.

    Derivatives of det C are its own where rounding makes it negative, too.
    """
    first, second, mixed = right
    whole = first * second - mixed * mixed
    square = autodiff.ruled(autodiff.maximum(whole, 0.0), [whole], _of_itself)
    near = autodiff.maximum(square, LEAST_SQUARE)
    root, below = autodiff.sqrt(near), square - near
    slope = 0.5 / LEAST_SQUARE**0.5
    bend = -0.5 * slope / LEAST_SQUARE
    return near, square, root + below * (slope + 0.5 * bend * below)


def _of_itself(_: Number, whole: Number) -> list[float]:
    return [1.0]


def _held(kept: _Kept, isochoric: Vector, across: Number) -> Number:
    """Return g (tr(C P⁻¹) + λ² det P)."""
    return _inner(isochoric, kept.inverse) + across * kept.part


def _along(right: Vector, x: Number, y: Number) -> Number:
    """Return the square of a stretch along a direction."""
    return right[0] * x * x + 2.0 * right[2] * x * y + right[1] * y * y


def _inner(a: Vector, b: Vector) -> Number:
    """Return the sum of the products of components of plane tensors."""
    return a[0] * b[0] + a[1] * b[1] + 2.0 * (a[2] * b[2])


def _numbers(a: Tensor) -> Vector:
    """Return the components 11, 22 and 12 of a plane tensor."""
    return Vector(a.rows[i][k] for i, k in PLACES[2])


def _tensor(numbers: Vector) -> Tensor:
    """Return a symmetric plane tensor from its components."""
    first, second, mixed = numbers
    return Tensor(((first, mixed), (mixed, second)))
