"""The reading of entries by their declarations; see ``entries``.

A new mesh or tool brings its ``Struct``, whose fields declare entries, and is checked,
converted, suggested and documented like all others.
"""

import math
import re
from collections.abc import Collection, Mapping, Sequence
from typing import Any, NoReturn, TypeVar

import numpy as np

from tissuec.core.errors import enumerated
from tissuec.core.fields import (
    FileIn,
    FromTo,
    Named,
    OneOf,
    Point,
    Real,
    Several,
    UnfitEntries,
    Whole,
)
from tissuec.core.hints import Edit, Hint, alternatives, proposal
from tissuec.core.source import Span
from tissuec.core.units import (
    ACCELERATION,
    NUMBER,
    describe,
    parse_unit,
    show,
    show_in,
    suggested_unit,
)
from tissuec.lang import syntax as s
from tissuec.scene.files import read_file
from tissuec.scene.reading.entries import Entry, Written, entries_of
from tissuec.scene.reading.entry_hints import blamed, chosen, left_side, missing, unknown_entry
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.reading.ranges import difference, refuse_range
from tissuec.scene.reading.values import SMALLEST_NUMBER, Value

_QUOTED = re.compile(r'"[^"]*"')

#: A number and its unit.
_AMOUNT = re.compile(r"(-?[0-9.]+(?:[eE][+-]?[0-9]+)?)\s*(\S*)")

_DIGITS = 4  # of limits
_RATIOS = ("%", "deg")  # units of numbers without a dimension
T = TypeVar("T")


def build(
    cls: type[T],
    items: Sequence[s.Item],
    scope: Scope,
    *,
    what: str,
    where: Span,
    usual: Mapping[str, Any] | None = None,
) -> tuple[T, Mapping[str, Span]]:
    """Return a member built from the items of its block, and the place of each entry.

    Args:
        cls: Class whose fields are the entries.
        items: The items between the braces.
        scope: Where names in expressions are looked up.
        what: The block in messages, such as "mesh tube".
        where: The head of the block, to point at when an entry is missing.
        usual: Values of required entries that need not be written here, by field name.
    """
    schema, usual = entries_of(cls), usual or {}
    with scope.findings.together():  # what is missing may be what was misspelt
        values, places = read(schema, items, scope, what=what)
    lacking = [
        one for one in schema.values()
        if one.is_required and one.name not in places and one.field not in usual
    ]  # fmt: skip
    if lacking:
        names = enumerated((f'"{one.name}"' for one in lacking), "and")
        hint = missing("; ".join(one.example for one in lacking), where)
        scope.findings.reject("TIS304", f"{what} needs {names}", where, hint=hint)
    try:
        with np.errstate(all="ignore"):
            return cls(**{**usual, **values}), places
    except ArithmeticError:
        message = f"{what} cannot be built from numbers that large or that small"
        scope.findings.reject("TIS309", message, where, hint="check the units")
    except ValueError as error:  # entries that are right one by one and impossible together
        reason, hint = str(error), error.hint if isinstance(error, UnfitEntries) else ""
        scope.findings.reject(
            "TIS309", f"{what}: {reason}", blamed(reason, places, where), hint=hint
        )


def read(
    schema: Mapping[str, Entry], items: Sequence[s.Item], scope: Scope, *, what: str
) -> tuple[dict[str, Any], dict[str, Span]]:
    """Return the written values by field name, and their places by entry name.

    Args:
        schema: Entries by name.
        items: Items of the block.
    """
    values: dict[str, Any] = {}
    places: dict[str, Span] = {}
    named = (item for item in items if isinstance(item, s.Assign | s.Sentence | s.Block))
    written = {item.name.key for item in named}
    for item in items:
        with scope.findings.item():
            entry = find_entry(schema, item, scope, what=what, written=written)
            if entry.name in places:
                scope.findings.refuse_second(f'"{entry.name}"', item.span, places[entry.name])
            places[entry.name] = item.span
            values[entry.field] = read_entry(entry, item, scope)
    return values, places


