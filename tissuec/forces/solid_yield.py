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

from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from tissuec.forces.solid_strain import EnergySlopes, SolidStrain
from tissuec.forces.stored_tensors import StoredTensors, unimodular_inverse
from tissuec.model.network import Floats, Indices


class SolidYield(StoredTensors, frozen=True):
    """Yielding of elements; those that yield keep Cp in the only row.

    Attributes:
        limit: Y [Pa], shape (element,); infinite where nothing yields.
        viscosity: η [Pa s], shape (element,); infinite where nothing ever yields.
    """

    limit: Floats
    viscosity: Floats

    @classmethod
    def new(cls, limit: Floats, viscosity: Floats) -> Self:
        """Return the same without storage.

        Args:
            limit, viscosity: As the attributes [Pa], [Pa s], shape (element,).
        """
        shape = (1, len(limit))
        return cls(np.full(shape, -1), np.ones(shape), limit, viscosity)

    def some(self, items: Indices) -> Self:
        """Return those of some elements, by indices of shape (n,)."""
        slot, rate = self.slot[:, items], self.rate[:, items]
        return type(self)(slot, rate, self.limit[items], self.viscosity[items])

    @property
    def keeps(self) -> NDArray[np.bool_]:
        """Return which elements yield, shape (1, element)."""
        return np.isfinite(self.viscosity)[None]

    @property
    def slowest(self) -> Floats:
        """Return zero, as the net alone sets their scale [1/s], shape (1, element)."""
        return np.zeros(self.slot.shape)

    @property
    def stopped(self) -> Self:
        """Return the same without any further flow."""
        limit = np.full_like(self.limit, np.inf)
        return type(self)(self.slot, self.rate, limit, self.viscosity)

    def fastest(self, elastic: SolidStrain, of: EnergySlopes, relaxing: Floats) -> float:
        """Return a bound of the rates at which elements flow [1/s]: 3 μ'/η.

        μ' is a shear modulus of the strained law, exact in tension along an axis.

        Args:
            elastic: Of Fe at the points of all elements.
            of: Derivatives of the laws there.
            relaxing: Σ μk g tr(C Ak) of branches [Pa], shape (element, point).
        """
        i1, i2 = elastic.first, elastic.second
        # |dev b|² of the isochoric b = Fe Feᵀ, and of its inverse.
        wide = np.maximum(2.0 / 3.0 * i1 * i1 - 2.0 * i2, 0.0)
        thin = np.maximum(2.0 / 3.0 * i2 * i2 - 2.0 * i1, 0.0)
        modulus = relaxing + _largest(of.by_first, i1, wide) + _largest(of.by_second, i2, thin)
        modulus += 2.0 * (abs(of.by_first_twice) * wide + abs(of.by_second_twice) * thin)
        modulus += 4.0 * abs(of.by_both) * np.sqrt(wide * thin)
        flows = np.isfinite(self.limit)
        return float((3.0 * modulus[flows] / self.viscosity[flows, None]).max(initial=0.0))

    def plastic(self, velocity: Floats, points: int) -> "PlasticDeformation":
        """Return the plastic deformation of the elements.

        Args:
            velocity: Of all nodes [m/s], shape (…, node, 3).
            points: Of each element.
        """
        return PlasticDeformation(self.tensors(velocity, points)[..., 0, :, :, :, :])


def _largest(weight: Floats, trace: Floats, square: Floats) -> Floats:
    """Return a bound of the largest eigenvalue of 2 w b [Pa], shape (…).

    Args:
        weight: w [Pa], shape (…).
        trace, square: tr b and |dev b|² of a symmetric tensor of order 3, shape (…).
    """
    apart = np.sqrt(2.0 / 3.0 * square)
    return 2.0 * (weight * trace / 3.0 + abs(weight) * apart)


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
        """Return that of some elements, by indices of shape (n,)."""
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


def yield_columns(yielding: SolidYield | None, elements: int, place: Indices) -> dict[str, Any]:
    """Return the columns of ``ElementTable`` that describe yielding, by name, in its units.

    Args:
        yielding: Of the elements; None without any.
        elements: How many there are.
        place: Index of each node in the arrays of the kernel, shape (node,). Hidden nodes that
            follow one another do so there, too.
    """
    slot = np.full(elements, -1)
    if yielding is None:
        none = np.zeros(0)
        return {"is_yielding": False, "yield_slot": slot, "yield_rate": none,
                "yield_stress": none, "yield_pace": none}  # fmt: skip
    own = np.flatnonzero(yielding.slot[0] >= 0)
    slot[own] = 3 * place[yielding.slot[0, own] // 3]
    return {
        "is_yielding": len(own) > 0, "yield_slot": slot, "yield_rate": yielding.rate[0],
        "yield_stress": yielding.limit, "yield_pace": 1.0 / yielding.viscosity,
    }  # fmt: skip
