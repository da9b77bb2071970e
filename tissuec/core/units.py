"""Units and dimensions: a small table of our own, converting to SI base units at the door.

Only mechanical units are needed, so a dimension is three exponents. Angles and percentages are
plain numbers (rad = 1, % = 0.01).
"""

import math
import re
from functools import cache
from typing import NamedTuple

from tissuec.core.hints import Edit, Hint, did_you_mean
from tissuec.core.prefixes import shown_unit, shown_units


class Dimension(NamedTuple):
    """Exponents of kilogram, metre and second."""

    mass: float = 0
    length: float = 0
    time: float = 0

    def __mul__(self, other: "Dimension") -> "Dimension":  # type: ignore[override]
        return Dimension(*(a + b for a, b in zip(self, other, strict=True)))

    def __truediv__(self, other: "Dimension") -> "Dimension":
        return Dimension(*(a - b for a, b in zip(self, other, strict=True)))

    def __pow__(self, exponent: float) -> "Dimension":
        return Dimension(*(a * exponent for a in self))


NUMBER = Dimension()
MASS = Dimension(mass=1)
LENGTH = Dimension(length=1)
TIME = Dimension(time=1)
FREQUENCY = NUMBER / TIME
AREA = LENGTH**2
VOLUME = LENGTH**3
FLOW = VOLUME / TIME
DENSITY = MASS / VOLUME
VELOCITY = LENGTH / TIME
ACCELERATION = VELOCITY / TIME
MOMENTUM = MASS * VELOCITY
FORCE = MASS * ACCELERATION
ENERGY = FORCE * LENGTH
POWER = ENERGY / TIME
PRESSURE = FORCE / AREA
STIFFNESS = FORCE / LENGTH
VISCOSITY = FORCE / VELOCITY
SLOWNESS = TIME / LENGTH
PRESSURE_TIME = PRESSURE * TIME
AREAL_VISCOSITY = PRESSURE / VELOCITY
AREAL_STIFFNESS = PRESSURE / LENGTH

#: What to call a dimension in messages, and the SI unit to show it in.
DIMENSION_NAMES: dict[Dimension, tuple[str, str]] = {
    NUMBER: ("a plain number", ""),
    MASS: ("a mass", "kg"),
    LENGTH: ("a length", "m"),
    TIME: ("a time", "s"),
    FREQUENCY: ("a frequency or a rate", "1/s"),
    AREA: ("an area", "m^2"),
    VOLUME: ("a volume", "m^3"),
    FLOW: ("a flow", "m^3/s"),
    VELOCITY: ("a speed", "m/s"),
    ACCELERATION: ("an acceleration", "m/s^2"),
    MOMENTUM: ("a momentum", "kg*m/s"),
    FORCE: ("a force", "N"),
    ENERGY: ("an energy", "J"),
    POWER: ("a power", "W"),
    PRESSURE: ("a pressure", "Pa"),
    STIFFNESS: ("force per length", "N/m"),
    VISCOSITY: ("force per speed", "N*s/m"),
    SLOWNESS: ("time per length", "s/m"),
    DENSITY: ("a density", "kg/m^3"),
    PRESSURE_TIME: ("a dynamic viscosity", "Pa*s"),
    AREAL_VISCOSITY: ("a pressure per speed", "Pa*s/m"),
    AREAL_STIFFNESS: ("a pressure per length", "Pa/m"),
}

_PREFIXES = {
    "": 1.0,
    "n": 1e-9,
    "u": 1e-6,
    "m": 1e-3,
    "c": 1e-2,
    "d": 1e-1,
    "k": 1e3,
    "M": 1e6,
    "G": 1e9,
}
_PREFIXED = {
    "m": (1.0, LENGTH),
    "g": (1e-3, MASS),
    "s": (1.0, TIME),
    "N": (1.0, FORCE),
    "Pa": (1.0, PRESSURE),
    "J": (1.0, ENERGY),
    "W": (1.0, POWER),
    "Hz": (1.0, FREQUENCY),
    "l": (1e-3, VOLUME),
}
_PLAIN = {
    "min": (60.0, TIME),
    "deg": (math.pi / 180.0, NUMBER),
    "rad": (1.0, NUMBER),
    "%": (0.01, NUMBER),
    # The conventional millimetre of mercury: NIST Special Publication 811 (2008), B.8.
    "mmHg": (133.322387415, PRESSURE),
}
#: Symbol -> (factor to SI, dimension). Micro is written u, µ (U+00B5) or μ (U+03BC).
SYMBOLS: dict[str, tuple[float, Dimension]] = _PLAIN | {
    spelling + unit: (_PREFIXES[prefix] * factor, dimension)
    for unit, (factor, dimension) in _PREFIXED.items()
    for prefix in _PREFIXES
    for spelling in (("u", "µ", "μ") if prefix == "u" else (prefix,))
}