def find_entry(
    schema: Mapping[str, Entry],
    item: s.Item,
    scope: Scope,
    *,
    what: str,
    written: Collection[str] = (),
) -> Entry:
    """Return the entry that an item writes, or reject the item.

    Args:
        schema: Entries by name.
        written: Names of all entries of the block, none of which can be meant by another word.
    """
    if not isinstance(item, s.Assign | s.Sentence | s.Block):
        scope.findings.reject("TIS303", f"this is not allowed in {what}", item.span)
    if item.name.quoted is not None and isinstance(item, s.Sentence):
        named = schema.get(s.key_of(item.name.words))
        if named is not None and isinstance(named.kind, FileIn | Named):
            return named
    if item.name.key not in schema:
        hint = chosen(item, schema) or unknown_entry(item, schema, written)
        scope.findings.refuse_entry(item.name, what, hint=hint)
    return schema[item.name.key]


def read_entry(entry: Entry, item: s.Item, scope: Scope) -> Any:
    """Return the value of one entry in SI units, or reject the item."""
    if entry.reads is not None:
        return entry.reads(item, scope)
    match entry.kind:
        case FromTo():
            return _read_from_to(entry, entry.kind, item, scope)
        case OneOf():
            return _read_word(entry, entry.kind, item, scope)
        case FileIn():
            if not isinstance(item, s.Sentence) or item.name.quoted is None or item.phrase:
                _wrong_form(entry, item, scope)
            return read_file(entry.kind, item, scope, example=entry.example)
        case Named():
            if not isinstance(item, s.Sentence) or not item.name.quoted or item.phrase:
                _wrong_form(entry, item, scope)
            _no_clauses(item, scope)
            return item.name.quoted
        case Written():
            _wrong_form(entry, item, scope)
        case kind:
            if not isinstance(item, s.Assign):
                _wrong_form(entry, item, scope)
            refuse_range(item, scope.findings)
            _no_clauses(item, scope)
            return read_value(kind, item.value, scope, what=entry.name)


def read_value(
    kind: Real | Whole | Point | Several, node: s.Expression, scope: Scope, *, what: str
) -> Any:
    """Return an expression as a number, whole number, vector or list within its limits.

    Args:
        kind: Kind of the entry.
    """
    match kind:
        case Several(dimension=dimension, at_least=low):
            if not isinstance(node, s.Listing) or len(node.items) < low:
                scope.findings.reject(
                    "TIS312", f"{what} must be a list of at least {low} numbers", node.span,
                    hint=f"for example: {Entry(what, what, kind, None, '').example}",
                )  # fmt: skip
            one = Real(dimension)
            return tuple(read_value(one, item, scope, what=what) for item in node.items)
        case Point(dimension=dimension):
            value = scope.evaluate(node)
            if not value.is_vector:
                message = f"{what} must be a vector: (x, y, z)"
                hint = _as_vector(kind, node, value, what=what)
                scope.findings.reject("TIS312", message, node.span, hint=hint)
            if np.any(value.amount) or not value.is_literal:
                scope.expect(value, dimension, node.span, what=what)
            return value.amount
        case Whole(at_least=low, at_most=high):
            value = scope.number(node)
            scope.expect(value, NUMBER, node.span, what=what)
            number = float(value.amount)
            if number != int(number):
                scope.findings.reject(
                    "TIS308",
                    f"{what} must be a whole number, not {number:g}",
                    node.span,
                    hint=Hint(
                        f"write {math.floor(number)} or {math.ceil(number)}",
                        Edit(str(math.floor(number))),
                        Edit(str(math.ceil(number))),
                    ),
                )
            if not low <= number <= high:
                scope.findings.reject(
                    "TIS308",
                    f"{what} = {_grouped(number)} is not between "
                    f"{_grouped(low)} and {_grouped(high)}",
                    node.span,
                    hint=proposal(str(low)) if number < low else "write a smaller number",
                )
            return int(number)
        case Real(by_axis=True) if isinstance(node, s.Vector) and len(node.items) < 3:
            message = f"{what} is one number, or three for x, y and z"
            scope.findings.reject("TIS312", message, node.span, hint=_by_axis(kind, what))
        case Real(by_axis=True) if (value := scope.evaluate(node)).is_vector:
            return _read_by_axis(kind, value, node, scope, what=what)
        case Real():
            return _read_real(kind, node, scope, what=what)


