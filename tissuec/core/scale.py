"""Numbers in the unit in which people see them: on axes, in tables of pages, in CSV."""

import re
from collections.abc import Iterable
from decimal import Decimal
from math import isfinite

import numpy as np
from msgspec import Struct
from numpy.typing import ArrayLike, NDArray

from tissuec.core.prefixes import shown_unit
from tissuec.core.units import rounded

_ROUNDING = 1e-6  # of numbers of single precision, and of what is computed from these
_SMALL, _LARGE = -7, 17  # exponents of numbers that are written without one
_MICRO = re.compile(r"\bu(?=[A-Za-z])")


class AxisUnit(Struct, frozen=True):
    """Unit of an axis for numbers in an SI unit.

    Attributes:
        power: The unit is 10**power of the SI unit.
        spelled: Its name, as texts and files spell it: "uJ", "N*s/m"; empty for plain numbers.
    """

    power: int
    spelled: str

    @property
    def factor(self) -> float:
        """Return the factor from numbers in the SI unit to this unit."""
        return float(f"1e{-self.power}")

    @property
    def unit(self) -> str:
        """Return the unit as people write it: µJ, N·s/m."""
        return readable(self.spelled)

    def of(self, values: ArrayLike) -> NDArray[np.float64]:
        """Return numbers in the unit of the axis, in the shape of ``values``.

        Args:
            values: In SI units.
        """
        return np.asarray(values, dtype=float) * self.factor

    def exactly(self, values: Iterable[float]) -> list[float | str]:
        """Return numbers in the unit with the digits that they have in the SI unit.

        A product in binary is rounded, and has further digits: 12.299999999999999 for 0.0123.

        Args:
            values: In SI units.
        """
        if not self.power:
            return [*values]
        return [
            _plain(Decimal(repr(one)).scaleb(-self.power)) if isfinite(one) else one
            for one in values
        ]

    def label(self, name: str) -> str:
        """Return the label of the axis."""
        return f"{name} [{self.unit}]" if self.spelled else name

    def text(self, value: float, *, digits: int = 3) -> str:
        """Return a value as text, such as "0.7 s".

        Args:
            value: In the SI unit.
            digits: Number of significant digits.
        """
        return f"{rounded(float(self.of(value)), digits)} {self.unit}".rstrip()


PERCENT = AxisUnit(-2, "%")


def scale_of(unit: str, values: Iterable[ArrayLike]) -> AxisUnit:
    """Return the unit for the size of numbers.

    Args:
        unit: As files and `si_unit` spell it, such as "N*s/m".
        values: In that unit, of any shape; those that are not finite are ignored.
    """
    return AxisUnit(*shown_unit(unit, largest_of(values)))


def snapped(value: float, size: float) -> float:
    """Return a number, but 0 where it is the rounding error of numbers of some size.

    Args:
        value: In any unit.
        size: Of the numbers that it is computed from, in the same unit.
    """
    return 0.0 if abs(value) < _ROUNDING * size else value


def largest_of(values: Iterable[ArrayLike]) -> float:
    """Return the largest absolute value; 0 if there are none.

    Args:
        values: In one unit, of any shape; those that are not finite are ignored.
    """
    found = 0.0
    for some in values:
        sizes = np.abs(np.asarray(some, dtype=float))
        found = max(found, float(sizes[np.isfinite(sizes)].max(initial=0.0)))
    return found


def _plain(number: Decimal) -> str:
    """Return a number without an exponent, unless it would have many zeros."""
    return f"{number:f}" if _SMALL < number.adjusted() < _LARGE else str(number)


def readable(unit: str) -> str:
    """Return a unit as people write it: µJ, N·s/m, mm², m³."""
    text = unit.replace("*", "·").replace("^2", "²").replace("^3", "³")
    return _MICRO.sub("µ", text)
