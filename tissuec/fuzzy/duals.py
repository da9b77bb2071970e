"""Dual numbers: a value with its derivatives.

This is the forward mode of automatic differentiation (R. E. Wengert, Comm. ACM 7:463, 1964).

A :class:`Dual` is a float, so that inference runs on it unchanged: comparisons choose a
branch by the value, and arithmetic carries the slopes along. Functions of :mod:`math` return
bare numbers and lose them; those of this module keep them, and cost bare numbers next to
nothing.
"""

import math
from collections.abc import Iterable
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Slopes: TypeAlias = NDArray[np.float64]

_ERFC = -2.0 / math.sqrt(math.pi)  # slope of erfc at zero


class Dual(float):
    """A number and its derivatives by some parameters, shape (parameter,)."""

    __slots__ = ("slopes",)
    slopes: Slopes

    def __new__(cls, value: float, slopes: Slopes) -> "Dual":
        number = super().__new__(cls, value)
        number.slopes = slopes
        return number

    def __add__(self, other: float) -> "Dual":
        slopes = self.slopes + other.slopes if isinstance(other, Dual) else self.slopes
        return Dual(float.__add__(self, other), slopes)

    __radd__ = __add__

    def __sub__(self, other: float) -> "Dual":
        slopes = self.slopes - other.slopes if isinstance(other, Dual) else self.slopes
        return Dual(float.__sub__(self, other), slopes)

    def __rsub__(self, other: float) -> "Dual":
        return Dual(float.__rsub__(self, other), -self.slopes)

    def __mul__(self, other: float) -> "Dual":
        slopes = self.slopes * float(other)
        if isinstance(other, Dual):
            slopes = slopes + other.slopes * float(self)
        return Dual(float.__mul__(self, other), slopes)

    __rmul__ = __mul__

    def __truediv__(self, other: float) -> "Dual":
        ratio = float.__truediv__(self, other)
        slopes = self.slopes
        if isinstance(other, Dual):
            slopes = slopes - other.slopes * ratio
        return Dual(ratio, slopes / float(other))

    def __rtruediv__(self, other: float) -> "Dual":
        ratio = float.__rtruediv__(self, other)
        return Dual(ratio, self.slopes * (-ratio / float(self)))

    def __pow__(self, exponent: float, modulus: None = None) -> "Dual":  # type: ignore[override]
        value, base = float.__pow__(self, exponent), float(self)
        # At zero a root is infinitely steep; what is false stays so, as far as anyone sees.
        steepness = exponent * value / base if base else 0.0
        return Dual(value, self.slopes * steepness)

    def __neg__(self) -> "Dual":
        return Dual(-float(self), -self.slopes)

    def __pos__(self) -> "Dual":
        return self

    def __abs__(self) -> "Dual":
        return -self if self < 0.0 else self


def slopes_of(number: float, count: int) -> Slopes:
    """Return the derivatives of a number by ``count`` parameters; a bare one has none."""
    return number.slopes if isinstance(number, Dual) else np.zeros(count)


def real(number: float) -> float:
    """Return a number as a float, with its slopes if it has any."""
    return number if isinstance(number, Dual) else float(number)


def snapped(value: float, number: float) -> float:
    """Return a value that replaces a number, with the derivatives of that number."""
    return Dual(value, number.slopes) if isinstance(number, Dual) else float(value)


def exp(x: float) -> float:
    """Return e to the power of ``x``."""
    value = math.exp(x)
    return Dual(value, x.slopes * value) if isinstance(x, Dual) else value


def log(x: float) -> float:
    """Return the natural logarithm of ``x``."""
    value = math.log(x)
    return Dual(value, x.slopes / float(x)) if isinstance(x, Dual) else value


def sqrt(x: float) -> float:
    """Return the square root of ``x``; without slopes at zero, where it has none."""
    value = math.sqrt(x)
    if not isinstance(x, Dual):
        return value
    return Dual(value, x.slopes / (2.0 * value)) if value else 0.0


def erfc(x: float) -> float:
    """Return the complementary error function of ``x``."""
    value = math.erfc(x)
    if not isinstance(x, Dual):
        return value
    return Dual(value, x.slopes * (_ERFC * math.exp(-float(x) * float(x))))


def fsum(numbers: Iterable[float]) -> float:
    """Return the correctly rounded sum."""
    listed = list(numbers)
    value, slopes = math.fsum(listed), [x.slopes for x in listed if isinstance(x, Dual)]
    return Dual(value, np.sum(slopes, axis=0)) if slopes else value