def _read_by_axis(
    kind: Real, value: Value, node: s.Expression, scope: Scope, *, what: str
) -> Any:
    """Return three numbers, each of which is within the limits, shape (3,)."""
    scope.expect(value, kind.dimension, node.span, what=what)
    for axis, amount in zip("xyz", value.amount.tolist(), strict=True):
        if abs(amount) < SMALLEST_NUMBER or not _within(kind, amount):
            shown = show(amount, kind.dimension)
            message = f"{what} cannot be {shown} along {axis}"
            scope.findings.reject("TIS308", message, node.span, hint=_by_axis(kind, what))
    return value.amount


def _by_axis(kind: Real, what: str) -> str:
    """Return a hint to write three numbers."""
    return f"for example: {what} = (4, 4, 1) {suggested_unit(kind.dimension)}".rstrip()


def _as_vector(kind: Point, node: s.Expression, value: Value, *, what: str) -> Hint:
    """Return a hint to write a number as a vector, downwards if it is of gravity."""
    amount = _AMOUNT.fullmatch(node.span.text)
    fits = value.dimension == kind.dimension or value.is_literal
    if amount is None or not fits:
        return Hint(f"for example: {Entry(what, what, kind, None, '').example}")
    is_upward = kind.dimension == ACCELERATION and float(value.amount) > 0.0
    number = f"-{amount[1]}" if is_upward else amount[1]
    unit = amount[2] or suggested_unit(kind.dimension)
    vector = f"(0, 0, {number}) {unit}".rstrip()
    return Hint(f"for example: {what} = {vector}", Edit(vector))


def _read_real(kind: Real, node: s.Expression, scope: Scope, *, what: str) -> float:
    value = scope.number(node)
    scope.expect(value, kind.dimension, node.span, what=what)
    amount = float(value.amount)
    if kind.at_most is not None and _is_limit(amount, kind.at_most):
        amount = kind.at_most
    if np.any(kind.dimension) and 0.0 < abs(amount) < SMALLEST_NUMBER:
        message = f"{what} is too small to compute with: {node.span.one_line}"
        hint = "check the units and the exponents"
        scope.findings.reject("TIS308", message, node.span, hint=hint)
    limits = (
        (kind.above is not None and amount <= kind.above, "above", kind.above),
        (kind.at_least is not None and amount < kind.at_least, "at least", kind.at_least),
        (kind.at_most is not None and amount > kind.at_most, "at most", kind.at_most),
    )
    if any(broken for broken, _, _ in limits):
        allowed = " and ".join(
            f"{words} {_as_written(limit, kind, node)}"
            for _, words, limit in limits
            if limit is not None
        )
        written = node.span.one_line if _unit_of(node) else str(value)
        message = f"{what} must be {allowed}, not {written}"
        hint = _allowed(kind, node, value, allowed)
        scope.findings.reject("TIS308", message, node.span, hint=hint)
    return amount


