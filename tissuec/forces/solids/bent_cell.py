"""Hexahedra that bend at any ratio of their edges: one mean strain and three bendings.

With the numbers of a cell as drawn (``geometry.bent_cells``) and places x of its nodes,

    F = Σ x_a ⊗ b_a,    e_k = F A_k,    g_h = Σ (h - (Σ h X)·b) x / 8,
    s_k = max(|e_k|²/|A_k|², 4/25),    v = its volume over that as drawn,

a cell has, in each plane k of two directions i and j, three curvatures relative to its present
edges,

    κ_ii = e_i·g_j / s_i,    κ_jj = e_j·g_i / s_j,    κ_ij = (e_i·g_i + e_j·g_j)/(s_i + s_j),

and bends in plane stress: with the part S of what they give in the plane, and its trace t,

    D_k = dev(S - β t n_k n_k),    D(ξ) = ξ D_1 + η D_2 + ζ D_3.

At eight points, laws refer to

    C(ξ) = (1 + D)ᵀ FᵀF (1 + D) + Dᵀ FᵀF D - sym(A FᵀF),    J = det F,
    A = Σ |S'|² (1/3 - n_k n_k)/6,

the first two of which are squares, so that C is positive wherever the nodes are; their sum has
the determinant J² but for the third order of D. S' is S without its trace in the plane. Where a
plane becomes longer one way and shorter the other, v falls by the second order; A is the change
of shape that belongs to it. Without A, cells that are stretched to twice their length would
narrow unevenly by themselves. For the whole cell follow, per volume,

    K h(v) + k0/6 Σ j_k² + Y/18 Σ (e_k·g_4)²/(s_k |A_k|⁴),

j_k being the slopes of the volume along ξ_k without those that lie across the plane. With

    k0 = min(K, μ (2/3 + max(ν', 0))),    ν' = λ/(λ + 2 μ),
    β = √(3/4 + 3/2 (ν' - k0/2μ)) - 1/2,

boxes that are bent store what a plate in plane stress does. The mean alone carries all uniform
strain, so that cells of any shape pass the patch test. Where a cell is nearly inside out, its
modes resist, too. (Compare the one-point elements of T. Belytschko, L. P. Bindeman, Comput.
Meth. Appl. Mech. Eng. 105:225, 1993, and the sampled energy of P. Krysl, Int. J. Numer. Meth.
Eng. 103:650, 2015. Trapezoids stay too stiff, as all elements of eight nodes that pass the
patch test do: R. H. MacNeal, Finite Elem. Anal. Des. 11:175, 1992.)
"""

from collections.abc import Callable, Sequence
from typing import ClassVar, NamedTuple, TypeVar

from tissuec import autodiff
from tissuec.autodiff import Number, Numbers, Tensor, Vector
from tissuec.autodiff.graph import Operand
from tissuec.autodiff.tensors import PLACES
from tissuec.geometry.bent_cells import ACROSS, HEXAHEDRON, CellForm

_Linear = TypeVar("_Linear", Number, Tensor)
LEAST_SQUARE = 0.16  # of |e_k|/|A_k|, so that flat cells have finite curvatures
GUARD = 0.2  # ratio of volumes below which modes resist
_TINY = 1e-12  # of what is under a root


class CurvedStrain:
    """The strain of a cell at its points, as coefficients of ``autodiff.cells.TERMS``.

    Args:
        right: C at the middle.
        bends: D_1 to D_3.
        uneven: A.
        mean: F.
        cell: Natural coordinates of the cell.
    """

    def __init__(
        self, right: Tensor, bends: Sequence[Tensor], uneven: Tensor, mean: Tensor,
        cell: CellForm,
    ):  # fmt: skip
        self._right, self._bends, self._mean = right, bends, mean
        self._products = cell.products
        self._turned = [right @ each for each in bends]
        self._uneven = autodiff.symmetric_part(uneven @ right)

    @property
    def trace(self) -> list[Number]:
        """Return tr C."""
        found = [autodiff.trace(self._right - self._uneven)]
        found += [2.0 * autodiff.inner(self._right, each) for each in self._bends]
        # C has D squared twice.
        return self._squared(
            found, lambda i, j: 2.0 * autodiff.inner(self._turned[i], self._bends[j])
        )

    @property
    def right(self) -> list[Tensor]:
        """Return the coefficients of C."""
        found = [self._right - self._uneven]
        found += [each + each.transposed for each in self._turned]
        return self._squared(found, lambda i, j: 2.0 * (self._bends[i] @ self._turned[j]))

    def _squared(
        self, linear: Sequence[_Linear], product: Callable[[int, int], _Linear]
    ) -> list[_Linear]:
        """Return linear coefficients with the products of D_1 to D_3 added.

        Args:
            linear: Coefficients without these products.
            product: Of D_i and D_j.
        """
        found = dict(enumerate(linear))
        for (i, j), shares in self._products.items():
            both = product(i, j) if i == j else product(i, j) + product(j, i)
            for term, share in shares.items():
                part = share * both
                found[term] = found[term] + part if term in found else part
        return [found[term] for term in sorted(found)]

    @property
    def form(self) -> list[Tensor]:
        """Return the coefficients of F (1 + D)."""
        return [self._mean, *(self._mean @ each for each in self._bends)]


