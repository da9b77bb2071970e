"""What a point of a solid stores, how it relaxes and yields.

For what it stores without memory, see ``solids.elements``.

Branches let stress relax. A branch k is a neo-Hookean solid and a liquid in series, in parallel
with the solid itself. At each point a symmetric tensor Ci stores how far the liquid has flowed;
it begins as 1. With C = FᵀF, the unimodular C' = g(J) C and A = det(Ci)^(1/3) Ci⁻¹, a branch
stores per volume

    E = μk/2 (tr(C' A) - 3),    P = μk (g F A + g'/2 tr(C A) cof F),

and gives way by

    dCi/dt = (C' - tr(C' A)/3 Ci)/τ.

At small strain, this is the dashpot of a Maxwell element: under a constant strain, the stress
falls as exp(-t/τ). The volume of Ci enters neither E nor P, and returns to 1. The dissipation,
with X = C' A,

    -∂E/∂Ci : dCi/dt = μk/2τ det(Ci)^(-1/3) tr((X - tr(X)/3)²),

is never negative, as X has real eigenvalues. (J. C. Simo, Comput. Meth. Appl. Mech. Eng.
60:153, 1987; A. Lion, Acta Mechanica 123:1, 1997; A. V. Shutov, R. Landgraf, J. Ihlemann,
Comput. Meth. Appl. Mech. Eng. 265:213, 2013.)

Ci is kept in the velocities of hidden nodes; see ``solids.element_memory``.

Elements yield at von Mises' limit of stress, and flow above it. F = Fe Fp; elements that yield
store the energy of Fe, and Fp is the shape without stress. Their laws do not depend on
directions, so that Cp = FpᵀFp is enough: it begins as 1, and with A = det(Cp)^(1/3) Cp⁻¹ the
energy is that of a law in the invariants I1 = tr(C A) and I2 = (I1² - tr(C A C A))/2 instead of
those of C. Branches are in series with the flow; fibres and viscosity are in parallel with it.
With the Kirchhoff stress τ of law and branches, and its deviator s,

    σ = √(3/2) |s|,    ε' = max(0, σ - Y)/η,    λ = 3 ε'/2σ,

plastic strain grows by λ s in space, so that a bar lengthens by ε' (P. Perzyna, Adv. Appl.
Mech. 9:243, 1966, of a Bingham solid). Drawn back, this is N = F⁻¹ s F = dev(Pᵀ F), P being the
stress of law and branches, and

    dCp/dt = λ (Cp N + Nᵀ Cp),    dCi/dt = … + λ (Ci N + Nᵀ Ci).

No inverse is taken, so that elements that are inside out have rates, too. Flow changes no
volume: tr N = 0. The dissipation, λ tr(N²) = σ ε', is never negative. (J. C. Simo, Comput.
Meth. Appl. Mech. Eng. 99:61, 1992; J. Lubliner, Plasticity Theory, 1990.)
"""

from collections.abc import Sequence
from functools import cache
from typing import Any, NamedTuple

from tissuec import autodiff
from tissuec.autodiff import Number, Numbers, Tensor
from tissuec.autodiff.points import PLACES, PointState, TracedPoint
from tissuec.laws.derivatives import energy
from tissuec.laws.solid import SolidLaw
from tissuec.laws.solid_constants import constant_name
from tissuec.laws.tracing import traced

#: Ratio of volumes below which the isochoric energy is continued by a parabola, so that it has
#: a value where an element is inverted, and grows.
LEAST = 0.2
_LARGEST = 1e4  # ratio of volumes above which it no longer falls