def _allowed(kind: Real, node: s.Expression, value: Value, allowed: str) -> Hint:
    """Return a hint with possible meanings of a number beyond its limits.

    Args:
        node: The number as written.
        allowed: Its limits in words.
    """
    amount = float(value.amount)
    is_share = kind.dimension == NUMBER and value.is_literal
    if is_share and _within(kind, amount / 100) and 0.5 < (kind.at_most or 0.0) <= 1.0:
        return proposal(f"{node.span.text} %")
    if (amount_range := difference(node)) is not None:
        return amount_range
    match node:
        case s.Signed(operand=s.Number() | s.Quantity() as plain) if _within(kind, -amount):
            if not _within(kind, 0.0):
                return proposal(plain.span.text)
            none = _as_written(0.0, kind, node)
            text = f'write "{plain.span.text}", or "{none}" for none'
            return Hint(text, Edit(plain.span.text), Edit(none))
        case s.Number() | s.Quantity() | s.Signed():
            pass
        case _:
            return Hint(f'"{node.span.one_line}" is {value}; it must be {allowed}')
    is_large = kind.at_most is not None and amount > kind.at_most
    nearest = kind.at_most if is_large else kind.at_least
    if nearest is not None and _within(kind, nearest):
        text, unit = _as_written(nearest, kind, node), _unit_of(node)
        if unit not in _RATIOS or _within(
            kind, float(text.split()[0]) * parse_unit(unit).factor
        ):
            return proposal(text)
    return Hint(f"write a number {allowed}")


def _unit_of(node: s.Expression) -> str:
    """Return the unit of a number, or nothing."""
    match node:
        case s.Quantity(unit=unit) | s.Signed(operand=s.Quantity(unit=unit)):
            return unit
        case _:
            return ""


def _as_written(limit: float, kind: Real, node: s.Expression) -> str:
    """Return a limit in the unit of a number beyond it, if readers expect it there.

    Args:
        limit: In SI units.
        node: The number.
    """
    unit = _unit_of(node)
    if unit in _RATIOS or (unit and limit == 0.0 and np.any(kind.dimension)):
        return show_in(limit, unit)
    return show(limit, kind.dimension, digits=_DIGITS)


def _within(kind: Real, amount: float) -> bool:
    return (
        (kind.above is None or amount > kind.above)
        and (kind.at_least is None or amount >= kind.at_least)
        and (kind.at_most is None or amount <= kind.at_most or _is_limit(amount, kind.at_most))
    )


def _is_limit(amount: float, limit: float) -> bool:
    """Return whether a number is a limit but for rounding: 95 % is a little more than 0.95."""
    return math.isclose(amount, limit, rel_tol=1e-14)


def _read_word(entry: Entry, kind: OneOf, item: s.Item, scope: Scope) -> str:
    if (
        isinstance(item, s.Assign)
        or not isinstance(item, s.Sentence | s.Block)
        or item.phrase is None
    ):
        _wrong_form(entry, item, scope)
    parts = (item.phrase, *item.clauses)  # "centre of gravity" reads as a word and a clause
    text = s.key_of(" ".join(part.span.text for part in parts))
    if text in kind.words and (kind.opens or not isinstance(item, s.Block)):
        return text
    _no_clauses(item, scope)
    if isinstance(item, s.Block) and not kind.opens:
        scope.findings.reject(
            "TIS303",
            f"{entry.name} does not have entries",
            item.span,
            hint=Hint(f"write: {item.head.text}", Edit(item.head.text)),
        )
    if item.phrase.kind != "word" or item.phrase.words[0].key not in kind.words:
        text = item.phrase.span.text
        scope.findings.reject(
            "TIS305",
            f'{entry.name} cannot be "{text}"',
            item.phrase.span,
            hint=alternatives(text.lower(), kind.words, what="choices"),
        )
    return item.phrase.words[0].key


def word_of(item: s.Assign | s.Sentence | s.Block, scope: Scope, *, example: str) -> s.Name:
    """Return the single word after ``is``."""
    refuse_sign(item, scope, example=example)
    if (
        isinstance(item, s.Assign)
        or item.phrase is None
        or item.phrase.kind != "word"
        or item.clauses
    ):
        scope.findings.reject(
            "TIS312",
            f'"{item.name.text}" needs a word',
            item.span,
            hint=f"for example: {example}",
        )
    return item.phrase.words[0]


