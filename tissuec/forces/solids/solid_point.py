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

Ci is an internal variable; see ``solids.element_memory``.

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

from collections.abc import Callable, Sequence
from functools import cache, partial
from typing import Any, NamedTuple

from tissuec import autodiff
from tissuec.autodiff import Number, Numbers, Tensor, Vector
from tissuec.autodiff.cells import CellKind, CellState
from tissuec.autodiff.points import PointState, TracedPoint
from tissuec.autodiff.tensors import PLACES
from tissuec.forces.solids import bent_cell
from tissuec.forces.solids.bent_cell import CellModes
from tissuec.forces.solids.bent_wedge import WedgeModes
from tissuec.forces.solids.isochoric import LEAST, falling, folded, isochoric, paired
from tissuec.geometry.bent_cells import BOX_WIDTHS, WIDTHS
from tissuec.geometry.bent_wedges import WEDGE_WIDTHS
from tissuec.laws.derivatives import by_first, energy
from tissuec.laws.formula import Formula, variables
from tissuec.laws.solid import COFACTORS, I2, SolidLaw
from tissuec.laws.solid.volume import is_whole, volume_energies
from tissuec.laws.solid_constants import constant_name
from tissuec.laws.tracing import traced


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
        is_bent: Whether ``solids.bent_cell`` strains their points.
        is_box: Whether they are hexahedra with edges along the axes.
        is_wedge: Whether they are wedges that bend.
        is_even: Whether a single point with the mean of C stands for all of a cell.
        functions: Of the place, on which the volume is projected.
    """

    laws: tuple[SolidLaw, ...]
    families: int
    branches: int
    is_yielding: bool
    is_viscous: bool
    directions: int = 3
    constants: int = 0
    is_stretched: bool = False
    is_bent: bool = False
    is_even: bool = False
    is_box: bool = False
    is_wedge: bool = False
    functions: int = 1

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
        if self.is_bent:
            del found["local"]
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


def evened(kind: SolidKind) -> SolidKind:
    """Return the kind of cells with a single point, if energies depend on the mean of C."""
    is_plain = all(map(_is_linear, kind.laws))
    has_more = kind.families or kind.tensors or kind.is_viscous
    return kind._replace(is_even=kind.is_bent and is_plain and not has_more)


def _is_linear(law: SolidLaw) -> bool:
    """Return whether the energy of a law is linear in C, but for its determinant."""
    return _is_of_trace(law) and not is_whole(law) and not variables(by_first(law))


def _is_of_trace(law: SolidLaw) -> bool:
    """Return whether the energy of a law depends on tr C and det C alone."""
    return not variables(energy(law)) & {I2.name, COFACTORS.name}


@cache
def traced_point(kind: SolidKind) -> TracedPoint:
    """Return a point of elements; tensors are Cp where any yields, and then Ci of branches."""

    def point(f: Tensor, rate: Tensor, tensors: Sequence[Tensor], p: Numbers) -> PointState:
        strain = _Strain(autodiff.gram(f), autodiff.determinant(f), f, rate)
        return _point(kind, strain.stretched(kind, p), tensors, p)

    def bent(
        f: Sequence[Number], rate: Sequence[Number], tensors: Sequence[Tensor], p: Numbers
    ) -> PointState:
        short, whole = _bent_strains(kind, f, rate)
        found = _point(kind, short, tensors, p)
        if kind.is_even:
            return found._replace(seen={})
        if whole is short:
            return found
        return found._replace(seen=_point(kind, whole, tensors, p).seen)

    def of_volume(ratio: Number, p: Numbers) -> Number:
        return p.bulk * _of_volume(kind, ratio, p)[0]

    def cell(
        x: Sequence[Vector], v: Sequence[Vector], c: Numbers, p: Numbers
    ) -> CellState:  # fmt: skip
        own = bent_cell.boxed(c) if kind.is_box else c
        moving = modes(v, own) if kind.is_viscous else None
        found = bent_cell.strained(modes(x, own), moving, own, p, of_volume)
        strains = _strains_of(kind, found, p)
        return CellState(strains, *found[2:])

    if kind.is_bent:
        modes, widths = CellModes, BOX_WIDTHS if kind.is_box else WIDTHS
        if kind.is_wedge:
            modes, widths = WedgeModes, WEDGE_WIDTHS
        shares = partial(bent_cell.vectors_of, cell=modes.cell)
        own = CellKind(cell, shares, modes.cell.shares.shape[1], widths)
        return TracedPoint(bent, None, kind.widths, kind.tensors, cell=own)
    functions = kind.functions
    mean = of_volume if _is_pooled(kind) else None
    return TracedPoint(point, mean, kind.widths, kind.tensors, functions=functions)


def _is_pooled(kind: SolidKind) -> bool:
    """Return whether the mean volume of any element counts."""
    return not all(map(is_whole, kind.laws))


def _has_whole(kind: SolidKind) -> bool:
    """Return whether any element has a whole law."""
    return any(map(is_whole, kind.laws))


class _Strain(NamedTuple):
    """The strain of a point.

    Attributes:
        right: C.
        j: The ratio of volumes.
        f, rate: The deformation and its rate, for viscosity and stress in space.
        trace: tr C, where that is known; None where it follows from C.
        squares: Of the stretches along families of fibres, likewise.
        ratio: Of volumes of the cell, to which whole laws refer; None where it is j.
    """

    right: Tensor
    j: Number
    f: Tensor
    rate: Tensor
    trace: Number | None = None
    squares: Sequence[Number] | None = None
    ratio: Number | None = None

    def stretched(self, kind: SolidKind, p: Numbers) -> "_Strain":
        """Return the strain with the prestretch."""
        if not kind.is_stretched:
            return self
        more = Tensor(p.stretch[k : k + 3] for k in (0, 3, 6))
        j = self.j * autodiff.determinant(more)
        right = autodiff.symmetric(more.transposed @ self.right @ more)
        return _Strain(right, j, self.f @ more, self.rate @ more)


def _strains_of(kind: SolidKind, cell: bent_cell.BentCell, p: Numbers) -> list[list[Number]]:
    """Return the coefficients of tr C, of squares of stretches, of C, J and F (1 + D).

    With whole laws, the ratio of volumes of the cell is the last one.
    """
    bending, j, ways = cell.bending, autodiff.determinant(cell.mean), _ways(kind, p)
    right = [autodiff.symmetric(each) for each in bending.right]
    form, ratio = bending.form, cell.ratio
    drawn, trace = right, bending.trace  # with fewer operations than from C
    if kind.families:
        trace = list(map(autodiff.trace, right))
    if kind.is_stretched:
        more = Tensor(p.stretch[k : k + 3] for k in (0, 3, 6))
        wider = autodiff.determinant(more)
        form, j, ratio = [each @ more for each in form], j * wider, ratio * wider
        right = [more.transposed @ each @ more for each in drawn]
        wide, ways = more @ more.transposed, [more.of(way) for way in ways]
        trace = [autodiff.inner(each, wide) for each in drawn]
    squares = [[autodiff.dot(way, each.of(way)) for each in drawn] for way in ways]
    found = [
        trace, *squares,
        *([each.rows[i][k] for each in right] for i, k in PLACES[3]),
        [j], *map(list, zip(*(each.flat for each in form), strict=True)),
        *([ratio] for _ in range(_has_whole(kind))),
    ]  # fmt: skip
    return [own[:1] for own in found] if kind.is_even else found


def _bent_strains(
    kind: SolidKind, f: Sequence[Number], rate: Sequence[Number]
) -> tuple[_Strain, _Strain]:
    """Return a strain of the numbers of ``_strains_of`` at a point: with and without the first.

    They stand for C where nothing else of it counts.
    """
    first, (trace, *squares) = 1 + kind.families, f[: 1 + kind.families]
    form, moving = (
        Tensor(each[first + k : first + k + 3] for k in (7, 10, 13)) for each in (f, rate)
    )
    whole = _Strain(autodiff.from_half(f[first : first + 6]), f[first + 6], form, moving)
    if _has_whole(kind):
        whole = whole._replace(ratio=f[first + 16])
    if kind.tensors or not all(map(_is_of_trace, kind.laws)):
        return whole, whole
    return whole._replace(trace=trace, squares=squares), whole


def _ways(kind: SolidKind, p: Numbers) -> list[Vector]:
    """Return the directions of families of fibres as drawn."""
    return [Vector(p.along[3 * k : 3 * k + 3]) for k in range(kind.families)]


def _point(
    kind: SolidKind, strain: _Strain, tensors: Sequence[Tensor], p: Numbers
) -> PointState:
    right, j, f, rate, i1, squares, ratio = strain
    if i1 is None or squares is None:
        i1 = autodiff.trace(right)
        squares = [autodiff.dot(each, right.of(each)) for each in _ways(kind, p)]
    g = isochoric(j)
    plastic, branches = (tensors[:1], tensors[1:]) if kind.is_yielding else ((), tensors)
    own = right
    for tensor in plastic:
        own = right @ _unimodular_inverse(tensor)
    first, second = autodiff.trace(own) if plastic else i1, _second_invariant(own)
    fold = folded(j)
    first = g * first + fold
    second = paired(first, g * g * second + 2.0 * fold, fold)
    # det C is J² but for the third order of the bending. Branches need their C' unimodular, so
    # that they store nothing once they have relaxed.
    shrink = g
    if kind.is_bent and branches:
        shrink = falling(autodiff.determinant(right), 1, LEAST**2)
    turned = shrink * right
    held = [autodiff.inner(turned, _unimodular_inverse(tensor)) + fold for tensor in branches]
    wide = g if ratio is None else isochoric(ratio)
    flows = in_series(kind, (g, wide), (first, second), held, p)
    stored = in_parallel(kind, flows, g * i1 + fold, j, squares, p)
    loss: Number | float = 0.0
    if kind.is_viscous:
        moving = autodiff.deviator(autodiff.symmetric_part(rate @ f.cofactors.transposed))
        loss = p.viscosity / autodiff.maximum(j, LEAST) * autodiff.square(moving)
    rates = _rates(kind, right, turned, flows, plastic, branches, p)
    kirchhoff = _kirchhoff(kind, stored, strain)
    seen = {
        "invariants": [first, second],
        "ratio": [j],
        "paces": paces(kind, flows, (first, second), held, p),
        "isochoric": [turned.rows[i][k] for i, k in PLACES[3]],
        "deformation": f.flat,
        "kirchhoff": kirchhoff,
        "cauchy": [each / autodiff.maximum(j, LEAST) for each in kirchhoff],
    }
    pooled = 0.0 if kind.is_bent or not _is_pooled(kind) else j
    return PointState(stored, loss, pooled, rates, seen)


def in_series(
    kind: SolidKind, volumes: Sequence[Number], invariants: Sequence[Number],
    held: Sequence[Number], p: Numbers,
) -> Number:  # fmt: skip
    """Return the energy of laws and branches, in series with the plastic flow [Pa].

    Args:
        volumes: J^(-2/3), and what whole laws have in its place.
        invariants: Isochoric, of the elastic strain.
        held: tr(C' A) of branches.
    """
    (i1, i2), (own, wide) = invariants, volumes
    values = {constant_name(k): one_of(p.constant, k) for k in range(kind.constants)}
    values |= {"i1": i1, "i2": i2, "trace": i1 / own}
    whole = values
    if _has_whole(kind):  # with the J of its power -2/3, which is positive
        j, lame = 1.0 / (wide * autodiff.sqrt(wide)), _lame(kind, p)
        more = {"trace": i1 / wide, "cofactors": i2 / (wide * wide), "j": j, "lame": lame}
        whole = values | more

    def of(law: SolidLaw) -> Number:
        return traced(energy(law), whole if is_whole(law) else values)

    found = p.shear * _chosen(kind, of, p)
    for k, each in enumerate(held):
        found = found + 0.5 * one_of(p.branch_shear, k) * (each - 3.0)
    return found


def in_parallel(
    kind: SolidKind, flows: Number, i1: Number, j: Number, squares: Sequence[Number], p: Numbers
) -> Number:
    """Return the energy of a point [Pa], with that of fibres and of the local volume.

    Args:
        flows: As of ``in_series``.
        i1: First isochoric invariant of the whole strain.
        j: Ratio of volumes.
        squares: Of the stretches along families of fibres.
    """
    of_bulk, of_shear = _of_volume(kind, j, p)
    found = flows + p.shear * of_shear
    if not kind.is_bent:
        found = found + p.local * of_bulk
    for each in squares:
        e = p.dispersion * (i1 - 3.0) + (1.0 - 3.0 * p.dispersion) * (each - 1.0)
        e = autodiff.maximum(e, 0.0)
        found = found + 0.5 * p.fibre_stiffness / p.fibre_stiffening * grown(
            p.fibre_stiffening * e * e
        )
    return found


def _kirchhoff(kind: SolidKind, stored: Number, strain: _Strain) -> list[Number]:
    """Return F S Fᵀ + J (∂W/∂J + p) with the pressure p of the element, by ``PLACES`` [Pa]."""
    half = [strain.right.rows[i][k] for i, k in PLACES[3]]
    by = [strain.j, *([] if strain.ratio is None else [strain.ratio])]
    by_j, *by_ratio = autodiff.gradient(stored, by, [*half, *by])
    stress = _stress(stored, strain.right, strain.j)
    turned = strain.f @ stress @ strain.f.transposed
    if _is_pooled(kind):
        by_j = by_j + strain.j.graph.input("swell")
    pressure = strain.j * by_j
    for each in by_ratio:
        pressure = pressure + by[1] * each
    return [turned.rows[i][k] + (pressure if i == k else 0.0) for i, k in PLACES[3]]


def _stress(stored: Number, right: Tensor, *fixed: Number) -> Tensor:
    """Return S = 2 ∂W/∂C [Pa], of a C that has each number off its diagonal twice."""
    by = autodiff.gradient(stored, [right.rows[i][k] for i, k in PLACES[3]], fixed)
    parts = zip(by, PLACES[3], strict=True)
    return autodiff.from_half([(2.0 if i == k else 1.0) * each for each, (i, k) in parts])


def _rates(
    kind: SolidKind, whole: Tensor, right: Tensor, flows: Number, plastic: Sequence[Tensor],
    branches: Sequence[Tensor], p: Numbers,
) -> list[Tensor]:  # fmt: skip
    """Return the rates of all tensors [1/s].

    Args:
        whole: C.
        right: C without its change of volume.
        flows: What is stored in series with the plastic flow [Pa].
    """
    found: list[Tensor] = []
    for k, tensor in enumerate(branches):
        third = autodiff.inner(right, _unimodular_inverse(tensor)) / 3.0
        found.append(one_of(p.branch_pace, k) * (right - third * tensor))
    if not kind.is_yielding:
        return found
    driving = autodiff.deviator(_stress(flows, whole) @ whole)
    pace = pace_of_flow(autodiff.inner(driving, driving.transposed), p)
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


def _of_volume(kind: SolidKind, j: Number, p: Numbers) -> list[Number]:
    """Return energies of the volume, over the bulk and the shear modulus.

    Below ``LEAST`` they are Taylor's polynomials of second order there.
    """
    near = autodiff.maximum(j, LEAST)
    below = j - near

    def continued(formula: Formula) -> Number:
        slope = formula.slope("j")
        first, second = (float(each.at({"j": LEAST})) for each in (slope, slope.slope("j")))
        return traced(formula, {"j": near}) + below * (first + 0.5 * second * below)

    return [
        _chosen(kind, lambda law, k=k: continued(volume_energies(law)[k]), p) for k in range(2)
    ]


def _lame(kind: SolidKind, p: Numbers) -> Number:
    """Return Lamé's constant λ over the shear modulus."""
    bulk, *more = (getattr(p, name) for name in ("bulk", "local") if name in kind.widths)
    for each in more:
        bulk = bulk + each
    return bulk / p.shear - 2.0 / 3.0


def _chosen(kind: SolidKind, of: Callable[[SolidLaw], Number], p: Numbers) -> Number:
    """Return a quantity of the law that the element follows, from those of all laws."""
    laws, each = kind.laws, [of(law) for law in kind.laws]
    found = each[0]
    for number, other in enumerate(each[1:], start=1):
        if laws[number] != laws[0]:
            others = autodiff.where(p.law > number + 0.5, found, other)
            found = autodiff.where(p.law > number - 0.5, others, found)
    return found


def one_of(numbers: Any, k: int) -> Number:
    """Return a number of those that are one alone, or several."""
    return numbers if isinstance(numbers, Number) else numbers[k]


def _second_invariant(a: Tensor) -> Number:
    """Return (tr² a - tr a²)/2 of a tensor."""
    (a00, a01, a02), (a10, a11, a12), (a20, a21, a22) = a.rows
    products = a00 * a11 + a11 * a22 + a22 * a00
    return products - a01 * a10 - a02 * a20 - a12 * a21


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
