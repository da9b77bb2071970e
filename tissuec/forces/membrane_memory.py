"""Branches and yielding of walls: stress in the plane that relaxes, and flow above a limit.

A branch is that of a solid (``forces.solid_memory``) in plane stress. Its tensor Ci keeps the
volume 1 and has no shear across the wall, where it is 1 / det P with the part P in the plane;
so three numbers determine it. With C and the stretch λ of the thickness, it stores per
volume

    E = μk/2 (g (tr(C P⁻¹) + λ² det P) - 3),    g = J^(-2/3),

and gives way by

    dP/dt = (g C - T/3 P)/τ,    T = g (tr(C P⁻¹) + λ² det P).

The thickness minimises the energy of the wall with all of its branches, so that the stresses of
the branches and of the law across the wall always balance. The dissipation,

    -∂E/∂P : dP/dt = μk/2τ (tr X² - T²/3),    X = diag(g C P⁻¹, g λ² det P),

is never negative, as X has real eigenvalues with the sum T.

P is kept in the velocities of hidden nodes; see ``forces.element_memory``.

Walls that yield: von Mises' limit of stress in plane stress, and the flow above it.

The flow is that of solids (``forces.solid_memory``). Its tensor Cp keeps the volume 1, and has
no shear across the wall: its part P in the plane determines it by three numbers, as it is 1 / π
across, with π = det P. With C, D = det C and the stretch λ of the thickness, the law stores the
energy of the invariants

    I1 = tr(C P⁻¹) + π λ²,    I2 = D/π + π λ² tr(C P⁻¹),    J = λ √D.

The thickness minimises the energy of the wall with all that it remembers. Branches are in
series with the flow; fibres and viscosity are in parallel with it. With the stress S of law and
branches at a fixed volume, in the plane and across it,

    N = S C - t 1,    N3 = S33 λ² - t,    t = (tr S C + S33 λ²)/3,
    σ = √(3/2 (tr N² + N3²)),    ε' = max(0, σ - Y)/η,    ν = 3 ε'/2σ,
    dP/dt = ν (P N + Nᵀ P),    and likewise for branches.

The dissipation is ν (tr N² + N3²) = σ ε', and never negative. Bending stays elastic.
"""

from typing import ClassVar, NamedTuple

import numpy as np

from tissuec.forces.element_memory import Branches, ElementYield
from tissuec.forces.membrane_memory_kernel import FLAT
from tissuec.model.network import Floats, Indices


class RelaxingPlane(NamedTuple):
    """Branches in a fixed state: energy per volume (g (tr(C W) + λ² w) - 3 Σ μk)/2.

    Attributes:
        weight: W = Σ μk P⁻¹ [Pa], shape (…, triangle, 2, 2).
        across: w = Σ μk det P [Pa], shape (…, triangle).
        shear: Σ μk [Pa], shape (triangle,).
    """

    weight: Floats
    across: Floats
    shear: Floats

    def some(self, items: Indices) -> "RelaxingPlane":
        """Return those of some triangles, by indices of shape (n,)."""
        weight, across = self.weight[..., items, :, :], self.across[..., items]
        return RelaxingPlane(weight, across, self.shear[items])


