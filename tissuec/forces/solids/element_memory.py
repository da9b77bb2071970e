"""What elements of solids and walls remember: tensors, branches that relax, and yielding.

A tensor T that begins as 1 is kept as T - 1 behind the velocities of nodes, six numbers for
each point, or three in the plane of a wall, times a ``rate``, so that it is stepped, stored and
resumed like all other motion; see ``Network.internal``.
"""

from abc import abstractmethod
from typing import Self

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.autodiff.tensors import PLACES
from tissuec.core.structs import replace
from tissuec.forces.effects import AbstractStruct
from tissuec.model.network import Floats, Indices

FLAT = 1e-6  # determinants and eigenvalues of tensors, below which they count as this


class StoredTensors(Struct, metaclass=AbstractStruct, frozen=True, eq=False):
    """Places of tensors, of which each element has up to one in each row.

    Attributes:
        slot: Place of the first number of T - 1 among the components of all velocities,
            followed by those of the other points, shape (row, element); -1 where there is none.
        rate: Factor of T - 1 there [m/s], shape (row, element).
        directions: Rows of a tensor: 3, or 2 in a wall.
    """

    slot: Indices
    rate: Floats
    directions: int

    @property
    def at(self) -> Indices:
        """Return rows and columns of the numbers of a tensor, shape (2, number)."""
        return np.array(PLACES[self.directions]).T

    @property
    def numbers(self) -> int:
        """Return the number of independent components of a tensor."""
        return len(PLACES[self.directions])

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

    def rows(self, points: int) -> Indices:
        """Return the rows of velocities that keep all tensors, ascending, shape (row,).

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
        return self.filled(self.told(velocity, points)) + np.eye(self.directions)

    def filled(self, numbers: Floats) -> Floats:
        """Return symmetric tensors from their numbers, in any unit, shape (…, n, n).

        Args:
            numbers: Independent components, shape (…, number).
        """
        rows, columns = self.at
        found = np.empty((*numbers.shape[:-1], self.directions, self.directions))
        found[..., rows, columns] = found[..., columns, rows] = numbers
        return found

    def told(self, velocity: Floats, points: int) -> Floats:
        """Return the numbers of T - 1 [1], shape (…, row, element, point, number).

        Args:
            velocity, points: As of ``tensors``.
        """
        flat = velocity.reshape(*velocity.shape[:-2], -1)
        has = (self.slot >= 0)[..., None, None]
        kept = flat[..., np.where(has, self.places(points), 0)] / self.rate[..., None, None]
        return np.where(has, kept, 0.0)

    def keep(self, velocity: Floats, tensors: Floats, items: Indices) -> None:
        """Set T of some elements, in the velocities of all nodes.

        Args:
            velocity: Changed in place [m/s], shape (node, 3).
            tensors: The same of all rows, dimensionless, shape (item, point, n, n).
            items: Indices of the elements, shape (item,).
        """
        flat, places = velocity.reshape(-1), self.places(tensors.shape[1])[:, items]
        rows, columns = self.at
        told = (tensors - np.eye(self.directions))[..., rows, columns]
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


class Branches(StoredTensors, frozen=True):
    """Branches of elements, each of which keeps a tensor of its own.

    Attributes:
        shear: μk [Pa], shape (branch, element); zero where there is none.
        time: τ [s], shape (branch, element); infinite where there is none.
    """

    shear: Floats
    time: Floats

    @classmethod
    def new(cls, shear: Floats, time: Floats, directions: int = 3) -> Self:
        """Return branches without storage.

        Args:
            shear, time: As the attributes [Pa], [s], shape (branch, element).
            directions: As the attribute.
        """
        return cls(np.full(shear.shape, -1), np.ones(shear.shape), directions, shear, time)

    def some(self, items: Indices) -> Self:
        """Return those of some elements, by indices of shape (n,)."""
        names = ("slot", "rate", "shear", "time")
        return replace(self, **{name: getattr(self, name)[:, items] for name in names})

    @property
    def sudden(self) -> Floats:
        """Return the instantaneous shear modulus of all branches [Pa], shape (element,)."""
        return self.shear.sum(axis=0)

    @property
    def keeps(self) -> NDArray[np.bool_]:
        """Return which branches exist, shape (branch, element)."""
        return self.shear > 0.0

    @property
    def pace(self) -> Floats:
        """Return 1/τ [1/s], shape (branch, element); zero where there is no branch."""
        return np.where(self.keeps, 1.0 / self.time, 0.0)

    @property
    def slowest(self) -> Floats:
        """Return the least rates that they are measured by [1/s], shape (branch, element)."""
        return 1.0 / self.time


class ElementYield(StoredTensors, frozen=True):
    """Yielding of elements; those that yield keep their plastic strain in the only row.

    Attributes:
        limit: Y [Pa], shape (element,); infinite where nothing yields.
        viscosity: η [Pa s], shape (element,); infinite where nothing ever yields.
    """

    limit: Floats
    viscosity: Floats

    @classmethod
    def new(cls, limit: Floats, viscosity: Floats, directions: int = 3) -> Self:
        """Return the same without storage.

        Args:
            limit, viscosity: As the attributes [Pa], [Pa s], shape (element,).
            directions: As the attribute.
        """
        shape = (1, len(limit))
        return cls(np.full(shape, -1), np.ones(shape), directions, limit, viscosity)

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

    def equivalent(self, velocity: Floats, points: int = 1) -> Floats:
        """Return √(2/3) |log Cp/2|, dimensionless, shape (…, element, point).

        For a bar, it is the logarithm of its permanent stretch. In a wall, Cp is 1 / det P
        across.

        Args:
            velocity: Of all nodes [m/s], shape (…, node, 3).
            points: Of each element.
        """
        tensors = self.tensors(velocity, points)[..., 0, :, :, :, :]
        logs = 0.5 * np.log(np.maximum(np.linalg.eigvalsh(tensors), FLAT))
        if self.directions == 2:
            logs = np.append(logs, -logs.sum(axis=-1, keepdims=True), axis=-1)
        logs -= logs.mean(axis=-1, keepdims=True)
        return np.sqrt(2.0 / 3.0 * (logs**2).sum(axis=-1))
