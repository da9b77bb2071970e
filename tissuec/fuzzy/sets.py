"""Fuzzy sets, piecewise linear: the degree of a word at each place of its scale.

Every coordinate here is the coordinate of the scale: the quantity itself, or its logarithm.

A set is a list of points with ascending x. A repeated x is a vertical edge, and the degree
there is the largest of its points, so that ``triangle(0, 0, 1)`` is fully true at 0. Beyond its
first and last point a set keeps their degree (as in IEC 61131-7).

(L. A. Zadeh, Information and Control 8:338, 1965.)
"""

import math
from bisect import bisect_left
from collections.abc import Iterable, Iterator
from itertools import groupby, pairwise
from typing import TypeAlias

from msgspec import Struct

from tissuec.fuzzy.duals import exp, real


class Piecewise(Struct, frozen=True):
    """A piecewise linear membership function.

    Attributes:
        xs: Coordinates of the points, ascending, shape (point,).
        ys: Degrees of the points, from 0 to 1, shape (point,).

    Raises:
        ValueError: The points are no membership function with a single peak or plateau.
    """

    xs: tuple[float, ...]
    ys: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.xs) != len(self.ys) or len(self.xs) < 2:
            raise ValueError("a set needs at least two points, each with one degree")
        if not all(map(math.isfinite, self.xs)):
            raise ValueError("the points of a set must be finite")
        if any(a > b for a, b in pairwise(self.xs)):
            raise ValueError("the points of a set must be in ascending order")
        if not all(0.0 <= y <= 1.0 for y in self.ys):
            raise ValueError("the degrees of a set must be between 0 and 1")
        top = max(self.ys)
        first = self.ys.index(top)
        if top == 0.0:
            raise ValueError("a set must have a degree above 0 somewhere")
        if any(y != top for y in self.ys[first : first + self.ys.count(top)]):
            raise ValueError("a set must have one peak or one plateau, not several")

    def degree(self, x: float) -> float:
        """Return how true the word is at ``x``."""
        xs, ys = self.xs, self.ys
        i = bisect_left(xs, x)
        if i == len(xs):
            return ys[-1]
        if xs[i] == x:
            end = i + 1
            while end < len(xs) and xs[end] == x:
                end += 1
            return max(ys[i:end])
        return ys[0] if i == 0 else between(xs[i - 1], ys[i - 1], xs[i], ys[i], x)

    @property
    def core(self) -> tuple[float, float]:
        """Return the interval on which the degree is largest."""
        first = self.ys.index(max(self.ys))
        return self.xs[first], self.xs[first + self.ys.count(self.ys[first]) - 1]

    @property
    def middle(self) -> float:
        """Return the middle of the core: the value of the word as a fact."""
        low, high = self.core
        return low + (high - low) / 2

    @property
    def support(self) -> tuple[float, float]:
        """Return the smallest interval of the points outside which the degree is zero."""
        positive = [i for i, y in enumerate(self.ys) if y > 0.0]
        last = len(self.xs) - 1
        return self.xs[max(positive[0] - 1, 0)], self.xs[min(positive[-1] + 1, last)]

    @property
    def corners(self) -> tuple[float, ...]:
        """Return the coordinates between which the degree is linear."""
        return self.xs

    def within(self, low: float, high: float) -> "Piecewise":
        """Return the part between ``low`` and ``high``, with a point at either end.

        Sets that agree on the range become equal, however they were written.

        Raises:
            ValueError: The core lies outside, or nothing but single points are true inside.
        """
        if self.core[1] < low or self.core[0] > high:
            raise ValueError("the peak is outside the range")
        inside = [(x, y) for x, y in zip(self.xs, self.ys, strict=True) if low <= x <= high]
        if not inside or inside[0][0] > low:
            inside.insert(0, (low, self.degree(low)))
        if inside[-1][0] < high:
            inside.append((high, self.degree(high)))
        part = points(_without_flat_points(list(_tidy_edges(inside, low, high))))
        corners = zip(part.xs, part.ys, strict=True)
        if not any(x < x1 and max(y, y1) > 0.0 for (x, y), (x1, y1) in pairwise(corners)):
            raise ValueError(
                "the set has a degree above 0 at a single point only; make it wider"
            )
        return part


def points(pairs: Iterable[tuple[float, float]]) -> Piecewise:
    """Return the set through points ``(x, degree)``."""
    listed = list(pairs)
    return Piecewise(tuple(real(x) for x, _ in listed), tuple(real(y) for _, y in listed))


def triangle(a: float, b: float, c: float) -> Piecewise:
    """Return the set that rises from ``a`` to its peak ``b`` and falls to ``c``.

    Args:
        a: Left foot.
        b: Peak.
        c: Right foot.
    """
    return points([(a, 0.0), (b, 1.0), (c, 0.0)])


