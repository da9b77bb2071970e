"""Units in which numbers are shown: one rule for messages, tables, pictures, pages, files."""

import math
from functools import cache
from typing import NamedTuple

#: SI units of which people use a multiple with a name of its own: the power of ten [SI] of what
#: takes the prefix, its symbol, and the rest of the unit.
_RENAMED = {
    "m^3": (-3, "l", ""),
    "m^3/s": (-3, "l", "/s"),
    "kg": (-3, "g", ""),
    "kg*m/s": (0, "N", "*s"),
}
_TAKE_PREFIXES = ("m", "s", "N", "J", "W", "Pa", "Hz")
_POWERS = {"n": -9, "u": -6, "m": -3, "": 0, "k": 3, "M": 6, "G": 9}
#: SI units of which larger numbers have no multiple: a thousand litres are a cubic metre.
_BEYOND = ("m^3", "m^3/s")
#: Of units that take no larger ones: there are no kiloseconds or megagrams.
_LARGEST = {"s": "", "l": "", "l/s": "", "g": "k", "m": "k", "m/s": "", "m/s^2": ""}


class ShownUnit(NamedTuple):
    """A unit in which numbers are shown: 10**power of the SI unit."""

    power: int
    unit: str

    @property
    def size(self) -> float:
        """Return the size of the unit, in the SI unit."""
        return float(f"1e{self.power}")


@cache
def shown_units(unit: str) -> tuple[ShownUnit, ...]:
    """Return the units in which numbers in an SI unit are shown, the smallest first.

    Args:
        unit: As `si_unit` spells it, such as "N*s/m"; any other is its only one.
    """
    power, symbol, rest = _RENAMED.get(unit) or _split(unit)
    if not symbol:
        return (ShownUnit(0, unit),)
    most = _POWERS[_LARGEST.get(f"{symbol}{rest}", "G")]
    known = tuple(
        ShownUnit(power + size, f"{prefix}{symbol}{rest}")
        for prefix, size in _POWERS.items()
        if size <= most
    )
    return (*known, ShownUnit(0, unit)) if unit in _BEYOND else known


def shown_unit(unit: str, largest: float, *, digits: int = 3) -> ShownUnit:
    """Return the unit in which a number is between 1 and 1000: mN, N, mm, ml, kPa, uJ, ms, …

    Args:
        unit: SI unit of the number, as `si_unit` spells it.
        largest: The number, or the largest magnitude of several; 0 has no prefix.
        digits: Number of significant digits that are shown: 0.99999 mN is 1 mN.
    """
    known = shown_units(unit)
    if largest == 0.0 or not math.isfinite(largest):
        plain = known[:-1] if unit in _BEYOND else known
        return next((one for one in plain if one.power == 0), plain[-1])
    # Half a unit in the last digit, so that 0.9999 mm is shown as 1 mm and not 1e+03 um.
    least = 1.0 - 0.5 * 10.0**-digits
    return next((one for one in known[::-1] if abs(largest) >= least * one.size), known[0])


def _split(unit: str) -> tuple[int, str, str]:
    """Split a unit into the symbol that takes a prefix and the rest; "" if none does."""
    for symbol in _TAKE_PREFIXES:
        rest = unit.removeprefix(symbol)
        if rest != unit and (not rest or rest[0] in "*/"):
            return 0, symbol, rest
    return 0, "", unit
