"""A range where one number is needed, such as ``5-6 kPa``: what to write instead."""

import re

from tissuec.core.hints import Edit, Hint
from tissuec.core.source import Span
from tissuec.lang.tokens import NUMBER_PATTERN

MESSAGE = "one number is needed here, not a range"

#: A number without a unit, and the unit after a number.
_BARE = re.compile(rf"-?{NUMBER_PATTERN}")
_UNIT = re.compile(rf"-?{NUMBER_PATTERN}\s*(\D.*)")

#: What begins a line on which a range can be tested, and the text before its numbers there.
_TESTED = re.compile(r"\s*(?:expect|when|set)\b|.*\bwhere\b")
_SIGN = re.compile(r"(?:==?|\bis)[ \t]*\Z")


def one_of(low: str, high: str, place: Span) -> Hint:
    """Return a hint to write one end of a range, or a range where that can be tested.

    Args:
        low: The lower end as written; without a unit, it has that of the upper end.
        high: The upper end as written.
        place: The range.
    """
    unit = _UNIT.fullmatch(high)
    if _BARE.fullmatch(low) and unit is not None:
        low = f"{low} {unit[1]}"
    line = place.source.line_text(place.line)
    before = line[: place.column - 1]
    if _TESTED.match(before):
        text = f"between {low} and {high}"
        sign = _SIGN.search(before)
        start = place.start - (len(sign[0]) if sign else 0)
        edits = [Edit(text, Span(place.source, start, place.end))] if sign else []
        return Hint(f'write the range: "{text}"', *edits)
    text = f'write "{low}" or "{high}", and vary it in a study'
    return Hint(text, Edit(low, place), Edit(high, place))


def amount_of(number: str, other: str) -> str:
    """Return a number with its unit, which may follow another number.

    Args:
        number: The number as written.
        other: The other number as written.
    """
    unit = _UNIT.fullmatch(other)
    is_bare = _BARE.fullmatch(number) and unit is not None and unit[1] != "%"
    return f"{number} {unit[1]}" if is_bare and unit is not None else number


def without_tolerance(number: str, unit: str | None, place: Span) -> Hint:
    """Return a hint to write a number alone, without its tolerance.

    Args:
        number: The number as written.
        unit: Its unit, which may follow the tolerance.
        place: Number and tolerance.
    """
    amount = f"{number} {'' if unit in (None, '%') else unit}".rstrip()
    hint = f'a number has no tolerance: write "{amount}", and vary it in a study'
    return Hint(hint, Edit(amount, place))