class SolidKind(NamedTuple):
    """What the points of elements have; kernels depend on it.

    Attributes:
        laws: That elements follow, by their numbers.
        families: Of fibres.
        branches: That relax.
        is_yielding: Whether any element yields.
        is_viscous: Whether any is viscous.
        directions: Of the strain of a point: 3, or 2 in a wall.
        constants: Of laws that are numbers of elements.
        is_stretched: Whether the prestretch F0 is a number of elements.
    """

    laws: tuple[SolidLaw, ...]
    families: int
    branches: int
    is_yielding: bool
    is_viscous: bool
    directions: int = 3
    constants: int = 0
    is_stretched: bool = False

    @property
    def tensors(self) -> int:
        """Return how many tensors a point remembers."""
        return int(self.is_yielding) + self.branches

    @property
    def widths(self) -> dict[str, int]:
        """Return the numbers of an element, with how many components each has."""
        found = {"shear": 1, "local": 1}
        if self.directions == 3:
            found["bulk"] = 1
        if len(self.laws) > 1:
            found["law"] = 1
        if self.constants:
            found["constant"] = self.constants
        if self.is_stretched:
            found["stretch"] = 9 if self.directions == 3 else 5
        if self.is_viscous:
            found["viscosity"] = 1
        if self.families:
            names = ("fibre_stiffness", "fibre_stiffening", "dispersion")
            found |= dict.fromkeys(names, 1) | {"along": self.directions * self.families}
        if self.branches:
            found |= {"branch_shear": self.branches, "branch_pace": self.branches}
        if self.is_yielding:
            found |= {"yield_stress": 1, "yield_pace": 1}
        return found


@cache
def traced_point(kind: SolidKind) -> TracedPoint:
    """Return a point of elements; tensors are Cp where any yields, and then Ci of branches."""

    def point(f: Tensor, rate: Tensor, tensors: Sequence[Tensor], p: Numbers) -> PointState:
        if kind.is_stretched:
            stretch = Tensor(p.stretch[k : k + 3] for k in (0, 3, 6))
            f, rate = f @ stretch, rate @ stretch
        return _point(kind, f, rate, tensors, p)

    return TracedPoint(point, _mean_volume, kind.widths, kind.tensors)


def _mean_volume(mean: Number, p: Numbers) -> Number:
    """Return the energy of the mean of J [Pa]."""
    return 0.5 * p.bulk * (mean - 1.0) ** 2


def _point(
    kind: SolidKind, f: Tensor, rate: Tensor, tensors: Sequence[Tensor], p: Numbers
) -> PointState:
    cofactors, j = f.cofactors, autodiff.determinant(f)
    g, right = isochoric(j), f.transposed @ f
    i1 = autodiff.trace(right)
    plastic, branches = (tensors[:1], tensors[1:]) if kind.is_yielding else ((), tensors)
    if plastic:
        left = f @ _unimodular_inverse(plastic[0]) @ f.transposed
        first, second = autodiff.trace(left), _second_invariant(left)
    else:
        first, second = i1, autodiff.square(cofactors)
    held = [g * _inner(right, _unimodular_inverse(tensor)) for tensor in branches]
    flows = in_series(kind, g * first, g * g * second, held, p)
    along = (p.along[3 * k : 3 * k + 3] for k in range(kind.families))
    squares = [autodiff.square(f.of(each)) for each in along]
    stored = in_parallel(flows, g * i1, j, squares, p)
    loss: Number | float = 0.0
    if kind.is_viscous:
        moving = autodiff.deviator(autodiff.symmetric_part(rate @ cofactors.transposed))
        loss = p.viscosity / autodiff.maximum(j, LEAST) * autodiff.square(moving)
    rates = _rates(kind, f, g * right, flows, plastic, branches, p)
    seen = {
        "invariants": [g * first, g * g * second],
        "paces": paces(kind, flows, (g * first, g * g * second), held, p),
        "isochoric": [g * right.rows[i][k] for i, k in PLACES[3]],
    }
    return PointState(stored, loss, j, rates, seen)


def in_series(
    kind: SolidKind, i1: Number, i2: Number, held: Sequence[Number], p: Numbers
) -> Number:
    """Return the energy of laws and branches, in series with the plastic flow [Pa].

    Args:
        i1, i2: Isochoric invariants of the elastic strain.
        held: tr(C' A) of branches.
    """
    found = p.shear * _law(kind, i1, i2, p)
    for k, each in enumerate(held):
        found = found + 0.5 * one_of(p.branch_shear, k) * (each - 3.0)
    return found