def trapezoid(a: float, b: float, c: float, d: float) -> Piecewise:
    """Return the set that rises from ``a`` to ``b`` and falls from ``c`` to ``d``.

    Args:
        a: Left foot.
        b: Start of the core.
        c: End of the core.
        d: Right foot.
    """
    return points([(a, 0.0), (b, 1.0), (c, 1.0), (d, 0.0)])


def between(x0: float, y0: float, x1: float, y1: float, x: float) -> float:
    """Return the height at ``x`` of the line through two points, ``x0 < x1``.

    Both terms are positive, so that small heights near a foot keep all their digits.

    Args:
        x0, y0: The left point.
        x1, y1: The right point.
        x: Argument.
    """
    if y0 == y1:
        return y0
    height = (y0 * (x1 - x) + y1 * (x - x0)) / (x1 - x0)
    return min(height, max(y0, y1))


def _tidy_edges(
    pairs: Iterable[tuple[float, float]], low: float, high: float
) -> Iterator[tuple[float, float]]:
    """Drop points of vertical edges that change neither a degree nor an integral."""
    for x, group in groupby(pairs, key=lambda pair: pair[0]):
        ys = [y for _, y in group]
        top = max(ys)
        left = ys[0] if x > low else top
        right = ys[-1] if x < high else top
        yield x, left
        if top > max(left, right):
            yield x, top
            yield x, right
        elif right != left:
            yield x, right


def _without_flat_points(pairs: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Drop points whose degree is that of both neighbours."""
    inner = (
        b
        for a, b, c in zip(pairs, pairs[1:], pairs[2:], strict=False)
        if not a[1] == b[1] == c[1]
    )
    return [pairs[0], *inner, pairs[-1]]


FAINTEST = 1e-100
"""Degrees below this count as zero: the far tail of a bell says nothing and would underflow."""

NEGLIGIBLE = 1e-6
"""Where no rule on a quantity holds to this degree, none speaks.

A mean or centre of gravity hardly depends on how small a single degree is: it would take what
is as good as false for true. A bell falls below it beyond five standard deviations.
"""

REACH = math.sqrt(-2 * math.log(FAINTEST))
"""Where a bell falls below the faintest degree, in multiples of its sigma."""


class Gaussian(Struct, frozen=True):
    """A bell: ``exp(-(x - mean)² / (2 sigma²))``, zero below the faintest degree."""

    mean: float
    sigma: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.mean) and math.isfinite(self.sigma) and self.sigma > 0.0):
            raise ValueError("a bell needs a finite mean and a width above zero")

    def degree(self, x: float) -> float:
        """Return how true the word is at ``x``."""
        z = (x - self.mean) / self.sigma
        return exp(-0.5 * z * z) if abs(z) < REACH else 0.0

    @property
    def core(self) -> tuple[float, float]:
        """Return the mean, twice."""
        return self.mean, self.mean

    @property
    def middle(self) -> float:
        """Return the mean."""
        return self.mean

    @property
    def support(self) -> tuple[float, float]:
        """Return the interval outside which the degree counts as zero."""
        return self.mean - REACH * self.sigma, self.mean + REACH * self.sigma

    @property
    def corners(self) -> tuple[float, ...]:
        """Return the coordinates between which the degree is negligible, or is not."""
        reach = self.sigma * math.sqrt(-2.0 * math.log(NEGLIGIBLE))
        return self.mean - reach, self.mean, self.mean + reach

    def within(self, low: float, high: float) -> "Gaussian":
        """Return the bell itself, if its peak and width fit the range.

        Raises:
            ValueError: The mean lies outside, or sigma exceeds the range. (A wider bell is
                no word, being true everywhere, and its integrals would lose digits.)
        """
        if not low <= self.mean <= high:
            raise ValueError("the peak is outside the range")
        if self.sigma > high - low:
            raise ValueError("the bell is wider than the range")
        return self


class Powered(Struct, frozen=True):
    """A set whose degrees are raised to a power; only conditions can use it."""

    base: Piecewise | Gaussian
    exponent: float

    def degree(self, x: float) -> float:
        """Return how true the word is at ``x``."""
        return self.base.degree(x) ** self.exponent

    @property
    def middle(self) -> float:
        """Return the middle of the core, which a power does not move."""
        return self.base.middle

    @property
    def corners(self) -> tuple[float, ...]:
        """Return the coordinates between which the degree is 0, is 1, or lies between."""
        if isinstance(self.base, Gaussian):  # raised to a power it is another bell
            return Gaussian(self.base.mean, self.base.sigma / self.exponent**0.5).corners
        return self.base.corners


Shape: TypeAlias = Piecewise | Gaussian
AnyShape: TypeAlias = Piecewise | Gaussian | Powered


class Word(Struct, frozen=True):
    """A word as written, hedges included, and its set in the coordinate of its scale."""

    text: str
    shape: AnyShape