def refuse_sign(item: s.Item, scope: Scope, *, example: str) -> None:
    """Reject ``kind = forceps``, where a word is chosen.

    Args:
        item: The entry.
        example: How the entry could be written.
    """
    if not isinstance(item, s.Assign):
        return
    is_word = isinstance(item.value, s.Name) and not item.clauses
    hint = f"for example: {example}"
    if is_word:
        is_yes = item.value.span.text.lower() in _YES
        hint = proposal(example if is_yes else f"{left_side(item)} is {item.value.span.text}")
    scope.findings.reject(
        "TIS312", 'use "is" to choose a word; "=" assigns a number', item.span, hint=hint
    )


def _read_from_to(entry: Entry, kind: FromTo, item: s.Item, scope: Scope) -> tuple[Any, ...]:
    if not isinstance(item, s.Sentence) or item.phrase is not None:
        _wrong_form(entry, item, scope)
    nodes = [clause.value for clause in item.clauses]
    match [clause.word for clause in item.clauses]:
        case ["from", "to"]:
            pass
        case ["through"] if kind.may_bend:
            nodes = _points_of_curve(entry, nodes[0], scope)
        case _:
            _wrong_form(entry, item, scope)
    point = Point(kind.dimension)
    return tuple(read_value(point, node, scope, what=entry.name) for node in nodes)


def _points_of_curve(entry: Entry, node: s.Expression, scope: Scope) -> list[s.Expression]:
    """Return the points of a curve, which are listed."""
    if isinstance(node, s.Listing) and len(node.items) > 2:
        return list(node.items)
    scope.findings.reject(
        "TIS312", f"{entry.name} must lead through a list of three points or more", node.span,
        hint=f"for example: {entry.name} through [(0, 0, 0) mm, (20, 0, 0) mm, (30, 10, 0) mm]",
    )  # fmt: skip


def _no_clauses(item: s.Assign | s.Sentence | s.Block, scope: Scope) -> None:
    if item.clauses:
        clause = item.clauses[0]
        hint = Hint(f'an entry ends with its value: remove "{clause.span.one_line}"', Edit(""))
        scope.findings.reject("TIS303", f'unexpected "{clause.word}"', clause.span, hint=hint)
    if isinstance(item, s.Assign) and (item.keyword or item.bounds):
        scope.findings.reject(
            "TIS303", "param and let are not allowed inside a block", item.span
        )


def _grouped(number: float) -> str:
    """Return a whole number with its digits in groups: 100 000 000."""
    return f"{number:,.12g}".replace(",", " ")


_OFF = ("off", "none", "zero", "no")
_YES = ("yes", "true", "on")


def _wrong_form(entry: Entry, item: s.Item, scope: Scope) -> NoReturn:
    example = entry.example
    if isinstance(item, s.Assign | s.Sentence | s.Block) and item.name.key == entry.name:
        example = left_side(item) + example.removeprefix(entry.name)
    if isinstance(entry.kind, OneOf) and isinstance(item, s.Assign):
        text = item.value.span.text
        hint = (
            proposal(f"{left_side(item)} is {text}")
            if text in entry.kind.words
            else Hint(f"for example: {example}", Edit(example))
        )
        scope.findings.reject(
            "TIS312", 'use "is" to choose a word; "=" assigns a number', item.span, hint=hint
        )
    if isinstance(entry.kind, FileIn) and (file := _QUOTED.search(item.span.text)):
        example = f"{entry.name} {file[0]} in mm"
    kind = describe(entry.kind.dimension) if isinstance(entry.kind, Real) else ""
    edits = [Edit(example)]
    if item.span.text.rsplit(" ", 1)[-1].lower() in _OFF:
        example, edits = example.replace("-9.81", "0"), []
    scope.findings.reject(
        "TIS312",
        f'wrong form of "{entry.name}"' + (f": it is {kind}" if kind else ""),
        item.span,
        hint=Hint(f"for example: {example}", *edits),
    )
