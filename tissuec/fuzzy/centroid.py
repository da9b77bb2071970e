"""Defuzzification: exact centre of gravity, weighted mean, and gradual rules.

Each word's set is clipped at (or scaled by) its firing degree, and the sets are joined by their
maximum. That maximum is cut at every corner and at every crossing, so that each piece belongs
to one arc with a closed-form area and moment. Nothing is sampled. Moments are taken from the
low end of the range, where all contributions are positive: nothing cancels, and a range far
from zero costs no digits.

Two kinds of arcs bound a clipped or scaled fuzzy set: lines and parts of bells. Each arc knows
its height, its area and first moment over an interval (closed forms), and where it crosses
another arc. Areas of bells are differences of error functions (M. Abramowitz, I. A. Stegun,
Handbook of Mathematical Functions, 1964, 7.1).

Gradual rules: "the more x is A, the more y is B".

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

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import combinations, pairwise
from typing import NamedTuple, TypeAlias

from tissuec.fuzzy.duals import erfc, exp, fsum, log, sqrt
from tissuec.fuzzy.hedges import nearer_end
from tissuec.fuzzy.rules import Implication
from tissuec.fuzzy.scale import Axis
from tissuec.fuzzy.sets import FAINTEST, AnyShape, Gaussian, Piecewise, Powered, Shape, between

_SQRT2 = math.sqrt(2.0)
_HALF_SQRT_2PI = math.sqrt(math.pi / 2.0)


class Line(NamedTuple):
    """A straight arc from ``(start, first)`` to ``(end, last)``."""

    start: float
    end: float
    first: float
    last: float

    def height(self, x: float) -> float:
        """Return the height at ``x``, which lies on the arc."""
        return between(self.start, self.first, self.end, self.last, x)

    def integrals(self, a: float, b: float) -> tuple[float, float]:
        """Return the area below the arc from ``a`` to ``b``, and its moment about ``a``."""
        ya, yb, width = self.height(a), self.height(b), b - a
        return width * (ya + yb) / 2, width * width * (ya + 2 * yb) / 6


class Bell(NamedTuple):
    """A part of ``peak · exp(-(x - mean)² / (2 sigma²))`` without mean or inflection inside."""

    start: float
    end: float
    mean: float
    sigma: float
    peak: float

    def height(self, x: float) -> float:
        """Return the height at ``x``."""
        z = (x - self.mean) / self.sigma
        return self.peak * exp(-0.5 * z * z)

    def slope(self, x: float) -> float:
        """Return the derivative at ``x``."""
        return (self.mean - x) / self.sigma**2 * self.height(x)

    def integrals(self, a: float, b: float) -> tuple[float, float]:
        """Return the area below the arc from ``a`` to ``b``, and its moment about ``a``."""
        # erfc of positive numbers only: differences of erf would lose the digits of tails.
        near, far = sorted((abs(a - self.mean), abs(b - self.mean)))
        tails = erfc(near / self.sigma / _SQRT2) - erfc(far / self.sigma / _SQRT2)
        area = self.peak * self.sigma * _HALF_SQRT_2PI * tails
        about_mean = self.sigma**2 * (self.height(a) - self.height(b))
        return area, about_mean + (self.mean - a) * area


Arc: TypeAlias = Line | Bell


def crossings(one: Arc, other: Arc, a: float, b: float) -> list[float]:
    """Return where two arcs that both span ``[a, b]`` cross inside it.

    Args:
        a: Start of the interval.
        b: End of the interval.
    """
    if isinstance(one, Line):
        if isinstance(other, Line):
            found = _of_lines(one, other, a, b)
        else:
            found = _of_bell_and_line(other, one, a, b)
    elif isinstance(other, Line):
        found = _of_bell_and_line(one, other, a, b)
    else:
        found = _of_bells(one, other)
    # Both arcs are equally high there: where the cut is has no influence on areas, to first
    # order, and needs no slopes.
    return [float(x) for x in found if a < x < b]


def _of_lines(one: Line, other: Line, a: float, b: float) -> list[float]:
    left = one.height(a) - other.height(a)
    right = one.height(b) - other.height(b)
    if (left < 0.0) == (right < 0.0):
        return []
    return [a + (b - a) * (left / (left - right))]


def _of_bells(one: Bell, other: Bell) -> list[float]:
    """Solve for equal logarithms, a quadratic in the distance from the first mean."""
    apart = other.mean - one.mean
    p, q = 1.0 / one.sigma**2, 1.0 / other.sigma**2
    squared, linear = (q - p) / 2, -apart * q
    constant = math.log(one.peak / other.peak) + apart * apart * q / 2
    root = linear * linear - 4 * squared * constant
    if root < 0.0 or (linear == 0.0 and (squared == 0.0 or constant == 0.0)):
        return []
    # The sum of numbers of one sign first: nothing cancels, also for nearly equal widths.
    larger = -(linear + math.copysign(math.sqrt(root), linear)) / 2
    return [one.mean + n / d for n, d in ((larger, squared), (constant, larger)) if d != 0.0]


def _of_bell_and_line(bell: Bell, line: Line, a: float, b: float) -> list[float]:
    """Bisect on either side of the one place where bell and line can be parallel.

    An arc of a bell has no inflection inside, so that its distance from a line has at most one
    extremum, and at most one root on either side of it.
    """
    bell, line = Bell(*map(float, bell)), Line(*map(float, line))
    rise = (line.last - line.first) / (line.end - line.start)

    def distance(x: float) -> float:
        return bell.height(x) - line.height(x)

    parallel = _root(lambda x: bell.slope(x) - rise, a, b)
    places = [a, b] if parallel is None else [a, parallel, b]
    roots = [_root(distance, x, y) for x, y in pairwise(places)]
    return [x for x in roots if x is not None]


def _root(function: Callable[[float], float], a: float, b: float) -> float | None:
    """Return a root to the last digit, or None where the ends have one sign."""
    if (function(a) < 0.0) == (function(b) < 0.0):
        return None
    negative = function(a) < 0.0
    while a < (x := a + (b - a) / 2) < b:
        a, b = (x, b) if (function(x) < 0.0) == negative else (a, x)
    return a


Term = tuple[AnyShape, float]
"""A set, cut to the range by its ``within``, and the firing degree of its word."""


def centre_of_gravity(
    terms: Sequence[Term], low: float, high: float, *, implication: Implication = "minimum"
) -> float:
    """Return the centre of gravity of the maximum of clipped or scaled sets.

    Args:
        terms: Sets that span the range, and firing degrees from 0 to 1.
        low: Low end of the range, in the coordinate of the sets.
        high: High end of the range.
        implication: "minimum" clips a set at its degree, "product" scales it.

    Returns:
        The centre, in the coordinate of the sets.

    Raises:
        ValueError: No word fires, or a set carries a power.
    """
    arcs: list[Arc] = []
    for shape, degree in _firing(terms):
        cut, factor = (degree, 1.0) if implication == "minimum" else (1.0, degree)
        arcs.extend(_outline(shape, cut, factor, low, high))
    area = moment = 0.0
    for arc, a, b in _upper(arcs):
        part, about_a = arc.integrals(a, b)
        area += part
        moment += about_a + part * (a - low)
    return min(max(low + moment / area, low), high)


def weighted_mean(terms: Sequence[Term], low: float, high: float) -> float:
    """Return the mean of the middles of the words' cores, weighted by their firing degrees.

    Args:
        terms: Sets and firing degrees from 0 to 1.
        low: Low end of the range, in the coordinate of the sets.
        high: High end of the range.

    Raises:
        ValueError: No word fires, or a set carries a power.
    """
    firing = _firing(terms)
    total = fsum(degree for _, degree in firing)
    moment = fsum(degree * (shape.middle - low) for shape, degree in firing)
    return min(max(low + moment / total, low), high)


def _firing(terms: Sequence[Term]) -> list[tuple[Shape, float]]:
    firing: list[tuple[Shape, float]] = []
    for shape, degree in terms:
        if isinstance(shape, Powered):
            raise ValueError("a power hedge is not allowed in a conclusion; use a shift")
        if degree >= FAINTEST:
            firing.append((shape, degree))
    if not firing:
        raise ValueError("no word fires, so the result is undefined")
    return firing


def _outline(shape: Shape, cut: float, factor: float, low: float, high: float) -> Iterator[Arc]:
    """Yield the arcs of ``factor · min(set, cut)`` that lie above zero."""
    if isinstance(shape, Gaussian):
        return _outline_of_bell(shape, cut, factor, low, high)
    return _outline_of_lines(shape, cut, factor)


def _outline_of_lines(shape: Piecewise, cut: float, factor: float) -> Iterator[Line]:
    xs, ys = shape.xs, shape.ys
    for i in range(len(xs) - 1):
        x0, y0, x1, y1 = xs[i], ys[i], xs[i + 1], ys[i + 1]
        if x0 == x1 or (y0 == 0.0 and y1 == 0.0):
            continue
        if min(y0, y1) < cut < max(y0, y1):
            x = x0 + (x1 - x0) * ((cut - y0) / (y1 - y0))
            if x0 < x:
                yield Line(x0, x, factor * min(y0, cut), factor * cut)
            if x < x1:
                yield Line(x, x1, factor * cut, factor * min(y1, cut))
        else:
            yield Line(x0, x1, factor * min(y0, cut), factor * min(y1, cut))


def _outline_of_bell(
    bell: Gaussian, cut: float, factor: float, low: float, high: float
) -> Iterator[Arc]:
    """Yield a flat top and flanks, divided at the mean and the inflections."""
    flat = bell.sigma * sqrt(-2.0 * log(cut))  # half width of the flat top
    reach = bell.support[1] - bell.mean
    distances = sorted({0.0, flat, bell.sigma, reach})
    places = [
        bell.mean + side * d for side, ds in ((-1, distances[::-1]), (1, distances)) for d in ds
    ]
    for a, b in pairwise(min(max(x, low), high) for x in places):
        if a == b:
            continue
        if abs(a + (b - a) / 2 - bell.mean) < flat:
            yield Line(a, b, factor * cut, factor * cut)
        else:
            yield Bell(a, b, bell.mean, bell.sigma, factor)


def _upper(arcs: list[Arc]) -> Iterator[tuple[Arc, float, float]]:
    """Yield the upper envelope: arcs with the interval on which each is the highest."""
    waiting = sorted(arcs, key=lambda arc: arc.start, reverse=True)
    ends = {arc.start for arc in arcs} | {arc.end for arc in arcs}
    present: list[Arc] = []
    for a, b in pairwise(sorted(ends)):
        present = [arc for arc in present if arc.end > a]
        while waiting and waiting[-1].start == a:
            present.append(waiting.pop())
        if len(present) == 1:
            yield present[0], a, b
        elif present:
            yield from _highest(present, a, b)


def _highest(arcs: list[Arc], a: float, b: float) -> Iterator[tuple[Arc, float, float]]:
    """Yield the highest of arcs that all span ``[a, b]``, divided where they cross."""
    cuts = {x for one, other in combinations(arcs, 2) for x in crossings(one, other, a, b)}
    for start, end in pairwise(sorted(cuts | {a, b})):
        middle = start + (end - start) / 2
        yield max(arcs, key=lambda arc: arc.height(middle)), start, end


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