FROM_KILO = 1e4  # of a unit, from which on a thousand of it is shown: 1400 J/m^2, 20 kJ/m^2

#: What people mean by 1 g of gravity [m/s^2]: CGPM, 1901.
STANDARD_GRAVITY = 9.80665

#: How units are called where they are not written with their symbols.
_SPOKEN = {
    "meter": "m", "metre": "m", "gram": "g", "second": "s", "sec": "s", "newton": "N",
    "pascal": "Pa", "joule": "J", "watt": "W", "hertz": "Hz", "liter": "l", "litre": "l",
    "minute": "min", "degree": "deg", "radian": "rad", "percent": "%",
}  # fmt: skip
#: Units of other systems, by their value in SI: NIST Special Publication 811 (2008), B.8.
_FOREIGN: dict[str, tuple[float, Dimension]] = {
    **dict.fromkeys(("in", "inch", "inches"), (0.0254, LENGTH)),
    **dict.fromkeys(("ft", "foot", "feet"), (0.3048, LENGTH)),
    **dict.fromkeys(("yd", "yard"), (0.9144, LENGTH)),
    **dict.fromkeys(("angstrom", "Å"), (1e-10, LENGTH)),
    **dict.fromkeys(("micron", "microns"), (1e-6, LENGTH)),
    **dict.fromkeys(("lb", "lbs", "lbm", "pound", "pounds"), (0.45359237, MASS)),
    **dict.fromkeys(("oz", "ounce", "ounces"), (0.028349523125, MASS)),
    **dict.fromkeys(("t", "ton", "tonne"), (1e3, MASS)),
    **dict.fromkeys(("lbf", "lbsf"), (4.4482216152605, FORCE)),
    **dict.fromkeys(("kgf", "kp"), (9.80665, FORCE)),
    **dict.fromkeys(("gf", "p", "pond"), (9.80665e-3, FORCE)),
    **dict.fromkeys(("dyn", "dyne", "dynes"), (1e-5, FORCE)),
    **dict.fromkeys(("psi", "PSI"), (6894.757293168, PRESSURE)),
    "bar": (1e5, PRESSURE),
    "mbar": (1e2, PRESSURE),
    "atm": (101325.0, PRESSURE),
    **dict.fromkeys(("torr", "Torr"), (101325.0 / 760, PRESSURE)),
    **dict.fromkeys(("cmH2O", "cmh2o", "cmH20"), (98.0665, PRESSURE)),
    **dict.fromkeys(("mmH2O", "mmh2o"), (9.80665, PRESSURE)),
    **dict.fromkeys(("P", "poise", "Poise"), (0.1, PRESSURE_TIME)),
    **dict.fromkeys(("cP", "cps"), (1e-3, PRESSURE_TIME)),
    "erg": (1e-7, ENERGY),
    "cal": (4.184, ENERGY),
    **dict.fromkeys(("cc", "ccm", "CC"), (1e-6, VOLUME)),
    **dict.fromkeys(("h", "hr", "hrs", "hour", "hours"), (3600.0, TIME)),
    **dict.fromkeys(("d", "day", "days"), (86400.0, TIME)),
    **dict.fromkeys(("rpm", "bpm"), (1 / 60, FREQUENCY)),
    **dict.fromkeys(("rev", "revolution", "revolutions", "turns"), (2 * math.pi, NUMBER)),
}
#: Units that nobody means.
_UNUSUAL = frozenset(prefix + unit for prefix in "MG" for unit in "mgsl")
_TEMPERATURES = frozenset(
    ("c", "k", "degc", "degf", "degk", "celsius", "fahrenheit", "kelvin", "degcelsius")
)
_SPOKEN_PREFIXES = {
    "nano": "n", "micro": "u", "milli": "m", "centi": "c", "deci": "d", "kilo": "k",
    "mega": "M", "giga": "G", **{prefix: prefix for prefix in _PREFIXES},
}  # fmt: skip

#: For messages.
ALL_UNITS = "units are m, g, s, N, Pa, J, W, Hz and l, also as mm or kPa, and min, deg, %, mmHg"

#: For messages about °C and K.
NO_TEMPERATURES = "temperatures are not part of the language"

#: Beyond, a unit is a slip, and its factor would leave the range of numbers.
LARGEST_EXPONENT = 9


class Unit(NamedTuple):
    """A unit: its value in SI base units, and its dimension."""

    factor: float
    dimension: Dimension


