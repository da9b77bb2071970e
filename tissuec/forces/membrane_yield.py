"""Walls that yield: von Mises' limit of stress in plane stress, and the flow above it.

The flow is that of solids (``forces.solid_yield``). Its tensor Cp keeps the volume 1, and has
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

from tissuec.forces.element_yield import ElementYield
from tissuec.forces.membrane_branches import plane_inverses
from tissuec.model.network import Floats, Indices


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

    def plastic(self, velocity: Floats) -> PlasticPlane:
        """Return the plastic deformation of the triangles.

        Args:
            velocity: Of all nodes [m/s], shape (…, node, 3).
        """
        return PlasticPlane(*plane_inverses(self.tensors(velocity, 1)[..., 0, :, 0, :, :]))
