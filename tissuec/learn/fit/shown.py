"""Learnt values as text."""

from math import ceil, isfinite, log10

from tissuec.core.units import NUMBER, Dimension, show

#: Plain numbers that are parts of something.
PARTS = ("prestress",)


def shown(value: float, dimension: Dimension, what: str = "", *, digits: int = 4) -> str:
    """Return a value with its unit: "12.35 N/m"; a prestress as "2.1 %"."""
    if what in PARTS and dimension == NUMBER and isfinite(value):
        return f"{100.0 * value:.{digits}g} %"
    return show(value, dimension, digits=digits)


def interval(
    low: float, high: float, dimension: Dimension, what: str = "", *, digits: int = 4
) -> str:
    """Return an interval: "1.2 N/m to 1.4 N/m"; "unknown" where it has no end.

    A narrow one is shown with as many digits as its ends need to differ in two of them.
    """
    if not (isfinite(low) and isfinite(high)):
        return "unknown"
    if high > low:
        needed = 2 + ceil(log10(max(abs(low), abs(high)) / (high - low)))
        digits = min(max(digits, needed), 15)
    ends = (shown(end, dimension, what, digits=digits) for end in (low, high))
    return " to ".join(ends)


def percent(part: float) -> str:
    """Return a part of 1 as "3.1 %"."""
    return f"{100.0 * part:.3g} %"
