"""The unknowns of all elements that relax, one field after the other."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from tissuec.validate.forces.elements import ElementSolid

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class RelaxingFields:
    """The unknowns of all fields that relax; see ``validate.forces.relaxing``.

    Args:
        fields: All of the net.

    Attributes:
        count: Number of unknowns.

    Shared arguments:
        position, velocity: Of all nodes [m], [m/s], shape (node, 3).
        given: The unknowns, dimensionless, shape (count,).
    """

    def __init__(self, fields: "tuple[ElementSolid, ...]"):
        self._fields = [(f, f.branches) for f in fields if f.branches is not None]
        self.count = sum(branches.count for _, branches in self._fields)

    def read(self, velocity: Floats) -> Floats:
        """Return the unknowns, dimensionless, shape (count,)."""
        return _joined([branches.read(velocity) for _, branches in self._fields])

    def write(self, given: Floats, velocity: Floats) -> None:
        """Store the unknowns, dimensionless, shape (count,), as velocities."""
        first = 0
        for _, branches in self._fields:
            branches.write(given[first : first + branches.count], velocity)
            first += branches.count

    def rates(self, position: Floats, velocity: Floats) -> Floats:
        """Return the rates of the unknowns [1/s], shape (count,)."""
        return _joined([b.rates(f.unimodular(position), velocity) for f, b in self._fields])

    def energy(self, position: Floats, velocity: Floats) -> float:
        """Return the energy of all branches at positions of shape (node, 3) [J]."""
        return sum(f.stored_in_branches(position, velocity) for f, _ in self._fields)

    def let_relax(self, position: Floats, velocity: Floats, free: Indices) -> None:
        """Store that the branches of elements at free nodes gave way for good.

        Args:
            position, velocity: Of all nodes [m], [m/s], shape (node, 3).
            free: The free nodes, shape (free,).
        """
        for field, branches in self._fields:
            branches.given_way(field.unimodular(position), field.touches(free), velocity)

    def allowed(self, place: float) -> Floats:
        """Return errors of unknowns that count as one of positions [m], shape (count,)."""
        return _joined([branches.allowed(place) for _, branches in self._fields])

    @property
    def slowing(self) -> Floats:
        """Return about the derivatives of rates by their own unknowns [1/s], shape (count,)."""
        return _joined([branches.slowing for _, branches in self._fields])


def _joined(parts: list[Floats]) -> Floats:
    return np.concatenate([np.zeros(0), *parts])
