"""Elements of solids and walls that yield: where they do, and how fast they flow."""

from typing import Any, Self

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from tissuec.forces.solid_strain import EnergySlopes
from tissuec.forces.stored_tensors import StoredTensors
from tissuec.model.network import Floats, Indices


class ElementYield(StoredTensors, frozen=True):
    """Yielding of elements; those that yield keep their plastic strain in the only row.

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
        return replace(
            self,
            slot=self.slot[:, items],
            rate=self.rate[:, items],
            limit=self.limit[items],
            viscosity=self.viscosity[items],
        )

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
        return replace(self, limit=np.full_like(self.limit, np.inf))

    def fastest(self, i1: Floats, i2: Floats, of: EnergySlopes, relaxing: Floats) -> float:
        """Return a bound of the rates at which elements flow [1/s]: 3 μ'/η.

        μ' is a shear modulus of the strained law, exact in tension along an axis.

        Args:
            i1, i2: Isochoric invariants of Fe at all points, shape (element, …).
            of: Derivatives of the laws there.
            relaxing: Σ μk g tr(C Ak) of branches [Pa], shape (element, …).
        """
        # |dev b|² of the isochoric b = Fe Feᵀ, and of its inverse.
        wide = np.maximum(2.0 / 3.0 * i1 * i1 - 2.0 * i2, 0.0)
        thin = np.maximum(2.0 / 3.0 * i2 * i2 - 2.0 * i1, 0.0)
        modulus = relaxing + _largest(of.by_first, i1, wide) + _largest(of.by_second, i2, thin)
        modulus += 2.0 * (abs(of.by_first_twice) * wide + abs(of.by_second_twice) * thin)
        modulus += 4.0 * abs(of.by_both) * np.sqrt(wide * thin)
        flows = np.isfinite(self.limit)
        widest = modulus.reshape(len(self.limit), -1).max(axis=1)
        return float((3.0 * widest[flows] / self.viscosity[flows]).max(initial=0.0))


def _largest(weight: Floats, trace: Floats, square: Floats) -> Floats:
    """Return a bound of the largest eigenvalue of 2 w b [Pa], shape (…).

    Args:
        weight: w [Pa], shape (…).
        trace, square: tr b and |dev b|² of a symmetric tensor of order 3, shape (…).
    """
    apart = np.sqrt(2.0 / 3.0 * square)
    return 2.0 * (weight * trace / 3.0 + abs(weight) * apart)


def yield_columns(
    yielding: ElementYield | None, elements: int, place: Indices
) -> dict[str, Any]:
    """Return the columns of records of kernels that describe yielding, by name, in SI units.

    Args:
        yielding: Of the elements; None without any.
        elements: How many there are.
        place: Index of each node in the arrays of the kernel, shape (node,). Hidden nodes that
            follow one another do so there, too.
    """
    slot = np.full(elements, -1)
    if yielding is None:
        none = np.zeros(0)
        return {"yield_slot": slot, "yield_rate": none, "yield_stress": none,
                "yield_pace": none}  # fmt: skip
    own = np.flatnonzero(yielding.slot[0] >= 0)
    slot[own] = 3 * place[yielding.slot[0, own] // 3]
    return {
        "yield_slot": slot, "yield_rate": yielding.rate[0], "yield_stress": yielding.limit,
        "yield_pace": 1.0 / yielding.viscosity,
    }  # fmt: skip
