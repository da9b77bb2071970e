"""The range of a field, as ``--range`` takes it."""

import re
from math import isfinite

from tissuec.core.prefixes import shown_units
from tissuec.core.units import NUMBER, Unit, UnitError, parse_unit
from tissuec.view.player.fields import NodeField

_NUMBER = r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?)\s*((?!to\b)[^\s,\d.+…-][^,.…]*?)?\s*"
_RANGE = re.compile(rf"{_NUMBER}(?:,|\.\.\.?|…|\bto\b){_NUMBER}", re.IGNORECASE)


def field_range(text: str, field: NodeField) -> tuple[float, float]:
    """Return the range that a text states, in the SI unit of a field.

    The unit of the second number is that of the first one too, unless that has its own.

    Args:
        text: Such as "0,2 mm", "-5 %,5 %" or "0 .. 20 %".
        field: The field.

    Raises:
        ValueError: It is none; says what to write.
    """
    example = f'write --range "0,{_round(field)}"'
    found = _RANGE.fullmatch(text)
    if found is None:
        raise ValueError(f'"{text}" does not have the form LOW,HIGH; {example}')
    low, high = (
        _size(float(number), unit or found[4] or "", field, example)
        for number, unit in ((found[1], found[2]), (found[3], found[4]))
    )
    if not low < high:
        raise ValueError(f'the first number of "{text}" must be smaller than the second')
    return low, high


def _size(value: float, unit: str, field: NodeField, example: str) -> float:
    if not unit and value != 0.0:
        raise ValueError(f"a range of {field.name} needs a unit; {example}")
    try:
        given = parse_unit(unit) if unit else _own(field)
    except UnitError as error:
        raise ValueError(f"{error}; {example}") from error
    if given.dimension != _own(field).dimension:
        raise ValueError(f'"{unit}" is not a unit of {field.name}; {example}')
    size = value * given.factor
    if not isfinite(size):
        raise ValueError(f"a number of this range is too large; {example}")
    return size


def _own(field: NodeField) -> Unit:
    return parse_unit(field.unit) if field.unit else Unit(1.0, NUMBER)


def _round(field: NodeField) -> str:
    """Return a number with a unit that people use for a field."""
    if not field.unit:
        return "20 %"
    small = [one.unit for one in shown_units(field.unit) if one.unit.startswith(("m", "k"))]
    return f"2 {next((unit for unit in small if unit != field.unit), field.unit)}"
