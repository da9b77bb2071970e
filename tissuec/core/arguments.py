"""Values that a program in Python gives, checked where they arrive.

A value of another kind is a TypeError that names it, one beyond its limits a ValueError.
"""

from collections.abc import Iterable
from math import isfinite, isnan
from numbers import Integral, Real
from typing import TypeVar

Items = TypeVar("Items", bound=Iterable[object])


def text(value: object, what: str) -> str:
    """Return a text.

    Raises:
        TypeError: It is none.
    """
    if not isinstance(value, str):
        raise TypeError(f"{what} must be a text, not {value!r}")
    return value


def several(values: Items, what: str) -> Items:
    """Return values; a text, which is a sequence of letters, is none.

    Raises:
        TypeError: It is a text, or cannot be iterated over.
    """
    if isinstance(values, str | bytes) or not hasattr(values, "__iter__"):
        raise TypeError(f"{what} must be a list, such as [{values!r}], not {values!r}")
    return values


def count(value: object, what: str, least: int = 1) -> int:
    """Return a whole number.

    Args:
        value: What was given.
        what: What messages call it.
        least: The smallest one that is allowed.

    Raises:
        TypeError: It is no whole number.
        ValueError: It is below ``least``.
    """
    if isinstance(value, bool) or not isinstance(value, Integral):
        raise TypeError(f"{what} must be a whole number, not {value!r}")
    if value < least:
        raise ValueError(f"{what} must be {least} or more, not {value}")
    return int(value)


def number(
    value: object, what: str, *, above: float | None = None, finite: bool = True
) -> float:
    """Return a number.

    Args:
        value: What was given.
        what: What messages call it.
        above: The number must be above this one.
        finite: Whether it must not be infinite.

    Raises:
        TypeError: It is no number.
        ValueError: It is NaN or infinite, too large for a floating-point number, or not above
            ``above``.
    """
    if isinstance(value, bool) or not isinstance(value, Real):
        raise TypeError(f"{what} must be a number, not {value!r}")
    try:
        found = float(value)
    except OverflowError:  # a whole number of hundreds of digits
        raise ValueError(f"{what} is too large for a floating-point number") from None
    if isnan(found) or (finite and not isfinite(found)):
        raise ValueError(f"{what} must be a {'finite ' * finite}number, not {found}")
    if above is not None and found <= above:
        raise ValueError(f"{what} must be above {above:g}, not {found:g}")
    return found
