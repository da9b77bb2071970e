"""Branches of elements of solids and walls, in which stress relaxes."""

from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from tissuec.forces.stored_tensors import StoredTensors
from tissuec.model.network import Floats, Indices


class Branches(StoredTensors, frozen=True):
    """Branches of elements, each of which keeps a tensor of its own.

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


def branch_columns(
    branches: Branches | None, elements: int, place: Indices
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
