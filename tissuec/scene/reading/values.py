"""Values with a dimension, and the arithmetic that refuses to mix them."""

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.units import NUMBER, Dimension, show, si_unit

#: In SI units; below it products of a few numbers are numbers still.
LARGEST_NUMBER = 1e100
SMALLEST_NUMBER = 1e-100  # besides 0, of what has a unit


class Value(Struct, frozen=True, eq=False):
    """A number, a vector or one number per node, in SI units.

    Attributes:
        amount: Shape () for a number, (3,) for a vector, (item,) inside set conditions.
        dimension: Of every component.
        is_vector: Whether the last axis holds x, y, z.
        is_literal: Whether it was written as a bare number, so that a hint may propose a unit.
    """

    amount: NDArray[np.float64]
    dimension: Dimension = NUMBER
    is_vector: bool = False
    is_literal: bool = False

    @classmethod
    def number(
        cls, amount: float | NDArray[np.float64], dimension: Dimension = NUMBER
    ) -> "Value":
        """Return a number in SI units, or numbers of shape (item,), as a value."""
        return cls(np.asarray(amount, dtype=float), dimension)

    @property
    def is_many(self) -> bool:
        """Return whether there is one for each of several items."""
        return self.amount.ndim > self.is_vector

    def __str__(self) -> str:
        if self.is_vector:
            parts = ", ".join(f"{component:.6g}" for component in self.amount)
            return f"({parts}) {si_unit(self.dimension)}".strip()
        return show(float(self.amount), self.dimension, digits=6)


def unit_vector(vector: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Return the dimensionless unit vector in the same direction, shape (3,); None for zero."""
    largest = np.abs(vector).max()
    if largest == 0.0:
        return None
    scaled = vector / largest
    return scaled / np.linalg.norm(scaled)
