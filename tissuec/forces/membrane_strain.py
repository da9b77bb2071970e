"""Strain of walls in plane stress, and the derivatives of their energies.

The energy of a triangle is a function of u = (A, D, f1, …, y): A = tr C and D = det C of its
plane, the squares f of the stretch along families of fibres, and y = log λ, λ being the stretch
of its thickness. Where W_y = 0, the energy has the derivatives W_u by the others alone, and the
second derivatives W_uu - W_uy W_yu / W_yy. (For the equations see ``forces.membranes``.) Where
triangles yield (``forces.membrane_memory``), A' = tr(C P⁻¹) follows the fibres, and where
branches are remembered that relax (``forces.membrane_memory``), B = tr(C W).
"""

from typing import Protocol

import numpy as np

from tissuec.forces.membrane_memory import PlasticPlane, RelaxingPlane
from tissuec.forces.membranes_kernel import CLOSE, LEAST_SQUARE, LONGEST, ROUNDS
from tissuec.forces.solid_strain import EnergySlopes, SolidFibres
from tissuec.laws.derivatives import DERIVATIVES, Derivative, at_invariants, energy
from tissuec.laws.solid import SolidLaw
from tissuec.model.network import Floats, Indices

_A, _D, _Y = 0, 1, -1  # places of A, D and y among the variables

#: A value with its first and second derivatives by the variables.
Derived = tuple[Floats, Floats, Floats]


class PlaneMatter(Protocol):
    """What triangles are made of; ``forces.membranes.Membranes`` says what the names mean."""

    @property
    def shear(self) -> Floats:
        """The shear modulus [Pa], shape (triangle,)."""
        ...

    @property
    def bulk(self) -> Floats:
        """The bulk modulus [Pa], shape (triangle,)."""
        ...

    @property
    def thinning(self) -> Floats:
        """The change of thickness per one of area, dimensionless, shape (triangle,)."""
        ...

    @property
    def law(self) -> Indices:
        """The number of the law, shape (triangle,)."""
        ...

    @property
    def laws(self) -> tuple[SolidLaw, ...]:
        """All laws."""
        ...

    @property
    def fibres(self) -> SolidFibres:
        """Families of fibres in the plane."""
        ...

    @property
    def remembered(self) -> RelaxingPlane | None:
        """The state of the branches; None without any, or where it is not known."""
        ...

    @property
    def plastic(self) -> PlasticPlane | None:
        """The plastic deformation; None where nothing yields, or where it is not known."""
        ...