def vectors_of(x: Sequence[Vector], cell: CellForm) -> list[Vector]:
    """Return r_k and q_h of the nodes x of a cell, of all edges and modes."""
    return [_summed(x, each) for each in cell.shares.tolist()]


def combined(vectors: Sequence[Vector], factors: Sequence[Operand]) -> Vector:
    """Return a sum of vectors with factors."""
    parts = [factor * each for factor, each in zip(factors, vectors, strict=True)]
    found = parts[0]
    for each in parts[1:]:
        found = found + each
    return found


class CellBending(NamedTuple):
    """How a cell bends.

    Attributes:
        bends: D_1 to D_3.
        uneven: A.
        curved: The numbers that these follow from.
    """

    bends: Sequence[Tensor]
    uneven: Tensor
    curved: Sequence[Number]


class BendingModuli(NamedTuple):
    """What follows from the moduli of a material.

    Attributes:
        lateral: β.
        slow: k0 [Pa].
        young: Young's modulus [Pa].
        shear: μ [Pa].
    """

    lateral: Number
    slow: Number
    young: Number
    shear: Number

    @classmethod
    def of(cls, p: Numbers) -> "BendingModuli":
        """Return those of an element, which has a shear and a bulk modulus."""
        shear, bulk = p.shear, p.bulk
        lame = bulk - 2.0 / 3.0 * shear
        ratio = lame / (lame + 2.0 * shear)
        slow = autodiff.minimum(bulk, shear * (2.0 / 3.0 + autodiff.maximum(ratio, 0.0)))
        under = 0.75 + 1.5 * (ratio - 0.5 * slow / shear)
        lateral = autodiff.sqrt(autodiff.maximum(under, _TINY)) - 0.5
        return cls(lateral, slow, 9.0 * bulk * shear / (3.0 * bulk + shear), shear)


