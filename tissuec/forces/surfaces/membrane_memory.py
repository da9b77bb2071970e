"""Branches and yielding of walls: stress in the plane that relaxes, and flow above a limit.

A branch is that of a solid (``solids.solid_memory``) in plane stress. Its tensor Ci keeps the
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

P is kept in the velocities of hidden nodes; see ``solids.element_memory``.

Walls that yield: von Mises' limit of stress in plane stress, and the flow above it.

The flow is that of solids (``solids.solid_memory``). Its tensor Cp keeps the volume 1, and has
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

from typing import ClassVar

import numpy as np

from tissuec.autodiff.points import PLACES
from tissuec.forces.solids.element_memory import Branches, ElementYield
from tissuec.forces.surfaces.plane_point import FLAT
from tissuec.model.network import Floats, Indices


class MembraneBranches(Branches, frozen=True):
    """Branches of triangles, each of which keeps P at the only point of a triangle."""

    at: ClassVar[Indices] = np.array(PLACES[2]).T


class MembraneYield(ElementYield, frozen=True):
    """Yielding of triangles, each of which keeps Pp at its only point."""

    at: ClassVar[Indices] = np.array(PLACES[2]).T

    def equivalent(self, velocity: Floats, points: int = 1) -> Floats:
        """Return equivalent plastic strains, dimensionless, shape (…, triangle, point).

        Args:
            velocity: Of all nodes [m/s], shape (…, node, 3).
            points: Of each triangle.
        """
        return equivalent_of(self.tensors(velocity, points)[..., 0, :, :, :, :])


def equivalent_of(plastic: Floats) -> Floats:
    """Return √(2/3) |log Cp/2|, dimensionless, shape (…).

    For a strip, it is the logarithm of its permanent stretch.

    Args:
        plastic: Pp, dimensionless, shape (…, 2, 2).
    """
    a, b, c = plastic[..., 0, 0], plastic[..., 1, 1], plastic[..., 0, 1]
    square = np.maximum(a * b - c * c, FLAT)
    turned = np.stack([np.stack([b, -c], axis=-1), np.stack([-c, a], axis=-1)], axis=-2)
    inverse = turned / square[..., None, None]
    logs = -0.5 * np.log(np.linalg.eigvalsh(inverse))
    across = -0.5 * np.log(square)
    return np.asarray(np.sqrt(2.0 / 3.0 * ((logs**2).sum(axis=-1) + across**2)))
