"""Units on axes: SI prefixes such that numbers range from 1 to 1000."""

from collections.abc import Iterable

import numpy as np
from msgspec import Struct
from numpy.typing import ArrayLike, NDArray

_PREFIXES = ((1e-12, "p"), (1e-9, "n"), (1e-6, "µ"), (1e-3, "m"), (1.0, ""),
             (1e3, "k"), (1e6, "M"), (1e9, "G"))  # fmt: skip
#: Unit of a file -> what of it is shown with prefixes: a factor, the symbol that takes the
#: prefix, and what stands behind it.
_SHOWN = {
    "m^3": (1e3, "l", ""),
    "m^3/s": (1e3, "l", "/s"),
    "kg": (1e3, "g", ""),
    "kg*m/s": (1.0, "N", "*s"),
}
_TAKE_PREFIXES = ("m", "s", "N", "J", "W", "Pa", "Hz")
_LARGEST = {"s": "", "g": "k", "l": ""}  # there are no kiloseconds or megagrams
_LEAST = {"s": 0.1}  # 0.4 s rather than 400 ms
_ROUNDING = 0.9995


class AxisUnit(Struct, frozen=True):
    """Unit of an axis for numbers in an SI unit.

    Attributes:
        factor: What they are multiplied by.
        unit: What they are then in, such as "mN"; empty for plain numbers.
    """

    factor: float
    unit: str

    def of(self, values: ArrayLike) -> NDArray[np.float64]:
        """Return numbers in the unit of the axis, in the shape of ``values``.

        Args:
            values: In SI units.
        """
        return np.asarray(values, dtype=float) * self.factor

    def label(self, name: str) -> str:
        """Return the label of the axis."""
        return f"{name} [{self.unit}]" if self.unit else name


def scale_of(unit: str, values: Iterable[ArrayLike]) -> AxisUnit:
    """Return the scale for the size of numbers.

    Args:
        unit: As files and `si_unit` spell it, such as "N*s/m".
        values: In that unit, of any shape; those that are not finite are ignored.
    """
    factor, symbol, rest = _SHOWN.get(unit) or _split(unit)
    if not symbol:
        return AxisUnit(factor, readable(rest))
    largest = factor * largest_of(values)
    size, prefix = _prefix(symbol, largest)
    return AxisUnit(factor / size, readable(f"{prefix}{symbol}{rest}"))


def largest_of(values: Iterable[ArrayLike]) -> float:
    """Return the largest absolute value; 0 if there are none."""
    found = 0.0
    for some in values:
        sizes = np.abs(np.asarray(some, dtype=float))
        found = max(found, float(sizes[np.isfinite(sizes)].max(initial=0.0)))
    return found


def readable(unit: str) -> str:
    """Return a unit as people write it: N·s/m, mm², m³."""
    return unit.replace("*", "·").replace("^2", "²").replace("^3", "³")


def _split(unit: str) -> tuple[float, str, str]:
    """Return factor, symbol with prefix, and rest; no symbol where none can take a prefix."""
    for symbol in _TAKE_PREFIXES:
        rest = unit.removeprefix(symbol)
        if rest != unit and (not rest or rest[0] in "*/"):
            return 1.0, symbol, rest
    return 1.0, "", unit


def _prefix(symbol: str, largest: float) -> tuple[float, str]:
    """Return the size of a prefix and its letter."""
    if largest == 0.0:
        return (1e-3, "m") if symbol == "m" else (1.0, "")
    least = _ROUNDING * _LEAST.get(symbol, 1.0)
    fitting = [p for p in _PREFIXES if least * p[0] <= largest] or [_PREFIXES[0]]
    names = [name for _, name in _PREFIXES]
    most = names.index(_LARGEST.get(symbol, "G"))
    return min(fitting[-1], _PREFIXES[most])
