"""Gradual rules: "the more x is A, the more y is B".

The outer word of a scale is fully true from some point, its shoulder, to the end of the scale.
There its degree says nothing more; how far a fact has gone does. A rule carries that over to
the word that it concludes, so that "very soft" concludes what "very low" means. (D. Dubois,
H. Prade, Gradual inference rules in approximate reasoning, Information Sciences 61:103, 1992;
S. Fukami, M. Mizumoto, K. Tanaka, Some considerations on fuzzy conditional inference, Fuzzy
Sets and Systems 4:243, 1980.)

A word that is given as a fact means the middle of its core, which for an outer word lies
beyond its shoulder. Facts are therefore stretched first, so that this middle comes to the
shoulder: from "soft" on, every step counts, outward to the end as inward to the next word.
"""

from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import TypeAlias

from tissuec.fuzzy.duals import fsum
from tissuec.fuzzy.hedges import nearer_end
from tissuec.fuzzy.scale import Axis
from tissuec.fuzzy.sets import AnyShape, Powered, Shape

Saying = tuple[AnyShape, float, float]
"""The set that a rule concludes, the degree of the rule, and how far its facts have gone."""

Stretching: TypeAlias = tuple[tuple[float, float], ...]
"""Places that facts can have, ascending, and where they count."""


def stretching(shapes: Iterable[AnyShape], axis: Axis) -> Stretching:
    """Return how places of a property are stretched.

    Args:
        shapes: The sets that conditions use of it.
        axis: Its scale.
    """
    low, high = axis.bounds
    bases = [shape.base if isinstance(shape, Powered) else shape for shape in shapes]
    first = max((s for s in bases if s.core[0] <= low < s.core[1]), key=_end, default=None)
    last = min((s for s in bases if s.core[0] < high <= s.core[1]), key=_start, default=None)
    left, right = low, high
    before, behind = [(low, low)], [(high, high)]
    if first is not None and first.core[1] < first.support[1]:
        before.append((first.middle, first.core[1]))
        left = first.support[1]
    if last is not None and last.support[0] < last.core[0]:
        behind.insert(0, (last.middle, last.core[0]))
        right = last.support[0]
    if before[-1][1] >= behind[0][1]:
        return (low, low), (high, high)  # words that overlap where both are fully true
    # Between the words next to the outer ones nothing moves, unless these are neighbours.
    inner = [(left, left), (right, right)] if left <= right else []
    return tuple(dict.fromkeys([*before, *inner, *behind]))


def stretched(place: float, anchors: Stretching) -> float:
    """Return where a place of a property counts."""
    for (x0, y0), (x1, y1) in pairwise(anchors):
        if x0 <= place <= x1 and x0 < x1 and (x0, x1) != (y0, y1):
            return (y0 * (x1 - place) + y1 * (place - x0)) / (x1 - x0)
    return place


def unstretched(place: float, anchors: Stretching) -> float:
    """Return the place that counts at a place."""
    return stretched(place, tuple((counts, x) for x, counts in anchors))


def progress(shape: AnyShape, place: float, axis: Axis) -> float:
    """Return how far a fact has gone from the shoulder of an outer word to the scale's end.

    Args:
        shape: The set of the word, in the coordinate of ``axis``.
        place: Where the fact counts.
        axis: The scale.

    Returns:
        0 up to the shoulder, 1 at the end of the scale; 0 if the word is not an outer one.
    """
    base = shape.base if isinstance(shape, Powered) else shape
    low, high = axis.bounds
    start, end = base.core
    if start <= low < end and place < end:
        return (end - place) / (end - low)
    if start < high <= end and place > start:
        return (place - start) / (high - start)
    return 0.0


def gradual_mean(sayings: Sequence[Saying], axis: Axis) -> float:
    """Return the mean of what rules conclude, weighted by their degrees.

    Each rule counts, also where several conclude one word. The middle of the core of a word
    moves towards the nearer end of the scale, as far as the facts have gone to theirs.

    Returns:
        The mean, in the coordinate of ``axis``.
    """
    low, high = axis.bounds
    total = fsum(degree for _, degree, _ in sayings)
    moment = fsum(
        degree * (_moved(shape.middle, far, axis) - low) for shape, degree, far in sayings
    )
    return min(max(low + moment / total, low), high)


def _moved(middle: float, far: float, axis: Axis) -> float:
    end = nearer_end(middle, axis)
    return middle if end is None else middle + far * (end - middle)


def _start(shape: Shape) -> tuple[float, float]:
    return shape.core[0], shape.support[0]


def _end(shape: Shape) -> tuple[float, float]:
    return shape.core[1], shape.support[1]