class CellModes:
    """Edges and modes of a hexahedron.

    Attributes:
        cell: Its natural coordinates.
        r, q: Those of the nodes themselves.
        mean: F.
        e: F A_k.
        g: Modes without what F gives them.
    """

    cell: ClassVar[CellForm] = HEXAHEDRON

    def __init__(self, vectors: Sequence[Vector], c: Numbers):
        self.r, self.q = vectors[:3], vectors[3:]
        if "inverse_length" in vars(c):  # a box, whose edges are along the axes
            over: Sequence[Number] = c.inverse_length
            self.mean = Tensor([self.r[k][m] * over[k] for k in range(3)] for m in range(3))
            self.e, self.g = self.r, self.q
            return
        every = range(len(self.q))
        parts = [c.modes[3 * h : 3 * h + 3] for h in every]
        beside = [q - combined(self.r, own) for q, own in zip(self.q, parts, strict=True)]
        self.e = [
            r + combined(beside, [c.slant[3 * h + k] for h in every])
            for k, r in enumerate(self.r)
        ]
        self.g = [q - combined(self.e, own) for q, own in zip(self.q, parts, strict=True)]
        dual = [c.dual[3 * k : 3 * k + 3] for k in range(3)]
        self.mean = Tensor(
            [autodiff.dot([e[m] for e in self.e], [each[n] for each in dual]) for n in range(3)]
            for m in range(3)
        )

    def bending(
        self, squares: Sequence[Number], moduli: BendingModuli, c: Numbers
    ) -> CellBending:
        """Return how the cell bends.

        Args:
            squares: s_k.
            moduli: Of its material.
            c: Numbers of the cell as drawn.
        """
        dots = [[autodiff.dot(e, g) for g in self.g[:3]] for e in self.e]
        kappa = [
            [dots[i][j] / squares[i], dots[j][i] / squares[j],
             (dots[i][i] + dots[j][j]) / (squares[i] + squares[j])]
            for i, j in ACROSS
        ]  # fmt: skip
        twists = [
            autodiff.dot([each[2] for each in kappa], c.twist[3 * k : 3 * k + 3])
            for k in range(3)
        ]
        kappa = [[*each[:2], twist] for each, twist in zip(kappa, twists, strict=True)]
        bends, narrowing = list[Tensor](), list[Number]()
        for k in range(3):
            out = c.lateral[6 * k : 6 * k + 6]
            rows = c.bend[18 * k : 18 * k + 18], c.trace[3 * k : 3 * k + 3], out
            bend, uneven = bent_in_plane(kappa[k], moduli.lateral, *rows)
            bends.append(bend)
            parts: list[Number] = [uneven * each for each in out]
            if narrowing:
                parts = [a + b for a, b in zip(narrowing, parts, strict=True)]
            narrowing = parts
        curved = [each for own in kappa for each in own]
        return CellBending(bends, autodiff.from_half(narrowing), curved)

    @property
    def volume(self) -> Number:
        """Return the volume of the cell over that of natural coordinates."""
        r, q = self.r, self.q
        rest = sum(
            (autodiff.dot(r[a], autodiff.cross(q[b], q[c])) for a, b, c in
             ((0, 2, 1), (1, 0, 2), (2, 1, 0))),
            start=0.0,
        )  # fmt: skip
        return autodiff.dot(r[0], autodiff.cross(r[1], r[2])) + rest / 3.0

    @property
    def slopes(self) -> list[Number]:
        """Return the slopes of ``volume`` along ξ_k."""
        r, q = self.r, self.q
        return [
            autodiff.dot(q[j], autodiff.cross(r[j], r[k]))
            + autodiff.dot(q[i], autodiff.cross(r[k], r[i]))
            for k, (i, j) in enumerate(ACROSS)
        ]

    def skewed(self, c: Numbers) -> list[Number]:
        """Return the slopes of volume along ξ_k that j_k leave out: those across the plane."""
        found = list[Number]()
        for k, (i, j) in enumerate(ACROSS):
            out = self.cell.volume / c.volume * autodiff.cross(self.e[i], self.e[j])
            one, other = (
                c.skew[2 * k + n] * autodiff.dot(out, self.g[m]) for n, m in enumerate((j, i))
            )
            found.append(one + other)
        return found

    @property
    def last(self) -> list[Number]:
        """Return e_k·g_4."""
        return [autodiff.dot(e, self.g[3]) for e in self.e]

    def last_rates(self, moving: "CellModes") -> list[Number]:
        """Return the rates of ``last``, given the edges and modes of velocities."""
        return [
            autodiff.dot(a, self.g[3]) + autodiff.dot(b, moving.g[3])
            for a, b in zip(moving.e, self.e, strict=True)
        ]


def bent_in_plane(
    kappa: Sequence[Number], lateral: Number, bend: Sequence[Number], trace: Sequence[Number],
    out: Sequence[Number],
) -> tuple[Tensor, Number]:  # fmt: skip
    """Return D of a plane, and |S'|²/6.

    Args:
        kappa: Its three curvatures.
        lateral: β.
        bend, trace, out: Of the cell as drawn; see ``geometry.bent_cells.BentPlane``.
    """
    total = autodiff.dot(kappa, trace)
    own = [autodiff.dot(kappa, [bend[6 * n + m] for n in range(3)]) for m in range(6)]
    uneven = autodiff.dot(own, [*own[:3], *(2.0 * each for each in own[3:])])
    uneven = (uneven - total * total / 6.0) / 6.0
    return autodiff.from_half(
        [a + lateral * total * b for a, b in zip(own, out, strict=True)]
    ), uneven


def _summed(x: Sequence[Vector], shares: Sequence[float]) -> Vector:
    """Return a sum of nodes by their shares."""
    used = [(each, share) for each, share in zip(x, shares, strict=True) if share]
    scale = abs(used[0][1])
    if any(abs(share) != scale for _, share in used):
        return combined(*zip(*used, strict=True))
    (first, sign), *rest = used
    found = first if sign > 0 else -first
    for each, sign in rest:
        found = found + each if sign > 0 else found - each
    return scale * found


