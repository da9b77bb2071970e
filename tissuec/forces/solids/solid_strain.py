"""Fibres and prestretch of solid elements.

Families of fibres store what ``solids.elements`` says. (T. C. Gasser, R. W. Ogden, G. A.
Holzapfel, J. R. Soc. Interface 3:15, 2006.)

Prestretch F0 is that by which the drawn body is stretched. Without stress, an element does not
have its drawn shape: it is shorter by a factor λ along an axis n, or in all directions of the
plane with the normal n, at the same volume:

    F0 = λ n ⊗ n + λ^(-1/2) (1 - n ⊗ n)    or    F0 = λ^(-2) n ⊗ n + λ (1 - n ⊗ n).

With F = ∂x/∂X of the drawn places X, the deformation that has stress is F F0 (A. Hoger, J.
Elasticity 48:125, 1997). As det F0 = 1, volumes are those drawn.
"""

from typing import Self

import numpy as np
from msgspec import Struct

from tissuec.core.structs import replace
from tissuec.geometry.elements import Measures
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
