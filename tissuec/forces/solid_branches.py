"""Branches of solid elements: stress that relaxes.

A branch k is a neo-Hookean solid and a liquid in a row, beside the solid itself. At each point
a symmetric tensor Ci stores how far the liquid has flowed; it begins as 1. With C = FᵀF, the
unimodular C' = g(J) C and A = det(Ci)^(1/3) Ci⁻¹, a branch stores per volume

    E = μk/2 (tr(C' A) - 3),    P = μk (g F A + g'/2 tr(C A) cof F),

and gives way by

    dCi/dt = (C' - tr(C' A)/3 Ci)/τ.

At small strain, this is the dashpot of a Maxwell element: of a strain that is held, the stress
falls with exp(-t/τ). The volume of Ci is neither part of E nor of P, and returns to 1. What is
lost, with X = C' A,

    -∂E/∂Ci : dCi/dt = μk/2τ det(Ci)^(-1/3) tr((X - tr(X)/3)²),

is never negative, as X has real eigenvalues. (J. C. Simo, Comput. Meth. Appl. Mech. Eng.
60:153, 1987; A. Lion, Acta Mechanica 123:1, 1997; A. V. Shutov, R. Landgraf, J. Ihlemann,
Comput. Meth. Appl. Mech. Eng. 265:213, 2013.)

Ci - 1 is kept in the velocities of hidden nodes, six numbers for each branch and point, times a
``rate``, so that it is stepped, stored and resumed like all other motion.
"""

from typing import Any, Self

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from tissuec.forces.elements_kernel import LEAST
from tissuec.forces.solid_strain import EnergySlopes, SolidStrain, outer
from tissuec.model.network import Floats, Indices

#: Rows and columns of the six numbers of a symmetric tensor.
ROWS, COLUMNS = np.array([0, 1, 2, 1, 0, 0]), np.array([0, 1, 2, 2, 2, 1])
SIX = len(ROWS)


class SolidBranches(Struct, frozen=True, eq=False):
    """Branches of elements.

    Attributes:
        shear: μk [Pa], shape (branch, element); zero where there is none.
        time: τ [s], shape (branch, element); infinite where there is none.
        slot: Place of the first number of Ci - 1 among the components of all velocities, those
            of the other points behind it, shape (branch, element); -1 where there is none.
        rate: What Ci - 1 is multiplied by there [m/s], shape (branch, element).
    """

    shear: Floats
    time: Floats
    slot: Indices
    rate: Floats

    @classmethod
    def new(cls, shear: Floats, time: Floats) -> Self:
        """Return branches without storage.

        Args:
            shear, time: As the attributes [Pa], [s], shape (branch, element).
        """
        return cls(shear, time, np.full(shear.shape, -1), np.ones(shear.shape))

    def some(self, items: Indices) -> Self:
        """Return those of some elements, by indices of shape (n,)."""
        columns = self.shear, self.time, self.slot, self.rate
        return type(self)(*(column[:, items] for column in columns))

    @property
    def sudden(self) -> Floats:
        """Return the instantaneous shear modulus of all branches [Pa], shape (element,)."""
        return self.shear.sum(axis=0)

    @property
    def exists(self) -> Indices:
        """Return elements and branches that there are, element by element, shape (n, 2)."""
        return np.argwhere((self.shear > 0.0).T)

    def stored(self, first: int, points: int, fastest: float, size: Floats) -> Self:
        """Return the same with storage.

        Args:
            first: Place of the first number among the components of all velocities.
            points: Of each element.
            fastest: A bound of the angular frequencies of the net [1/s].
            size: Of elements [m], shape (element,).
        """
        element, branch = self.exists.T
        slot = np.full(self.shear.shape, -1)
        slot[branch, element] = first + SIX * points * np.arange(len(element))
        return replace(self, slot=slot, rate=size * np.maximum(1.0 / self.time, fastest))

    def nodes(self, points: int) -> Indices:
        """Return the hidden nodes that keep all Ci, ascending, shape (node,).

        Args:
            points: Of each element.
        """
        element, branch = self.exists.T
        first = self.slot[branch, element] // 3
        nodes = first[:, None] + np.arange(SIX * points // 3)
        return nodes[first >= 0].ravel()

    # --- variables ----------------------------------------------------------------------------

    def tensors(self, velocity: Floats, points: int) -> Floats:
        """Return Ci, dimensionless, shape (…, branch, element, point, 3, 3); 1 without storage.

        Args:
            velocity: Of all nodes [m/s], shape (…, node, 3).
            points: Of each element.
        """
        flat = velocity.reshape(*velocity.shape[:-2], -1)
        place = self._places(points)
        has = (self.slot >= 0)[..., None, None]
        kept = flat[..., np.where(has, place, 0)] / self.rate[..., None, None]
        six = np.where(has, kept, 0.0)
        found = np.empty((*six.shape[:-1], 3, 3))
        found[..., ROWS, COLUMNS] = found[..., COLUMNS, ROWS] = six
        return found + np.eye(3)

    def keep(self, velocity: Floats, tensors: Floats, items: Indices) -> None:
        """Set Ci of some elements, in the velocities of all nodes.

        Args:
            velocity: Changed in place [m/s], shape (node, 3).
            tensors: The same of all branches, dimensionless, shape (item, point, 3, 3).
            items: Indices of the elements, shape (item,).
        """
        flat, places = velocity.reshape(-1), self._places(tensors.shape[1])[:, items]
        six = (tensors - np.eye(3))[..., ROWS, COLUMNS]
        for slot, place, rate in zip(self.slot, places, self.rate, strict=True):
            has = slot[items] >= 0
            flat[place[has]] = (rate[items, None, None] * six)[has]

    def _places(self, points: int) -> Indices:
        """Return places of the six numbers, shape (branch, element, point, 6)."""
        return self.slot[..., None, None] + np.arange(SIX * points).reshape(points, SIX)

    def remembered(self, velocity: Floats, points: int) -> "RelaxingStress":
        """Return what branches do while nothing gives way.

        Args:
            velocity: Of all nodes [m/s], shape (…, node, 3).
            points: Of each element.
        """
        inverse = unimodular_inverse(self.tensors(velocity, points))
        weight = self.shear[..., None, None, None] * inverse
        return RelaxingStress(weight.sum(axis=-5), self.sudden)

    def fastest(self, strain: SolidStrain, velocity: Floats) -> float:
        """Return the largest rate at which any branch gives way [1/s].

        Args:
            strain: At the points of all elements.
            velocity: Of all nodes [m/s], shape (node, 3).
        """
        inverse = unimodular_inverse(self.tensors(velocity, strain.j.shape[-1]))
        right = strain.f.swapaxes(-1, -2) @ strain.f
        trace = strain.g * np.einsum("...kl,...kl->...", right, inverse)
        is_there = (self.shear > 0.0)[..., None]
        return float(np.where(is_there, trace / (3.0 * self.time[..., None]), 0.0).max())


def unimodular_inverse(tensors: Floats) -> Floats:
    """Return A = Ci⁻¹ det(Ci)^(1/3), dimensionless, shape (…, 3, 3).

    Args:
        tensors: Ci, dimensionless, shape (…, 3, 3).
    """
    strain = SolidStrain(tensors)
    return strain.g[..., None, None] * strain.cofactors


def branch_columns(
    branches: SolidBranches | None, elements: int, place: Indices
) -> dict[str, NDArray[Any]]:
    """Return the columns of ``ElementTable`` that describe branches, by name, in its units.

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
