"""Frozen syntax nodes, one class per sentence shape or expression of the grammar.

The parser knows shapes only; what a word means is decided in :mod:`tissuec.scene`. Equality
ignores spans and the spelling of numbers, so that ``parse(fmt(x)) == parse(x)``.
"""

# ruff: noqa: RUF009 (the function only abbreviates a call of "field")
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

from tissuec.core.names import key_of
from tissuec.core.source import Source, Span


def _span() -> Span:
    """Declare the field that every node ends with: its place in the text."""
    return field(compare=False, repr=False)


# --- expressions ------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Name:
    """One or more words, optionally ending in a quoted part: ``tissue "head of pancreas"``."""

    words: str  # unquoted words as written, single blanks between them; may be empty
    quoted: str | None  # the quoted part without its quotes
    span: Span = _span()

    @property
    def text(self) -> str:
        """Return the whole name as written, without quotes."""
        return self.words if self.quoted is None else f"{self.words} {self.quoted}".strip()

    @property
    def key(self) -> str:
        """Return the name as ``key_of`` has it."""
        return key_of(self.text)


@dataclass(frozen=True, slots=True)
class Number:
    value: float
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class Quantity:
    value: float  # in the written unit
    unit: str  # canonical spelling, such as "N*s/m"; "" if it, or the value, is wrong
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class Vector:
    items: "tuple[Expression, ...]"
    unit: str | None  # applies to every item that has none; "" if it is wrong
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class Listing:
    """``[a, b, c]``"""

    items: "tuple[Expression, ...]"
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class Call:
    """``force(pressed, 0.8 s)``; an argument may carry clauses: ``distance(a to b)``."""

    function: Name
    arguments: "tuple[Argument, ...]"
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class Argument:
    value: "Expression"
    clauses: "tuple[Clause, ...]"
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class Signed:
    """An operand behind an odd number of minus signs."""

    operand: "Expression"
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class Sum:
    """``first + a - b``: flat, so that long sums do not nest."""

    first: "Expression"
    rest: "tuple[tuple[Literal['+', '-'], Expression], ...]"
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class Product:
    first: "Expression"
    rest: "tuple[tuple[Literal['*', '/'], Expression], ...]"
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class Power:
    base: "Expression"
    exponent: "Expression"
    span: Span = _span()


# --- conditions -------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Compare:
    left: "Expression"
    sign: Literal["<", "<=", ">", ">=", "==", "!="]
    right: "Expression"
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class Is:
    """``hardness is very soft``, ``region is cover``"""

    subject: "Expression"
    phrase: "Phrase"
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class Between:
    subject: "Expression"
    low: "Expression"
    high: "Expression"
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class Within:
    """``within 4 mm of (20, 20, 10) mm``; without a subject the node itself is meant."""

    subject: "Expression | None"
    radius: "Expression"
    centre: "Expression"
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class Not:
    operand: "Expression"
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class And:
    operands: "tuple[Expression, ...]"
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class Or:
    operands: "tuple[Expression, ...]"
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class Phrase:
    """What stands after ``is``: a word, ``not`` a word, ``between`` a word ``and`` a word."""

    kind: Literal["word", "not", "between"]
    words: tuple[Name, ...]  # two for "between", otherwise one
    span: Span = _span()


Expression: TypeAlias = (
    Name | Number | Quantity | Vector | Listing | Call | Signed | Sum | Product | Power
    | Compare | Is | Between | Within | Not | And | Or
)  # fmt: skip


# --- sentences --------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Clause:
    """A joining word and what follows it: ``with forceps A``, ``where x > 0 m``."""

    word: str
    value: Expression
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class Bounds:
    low: Expression
    high: Expression
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class Assign:
    """``[param|let|set] name = value [between a and b] clauses``"""

    keyword: Literal["", "param", "let", "set"]
    name: Name
    value: Expression
    bounds: Bounds | None
    clauses: tuple[Clause, ...]
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class Function:
    """``name of argument [and argument] = value``: a formula of its arguments."""

    name: Name
    arguments: tuple[Clause, ...]  # the word of a second one is "and"
    value: Expression
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class Sentence:
    """``name [is phrase] clauses``"""

    name: Name
    phrase: Phrase | None
    clauses: tuple[Clause, ...]
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class Block:
    """``name [is phrase] clauses { items }``"""

    name: Name
    phrase: Phrase | None
    clauses: tuple[Clause, ...]
    items: "tuple[Item, ...]"
    span: Span = _span()
    head: Span = _span()  # without the braces


@dataclass(frozen=True, slots=True)
class Table:
    """``table name clauses { raw rows }``; the rows are read later, by a fast loader."""

    name: Name
    clauses: tuple[Clause, ...]
    rows: str = field(repr=False)  # one per line, single blanks, no comments
    span: Span = _span()
    rows_span: Span = _span()


@dataclass(frozen=True, slots=True)
class Conclusion:
    quantity: Name
    phrase: Phrase
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class Rule:
    """``if condition then quantity is word and … weighing 0.5``"""

    condition: Expression
    conclusions: tuple[Conclusion, ...]
    clauses: tuple[Clause, ...]
    span: Span = _span()


@dataclass(frozen=True, slots=True)
class Timed:
    """``at 0.1 s: grasp …``; either ``times`` or ``trigger`` (``when condition:``) is given."""

    times: tuple[Clause, ...]
    trigger: Expression | None
    body: "tuple[Item, ...]"
    span: Span = _span()
    head: Span = _span()


@dataclass(frozen=True, slots=True)
class Expect:
    condition: Expression
    clauses: tuple[Clause, ...]
    span: Span = _span()


Item: TypeAlias = Assign | Function | Sentence | Block | Table | Rule | Timed | Expect


@dataclass(frozen=True, slots=True)
class Module:
    """A whole file."""

    version: Number
    items: tuple[Item, ...]
    source: Source = field(compare=False, repr=False)