class UnitError(ValueError):
    """The text is not a unit; ``symbol`` is the part that is not known."""

    def __init__(self, symbol: str):
        self.symbol = symbol
        super().__init__(f'"{symbol}" is not a unit')


_STEP = re.compile(r"([*/·]?)(cmH2O|cmH20|cmh2o|mmH2O|mmh2o|[^\W\d_]+|%)(?:\^(-?\d+))?")


def parse_unit(text: str) -> Unit:
    """Return the unit that ``text`` spells, such as ``mm``, ``N*s/m`` or ``kg/m^3``.

    Raises:
        UnitError: A symbol is not in the table, or the text has another form.
    """
    return _parsed(text, False)


@cache
def _parsed(text: str, has_foreign: bool) -> Unit:
    factor, dimension, position = 1.0, NUMBER, 0
    compact = text.replace(" ", "")
    while position < len(compact):
        step = _STEP.match(compact, position)
        if step is None or (position > 0) != bool(step[1]):
            raise UnitError(compact[position:] or text)
        position = step.end()
        symbol = SYMBOLS.get(step[2]) or (_FOREIGN.get(step[2]) if has_foreign else None)
        if symbol is None:
            raise UnitError(step[2])
        size, kind = symbol
        exponent = int(step[3] or 1) * (-1 if step[1] == "/" else 1)
        if abs(exponent) > LARGEST_EXPONENT:
            raise UnitError(step[0])
        factor *= size**exponent
        dimension = dimension * kind**exponent
    if not compact:
        raise UnitError(text)
    return Unit(factor, dimension)


def canonical_unit(text: str) -> str:
    """Return the spelling that ``fmt`` writes: no blanks, ``*`` for ``·``, ``u`` for micro."""
    return text.replace(" ", "").replace("·", "*").replace("µ", "u").replace("μ", "u")


def unit_pattern() -> str:
    """Return a regular expression that matches any unit directly after a number."""
    symbols = "|".join(sorted(map(re.escape, SYMBOLS), key=len, reverse=True))
    one = rf"(?:{symbols})(?![^\W\d_]|_)(?:\^-?[0-9]+)?(?!\w)"
    # Before a bracket, it is the name of a function: 2 N*min(…) is no number of newton minutes.
    return rf"{one}(?:[*/·]{one}(?![ \t]*\())*"


def show_interval(first: float, last: float) -> str:
    """Return an interval of time [s]: ``0 s to 300 ms``."""
    return f"{show(first, TIME)} to {show(last, TIME)}"


def describe(dimension: Dimension) -> str:
    """Return a dimension in words with its SI unit, such as ``a force (N)``."""
    name, unit = DIMENSION_NAMES.get(dimension, ("a quantity", si_unit(dimension)))
    return f"{name} ({unit})" if unit else name


def si_unit(dimension: Dimension) -> str:
    """Return the SI unit of a dimension, named where it has a name: ``N/m``, ``kg*m^3``."""
    if dimension in DIMENSION_NAMES:
        return DIMENSION_NAMES[dimension][1]
    parts = [
        symbol if exponent == 1 else f"{symbol}^{exponent:g}"
        for symbol, exponent in zip(("kg", "m", "s"), dimension, strict=True)
        if exponent
    ]
    return "*".join(parts)


def written_unit(dimension: Dimension) -> str:
    """Return the SI unit of a dimension as it can follow a number."""
    # A number cannot be followed by the 1 of 1/s.
    return "Hz" if dimension == FREQUENCY else si_unit(dimension)


def suggested_unit(dimension: Dimension) -> str:
    """Return the unit to propose where one was forgotten: ``mm`` rather than ``m``."""
    usual = {LENGTH: "mm", VOLUME: "ml", FLOW: "ml/s", PRESSURE: "kPa"}
    return usual.get(dimension) or written_unit(dimension)


def show(value: float, dimension: Dimension, *, digits: int = 3) -> str:
    """Return a value as text for users: ``3.16 mN*s/m``, ``4.27 mm``, ``0.25``.

    Args:
        value: In SI units.
        digits: Number of significant digits.
    """
    return show_si(value, si_unit(dimension), digits=digits)


def show_apart(first: float, second: float, dimension: Dimension) -> tuple[str, str]:
    """Return two different values as texts that differ: ``100.75 ms``, ``100.74 ms``.

    Args:
        first, second: In SI units.
    """
    one, other = "", ""
    for digits in range(3, 18):  # 17 tell apart all numbers
        one, other = (show(value, dimension, digits=digits) for value in (first, second))
        if one != other:
            break
    return one, other