def in_parallel(
    flows: Number, i1: Number, j: Number, squares: Sequence[Number], p: Numbers
) -> Number:
    """Return the energy of a point [Pa], with that of fibres and of the local volume.

    Args:
        flows: As of ``in_series``.
        i1: First isochoric invariant of the whole strain.
        j: Ratio of volumes.
        squares: Of the stretches along families of fibres.
    """
    found = flows + 0.5 * p.local * (j - 1.0) ** 2
    for each in squares:
        e = p.dispersion * (i1 - 3.0) + (1.0 - 3.0 * p.dispersion) * (each - 1.0)
        e = autodiff.maximum(e, 0.0)
        found = found + 0.5 * p.fibre_stiffness / p.fibre_stiffening * grown(
            p.fibre_stiffening * e * e
        )
    return found


def _rates(
    kind: SolidKind, f: Tensor, right: Tensor, flows: Number, plastic: Sequence[Tensor],
    branches: Sequence[Tensor], p: Numbers,
) -> list[Tensor]:  # fmt: skip
    """Return the rates of all tensors [1/s].

    Args:
        right: C without its change of volume.
        flows: What is stored in series with the plastic flow [Pa].
    """
    found: list[Tensor] = []
    for k, tensor in enumerate(branches):
        third = _inner(right, _unimodular_inverse(tensor)) / 3.0
        found.append(one_of(p.branch_pace, k) * (right - third * tensor))
    if not kind.is_yielding:
        return found
    flat = autodiff.gradient(flows, f.flat)
    piola = Tensor((flat[:3], flat[3:6], flat[6:]))
    driving = autodiff.deviator(piola.transposed @ f)
    pace = pace_of_flow(_inner(driving, driving.transposed), p)
    return carried(pace, driving, [*plastic, *branches], found)


def paces(
    kind: SolidKind, flows: Number, invariants: Sequence[Number], held: Sequence[Number],
    p: Numbers,
) -> list[Number]:  # fmt: skip
    """Return the rates at which branches relax, and a bound of that of the flow [1/s]: 3 μ'/η.

    Args:
        flows, held: As of ``in_series``.
        invariants: Isochoric, of the elastic strain.
    """
    found = [one_of(p.branch_pace, k) * each / 3.0 for k, each in enumerate(held)]
    if kind.is_yielding:
        modulus = largest_modulus(flows, *invariants)
        for k, each in enumerate(held):
            modulus = modulus + one_of(p.branch_shear, k) * each
        found.append(3.0 * p.yield_pace * modulus)
    return found


def largest_modulus(stored: Number, i1: Number, i2: Number) -> Number:
    """Return a shear modulus of a strained law [Pa], exact in tension along an axis.

    Args:
        stored: Its energy [Pa].
        i1, i2: Isochoric invariants on which it depends.
    """
    by = [i1, i2]
    one, two = autodiff.gradient(stored, by, by)
    (one_twice, both), (_, two_twice) = (autodiff.gradient(each, by, by) for each in (one, two))
    # |dev b|² of the isochoric b = Fe Feᵀ, and of its inverse.
    wide = autodiff.maximum(2.0 / 3.0 * i1 * i1 - 2.0 * i2, 0.0)
    thin = autodiff.maximum(2.0 / 3.0 * i2 * i2 - 2.0 * i1, 0.0)
    # Bounds of the largest eigenvalues of 2 ∂W/∂i b.
    ends = [
        2.0 / 3.0 * slope * mean + abs(slope) * autodiff.sqrt(8.0 / 3.0 * square)
        for slope, mean, square in ((one, i1, wide), (two, i2, thin))
    ]
    bends = 2.0 * (abs(one_twice) * wide + abs(two_twice) * thin)
    return ends[0] + ends[1] + bends + 4.0 * abs(both) * autodiff.sqrt(wide * thin)


def pace_of_flow(square: Number, p: Numbers) -> Number:
    """Return the pace of a plastic flow [1/(Pa s)], given the square of what drives it."""
    size = autodiff.sqrt(1.5 * autodiff.maximum(square, autodiff.TINY))
    excess = autodiff.maximum(size - p.yield_stress, 0.0)
    return 1.5 * p.yield_pace * excess / size


