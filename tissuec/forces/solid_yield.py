"""Solid elements that yield: von Mises' limit of stress, and the flow above it.

F = Fe Fp; elements that yield store the energy of Fe, and Fp is the shape without stress. Their
laws do not depend on directions, so that Cp = FpᵀFp is enough: it begins as 1, and with
A = det(Cp)^(1/3) Cp⁻¹ the energy is that of a law in the invariants I1 = tr(C A) and
I2 = (I1² - tr(C A C A))/2 instead of those of C. Branches k (``forces.solid_branches``) are in
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

from tissuec.forces.element_yield import ElementYield
from tissuec.forces.solid_strain import SolidStrain
from tissuec.forces.stored_tensors import unimodular_inverse
from tissuec.model.network import Floats, Indices


class SolidYield(ElementYield, frozen=True):
    """Yielding of solid elements, each of which keeps Cp at each point."""

    def plastic(self, velocity: Floats, points: int) -> "PlasticDeformation":
        """Return the plastic deformation of the elements.

        Args:
            velocity: Of all nodes [m/s], shape (…, node, 3).
            points: Of each element.
        """
        return PlasticDeformation(self.tensors(velocity, points)[..., 0, :, :, :, :])


class PlasticDeformation:
    """The plastic deformation of elements.

    Args:
        tensors: Cp, dimensionless, shape (…, element, point, 3, 3).
        root: A^(1/2) if it is known.
    """

    def __init__(self, tensors: Floats, root: Floats | None = None):
        self._tensors = tensors
        if root is None:
            values, ways = np.linalg.eigh(unimodular_inverse(tensors))
            widths = np.sqrt(np.maximum(values, 0.0))[..., None, :]
            root = (ways * widths) @ ways.swapaxes(-1, -2)
        self._root = root

    def some(self, items: Indices) -> "PlasticDeformation":
        """Return the yielding of some elements, by indices of shape (n,)."""
        tensors, root = (
            each[..., items, :, :, :] for each in (self._tensors, self._root)
        )  # fmt: skip
        return PlasticDeformation(tensors, root)

    @property
    def equivalent(self) -> Floats:
        """Return √(2/3) |log Cp/2|, dimensionless, shape (…, element, point).

        For a bar, it is the logarithm of its permanent stretch.
        """
        logs = 0.5 * np.log(np.linalg.eigvalsh(self._tensors))
        logs -= logs.mean(axis=-1, keepdims=True)
        return np.sqrt(2.0 / 3.0 * (logs**2).sum(axis=-1))

    def elastic(self, strain: SolidStrain) -> SolidStrain:
        """Return F A^(1/2), which has the invariants, stress and volume of Fe.

        Args:
            strain: F at the points.
        """
        return SolidStrain(strain.f @ self._root)

    def drawn_back(self, stiff: Floats) -> Floats:
        """Return ∂²/∂F∂F of an energy from its derivatives by F A^(1/2).

        Args:
            stiff: The latter [Pa], shape (…, point, 9, 9).
        """
        full = stiff.reshape(*stiff.shape[:-2], 3, 3, 3, 3)
        root = self._root
        full = np.einsum("...ikjl,...km,...ln->...imjn", full, root, root, optimize=True)
        return full.reshape(stiff.shape)
