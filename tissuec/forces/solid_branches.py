"""Branches of solid elements: stress that relaxes.

A branch k is a neo-Hookean solid and a liquid in series, in parallel with the solid itself. At
each point a symmetric tensor Ci stores how far the liquid has flowed; it begins as 1. With C =
FᵀF, the unimodular C' = g(J) C and A = det(Ci)^(1/3) Ci⁻¹, a branch stores per volume

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

Ci is kept in the velocities of hidden nodes; see ``forces.stored_tensors``.
"""

from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from tissuec.forces.elements_kernel import LEAST
from tissuec.forces.solid_strain import EnergySlopes, SolidStrain, outer
from tissuec.forces.stored_tensors import StoredTensors, unimodular_inverse
from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:
    from tissuec.forces.membrane_branches import MembraneBranches


class SolidBranches(StoredTensors, frozen=True):
    """Branches of elements, each of which keeps Ci.

    Attributes:
        shear: μk [Pa], shape (branch, element); zero where there is none.
        time: τ [s], shape (branch, element); infinite where there is none.
    """

    shear: Floats
    time: Floats

    @classmethod
    def new(cls, shear: Floats, time: Floats) -> Self:
        """Return branches without storage.

        Args:
            shear, time: As the attributes [Pa], [s], shape (branch, element).
        """
        return cls(np.full(shear.shape, -1), np.ones(shear.shape), shear, time)

    def some(self, items: Indices) -> Self:
        """Return those of some elements, by indices of shape (n,)."""
        slot, rate = self.slot[:, items], self.rate[:, items]
        return type(self)(slot, rate, self.shear[:, items], self.time[:, items])

    @property
    def sudden(self) -> Floats:
        """Return the instantaneous shear modulus of all branches [Pa], shape (element,)."""
        return self.shear.sum(axis=0)

    @property
    def keeps(self) -> NDArray[np.bool_]:
        """Return which branches exist, shape (branch, element)."""
        return self.shear > 0.0

    @property
    def slowest(self) -> Floats:
        """Return the least rates that they are measured by [1/s], shape (branch, element)."""
        return 1.0 / self.time

    def remembered(self, velocity: Floats, points: int) -> "RelaxingStress":
        """Return what branches do while nothing gives way.

        Args:
            velocity: Of all nodes [m/s], shape (…, node, 3).
            points: Of each element.
        """
        inverse = unimodular_inverse(self.tensors(velocity, points))
        weight = self.shear[..., None, None, None] * inverse
        return RelaxingStress(weight.sum(axis=-5), self.sudden)

    def fastest(self, strain: SolidStrain, velocity: Floats) -> tuple[float, Floats]:
        """Return the largest rate at which any branch gives way [1/s], and Σ μk tr(C' A).

        The latter has the shape (element, point) [Pa].

        Args:
            strain: At the points of all elements.
            velocity: Of all nodes [m/s], shape (node, 3).
        """
        inverse = unimodular_inverse(self.tensors(velocity, strain.j.shape[-1]))
        right = strain.f.swapaxes(-1, -2) @ strain.f
        trace = strain.g * np.einsum("...kl,...kl->...", right, inverse)
        rates = np.where(self.keeps[..., None], trace / (3.0 * self.time[..., None]), 0.0)
        return float(rates.max()), (self.shear[..., None] * trace).sum(axis=0)


def branch_columns(
    branches: "SolidBranches | MembraneBranches | None", elements: int, place: Indices
) -> dict[str, NDArray[Any]]:
    """Return the columns of records of kernels that describe branches, by name [Pa], [1/s].

    Args:
        branches: Of the elements; None without any.
        elements: How many there are.
        place: Index of each node in the arrays of the kernel, shape (node,). Hidden nodes that
            follow one another do so there, too.
    """
    if branches is None:
        none = np.zeros(0)
        return {
            "first": np.zeros(elements + 1, dtype=np.int64), "branch_shear": none,
            "branch_pace": none, "branch_slot": none.astype(np.int64), "branch_rate": none,
        }  # fmt: skip
    element, branch = np.argwhere(branches.slot.T >= 0).T
    return {
        "first": np.searchsorted(element, np.arange(elements + 1)),
        "branch_shear": branches.shear[branch, element],
        "branch_pace": 1.0 / branches.time[branch, element],
        "branch_slot": 3 * place[branches.slot[branch, element] // 3],
        "branch_rate": branches.rate[branch, element],
    }


class RelaxingStress:
    """Branches that do not give way: energy per volume Σ μk/2 (g tr(C A) - 3).

    Args:
        weight: Σ μk A [Pa], shape (…, element, point, 3, 3).
        shear: Σ μk [Pa], shape (element,).
    """

    def __init__(self, weight: Floats, shear: Floats):
        self._weight, self._shear = weight, shear

    def some(self, items: Indices) -> "RelaxingStress":
        """Return those of some elements, by indices of shape (n,)."""
        return RelaxingStress(self._weight[..., items, :, :, :], self._shear[items])

    def _trace(self, strain: SolidStrain) -> tuple[Floats, Floats]:
        """Return F W with the weight W, and tr(C W)."""
        turned = strain.f @ self._weight
        return turned, np.einsum("...xk,...xk->...", strain.f, turned)

    def energy(self, strain: SolidStrain) -> Floats:
        """Return the energy per volume [Pa], shape (…, point)."""
        _, trace = self._trace(strain)
        return 0.5 * strain.g * trace - 1.5 * self._shear[:, None]

    def cauchy(self, strain: SolidStrain) -> Floats:
        """Return the stress [Pa], shape (…, point, 3, 3); see ``SolidStrain``."""
        turned, trace = self._trace(strain)
        piola = strain.g[..., None, None] * turned
        piola = piola + (0.5 * strain.by_j * trace)[..., None, None] * strain.cofactors
        volume = np.maximum(strain.j, LEAST)[..., None, None]
        return piola @ strain.f.swapaxes(-1, -2) / volume

    def second_derivatives(self, strain: SolidStrain) -> Floats:
        """Return ∂²/∂F∂F of the energy [Pa], shape (…, point, 9, 9)."""
        turned, trace = self._trace(strain)
        none = np.zeros_like(trace)
        of_volume = EnergySlopes(
            none, none, none, none, none,
            0.5 * strain.by_j * trace, 0.5 * strain.by_j_twice * trace,
        )  # fmt: skip
        found = strain.second_derivatives(of_volume)
        flat = turned.reshape(*turned.shape[:-2], 9)
        both = outer(strain.by_j, flat, strain.cofactors.reshape(flat.shape))
        found += both + both.swapaxes(-1, -2)
        weight = strain.g[..., None, None] * self._weight
        alike = np.eye(3)[:, None, :, None] * weight[..., None, :, None, :]
        return found + alike.reshape(*weight.shape[:-2], 9, 9)
