"""Numbers as text: exactly, or to the precision that is known."""

import math
from collections.abc import Iterator

from tissuec.core.prefixes import shown_units
from tissuec.core.units import NUMBER, Dimension, parse_unit, si_unit

LEAST = 6  # significant digits of what was learnt
BEYOND = 2  # digits after the first one in which the interval is seen
MOST = 17  # this many distinguish every number from the next
_PERCENT = (0.01, "%")


def learnt(
    value: float, low: float, high: float, dimension: Dimension, *, percent: bool = False
) -> str:
    """Return a learnt value with its unit, and with as many digits as its interval needs."""
    factor, unit = _scale(value, dimension, percent=percent)
    return f"{_plain(value / factor, digits(value, low, high))} {unit}".rstrip()


def _plain(value: float, count: int) -> str:
    """Return a number with so many significant digits, without an exponent where it can be."""
    return repr(float(f"{value:.{count}g}")).removesuffix(".0")


def digits(value: float, low: float, high: float) -> int:
    """Return how many significant digits a value needs for its interval to be resolved."""
    half = (high - low) / 2.0
    if value == 0.0 or not math.isfinite(half) or half <= 0.0:
        return LEAST
    needed = math.ceil(math.log10(max(abs(value) / half, 1.0))) + BEYOND
    return min(max(needed, LEAST), MOST)


def exact(value: float, dimension: Dimension, *, percent: bool = False) -> str:
    """Return the shortest text that is read as exactly this value, which is finite.

    Where no number of another unit is exactly this one, it is in SI units.
    """
    for amount, factor, unit in _spellings(value, dimension, percent=percent):
        if float(amount) * factor == value:
            return f"{amount} {unit}".rstrip()
    return f"{value!r} {si_unit(dimension)}".rstrip()


def _spellings(
    value: float, dimension: Dimension, *, percent: bool
) -> Iterator[tuple[str, float, str]]:
    factor, unit = _scale(value, dimension, percent=percent)
    for count in range(1, MOST + 1):
        yield _plain(value / factor, count), factor, unit


def _scale(value: float, dimension: Dimension, *, percent: bool) -> tuple[float, str]:
    """Return the unit in which a value is easiest to read, and what it is in SI."""
    if percent and dimension == NUMBER:
        return _PERCENT
    known = shown_units(si_unit(dimension))
    chosen = ([one for one in known if one.size <= abs(value)] or known[:1])[-1]
    factor = parse_unit(chosen.unit).factor if chosen.unit else 1.0
    return factor, chosen.unit  # as it is read: not quite 1e-12 for ng
