"""Laws and numbers as text of a preset: exactly, or to the precision that is known."""

import math
from collections.abc import Iterator, Mapping
from typing import Any

from msgspec.structs import replace

from tissuec.core.fields import OneOf, Real, Several, Whole
from tissuec.core.prefixes import shown_units
from tissuec.core.source import Source
from tissuec.core.units import NUMBER, Dimension, parse_unit, si_unit
from tissuec.lang import syntax as s
from tissuec.lang.parser import parse
from tissuec.lang.walk import names_in
from tissuec.learn.presets.drafts import LearntNumber
from tissuec.scene.model import WrittenLaw
from tissuec.scene.program.parameters import Constants
from tissuec.scene.reading.entries import Entry, entries_of
from tissuec.scene.tissues.laws import FORMS


def constants_in(law: WrittenLaw) -> set[str]:
    """Return the constants of a law that can be learnt: its entries, or names of a formula."""
    if law.law is not None:
        return set(entries_of(type(law.law)))
    function = _parsed(law)
    return {name.key for name in names_in(function.value)}


def changed_constants(
    law: WrittenLaw, learned: Mapping[str, LearntNumber]
) -> dict[str, LearntNumber]:
    """Return those of the learnt constants that belong to a law."""
    own = constants_in(law)
    return {name: number for name, number in learned.items() if s.key_of(name) in own}


def law_text(
    word: str, law: WrittenLaw, learned: Mapping[str, LearntNumber], constants: Constants
) -> str:
    """Return the entry of a tissue that writes a law, with its learnt constants.

    Args:
        word: "spring law" or "viscosity law".
        constants: Values of the names in a formula.
    """
    if law.law is None:
        return _formula_text(law, learned, constants)
    entries = [
        f"{entry.name} {_entry_text(entry, getattr(law.law, entry.field), learned)}"
        for entry in entries_of(type(law.law)).values()
    ]
    inner = f" {{ {'; '.join(entries)} }}" if entries else ""
    return f"{word} is {law.name}{inner}"


def _entry_text(entry: Entry, value: Any, learned: Mapping[str, LearntNumber]) -> str:
    """Return the text after the name of an entry."""
    match entry.kind:
        case Real(dimension=dimension):
            if entry.name in learned:
                return f"= {_learnt(learned[entry.name])}"
            return f"= {exact(value, dimension)}"
        case Several(dimension=dimension):
            return f"= [{', '.join(exact(one, dimension) for one in value)}]"
        case Whole():
            return f"= {value}"
        case OneOf():
            return f"is {value}"
        case _:
            raise TypeError(f"a law with an entry of {entry.kind} cannot be written")


def _learnt(number: LearntNumber) -> str:
    return learnt(number.value, number.low, number.high, number.dimension)


def _formula_text(
    law: WrittenLaw, learned: Mapping[str, LearntNumber], constants: Constants
) -> str:
    """Return a free formula in which every name that is no variable is a number."""
    function = _parsed(law)
    own = FORMS[function.name.key].variables(function)
    by_key = {s.key_of(name): number for name, number in learned.items()}
    text = function.span.source.text
    end = function.span.end
    pieces: list[str] = []
    for name in sorted(names_in(function.value), key=lambda name: -name.span.start):
        if name.key in own:
            continue
        value = constants.name(name)
        number = by_key.get(name.key)
        if number is None:
            shown = exact(float(value.amount), value.dimension)
        else:
            shown = _learnt(replace(number, dimension=value.dimension))
        pieces += [text[name.span.end : end], f"({shown})"]
        end = name.span.start
    return text[function.span.start : end] + "".join(reversed(pieces))


def _parsed(law: WrittenLaw) -> s.Function:
    """Return the syntax of a free formula, read again from its own text."""
    item = parse(Source(law.span.source.name, law.span.text), has_heading=False).items[0]
    assert isinstance(item, s.Function)
    return item


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
    return factor, chosen.unit  # as texts are read: not exactly 1e-12 for ng