def carried(
    pace: Number, driving: Tensor, tensors: Sequence[Tensor], relaxing: Sequence[Tensor]
) -> list[Tensor]:
    """Return the rates of tensors that a plastic flow carries along [1/s].

    Args:
        pace: Of the flow [1/(Pa s)].
        driving: What drives it [Pa].
        tensors: That of the flow, and those of branches.
        relaxing: Rates of the latter without the flow [1/s].
    """
    turned = [pace * (each @ driving) for each in tensors]
    found = [each + each.transposed for each in turned]
    return [found[0], *(a + b for a, b in zip(relaxing, found[1:], strict=True))]


def _law(kind: SolidKind, i1: Number, i2: Number, p: Numbers) -> Number:
    """Return the energy of the law of an element, over its shear modulus."""
    laws, values = kind.laws, {"i1": i1, "i2": i2}
    values |= {constant_name(k): one_of(p.constant, k) for k in range(kind.constants)}
    each = [traced(energy(law), values) for law in laws]
    found = each[0]
    for number, other in enumerate(each[1:], start=1):
        if laws[number] != laws[0]:
            others = autodiff.where(p.law > number + 0.5, found, other)
            found = autodiff.where(p.law > number - 0.5, others, found)
    return found


def one_of(numbers: Any, k: int) -> Number:
    """Return a number of those that are one alone, or several."""
    return numbers if isinstance(numbers, Number) else numbers[k]


def _inner(a: Tensor, b: Tensor) -> Number:
    """Return the sum of the products of components."""
    return autodiff.dot(a.flat, b.flat)


def _second_invariant(a: Tensor) -> Number:
    """Return (tr² a - tr a²)/2 of a symmetric tensor."""
    (a00, a01, a02), (_, a11, a12), (_, _, a22) = a.rows
    products = a00 * a11 + a11 * a22 + a22 * a00
    return products - a01 * a01 - a02 * a02 - a12 * a12


def _unimodular_inverse(a: Tensor) -> Tensor:
    """Return det(a)^(1/3) a⁻¹ of a symmetric tensor."""
    return isochoric(autodiff.determinant(a)) * a.cofactors


def grown(exponent: Number) -> Number:
    """Return exp(z) - 1, exact where z is small, too, by the quotient of both roundings.

    (W. Kahan; see N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2002, section
    1.14.1.)
    """
    power = autodiff.exp(exponent)
    is_seen = power > 1.0
    near = autodiff.where(is_seen, autodiff.minimum(power, 2.0), 2.0)
    exact = exponent * (near - 1.0) / autodiff.log(near)
    small = autodiff.where(is_seen, exact, exponent)
    value = autodiff.where(power > 2.0, power - 1.0, small)
    return autodiff.ruled(value, [exponent], _of_grown)


def _of_grown(_: Number, exponent: Number) -> list[Number]:
    return [autodiff.exp(exponent)]


def isochoric(j: Number) -> Number:
    """Return J^(-2/3), continued by a parabola below ``LEAST``."""
    near = autodiff.maximum(j, LEAST)
    root = _inverse_cube_root(near)
    value = LEAST ** (-2.0 / 3.0)
    slope = -2.0 / 3.0 * value / LEAST
    bend = -5.0 / 3.0 * slope / LEAST
    below = j - near
    return root * root + below * (slope + 0.5 * bend * below)


def _inverse_cube_root(j: Number) -> Number:
    """Return J^(-1/3) by two rounds of fifth order, which leave rounding."""
    small, scale = autodiff.minimum(j, _LARGEST), j.graph.number(1.0)
    # So that it is at most 4, where the start is within 8 %.
    for cube, factor in ((512.0, 0.125), (8.0, 0.5)):
        is_large = small > 0.5 * cube
        small = autodiff.where(is_large, small / cube, small)
        scale = autodiff.where(is_large, factor * scale, scale)
    root = (2.0 + small) / (1.0 + 2.0 * small)
    for _ in range(2):
        r = 1.0 - small * root * root * root
        series = 2.0 / 9.0 + r * (14.0 / 81.0 + r * (35.0 / 243.0))
        root = root * (1.0 + r * (1.0 / 3.0 + r * series))
    return autodiff.ruled(root * scale, [j], _of_root)


def _of_root(root: Number, _: Number) -> list[Number]:
    return [(-1.0 / 3.0) * (root * root) ** 2]
