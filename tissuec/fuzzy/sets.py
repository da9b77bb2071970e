"""Fuzzy sets: the degree of a word at each place of its scale.

(L. A. Zadeh, Information and Control 8:338, 1965.)

Every coordinate here is the coordinate of the scale: the quantity itself, or its logarithm.
"""

import math
from typing import TypeAlias

from msgspec import Struct

from tissuec.fuzzy.duals import exp
from tissuec.fuzzy.piecewise import Piecewise

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
