"""Strain of solids at points, and what their energies change by with it."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from tissuec.forces.elements_kernel import LEAST
from tissuec.model.network import Floats


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
