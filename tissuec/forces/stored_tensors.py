"""Symmetric tensors at the points of elements, which change in the course of a run.

A tensor T that begins as 1 is kept as T - 1 in the velocities of hidden nodes, six numbers for
each point, or three in the plane of a wall, times a ``rate``, so that it is stepped, stored and
resumed like all other motion.
"""

from abc import abstractmethod
from typing import ClassVar, Self

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from tissuec.forces import AbstractStruct
from tissuec.forces.solid_strain import SolidStrain
from tissuec.model.network import Floats, Indices

#: Rows and columns of the six numbers of a symmetric tensor.
ROWS, COLUMNS = np.array([0, 1, 2, 1, 0, 0]), np.array([0, 1, 2, 2, 2, 1])
SIX = len(ROWS)


class StoredTensors(Struct, metaclass=AbstractStruct, frozen=True, eq=False):
    """Places of tensors, of which each element has up to one in each row.

    Attributes:
        slot: Place of the first number of T - 1 among the components of all velocities,
            followed by those of the other points, shape (row, element); -1 where there is none.
        rate: Factor of T - 1 there [m/s], shape (row, element).
        at: Rows and columns of the independent components of a tensor, shape (2, number).
    """

    at: ClassVar[Indices] = np.stack([ROWS, COLUMNS])

    slot: Indices
    rate: Floats

    @property
    def numbers(self) -> int:
        """Return the number of independent components of a tensor."""
        return len(self.at[0])

    @property
    @abstractmethod
    def keeps(self) -> NDArray[np.bool_]:
        """Return which tensors exist, shape (row, element)."""

    @property
    @abstractmethod
    def slowest(self) -> Floats:
        """Return the least rates that they are measured by [1/s], shape (row, element)."""

    @property
    def exists(self) -> Indices:
        """Return element and row of each existing tensor, by elements, shape (n, 2)."""
        return np.argwhere(self.keeps.T)

    def stored(self, first: int, points: int, fastest: float, size: Floats) -> Self:
        """Return the same with storage.

        Args:
            first: Place of the first number among the components of all velocities.
            points: Of each element.
            fastest: A bound of the angular frequencies of the net [1/s].
            size: Of elements [m], shape (element,).
        """
        element, row = self.exists.T
        slot = np.full(self.slot.shape, -1)
        slot[row, element] = first + self.numbers * points * np.arange(len(element))
        return replace(self, slot=slot, rate=size * np.maximum(self.slowest, fastest))

    def nodes(self, points: int) -> Indices:
        """Return the hidden nodes that keep all tensors, ascending, shape (node,).

        Args:
            points: Of each element.
        """
        element, row = self.exists.T
        first = self.slot[row, element] // 3
        nodes = first[:, None] + np.arange(self.numbers * points // 3)
        return nodes[first >= 0].ravel()

    def tensors(self, velocity: Floats, points: int) -> Floats:
        """Return T, dimensionless, shape (…, row, element, point, n, n); 1 without storage.

        n is 3, or 2 in a plane.

        Args:
            velocity: Of all nodes [m/s], shape (…, node, 3).
            points: Of each element.
        """
        flat = velocity.reshape(*velocity.shape[:-2], -1)
        place = self.places(points)
        has = (self.slot >= 0)[..., None, None]
        kept = flat[..., np.where(has, place, 0)] / self.rate[..., None, None]
        told = np.where(has, kept, 0.0)
        rows, columns = self.at
        size = int(rows.max()) + 1
        found = np.empty((*told.shape[:-1], size, size))
        found[..., rows, columns] = found[..., columns, rows] = told
        return found + np.eye(size)

    def keep(self, velocity: Floats, tensors: Floats, items: Indices) -> None:
        """Set T of some elements, in the velocities of all nodes.

        Args:
            velocity: Changed in place [m/s], shape (node, 3).
            tensors: The same of all rows, dimensionless, shape (item, point, n, n).
            items: Indices of the elements, shape (item,).
        """
        flat, places = velocity.reshape(-1), self.places(tensors.shape[1])[:, items]
        rows, columns = self.at
        told = (tensors - np.eye(tensors.shape[-1]))[..., rows, columns]
        for slot, place, rate in zip(self.slot, places, self.rate, strict=True):
            has = slot[items] >= 0
            flat[place[has]] = (rate[items, None, None] * told)[has]

    def places(self, points: int) -> Indices:
        """Return places of the numbers, shape (row, element, point, number).

        Args:
            points: Of each element.
        """
        own = np.arange(self.numbers * points).reshape(points, self.numbers)
        return self.slot[..., None, None] + own


def unimodular_inverse(tensors: Floats) -> Floats:
    """Return det(T)^(1/3) T⁻¹, dimensionless, shape (…, 3, 3).

    Args:
        tensors: T, dimensionless, shape (…, 3, 3).
    """
    strain = SolidStrain(tensors)
    return strain.g[..., None, None] * strain.cofactors