class MembraneBranches(Branches, frozen=True):
    """Branches of triangles, each of which keeps P at the only point of a triangle."""

    at: ClassVar[Indices] = np.array([[0, 1, 0], [0, 1, 1]])

    def remembered(self, velocity: Floats) -> RelaxingPlane:
        """Return the effect of the branches in their present state.

        Args:
            velocity: Of all nodes [m/s], shape (…, node, 3).
        """
        return self.effect_of(self.tensors(velocity, 1)[..., 0, :, :])

    def effect_of(self, tensors: Floats) -> RelaxingPlane:
        """Return the effect of branches.

        Args:
            tensors: P, dimensionless, shape (…, branch, triangle, 2, 2).
        """
        inverse, across = plane_inverses(tensors)
        weight = (self.shear[..., None, None] * inverse).sum(axis=-4)
        return RelaxingPlane(weight, (self.shear * across).sum(axis=-2), self.sudden)

    def rates(self, right: Floats, across: Floats, tensors: Floats) -> Floats:
        """Return dP/dt [1/s], shape (branch, triangle, 2, 2).

        Args:
            right, across: As for ``fastest``.
            tensors: P, dimensionless, shape (branch, triangle, 2, 2).
        """
        inverse, part = plane_inverses(tensors)
        trace = np.einsum("tkl,btkl->bt", right, inverse) + across * part
        excess = right - trace[..., None, None] / 3.0 * tensors
        return np.asarray(excess / self.time[..., None, None])

    def fastest(self, right: Floats, across: Floats, velocity: Floats) -> tuple[float, Floats]:
        """Return the largest rate at which any branch gives way [1/s], and Σ μk T.

        The latter has the shape (triangle,) [Pa].

        Args:
            right: g C in the plane, dimensionless, shape (triangle, 2, 2).
            across: g λ², dimensionless, shape (triangle,).
            velocity: Of all nodes [m/s], shape (node, 3).
        """
        inverse, part = plane_inverses(self.tensors(velocity, 1)[..., 0, :, :])
        trace = np.einsum("tkl,btkl->bt", right, inverse) + across * part
        rates = np.where(self.keeps, trace / (3.0 * self.time), 0.0)
        return float(rates.max()), (self.shear * trace).sum(axis=0)


def plane_inverses(tensors: Floats) -> tuple[Floats, Floats]:
    """Return P⁻¹ and det P, which has the lower bound that kernels use.

    Args:
        tensors: P, dimensionless, shape (…, 2, 2).
    """
    a, b, c = tensors[..., 0, 0], tensors[..., 1, 1], tensors[..., 0, 1]
    square = np.maximum(a * b - c * c, FLAT)
    found = np.empty_like(tensors)
    found[..., 0, 0], found[..., 1, 1] = b / square, a / square
    found[..., 0, 1] = found[..., 1, 0] = -c / square
    return found, square


class PlasticPlane(NamedTuple):
    """The plastic deformation of triangles.

    Attributes:
        inverse: P⁻¹, dimensionless, shape (…, triangle, 2, 2).
        square: π, dimensionless, shape (…, triangle).
    """

    inverse: Floats
    square: Floats

    def some(self, items: Indices) -> "PlasticPlane":
        """Return the yielding of some triangles, by indices of shape (n,)."""
        return PlasticPlane(self.inverse[..., items, :, :], self.square[..., items])

    @property
    def equivalent(self) -> Floats:
        """Return √(2/3) |log Cp/2|, dimensionless, shape (…, triangle).

        For a strip, it is the logarithm of its permanent stretch.
        """
        logs = -0.5 * np.log(np.linalg.eigvalsh(self.inverse))
        across = -0.5 * np.log(self.square)
        return np.sqrt(2.0 / 3.0 * ((logs**2).sum(axis=-1) + across**2))


class MembraneYield(ElementYield, frozen=True):
    """Yielding of triangles, each of which keeps P at its only point."""

    at: ClassVar[Indices] = np.array([[0, 1, 0], [0, 1, 1]])

    def equivalent(self, velocity: Floats) -> Floats:
        """Return equivalent plastic strains, dimensionless, shape (…, triangle).

        Args:
            velocity: Of all nodes [m/s], shape (…, node, 3).
        """
        return self.plastic(velocity).equivalent

    def plastic(self, velocity: Floats) -> PlasticPlane:
        """Return the plastic deformation of the triangles.

        Args:
            velocity: Of all nodes [m/s], shape (…, node, 3).
        """
        return PlasticPlane(*plane_inverses(self.tensors(velocity, 1)[..., 0, :, 0, :, :]))
