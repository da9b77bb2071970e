"""Numerals for places of a scale: as few digits as needed, in the unit of the text."""

import math
import re

from tissuec.core.prefixes import shown_units
from tissuec.core.units import Dimension, parse_unit, si_unit
from tissuec.fuzzy.axis import Axis
from tissuec.lang import syntax as s

_NUMERAL = re.compile(r"[0-9]+(\.[0-9]+)?([eE][+-]?[0-9]+)?")
_MOST_DIGITS = 17  # that a float can represent
_SAME = 15  # digits that survive a change of units

#: As a part of the smallest gap: what a rounded place may differ by.
CLOSE = 1e-11


class Numerals:
    """Numerals for the places of one scale.

    A place that is written several times gets the same numeral everywhere, so that corners that
    are shared stay shared in the text.

    Args:
        gap: The smallest distance between places, in the coordinate.
        close: Allowed deviation of a written place, as a part of the gap.
    """

    def __init__(self, axis: Axis, dimension: Dimension, gap: float, close: float = CLOSE):
        self._axis = axis
        self._dimension = dimension
        self._near = max(close * gap, axis.rounding)
        #: Numerals with the sizes of their units, by place.
        self._written: dict[float, tuple[str, float]] = {}

    def place(self, place: float, node: s.Expression | None = None) -> str:
        """Return a coordinate as a number with its unit, that of ``node`` if it has one."""
        value = math.exp(place) if self._axis.log else place
        factor, unit = self._unit(value, node)
        if place not in self._written:
            texts = _numerals(value / factor)
            close = (t for t in texts if self._is_close(float(t) * factor, place))
            self._written[place] = next(close, texts[-1]), factor
        text, written_in = self._written[place]
        if written_in != factor:
            text = f"{float(text) * written_in / factor:.{_SAME}g}"
        return text + unit

    def value(self, place: float) -> float:
        """Return the value of the numeral at a place."""
        text, factor = self._written[place]
        return float(text) * factor

    def width(self, value: float, node: s.Expression) -> str:
        """Return a positive number with its unit, to nearly all digits."""
        factor, unit = self._unit(value, node)
        texts = _numerals(value / factor)
        close = (t for t in texts if abs(float(t) * factor - value) <= CLOSE * value)
        return next(close, texts[-1]) + unit

    def _is_close(self, value: float, place: float) -> bool:
        if self._axis.log:
            return value > 0.0 and abs(math.log(value) - place) <= self._near
        return abs(value - place) <= self._near

    def _unit(self, value: float, node: s.Expression | None) -> tuple[float, str]:
        """Return the size of a unit and how it is written after a number."""
        match node:
            case s.Signed(operand=s.Number() | s.Quantity() as operand):
                return self._unit(value, operand)
            case s.Number():
                return 1.0, ""
            case s.Quantity(unit=unit, span=span):
                return parse_unit(unit).factor, _NUMERAL.sub("", span.text, count=1)
            case _:
                known = shown_units(si_unit(self._dimension))
                chosen = ([one for one in known if one.size <= abs(value)] or known[:1])[-1]
                return chosen.size, f" {chosen.unit}".rstrip()


def _numerals(value: float) -> list[str]:
    """Return a number with more and more digits; the last one is exact."""
    texts = [f"{value:.{digits}g}" for digits in range(3, _MOST_DIGITS)]
    return [*texts, repr(float(value))]
