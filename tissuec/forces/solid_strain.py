"""Strain of solids at points: energies that change with it, families of fibres, and prestretch.

Families of fibres in solid elements; for the equations see ``forces.elements``.

T. C. Gasser, R. W. Ogden, G. A. Holzapfel, J. R. Soc. Interface 3:15, 2006.

Prestretch of solid elements: F0, by which the drawn body is stretched.

Without stress, an element does not have its drawn shape: it is shorter by a factor λ along an
axis n, or in all directions of the plane with the normal n, at the same volume:

    F0 = λ n ⊗ n + λ^(-1/2) (1 - n ⊗ n)    or    F0 = λ^(-2) n ⊗ n + λ (1 - n ⊗ n).

With F = ∂x/∂X of the drawn places X, the deformation that has stress is F F0 (A. Hoger, J.
Elasticity 48:125, 1997). As det F0 = 1, volumes are those drawn.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple, Self

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from tissuec.forces.elements_kernel import LEAST
from tissuec.geometry.elements import Measures
from tissuec.model.network import Floats, Indices


class EnergySlopes(NamedTuple):
    """What an energy μ ψ(i1, i2) + h(J) changes by, each of shape (…) [Pa].

    Attributes:
        by_first, by_second: μ ∂ψ/∂i1 and μ ∂ψ/∂i2.
        by_first_twice, by_both, by_second_twice: Second derivatives of μ ψ.
        pressure: dh/dJ.
        local: d²h/dJ².
    """

    by_first: Floats
    by_second: Floats
    by_first_twice: Floats
    by_both: Floats
    by_second_twice: Floats
    pressure: Floats
    local: Floats

    @classmethod
    def of(cls, slopes: Sequence[Floats], pressure: Floats, local: Floats) -> "EnergySlopes":
        """Return those with the first five in the order of ``DERIVATIVES``.

        Args:
            slopes: Of the law, times μ [Pa], each of shape (…).
            pressure: dh/dJ [Pa], shape (…).
            local: d²h/dJ² [Pa], shape (…).
        """
        first, second, first_twice, both, second_twice = slopes
        return cls(first, second, first_twice, both, second_twice, pressure, local)


class SolidStrain:
    """Strain at points.

    Args:
        deformation: F, shape (…, 3, 3).

    Attributes:
        f, cofactors: F and cof F, shape (…, 3, 3).
        j: det F, shape (…).
        g, by_j, by_j_twice: Of J^(-2/3), continued below ``LEAST``, and its derivatives.
        i1, i2: tr FᵀF and |cof F|², shape (…).
        first, second: Invariants without the change of volume, shape (…).
    """

    def __init__(self, deformation: Floats):
        self.f = f = deformation
        a, b, c = f[..., 0, :], f[..., 1, :], f[..., 2, :]
        self.cofactors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=-2)
        self.j = np.einsum("...k,...k->...", a, self.cofactors[..., 0, :])
        near = np.maximum(self.j, LEAST)
        power, below = near ** (-2.0 / 3.0), self.j - near
        slope = -2.0 / 3.0 * power / near
        self.by_j_twice = 10.0 / 9.0 * power / near**2
        self.by_j = slope + self.by_j_twice * below
        self.g = power + below * (slope + 0.5 * self.by_j_twice * below)
        self.i1 = np.einsum("...ij,...ij->...", f, f)
        self.i2 = np.einsum("...ij,...ij->...", self.cofactors, self.cofactors)
        self.first, self.second = self.g * self.i1, self.g**2 * self.i2

    def cauchy(self, of: EnergySlopes) -> Floats:
        """Return the stress P Fᵀ / J [Pa], shape (…, 3, 3); J is at least ``LEAST``.

        Args:
            of: Derivatives of the energy at these points.
        """
        by_j = of.by_first * self.by_j * self.i1 + of.pressure
        by_j = by_j + 2.0 * of.by_second * self.g * self.by_j * self.i2
        piola = (2.0 * of.by_first * self.g)[..., None, None] * self.f
        piola = piola + by_j[..., None, None] * self.cofactors
        piola += (of.by_second * self.g**2)[..., None, None] * self._by_deformation_of_second()
        return piola @ self.f.swapaxes(-1, -2) / np.maximum(self.j, LEAST)[..., None, None]

    def second_derivatives(self, of: EnergySlopes) -> Floats:
        """Return ∂²/∂F∂F of the energy per volume [Pa], shape (…, 9, 9).

        Args:
            of: Derivatives of the energy at these points.
        """
        g, slope, bend = self.g, self.by_j, self.by_j_twice
        f, c = (each.reshape(*each.shape[:-2], 9) for each in (self.f, self.cofactors))
        d = self._by_deformation_of_second().reshape(f.shape)
        a = _scaled(2.0 * g, f) + _scaled(slope * self.i1, c)
        found = outer(of.by_first_twice, a, a)
        turning = of.by_first * slope * self.i1 + of.pressure
        by_c = of.by_first * bend * self.i1 + of.local
        alike = of.by_first * g
        by_both = of.by_first * slope
        if of.by_second.any():
            w = of.by_second * g * g
            b = _scaled(g * g, d) + _scaled(2.0 * g * slope * self.i2, c)
            found += outer(of.by_second_twice, b, b) + _either_way(of.by_both, a, b)
            found += self._second_of_second(w) + _either_way(
                2.0 * of.by_second * g * slope, d, c
            )
            by_c = by_c + 2.0 * of.by_second * (slope**2 + g * bend) * self.i2
            turning = turning + 2.0 * of.by_second * g * slope * self.i2
        found += (2.0 * alike)[..., None, None] * np.eye(9)
        found += _either_way(2.0 * by_both, f, c) + outer(by_c, c, c)
        found += (_scaled(turning, f) @ _OF_COFACTORS).reshape(found.shape)
        return found

    def _by_deformation_of_second(self) -> Floats:
        """Return ∂|cof F|²/∂F, shape (…, 3, 3)."""
        return 2.0 * (
            self.i1[..., None, None] * self.f - self.f @ self.f.swapaxes(-1, -2) @ self.f
        )

    def _second_of_second(self, weight: Floats) -> Floats:
        """Return a multiple of ∂²|cof F|²/∂F∂F, shape (…, 9, 9).

        Args:
            weight: The factor, shape (…).
        """
        f, one = self.f, np.eye(3)
        right, left = f.swapaxes(-1, -2) @ f, f @ f.swapaxes(-1, -2)
        flat = f.reshape(*f.shape[:-2], 9)
        mixed = one[:, None, :, None] * right[..., None, :, None, :]
        mixed = mixed + f[..., :, None, None, :] * f[..., None, :, :, None].swapaxes(-3, -2)
        mixed += left[..., :, None, :, None] * one[None, :, None, :]
        found = self.i1[..., None, None] * np.eye(9) - mixed.reshape(*flat.shape, 9)
        return (2.0 * weight)[..., None, None] * found + outer(4.0 * weight, flat, flat)


def _scaled(weight: Floats, vector: Floats) -> Floats:
    return weight[..., None] * vector


def outer(weight: Floats, one: Floats, other: Floats) -> Floats:
    """Return w a bᵀ in the unit of w, shape (…, 9, 9).

    Args:
        weight: w, in any unit, shape (…).
        one, other: a and b, dimensionless, shape (…, 9).
    """
    return _scaled(weight, one)[..., :, None] * other[..., None, :]


def _either_way(weight: Floats, one: Floats, other: Floats) -> Floats:
    """Return w (a bᵀ + b aᵀ), shape (…, 9, 9)."""
    half = outer(weight, one, other)
    return half + half.swapaxes(-1, -2)


#: The permutation symbol.
_SIGNS = np.zeros((3, 3, 3))
for _i, _j, _k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
    _SIGNS[_i, _j, _k], _SIGNS[_i, _k, _j] = 1.0, -1.0
#: How F makes up ∂cof F/∂F, which is two cyclic permutations of it, shape (9, 81).
_OF_COFACTORS = np.einsum("ikm,jln->mnijkl", _SIGNS, _SIGNS).reshape(9, 81)


class SolidFibres(Struct, frozen=True, eq=False):
    """Families of fibres, element by element.

    Attributes:
        along: Unit vectors as drawn, shape (element, family, 3).
        stiffness: k1 [Pa], shape (element,); a quarter of what each family adds to Young's
            modulus along it.
        stiffening: k2, shape (element,); positive.
        dispersion: κ, 0 to 1/3, shape (element,).
    """

    along: Floats
    stiffness: Floats
    stiffening: Floats
    dispersion: Floats

    @classmethod
    def none(cls, count: int) -> Self:
        """Return no families of some elements."""
        return cls(np.zeros((count, 0, 3)), *(np.zeros(count) for _ in range(3)))

    def some(self, items: Indices) -> Self:
        """Return those of some elements, by indices of shape (n,)."""
        parts = self.along, self.stiffness, self.stiffening, self.dispersion
        return type(self)(*(part[items] for part in parts))

    @property
    def modulus(self) -> Floats:
        """Return the sum of the moduli that families add at rest [Pa], shape (element,)."""
        each = 4.0 * self.stiffness * (1.0 - 3.0 * self.dispersion) ** 2
        return self.along.shape[1] * each

    def families(self) -> "Iterator[FibreFamily]":
        """Yield the families."""
        for along in np.moveaxis(self.along, 1, 0):
            yield FibreFamily(along, self.stiffness, self.stiffening, self.dispersion)


class FibreFamily:
    """A family of fibres at the points of elements; see ``forces.elements``.

    Args:
        along: Unit vectors as drawn, shape (element, 3).
        stiffness: k1 [Pa], shape (element,).
        stiffening: k2, shape (element,).
        dispersion: κ, shape (element,).
    """

    def __init__(
        self, along: Floats, stiffness: Floats, stiffening: Floats, dispersion: Floats
    ):
        self._along = along[:, None]
        self._k1, self._k2 = stiffness[:, None], stiffening[:, None]
        self._spread = dispersion[:, None]

    def _strain(self, strain: SolidStrain) -> tuple[Floats, Floats]:
        """Return e where it is positive, otherwise 0, shape (…, point), and F a."""
        along = (strain.f @ self._along[..., None])[..., 0]
        square = np.einsum("...k,...k->...", along, along)
        found = self._spread * (strain.first - 3.0)
        found = found + (1.0 - 3.0 * self._spread) * (square - 1.0)
        return np.maximum(found, 0.0), along

    def energy(self, strain: SolidStrain) -> Floats:
        """Return the energy per volume [Pa], shape (…, point)."""
        e, _ = self._strain(strain)
        return 0.5 * self._k1 / self._k2 * np.expm1(self._k2 * e * e)

    def _by_deformation(self, strain: SolidStrain, along: Floats) -> Floats:
        """Return ∂e/∂F, shape (…, point, 3, 3)."""
        iso = (2.0 * strain.g)[..., None, None] * strain.f
        iso = iso + (strain.by_j * strain.i1)[..., None, None] * strain.cofactors
        line = along[..., :, None] * self._along[..., None, :]
        spread = self._spread[..., None, None]
        return spread * iso + 2.0 * (1.0 - 3.0 * spread) * line

    def cauchy(self, strain: SolidStrain) -> Floats:
        """Return the stress of the fibres [Pa], shape (…, point, 3, 3); see ``SolidStrain``."""
        e, along = self._strain(strain)
        slope = self._k1 * e * np.exp(self._k2 * e * e)
        piola = slope[..., None, None] * self._by_deformation(strain, along)
        volume = np.maximum(strain.j, LEAST)[..., None, None]
        return piola @ strain.f.swapaxes(-1, -2) / volume

    def second_derivatives(self, strain: SolidStrain) -> Floats:
        """Return ∂²/∂F∂F of the energy [Pa], shape (…, point, 9, 9)."""
        e, along = self._strain(strain)
        slope = self._k1 * e * np.exp(self._k2 * e * e)
        bend = self._k1 * (1.0 + 2.0 * self._k2 * e * e) * np.exp(self._k2 * e * e)
        way = self._by_deformation(strain, along).reshape(*e.shape, 9)
        found = outer(np.where(e > 0.0, bend, 0.0), way, way)
        none = np.zeros_like(slope)
        spread = EnergySlopes(slope * self._spread, none, none, none, none, none, none)
        found += strain.second_derivatives(spread)
        line = self._along[..., :, None] * self._along[..., None, :]
        line = np.eye(3)[:, None, :, None] * line[..., None, :, None, :]
        weight = 2.0 * slope * (1.0 - 3.0 * self._spread)
        return found + weight[..., None, None] * line.reshape(*line.shape[:-4], 9, 9)


class Prestretch(Struct, frozen=True, eq=False):
    """Prestretch of elements.

    Attributes:
        axis: n, a unit vector, shape (3,).
        is_across: Whether the plane with this normal is stretched, and not the axis.
        stretch: λ of each element, positive, shape (element,).
    """

    axis: Floats
    is_across: bool
    stretch: Floats

    def some(self, items: Indices) -> Self:
        """Return the prestretch of some elements, by indices of shape (n,)."""
        return replace(self, stretch=self.stretch[items])

    @property
    def deformation(self) -> Floats:
        """Return F0, dimensionless, shape (element, 3, 3)."""
        line = np.outer(self.axis, self.axis)
        along, across = self.stretch, self.stretch**-0.5
        if self.is_across:
            along, across = self.stretch**-2, self.stretch
        return across[:, None, None] * (np.eye(3) - line) + along[:, None, None] * line

    def unstressed(self, drawn: Floats) -> Floats:
        """Return directions as they are without stress: unit vectors along F0⁻¹ a.

        Args:
            drawn: a, shape (element, direction, 3).
        """
        back = np.linalg.inv(self.deformation)
        found = np.einsum("exy,edy->edx", back, drawn)
        return np.asarray(found / np.linalg.norm(found, axis=2)[..., None])

    def measures(self, drawn: Measures, row: Indices) -> tuple[Measures, Indices]:
        """Return measures with gradients by places without stress, and the row of each element.

        Args:
            drawn: With gradients by drawn places.
            row: Of each element among them, shape (element,).
        """
        _, first, place = np.unique(
            np.column_stack([row, self.stretch]), axis=0, return_index=True,
            return_inverse=True,
        )  # fmt: skip
        old, turned = row[first], self.some(first).deformation[:, None]
        gradients = np.ascontiguousarray(drawn.gradients[old] @ turned)
        return Measures(gradients, drawn.volume[old]), place.reshape(-1)
