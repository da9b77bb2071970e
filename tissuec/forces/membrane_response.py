"""The response of walls that relax or yield to strain and to the tensors that they remember.

The formulas are those of ``forces.membrane_memory`` and ``forces.membrane_memory``; here they
are functions of F and of the tensors P alone, for differences of implicit steps.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from tissuec.forces.membrane_memory import (
    MembraneBranches,
    MembraneYield,
    PlasticPlane,
    RelaxingPlane,
    plane_inverses,
)
from tissuec.forces.membrane_strain import MembraneStrain, PlaneMatter
from tissuec.forces.solid_memory import NEVER
from tissuec.model.network import Floats


class MembraneResponse(NamedTuple):
    """Triangles that relax or yield, with all of their internal variables.

    Attributes:
        yielding: Of the triangles; None where nothing yields.
        branches: Of the triangles; None without any.
        recalling: Returns the triangles in a state of their branches and of their flow, each
            None where there is none.
    """

    yielding: MembraneYield | None
    branches: MembraneBranches | None
    recalling: Callable[[RelaxingPlane | None, PlasticPlane | None], PlaneMatter]

    def __call__(self, f: Floats, tensors: Floats) -> tuple[Floats, Floats]:
        """Return stress and the rates of tensors.

        Args:
            f: F, shape (triangle, 1, 3, 2).
            tensors: P of the plastic flow, if triangles yield, and then of each branch,
                dimensionless, shape (tensor, triangle, 1, 2, 2).

        Returns:
            P [Pa], shape (triangle, 1, 3, 2), and [1/s], shape of ``tensors``.
        """
        planes, branches = tensors[..., 0, :, :], self.branches
        yields = int(self.yielding is not None)
        plastic = PlasticPlane(*plane_inverses(planes[0])) if yields else None
        remembered = branches and branches.effect_of(planes[yields:])
        strain = MembraneStrain(self.recalling(remembered, plastic), f[:, 0])
        rates = np.zeros_like(planes)
        if branches is not None:
            rates[yields:] = branches.rates(*strain.isochoric, planes[yields:])
        if plastic is not None:
            rates += self._flow(strain, plastic, planes)
        return strain.piola()[:, None], rates[..., None, :, :]

    def _flow(self, strain: MembraneStrain, plastic: PlasticPlane, planes: Floats) -> Floats:
        """Return ν (P N + Nᵀ P) of all tensors P [1/s], shape (tensor, triangle, 2, 2)."""
        yielding = self.yielding
        assert yielding is not None
        within, across = self._driving(strain, plastic, planes[1:])
        third = (np.trace(within, axis1=-2, axis2=-1) + across) / 3.0
        within = within - third[:, None, None] * np.eye(2)
        square = np.einsum("tij,tji->t", within, within) + (across - third) ** 2
        size = np.sqrt(1.5 * np.maximum(square, 0.0))
        over = np.maximum(size - np.minimum(yielding.limit, NEVER), 0.0)
        pace = 1.5 * over / np.where(size > 0.0, size, 1.0) / yielding.viscosity
        carried = planes @ within
        return pace[:, None, None] * (carried + carried.swapaxes(-1, -2))

    def _driving(
        self, strain: MembraneStrain, plastic: PlasticPlane, branches: Floats
    ) -> tuple[Floats, Floats]:
        """Return S C in the plane and S33 λ² of law and branches at a fixed volume [Pa].

        The shapes are (triangle, 2, 2) and (triangle,).
        """
        (right, thick), slopes = strain.isochoric, strain.of_laws
        by_first, by_second = (
            2.0 * slope[:, None, None] for slope in (slopes.by_first, slopes.by_second)
        )
        inner, outer = plastic.inverse @ right, plastic.square * thick
        area = np.linalg.det(right) / plastic.square
        within = (by_first + by_second * outer[:, None, None]) * inner
        within = within + by_second * area[:, None, None] * np.eye(2)
        trace = np.trace(inner, axis1=-2, axis2=-1)
        across = 2.0 * outer * (slopes.by_first + slopes.by_second * trace)
        if self.branches is not None:
            shear, (inverse, part) = self.branches.shear, plane_inverses(branches)
            within = within + (shear[..., None, None] * (inverse @ right)).sum(axis=0)
            across = across + (shear * part).sum(axis=0) * thick
        return within, across
