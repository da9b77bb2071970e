"""Scales: the words of a property or quantity, and the ways to lay them out over a range."""

from collections.abc import Mapping, Sequence
from functools import lru_cache
from itertools import pairwise
from types import MappingProxyType

from msgspec import Struct
from msgspec.structs import force_setattr

from tissuec.fuzzy.axis import Axis
from tissuec.fuzzy.piecewise import points
from tissuec.fuzzy.sets import Shape

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
