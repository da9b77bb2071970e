"""The two kinds of arcs that bound a clipped or scaled fuzzy set: lines and parts of bells.

Each arc knows its height, its area and first moment over an interval (closed forms), and where
it crosses another arc. Areas of bells are differences of error functions (M. Abramowitz,
I. A. Stegun, Handbook of Mathematical Functions, 1964, 7.1).
"""

import math
from collections.abc import Callable
from itertools import pairwise
from typing import NamedTuple, TypeAlias

from tissuec.fuzzy.duals import erfc, exp
from tissuec.fuzzy.piecewise import between

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
        one: One arc.
        other: The other arc.
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