class MembraneStrain:
    """Strain of triangles whose thickness has no stress across it.

    Args:
        wall: The triangles.
        deformation: F, shape (…, triangle, 3, 2).

    Attributes:
        f, c, cofactors: F, C = FᵀF and cof C, shape (…, triangle, 3 or 2, 2).
        root: The cube root of λ, shape (…, triangle).
        thickness: λ, shape (…, triangle).
        square: D, at least 1/25, shape (…, triangle).
        ratio: J, shape (…, triangle).
        squares: Of stretches along families of fibres, shape (…, triangle, family).
        slopes: ∂W/∂u at fixed y [Pa], shape (…, triangle, u - 1).
    """

    def __init__(self, wall: PlaneMatter, deformation: Floats):
        self._wall, self.f, self._kept = wall, deformation, wall.remembered
        self._families = slice(2, 2 + wall.fibres.along.shape[1])
        self.c = c = deformation.swapaxes(-1, -2) @ deformation
        self.cofactors = np.stack(
            [
                np.stack([c[..., 1, 1], -c[..., 0, 1]], axis=-1),
                np.stack([-c[..., 0, 1], c[..., 0, 0]], axis=-1),
            ],
            axis=-2,
        )
        self._trace = c[..., 0, 0] + c[..., 1, 1]
        square = c[..., 0, 0] * c[..., 1, 1] - c[..., 0, 1] ** 2
        self._square = np.maximum(square, 0.0)
        near = np.maximum(self._square, LEAST_SQUARE)
        below, area = self._square - near, np.sqrt(near)
        slope, bend = 0.5 / area, -0.25 / area**3
        q, by_q = area + below * (slope + 0.5 * bend * below), slope + bend * below
        p, rate = q ** (-2.0 / 3.0), by_q / q
        twice = 10.0 / 9.0 * rate**2 - 2.0 / 3.0 * bend / q
        self._q, self._p = (q, by_q, bend), (p, -2.0 / 3.0 * rate * p, twice * p)
        along = wall.fibres.along
        self.squares = np.einsum("...eij,efi,efj->...ef", c, along, along)
        self._law, self._part, self._weights = _A, np.ones_like(square), list[Floats]()
        self._law_trace = self._trace
        if wall.plastic is not None:
            self._law, self._part = self._families.stop, wall.plastic.square
            self._weights.append(wall.plastic.inverse)
            self._law_trace = np.einsum("...ij,...ij->...", c, wall.plastic.inverse)
        if self._kept is not None:
            self._weights.append(self._kept.weight)
            self._pulled = np.einsum("...ij,...ij->...", c, self._kept.weight)
        self.root = self._balanced()
        self.thickness = self.root**3
        self.square, self.ratio = near, self._q[0] * self.thickness
        self.slopes = self._derivatives(self.root)[0][..., :_Y]

    def _balanced(self) -> Floats:
        """Return the cube root of λ; the iteration is that of the kernel."""
        q, _, _ = self._q
        # Of λ from that of J; in the kernel, it is that of J.
        wide = q / np.sqrt(self._part)  # without what is plastic
        root = (1.0 + (1.0 + self._wall.thinning) / 3.0 * (wide - 1.0)) / np.cbrt(q)
        low, high = np.zeros_like(root), np.full_like(root, 1e300)
        is_open = np.ones(root.shape, dtype=bool)
        for _ in range(ROUNDS):
            if not is_open.any():
                break
            slope, bend = self.across(root)
            high, low = np.where(slope > 0.0, root, high), np.where(slope > 0.0, low, root)
            with np.errstate(all="ignore"):
                step = -slope / (3.0 * bend)
            fails = ~(np.isfinite(step) & (bend > 0.0))
            step = np.where(fails, np.where(slope > 0.0, -LONGEST, LONGEST), step)
            step = np.clip(step, -LONGEST, LONGEST)
            found = root * (1.0 + step * (1.0 + 0.5 * step))
            inside = (low <= found) & (found <= high)
            found = np.where(inside, found, np.sqrt(low * high))
            root = np.where(is_open, found, root)
            is_open &= np.abs(step) >= CLOSE
        return root

    def across(self, root: Floats) -> tuple[Floats, Floats]:
        """Return ∂W/∂y and ∂²W/∂y² [Pa], shape (…, triangle), of the root of λ."""
        slopes, second = self._derivatives(root)
        return slopes[..., _Y], second[..., _Y, _Y]

    # --- energy -------------------------------------------------------------------------------

    def energy(self) -> Floats:
        """Return the energy per volume as drawn [Pa], shape (…, triangle)."""
        wall, (i1, i2, j) = self._wall, self._invariants(self.root)
        stored = wall.shear * self._of_laws(i1[0], i2[0], energy)[0]
        stored = stored + 0.5 * wall.bulk * (j[0] - 1.0) ** 2
        k1, k2 = wall.fibres.stiffness, wall.fibres.stiffening
        whole = self._whole(self.root, i1)[0]
        for k in range(wall.fibres.along.shape[1]):
            e = self._fibre_strain(k, whole)
            stored += 0.5 * k1 / k2 * np.expm1(k2 * e * e)
        if self._kept is not None:
            held, _, _ = self._of_branches(self.root, self._kept.across)
            stored += 0.5 * held - 1.5 * self._kept.shear
        return stored

    @property
    def of_laws(self) -> EnergySlopes:
        """Return the derivatives of laws by both invariants [Pa], shape (…, triangle)."""
        i1, i2, _ = self._invariants(self.root)
        return EnergySlopes(*(self._wall.shear * self._of_laws(i1[0], i2[0], *DERIVATIVES)))

    @property
    def isochoric(self) -> tuple[Floats, Floats]:
        """Return g C and g λ², dimensionless, shape (…, triangle, 2, 2) and (…, triangle)."""
        r2 = self.root * self.root
        g = self._p[0] / r2
        return g[..., None, None] * self.c, self._p[0] * r2 * r2

    def piola(self) -> Floats:
        """Return P [Pa], shape (…, triangle, 3, 2)."""
        return self.f @ self._second_piola(self.slopes)

    def _second_piola(self, slopes: Floats) -> Floats:
        """Return S of derivatives by u [Pa], shape (…, triangle, 2, 2)."""
        along = self._wall.fibres.along
        inner = 2.0 * slopes[..., _A, None, None] * np.eye(2)
        inner = inner + 2.0 * slopes[..., _D, None, None] * self.cofactors
        of_fibres = slopes[..., self._families]
        inner += 2.0 * np.einsum("...ef,efi,efj->...eij", of_fibres, along, along)
        for k, weight in enumerate(self._weights, start=self._families.stop):
            inner += 2.0 * slopes[..., k, None, None] * weight
        return inner

    def cauchy(self) -> Floats:
        """Return P Fᵀ / J [Pa], shape (…, triangle, 3, 3); the area ratio is at least 1/5."""
        volume = np.sqrt(self.square) * self.thickness
        return self.piola() @ self.f.swapaxes(-1, -2) / volume[..., None, None]

    def second_derivatives(self) -> Floats:
        """Return ∂²W/∂F∂F [Pa], shape (…, triangle, 6, 6)."""
        slopes, whole = self._derivatives(self.root)
        steep = whole[..., _Y, _Y]
        mixed = whole[..., :_Y, _Y]
        holds = steep > 0.0
        yields = np.where(holds, 1.0 / np.where(holds, steep, 1.0), 0.0)
        inner = whole[..., :_Y, :_Y] - yields[..., None, None] * (
            mixed[..., :, None] * mixed[..., None, :]
        )
        first = self._of_variables()
        found = np.einsum("...ux,...uv,...vy->...xy", first, inner, first)
        turning = self._second_piola(slopes)
        every = np.eye(3)[:, None, :, None] * turning[..., None, :, None, :]
        found += every.reshape(found.shape)
        stretch = self._of_components()
        by_square = slopes[..., _D, None, None]
        pair = stretch[..., 0, :, None] * stretch[..., 1, None, :]
        found += by_square * (pair + pair.swapaxes(-1, -2))
        return found - 2.0 * by_square * stretch[..., 2, :, None] * stretch[..., 2, None, :]

    def _of_components(self) -> Floats:
        """Return the derivatives of C11, C22 and C12 by F, shape (…, triangle, 3, 6)."""
        f = self.f
        none = np.zeros_like(f[..., 0])
        parts = [
            np.stack([2.0 * f[..., 0], none], axis=-1),
            np.stack([none, 2.0 * f[..., 1]], axis=-1),
            f[..., ::-1],
        ]
        return np.stack([part.reshape(*f.shape[:-2], 6) for part in parts], axis=-2)

    def _of_variables(self) -> Floats:
        """Return ∂u/∂F but for y, shape (…, triangle, u - 1, 6)."""
        along, shape = self._wall.fibres.along, (*self.f.shape[:-2], 6)
        parts = [2.0 * self.f, 2.0 * self.f @ self.cofactors]
        lines = (own[:, :, None] * own[:, None, :] for own in np.moveaxis(along, 1, 0))
        parts += [2.0 * self.f @ line for line in lines]
        parts += [2.0 * self.f @ weight for weight in self._weights]
        return np.stack([part.reshape(shape) for part in parts], axis=-2)

    # --- variables ----------------------------------------------------------------------------

    def _derivatives(self, root: Floats) -> tuple[Floats, Floats]:
        """Return ∂W/∂u, shape (…, triangle, u), and ∂²W/∂u∂u, shape (…, triangle, u, u)."""
        wall, (i1, i2, j) = self._wall, self._invariants(root)
        shear = wall.shear
        first, second, first_twice, both, second_twice = shear * self._of_laws(
            i1[0], i2[0], *DERIVATIVES
        )
        slopes = _rows(first, i1[1]) + _rows(second, i2[1])
        slopes += _rows(wall.bulk * (j[0] - 1.0), j[1])
        cross = i1[1][..., :, None] * i2[1][..., None, :]
        bends = _blocks(first, i1[2]) + _blocks(second, i2[2])
        bends += _blocks(first_twice, _square_of(i1[1]))
        bends += _blocks(both, cross + cross.swapaxes(-1, -2))
        bends += _blocks(second_twice, _square_of(i2[1]))
        bends += _blocks(wall.bulk, _square_of(j[1])) + _blocks(wall.bulk * (j[0] - 1.0), j[2])
        k1, k2, spread = wall.fibres.stiffness, wall.fibres.stiffening, wall.fibres.dispersion
        whole = self._whole(root, i1)
        for k in range(wall.fibres.along.shape[1]):
            e = self._fibre_strain(k, whole[0])
            with np.errstate(over="ignore"):
                power = np.exp(k2 * e * e)
            pull = k1 * e * power
            steep = np.where(e > 0.0, k1 * (1.0 + 2.0 * k2 * e * e) * power, 0.0)
            way = spread[:, None] * whole[1]
            way[..., 2 + k] += 1.0 - 3.0 * spread
            slopes += _rows(pull, way)
            bends += _blocks(steep, _square_of(way)) + _blocks(pull * spread, whole[2])
        if self._kept is not None:
            _, more, twice = self._of_branches(root, self._kept.across)
            slopes, bends = slopes + 0.5 * more, bends + 0.5 * twice
        return slopes, bends

    def _fibre_strain(self, family: int, i1: Floats) -> Floats:
        spread = self._wall.fibres.dispersion
        square = self.squares[..., family]
        return np.maximum(spread * (i1 - 3.0) + (1.0 - 3.0 * spread) * (square - 1.0), 0.0)

    @property
    def invariants(self) -> tuple[Floats, Floats]:
        """Return both isochoric invariants, dimensionless, shape (…, triangle)."""
        first, second, _ = self._invariants(self.root)
        return first[0], second[0]

    def _invariants(self, root: Floats) -> tuple[Derived, Derived, Derived]:
        """Return both isochoric invariants of laws, and J, with their derivatives by u."""
        a, d, part = self._law_trace, self._square, self._part
        p, by_p, by_p_twice = self._p
        q, by_q, by_q_twice = self._q
        r2 = root * root
        r4, cube = r2 * r2, r2 * root
        one = self._first(root, a, part, self._law)
        inner, outer = d / (part * r4), part * a * r2
        side, tilt = inner + outer, (2.0 * outer - 4.0 * inner) / 3.0
        two = self._filled(
            p * p * side, p * p * part * r2, 2.0 * p * by_p * side + p * p / (part * r4),
            p * p * tilt,
            {"ad": 2.0 * p * by_p * part * r2,
             "dd": 2.0 * (by_p**2 + p * by_p_twice) * side + 4.0 * p * by_p / (part * r4),
             "ay": 2.0 / 3.0 * p * p * part * r2,
             "dy": 2.0 * p * by_p * tilt - 4.0 / 3.0 * p * p / (part * r4),
             "yy": p * p * (16.0 * inner + 4.0 * outer) / 9.0},
            self._law,
        )  # fmt: skip
        none = np.zeros_like(root)
        volume = self._filled(
            q * cube, none, by_q * cube, q * cube,
            {"ad": none, "dd": by_q_twice * cube, "ay": none, "dy": by_q * cube,
             "yy": q * cube},
            _A,
        )  # fmt: skip
        return one, two, volume

    def _whole(self, root: Floats, of_law: Derived) -> Derived:
        """Return the first invariant of the whole strain, for fibres; that of laws is known."""
        if self._law == _A or not self._wall.fibres.along.shape[1]:
            return of_law
        return self._first(root, self._trace, np.ones_like(root), _A)

    def _of_branches(self, root: Floats, across: Floats) -> Derived:
        """Return g (B + λ² w) with first and second derivatives by u; ``across`` is w."""
        return self._first(root, self._pulled, across, _Y - 1)

    def _first(self, root: Floats, trace: Floats, part: Floats, place: int) -> Derived:
        """Return g (a + λ² c) of a variable a and a constant c with its derivatives by u.

        Args:
            root: The cube root of λ.
            trace, part: a and c.
            place: Of a among the variables.
        """
        p, by_p, by_p_twice = self._p
        r2 = root * root
        inner, outer = trace / r2, part * r2 * r2
        plain, lean = inner + outer, (4.0 * outer - 2.0 * inner) / 3.0
        return self._filled(
            p * plain, p / r2, by_p * plain, p * lean,
            {"ad": by_p / r2, "dd": by_p_twice * plain, "ay": -2.0 / 3.0 * p / r2,
             "dy": by_p * lean, "yy": p * (4.0 * inner + 16.0 * outer) / 9.0},
            place,
        )  # fmt: skip

    def _filled(
        self,
        value: Floats,
        by_a: Floats,
        by_d: Floats,
        by_y: Floats,
        twice: dict[str, Floats],
        place: int,
    ) -> Derived:
        """Return a value with its derivatives by all variables; ``place`` is that of a."""
        count = 3 + self._wall.fibres.along.shape[1] + len(self._weights)
        first = np.zeros((*value.shape, count))
        first[..., place], first[..., _D], first[..., _Y] = by_a, by_d, by_y
        second = np.zeros((*value.shape, count, count))
        places = {"a": place, "d": _D, "y": _Y}
        for (one, other), part in twice.items():
            second[..., places[one], places[other]] = part
            second[..., places[other], places[one]] = part
        return value, first, second

    def _of_laws(self, i1: Floats, i2: Floats, *each: Derivative) -> Floats:
        """Return derivatives of laws by both invariants, shape (derivative, …, triangle)."""
        wall, at = self._wall, (i1[..., None], i2[..., None])
        return at_invariants(wall.laws, wall.law, each, *at)[..., 0]


def _rows(weight: Floats, rows: Floats) -> Floats:
    """Return w v, shape (…, triangle, u)."""
    return weight[..., None] * rows


def _blocks(weight: Floats, blocks: Floats) -> Floats:
    """Return w m, shape (…, triangle, u, u)."""
    return weight[..., None, None] * blocks


def _square_of(vector: Floats) -> Floats:
    """Return v vᵀ, shape (…, u, u)."""
    return vector[..., :, None] * vector[..., None, :]
