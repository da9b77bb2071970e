"""Scales: the range of a property or quantity, and its words, laid out over the range.

On a log scale everything happens in the logarithm; values are converted here and nowhere else.
There, a bell is by definition as wide as from its mean to one standard deviation above it.
"""

import math
from collections.abc import Mapping, Sequence
from functools import cached_property, lru_cache
from itertools import pairwise
from types import MappingProxyType

from msgspec import Struct
from msgspec.structs import force_setattr

from tissuec.fuzzy.duals import exp, log, real
from tissuec.fuzzy.sets import AnyShape, Gaussian, Piecewise, Shape, points

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


_NEGLIGIBLE = 1e-9  # of the range; what is narrower than this is rounding, not a gap


class Scale(Struct, frozen=True):
    """A range and the words for its parts; build one with the functions of this module.

    Attributes:
        axis: The range, and the coordinate of the sets.
        words: The set of each word, in the coordinate of the axis, cut to its range.
    """

    axis: Axis
    words: Mapping[str, Shape]

    def __post_init__(self) -> None:
        force_setattr(self, "words", MappingProxyType(dict(self.words)))

    def __reduce__(self) -> tuple[type["Scale"], tuple[object, ...]]:
        return Scale, (self.axis, dict(self.words))  # read-only views cannot be pickled


class Plateau(Struct, frozen=True):
    """A word that is fully true from ``start`` to ``end``; None is the end of the range."""

    word: str
    start: float | None
    end: float | None


def shaped(axis: Axis, shapes: Mapping[str, Shape]) -> Scale:
    """Return a scale of explicit shapes given in values, not coordinates.

    Raises:
        ValueError: A shape does not fit the range; the message names its word.
    """
    placed: dict[str, Shape] = {}
    for word, shape in shapes.items():
        try:
            placed[word] = axis.place(shape)
        except ValueError as error:
            raise ValueError(f'{axis.name}, "{word}": {error}') from error
    return Scale(axis, placed)


def evenly(axis: Axis, words: Sequence[str]) -> Scale:
    """Return a scale whose range is cut into equal parts, one for each word.

    Each word peaks in the middle of its part and reaches zero at its neighbours' peaks; the
    outer words stay fully true to the ends, so that the degrees always sum to 1.

    Raises:
        ValueError: There is no word, or one appears twice.
    """
    return _even(axis, tuple(words))


@lru_cache(maxsize=256)  # the same vocabularies are read again and again
def _even(axis: Axis, words: tuple[str, ...]) -> Scale:
    """Return the scale that ``evenly`` returns."""
    low, high = axis.bounds
    count = len(words)
    peaks = [low + (high - low) * ((2 * i + 1) / (2 * count)) for i in range(count)]
    return _partition(axis, words, [low, *peaks[1:]], [*peaks[:-1], high])


def plateaus(axis: Axis, parts: Sequence[Plateau]) -> Scale:
    """Return a scale of plateaus in ascending order, whose degrees sum to 1.

    Between two plateaus one word fades as the next one grows. Where two plateaus touch there is
    a sharp edge, and exactly on it both words are fully true.

    Raises:
        ValueError: Plateaus overlap, are out of order or range, do not reach the ends of the
            range, or name a word twice.
    """
    low, high = axis.bounds
    starts = [low if part.start is None else axis.to_scale(part.start) for part in parts]
    ends = [high if part.end is None else axis.to_scale(part.end) for part in parts]
    if parts and (starts[0] != low or ends[-1] != high):
        raise ValueError(f"the outer words of {axis.name} must reach the ends of its range")
    return _partition(axis, [part.word for part in parts], starts, ends)


def _partition(
    axis: Axis, words: Sequence[str], starts: Sequence[float], ends: Sequence[float]
) -> Scale:
    """Return neighbouring plateaus that share their slopes; coordinates, shape (word,)."""
    if not words or len(set(words)) != len(words):
        raise ValueError(f"{axis.name} needs words, each of them once")
    edges = [edge for plateau in zip(starts, ends, strict=True) for edge in plateau]
    for k, (before, after) in enumerate(pairwise(edges)):
        if before > after:
            raise ValueError(f'{axis.name}, "{words[(k + 1) // 2]}": plateaus must ascend')
    shapes: dict[str, Shape] = {}
    for i, word in enumerate(words):
        rise = [(ends[i - 1], 0.0)] if i > 0 else []
        fall = [(starts[i + 1], 0.0)] if i + 1 < len(words) else []
        shape = points([*rise, (starts[i], 1.0), (ends[i], 1.0), *fall])
        shapes[word] = shape.within(*axis.bounds)
    return Scale(axis, shapes)


def gaps(scale: Scale) -> list[tuple[float, float]]:
    """Return the parts of the range that belong to no word, as values."""
    low, high = scale.axis.bounds
    corners = {min(max(x, low), high) for s in scale.words.values() for x in s.corners}
    wide = _NEGLIGIBLE * (high - low)
    return [
        (scale.axis.from_scale(start), scale.axis.from_scale(end))
        for start, end in pairwise(sorted(corners | {low, high}))
        if end - start > wide
        and not any(s.degree(start + (end - start) / 2) for s in scale.words.values())
    ]
