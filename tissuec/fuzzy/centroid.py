"""Defuzzification of a set of firing words: exact centre of gravity, or weighted mean.

Each word's set is clipped at (or scaled by) its firing degree, and the sets are joined by their
maximum. That maximum is cut at every corner and at every crossing, so that each piece belongs
to one arc with a closed-form area and moment. Nothing is sampled. Moments are taken from the
low end of the range, where all contributions are positive: nothing cancels, and a range far
from zero costs no digits.
"""

from collections.abc import Iterator, Sequence
from itertools import combinations, pairwise

from tissuec.fuzzy.curves import Arc, Bell, Line, crossings
from tissuec.fuzzy.duals import fsum, log, sqrt
from tissuec.fuzzy.operators import Implication
from tissuec.fuzzy.piecewise import Piecewise
from tissuec.fuzzy.sets import FAINTEST, AnyShape, Gaussian, Powered, Shape

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
