"""The range of a property or quantity, and the coordinate of its sets.

On a log scale everything happens in the logarithm; values are converted here and nowhere else.
There, a bell is by definition as wide as from its mean to one standard deviation above it.
"""

import math
from functools import cached_property

from msgspec import Struct

from tissuec.fuzzy.duals import exp, log, real
from tissuec.fuzzy.piecewise import Piecewise
from tissuec.fuzzy.sets import AnyShape, Gaussian, Shape

_ULPS = (
    8 * 2.0**-52
)  # a value converted between units and through exp and log is this uncertain


class OutOfRange(ValueError):
    """A value lies outside the range of its property or quantity."""

    def __init__(self, axis: "Axis", value: float):
        self.axis = axis
        self.value = value
        super().__init__(
            f"{axis.name} = {value:g} is outside its range from {axis.low:g} to {axis.high:g}"
        )


class Axis(Struct, frozen=True, dict=True):
    """A named range, linear or logarithmic.

    Attributes:
        name: Name of the property or quantity, for messages.
        low: Smallest value, in the unit of the values (SI).
        high: Largest value.
        log: Whether the coordinate is the natural logarithm of the value.

    Raises:
        ValueError: The range is empty, not finite, or not positive on a log scale.
    """

    name: str
    low: float
    high: float
    log: bool = False

    def __post_init__(self) -> None:
        if not (math.isfinite(self.low) and math.isfinite(self.high) and self.low < self.high):
            raise ValueError(
                f"the range of {self.name} must run from a smaller to a larger number"
            )
        if self.log and self.low <= 0.0:
            raise ValueError(f"the log scale of {self.name} must begin above zero")
        if self.bounds[1] - self.bounds[0] <= 2 * self.rounding:
            raise ValueError(f"the range of {self.name} is too narrow to compute with")

    @cached_property
    def bounds(self) -> tuple[float, float]:
        """Return the smallest and the largest coordinate."""
        return self._coordinate(self.low), self._coordinate(self.high)

    @cached_property
    def rounding(self) -> float:
        """Return the distance up to which coordinates differ by rounding alone."""
        return _ULPS * max(*map(abs, self.bounds), 1.0 if self.log else 0.0)

    def to_scale(self, value: float) -> float:
        """Return the coordinate of a value.

        Raises:
            OutOfRange: The value lies outside the range by more than rounding, or is NaN.
        """
        if self.log and not value > 0.0:
            raise OutOfRange(self, value)
        place = self.coordinate(value)
        if not self.bounds[0] <= place <= self.bounds[1]:
            raise OutOfRange(self, value)
        return place

    def coordinate(self, value: float) -> float:
        """Return the coordinate of a value that may lie outside the range.

        Raises:
            ValueError: The value has no place on a log scale.
        """
        return self._snapped(self._coordinate(value))

    def from_scale(self, place: float) -> float:
        """Return the value at a coordinate; rounding never carries it out of the range."""
        value = exp(place) if self.log else place
        return min(max(value, self.low), self.high)

    def place(self, shape: Shape) -> Shape:
        """Return a set given in values as a set in the coordinate, cut to the range.

        The corners keep their values and the edges are straight in the coordinate. Of a bell,
        the values ``mean`` and ``mean + sigma`` keep their degrees.

        Raises:
            ValueError: The set has no place on the scale, or its peak lies outside the range.
        """
        if isinstance(shape, Gaussian):
            mean = self.coordinate(shape.mean)
            width = math.log1p(shape.sigma / shape.mean) if self.log else shape.sigma
            return Gaussian(mean, width).within(*self.bounds)
        xs = tuple(self.coordinate(x) for x in shape.xs)
        return Piecewise(xs, shape.ys).within(*self.bounds)

    def value_of(self, shape: AnyShape) -> float:
        """Return the value of a word given as a fact: the middle of its core."""
        return self.from_scale(shape.middle)

    def reach_of(self, shape: Shape) -> tuple[float, float]:
        """Return the least and the largest value that a word can mean."""
        lowest, highest = self.bounds
        low, high = (min(max(end, lowest), highest) for end in shape.support)
        return self.from_scale(low), self.from_scale(high)

    def halfway(self, first: AnyShape, second: AnyShape) -> float:
        """Return the value half way between two words, for ``is between … and …``."""
        return self.from_scale(first.middle + (second.middle - first.middle) / 2)

    def _coordinate(self, value: float) -> float:
        if self.log and value <= 0.0:
            raise ValueError(f"{value:g} is not on the log scale of {self.name}")
        return log(value) if self.log else real(value)

    def _snapped(self, place: float) -> float:
        """Return the end of the range where ``place`` equals it up to rounding."""
        for end in self.bounds:
            if abs(place - end) <= self.rounding:
                return end
        return place
