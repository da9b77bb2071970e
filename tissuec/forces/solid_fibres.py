"""Families of fibres in solid elements; for the equations see ``forces.elements``.

T. C. Gasser, R. W. Ogden, G. A. Holzapfel, J. R. Soc. Interface 3:15, 2006.
"""

from collections.abc import Iterator
from typing import Self

import numpy as np
from msgspec import Struct

from tissuec.forces.elements_kernel import LEAST
from tissuec.forces.solid_strain import EnergySlopes, SolidStrain, outer
from tissuec.model.network import Floats, Indices


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
