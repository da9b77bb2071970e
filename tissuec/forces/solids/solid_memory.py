"""Branches and yielding of solid elements: stress that relaxes, and flow.

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

Ci is kept in the velocities of hidden nodes; see ``solids.element_memory``.

Solid elements that yield: von Mises' limit of stress, and the flow above it.

F = Fe Fp; elements that yield store the energy of Fe, and Fp is the shape without stress. Their
laws do not depend on directions, so that Cp = FpᵀFp is enough: it begins as 1, and with
A = det(Cp)^(1/3) Cp⁻¹ the energy is that of a law in the invariants I1 = tr(C A) and
I2 = (I1² - tr(C A C A))/2 instead of those of C. Branches k (``solids.solid_memory``) are in
series with the flow; fibres and viscosity are in parallel with it. With the Kirchhoff stress τ
of law and branches, and its deviator s,

    σ = √(3/2) |s|,    ε' = max(0, σ - Y)/η,    λ = 3 ε'/2σ,

plastic strain grows by λ s in space, so that a bar lengthens by ε' (P. Perzyna, Adv. Appl.
Mech. 9:243, 1966, of a Bingham solid). Drawn back, this is N = F⁻¹ s F = dev(Pᵀ F), P being the
stress of law and branches, and

    dCp/dt = λ (Cp N + Nᵀ Cp),    dCi/dt = … + λ (Ci N + Nᵀ Ci).

No inverse is taken, so that elements that are inside out have rates, too. Flow changes no
volume: tr N = 0. The dissipation, λ tr(N²) = σ ε', is never negative. (J. C. Simo, Comput.
Meth. Appl. Mech. Eng. 99:61, 1992; J. Lubliner, Plasticity Theory, 1990.)
"""

import numpy as np

from tissuec.forces.solids.element_memory import Branches, ElementYield
from tissuec.model.network import Floats

NEVER = 1e300  # a yield stress instead of an infinite one [Pa]


class SolidBranches(Branches, frozen=True):
    """Branches of solid elements, each of which keeps Ci at each point."""


class SolidYield(ElementYield, frozen=True):
    """Yielding of solid elements, each of which keeps Cp at each point."""

    def equivalent(self, velocity: Floats, points: int) -> Floats:
        """Return √(2/3) |log Cp/2|, dimensionless, shape (…, element, point).

        For a bar, it is the logarithm of its permanent stretch.

        Args:
            velocity: Of all nodes [m/s], shape (…, node, 3).
            points: Of each element.
        """
        tensors = self.tensors(velocity, points)[..., 0, :, :, :, :]
        logs = 0.5 * np.log(np.linalg.eigvalsh(tensors))
        logs -= logs.mean(axis=-1, keepdims=True)
        return np.sqrt(2.0 / 3.0 * (logs**2).sum(axis=-1))
