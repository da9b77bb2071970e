"""The response of elements that yield to strain and to the tensors that they remember.

The formulas are those of ``forces.solid_yield`` and ``forces.solid_branches``; here they are
functions of F, Cp and Ci alone, for differences of implicit steps.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from tissuec.forces.solid_branches import SolidBranches
from tissuec.forces.solid_strain import SolidStrain
from tissuec.forces.solid_yield import SolidYield
from tissuec.forces.stored_tensors import unimodular_inverse
from tissuec.model.network import Floats

NEVER = 1e300  # a yield stress instead of an infinite one [Pa]


class YieldResponse(NamedTuple):
    """Elements that yield, and relax if they have branches.

    Attributes:
        yielding: Of the elements.
        branches: Of the elements; None without any.
        slopes: Given both isochoric invariants, shape (element, point), returns the derivatives
            μ ∂ψ/∂i by them [Pa].
    """

    yielding: SolidYield
    branches: SolidBranches | None
    slopes: Callable[[Floats, Floats], tuple[Floats, Floats]]

    def __call__(self, f: Floats, tensors: Floats) -> tuple[Floats, Floats]:
        """Return P of law and branches but for the pressure, and the rates of tensors.

        Args:
            f: F, shape (element, point, 3, 3).
            tensors: Cp, and then Ci of each branch, shape (tensor, element, point, 3, 3).

        Returns:
            [Pa], shape (element, point, 3, 3), and [1/s], shape of ``tensors``.
        """
        strain, inverse = SolidStrain(f), unimodular_inverse(tensors)
        piola, rates = self._of_law(strain, inverse[0]), np.zeros_like(tensors)
        for k in range(len(tensors) - 1):
            assert self.branches is not None
            shear, time = self.branches.shear[k, :, None], self.branches.time[k, :, None]
            right, own = f.swapaxes(-1, -2) @ f, inverse[1 + k]
            trace = np.einsum("...kl,...kl->...", right, own)
            piola = piola + _times(shear * strain.g, f @ own)
            piola = piola + _times(0.5 * shear * strain.by_j * trace, strain.cofactors)
            excess = _times(strain.g, right) - _times(strain.g * trace / 3.0, tensors[1 + k])
            rates[1 + k] = _times(1.0 / time, excess)
        driving = piola.swapaxes(-1, -2) @ f  # N, but for its trace
        third = np.trace(driving, axis1=-2, axis2=-1) / 3.0
        driving = driving - _times(third, np.eye(3))
        square = np.einsum("...ij,...ji->...", driving, driving)
        size = np.sqrt(1.5 * np.maximum(square, 0.0))
        over = np.maximum(size - np.minimum(self.yielding.limit, NEVER)[:, None], 0.0)
        pace = 1.5 * over / np.where(size > 0.0, size, 1.0) / self.yielding.viscosity[:, None]
        carried = tensors @ driving
        return piola, rates + _times(pace, carried + carried.swapaxes(-1, -2))

    def _of_law(self, strain: SolidStrain, inverse: Floats) -> Floats:
        """Return P of the law but for its pressure [Pa]; ``inverse`` is A."""
        g, turned = strain.g, strain.f @ inverse
        left = turned @ strain.f.swapaxes(-1, -2)  # with the invariants of Fe Feᵀ
        i1 = np.trace(left, axis1=-2, axis2=-1)
        i2 = 0.5 * (i1 * i1 - np.einsum("...ij,...ij->...", left, left))
        first, second = self.slopes(g * i1, g * g * i2)
        piola = _times(2.0 * (g * first + g * g * second * i1), turned)
        piola = piola - _times(2.0 * g * g * second, left @ turned)
        by_j = strain.by_j * (first * i1 + 2.0 * g * second * i2)
        return piola + _times(by_j, strain.cofactors)


def _times(factor: Floats, matrices: Floats) -> Floats:
    return factor[..., None, None] * matrices
