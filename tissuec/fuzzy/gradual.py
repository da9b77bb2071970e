"""Gradual rules: "the more x is A, the more y is B".

The outer word of a scale is fully true from some point, its shoulder, to the end of the scale.
There its degree says nothing more; how far a fact has gone does. A rule carries that over to
the word that it concludes, so that "very soft" concludes what "very low" means. (D. Dubois,
H. Prade, Gradual inference rules in approximate reasoning, Information Sciences 61:103, 1992;
S. Fukami, M. Mizumoto, K. Tanaka, Some considerations on fuzzy conditional inference, Fuzzy
Sets and Systems 4:243, 1980.)
"""

from collections.abc import Sequence

from tissuec.fuzzy.axis import Axis
from tissuec.fuzzy.duals import fsum
from tissuec.fuzzy.hedges import nearer_end
from tissuec.fuzzy.sets import AnyShape, Powered

FARTHEST = 0.5  # of its way to the end of the scale: how far a conclusion moves

Saying = tuple[AnyShape, float, float]
"""The set that a rule concludes, the degree of the rule, and how far its facts have gone."""


def progress(shape: AnyShape, place: float, axis: Axis) -> float:
    """Return how far a fact has gone from the shoulder of an outer word to the scale's end.

    Args:
        shape: The set of the word, in the coordinate of ``axis``.
        place: The coordinate of the fact.
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
    moves towards the nearer end of the scale, at most half of its way.

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
    return middle if end is None else middle + FARTHEST * far * (end - middle)