def boxed(c: Numbers) -> Numbers:
    """Return the numbers of a box with edges along the axes, most of which are zero.

    Args:
        c: Those of ``BOX_WIDTHS``.
    """
    graph = c.volume.graph
    none, third = graph.number(0.0), graph.number(1.0 / 3.0)
    over: Sequence[Number] = c.inverse_length
    bend, trace, lateral = list[Number](), list[Number](), list[Number]()
    for k, (i, j) in enumerate(ACROSS):
        for m in (i, j):
            square = over[m] * over[m]
            bend += [
                square * ((1.0 if n == m else 0.0) - third) if n < 3 else none for n in range(6)
            ]
            trace.append(square)
        # The number of i and j in ``PLACES`` is 3 + k.
        bend += [over[i] * over[j] if n == 3 + k else none for n in range(6)]
        trace.append(none)
        lateral += [third - (1.0 if n == k else 0.0) if n < 3 else none for n in range(6)]
    squares = [each * each for each in over]
    return Numbers({
        "inverse_length": c.inverse_length, "inverse_square": Vector(squares),
        "bend": Vector(bend), "trace": Vector(trace),
        "lateral": Vector(lateral), "twist": c.twist, "skew": Vector([none] * 6),
        "slope": Vector([none] * 3), "volume": c.volume,
        "steep": squares[0] + squares[1] + squares[2],
    })  # fmt: skip


class BentCell(NamedTuple):
    """The strain of a cell, and what it stores besides its points.

    Attributes:
        bending: Its strain at points.
        mean: F.
        energy: Per volume [Pa].
        dissipation: Per volume [W/m³].
        ratio: Its volume over that as drawn.
        volumetric: The part of the energy that depends on the ratio alone [Pa].
        between, inner: As of ``CellState``.
    """

    bending: CurvedStrain
    mean: Tensor
    energy: Number
    dissipation: Operand
    ratio: Number
    volumetric: Number
    between: Sequence[Number]
    inner: Sequence[Vector]


def strained(
    modes: CellModes, moving: CellModes | None, c: Numbers, p: Numbers,
    of_volume: Callable[[Number, Numbers], Number],
) -> BentCell:  # fmt: skip
    """Return the strain of a cell, and what it stores besides its points.

    Args:
        modes: Its edges and modes.
        moving: Their rates, if p has a viscosity.
        c: Numbers of the cell as drawn, those of ``BentCells`` or ``BentWedges``.
        p: Numbers of the element; shear and bulk moduli.
        of_volume: Energy of a ratio of volumes [Pa].
    """
    moduli, natural = BendingModuli.of(p), modes.cell.volume
    squares = [
        autodiff.maximum(autodiff.dot(e, e) * c.inverse_square[k], LEAST_SQUARE)
        for k, e in enumerate(modes.e)
    ]
    bends, uneven, curved = modes.bending(squares, moduli, c)
    right = autodiff.gram(modes.mean)
    bending = CurvedStrain(right, bends, uneven, modes.mean, modes.cell)
    ratio = natural * modes.volume / c.volume
    slopes = [natural / c.volume * each for each in modes.slopes]
    skewed = modes.skewed(c)
    # What the volume changes by along ξ_k, without what is across the plane.
    swelling = [
        a - b - natural / c.volume * ratio * drawn
        for a, b, drawn in zip(slopes, skewed, c.slope, strict=True)
    ]
    both = autodiff.dot(swelling, swelling)
    volumetric = of_volume(ratio, p)
    stored = moduli.slow / 6.0 * both + volumetric
    last, loss = modes.last, 0.0
    if last:
        weights = [c.inverse_square[k] * c.inverse_square[k] / squares[k] for k in range(3)]
        stored = stored + moduli.young / 18.0 * autodiff.dot([a * a for a in last], weights)
        if moving is not None:
            faster = modes.last_rates(moving)
            loss = p.viscosity / 6.0 * autodiff.dot([a * a for a in faster], weights)
    j = autodiff.determinant(modes.mean)
    least = autodiff.minimum(j, ratio - autodiff.sqrt(both + _TINY))
    part = autodiff.minimum(autodiff.maximum(1.0 - least / GUARD, 0.0), 1.0)
    part = part * part * (3.0 - 2.0 * part)
    size = autodiff.dot(*2 * [[each for g in modes.g for each in g]])
    stored = stored + part * moduli.shear * c.steep / 6.0 * size
    half = [right.rows[m][n] for m, n in PLACES[3]]
    of_last = [*squares, *last] if last else []
    between = [*half, *curved, j, ratio, *slopes, *skewed, *of_last, size]
    varying = [each for each in between if each.value is None]
    state = bending, modes.mean, stored, loss, ratio, volumetric, varying
    return BentCell(*state, [*modes.e, *modes.g])
