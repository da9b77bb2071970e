"""The unknowns of all elements that relax or yield, one field after the other."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from tissuec.validate.forces.elements import ElementSolid
    from tissuec.validate.forces.membranes import MembraneWall

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class RelaxingFields:
    """The unknowns of all fields with internal variables; see ``validate.forces.relaxing``.

    Args:
        fields: All of the net.

    Attributes:
        count: Number of unknowns.

    Shared arguments:
        position, velocity: Of all nodes [m], [m/s], shape (node, 3).
        given: The unknowns, dimensionless, shape (count,).
    """

    def __init__(self, fields: "Sequence[ElementSolid | MembraneWall]"):
        self._fields = [field for field in fields if field.kept]
        self._kept = [kept for field in self._fields for kept in field.kept]
        self.count = sum(kept.count for kept in self._kept)

    def read(self, velocity: Floats) -> Floats:
        """Return the unknowns, dimensionless, shape (count,)."""
        return _joined([kept.read(velocity) for kept in self._kept])

    def write(self, given: Floats, velocity: Floats) -> None:
        """Store the unknowns, dimensionless, shape (count,), as velocities."""
        first = 0
        for kept in self._kept:
            kept.write(given[first : first + kept.count], velocity)
            first += kept.count

    def rates(self, position: Floats, velocity: Floats) -> Floats:
        """Return the rates of the unknowns [1/s], shape (count,)."""
        return _joined([field.rates(position, velocity) for field in self._fields])

    def energy(self, position: Floats, velocity: Floats) -> float:
        """Return the energy that depends on unknowns, at positions of shape (node, 3) [J]."""
        return sum(field.remembered_energy(position, velocity) for field in self._fields)

    def let_relax(self, position: Floats, velocity: Floats, free: Indices) -> None:
        """Store that the branches of elements at free nodes gave way for good.

        Args:
            position, velocity: Of all nodes [m], [m/s], shape (node, 3).
            free: The free nodes, shape (free,).
        """
        for field in self._fields:
            field.give_way(position, velocity, free)

    def allowed(self, place: float) -> Floats:
        """Return errors of unknowns that count as one of positions [m], shape (count,)."""
        return _joined([kept.allowed(place) for kept in self._kept])

    @property
    def slowing(self) -> Floats:
        """Return about the derivatives of rates by their own unknowns [1/s], shape (count,)."""
        return _joined([kept.slowing for kept in self._kept])


def _joined(parts: list[Floats]) -> Floats:
    return np.concatenate([np.zeros(0), *parts])