def show_si(value: float, unit: str, *, digits: int = 3) -> str:
    """Return a value as text for users.

    Args:
        value: In an SI unit.
        unit: That unit, as `si_unit` spells it.
        digits: Number of significant digits.
    """
    chosen = shown_unit(unit, value, digits=digits)
    if value == 0.0 or not math.isfinite(value):
        return f"{value:g} {chosen.unit}".rstrip()
    return f"{rounded(value / chosen.size, digits)} {chosen.unit}".rstrip()


def rounded(value: float, digits: int = 3) -> str:
    """Return a number with so many significant digits: 1050 and not 1.05e+03."""
    return f"{float(f'{value:.{digits}g}'):.{max(digits, 6)}g}"


def show_in(value: float, unit: str, *, digits: int = 3) -> str:
    """Return a value as text in the unit that somebody wrote, such as ``33 ml``.

    Args:
        value: In SI units.
        unit: As it was written.
        digits: Number of significant digits.
    """
    return f"{rounded(value / parse_unit(unit).factor, digits)} {unit}".rstrip()


def show_or_kilo(value: float, unit: str, *, digits: int = 3) -> str:
    """Return a value as text in a unit, or in a thousand of it from 10 000 on: ``20 kJ/m^2``.

    Args:
        value: In SI units.
        unit: Without a prefix.
        digits: Number of significant digits.
    """
    return show_in(value, f"k{unit}" if abs(value) >= FROM_KILO else unit, digits=digits)


def converted(number: str, unit: str) -> str | None:
    """Return an amount in a unit of another system as it is written here: 5.08 mm for 0.2 in.

    Returns:
        None if the unit is not known there either.
    """
    try:
        found = _parsed(unit, True)
    except UnitError:
        return None
    value = float(number) * found.factor
    if found.dimension == NUMBER:
        return f"{rounded(math.degrees(value), 7)} deg"
    if found.dimension == VOLUME:
        return f"{rounded(value * 1e6, 7)} ml"
    if len(shown_units(si_unit(found.dimension))) == 1:
        return f"{rounded(value, 7)} {written_unit(found.dimension)}"
    return show(value, found.dimension, digits=7)


def alternatives_of(first: str, second: str) -> str:
    """Return the signs that two units side by side can lack, the likely one first.

    Empty for two of one kind, such as ms and s, of which one is a slip.
    """
    one, two = parse_unit(first).dimension, parse_unit(second).dimension
    if one == two:
        return ""
    # Few write a moment or an energy so: N mm is a spring constant.
    is_product = one * two in DIMENSION_NAMES and one * two != ENERGY
    return "/*" if one / two in DIMENSION_NAMES and not is_product else "*/"


def keeping_prefix(written: str, dimension: Dimension) -> str | None:
    """Return the unit of a dimension with the prefix of another unit: mN*s/m for mPa*s.

    Returns:
        None if there is none of the same value in SI units, so that a number would change.
    """
    if dimension == NUMBER:
        return "" if parse_unit(written).factor == 1.0 else None
    target = written_unit(dimension)
    bare = target.removeprefix("k") if target.startswith("kg") else target
    symbol = _STEP.match(written)
    assert symbol is not None
    whole = symbol[2]
    prefixes = [whole.removesuffix(base) for base in _PREFIXED if whole.endswith(base)]
    for prefix in prefixes if whole not in _PREFIXED else ("",):
        unit = f"{prefix}{bare}"
        try:
            same = math.isclose(parse_unit(unit).factor, parse_unit(written).factor)
        except UnitError:
            continue
        if same:
            return unit
    return None


def near_unit(word: str) -> Hint:
    """Return a hint about a word that is no unit, such as a near one, or an empty hint."""
    if word.lower() in _TEMPERATURES:
        return Hint(NO_TEMPERATURES)
    if amount := converted("1", word):
        return Hint(f"write it in other units: 1 {word} is {amount}")
    same = [symbol for symbol in SYMBOLS if symbol.lower() == word.lower()]
    same = [symbol for symbol in same if symbol not in _UNUSUAL]
    if symbol := _spoken(word.lower()) or (same[0] if same else ""):
        return Hint(f'did you mean "{symbol}"?', Edit(symbol))
    return did_you_mean(word, SYMBOLS)


def _spoken(word: str) -> str:
    """Return the symbol of a unit by its name, such as ms for milliseconds, or nothing."""
    for prefix, short in _SPOKEN_PREFIXES.items():
        for name in (word.removeprefix(prefix), word.removeprefix(prefix).removesuffix("s")):
            symbol = short + _SPOKEN.get(name, "?")
            if word.startswith(prefix) and symbol in SYMBOLS:
                return symbol
    return ""
