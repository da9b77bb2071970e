"""Frozen syntax nodes, one class per sentence shape or expression of the grammar.

The parser knows shapes only; what a word means is decided in :mod:`tissuec.scene`. Equality
ignores spans and the spelling of numbers, so that ``parse(fmt(x)) == parse(x)``.
"""

from typing import Any, Literal, TypeAlias

from msgspec import Struct

from tissuec.core.names import key_of
from tissuec.core.source import Source, Span

#: Fields for the place of a node; equal nodes may differ in them.
PLACES = frozenset(("span", "head", "rows_span", "source"))


class Node(Struct, frozen=True, eq=False):
    """A node of the syntax tree; equality and representation ignore its place."""

    def _content(self) -> tuple[Any, ...]:
        names = (name for name in self.__struct_fields__ if name not in PLACES)
        return tuple(getattr(self, name) for name in names)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Node) or type(other) is not type(self):
            return NotImplemented
        return self._content() == other._content()

    def __hash__(self) -> int:
        return hash((type(self), self._content()))

    def __repr__(self) -> str:
        return f"{type(self).__name__}{self._content()!r}"


# --- expressions ------------------------------------------------------------------------------


class Name(Node, frozen=True):
    """One or more words, optionally ending in a quoted part: ``tissue "head of pancreas"``."""

    words: str  # unquoted words as written, single blanks between them; may be empty
    quoted: str | None  # the quoted part without its quotes
    span: Span
    listed: "tuple[Name, ...]" = ()  # names of a union after the words: ``fix [A, B]``

    @property
    def text(self) -> str:
        """Return the whole name as written, without quotes."""
        text = self.words if self.quoted is None else f"{self.words} {self.quoted}".strip()
        if self.listed:
            text = f"{text} [{', '.join(name.text for name in self.listed)}]".strip()
        return text

    @property
    def key(self) -> str:
        """Return the name as ``key_of`` has it."""
        return key_of(self.text)


class Number(Node, frozen=True):
    value: float
    span: Span


class Quantity(Node, frozen=True):
    value: float  # in the written unit
    unit: (
        str  # "steps", or canonical spelling, such as "N*s/m"; "" if it, or the value, is wrong
    )
    span: Span


class Vector(Node, frozen=True):
    items: "tuple[Expression, ...]"
    unit: str | None  # applies to every item that has none; "" if it is wrong
    span: Span


class Listing(Node, frozen=True):
    """``[a, b, c]``"""

    items: "tuple[Expression, ...]"
    span: Span


class Call(Node, frozen=True):
    """``force(pressed, 0.8 s)``; an argument may carry clauses: ``distance(a to b)``."""

    function: Name
    arguments: "tuple[Argument, ...]"
    span: Span


class FormalParameter(Node, frozen=True):
    """A parameter of a function in its value, by its place among the parameters."""

    number: int
    span: Span


class Applied(Node, frozen=True):
    """The call of a function of the scene, with the value of that function.

    Attributes:
        arguments: What its parameters are, in their order.
        value: Contains a ``FormalParameter`` in place of the name of each; None where it is
            wrong.
        definition: Of the function.
        span: Of the call.
    """

    name: Name
    arguments: "tuple[Expression, ...]"
    value: "Expression | None"
    definition: Span
    span: Span


class Argument(Node, frozen=True):
    value: "Expression"
    clauses: "tuple[Clause, ...]"
    span: Span


class Signed(Node, frozen=True):
    """An operand after an odd number of minus signs."""

    operand: "Expression"
    span: Span


class Sum(Node, frozen=True):
    """``first + a - b``: flat, so that long sums do not nest."""

    first: "Expression"
    rest: "tuple[tuple[Literal['+', '-'], Expression], ...]"
    span: Span


class Product(Node, frozen=True):
    first: "Expression"
    rest: "tuple[tuple[Literal['*', '/'], Expression], ...]"
    span: Span


class Power(Node, frozen=True):
    base: "Expression"
    exponent: "Expression"
    span: Span


def as_name(node: "Expression") -> Name | None:
    """Return a name, also ``[A, B]`` as that of a union; None for anything else."""
    if isinstance(node, Name):
        return node
    if not isinstance(node, Listing) or not node.items:
        return None
    names = tuple(item for item in node.items if isinstance(item, Name) and not item.listed)
    return Name("", None, node.span, names) if len(names) == len(node.items) else None


# --- conditions -------------------------------------------------------------------------------


class Compare(Node, frozen=True):
    left: "Expression"
    sign: Literal["<", "<=", ">", ">=", "==", "!="]
    right: "Expression"
    span: Span


class Is(Node, frozen=True):
    """``hardness is very soft``, ``region is cover``"""

    subject: "Expression"
    phrase: "Predicate"
    span: Span


class Between(Node, frozen=True):
    subject: "Expression"
    low: "Expression"
    high: "Expression"
    span: Span


class Within(Node, frozen=True):
    """``within 4 mm of (20, 20, 10) mm``; without a subject the node itself is meant."""

    subject: "Expression | None"
    radius: "Expression"
    centre: "Expression"
    span: Span


class Not(Node, frozen=True):
    operand: "Expression"
    span: Span


class And(Node, frozen=True):
    operands: "tuple[Expression, ...]"
    span: Span


class Or(Node, frozen=True):
    operands: "tuple[Expression, ...]"
    span: Span


class Predicate(Node, frozen=True):
    """The phrase after ``is``: a word, ``not`` a word, ``between`` a word ``and`` a word."""

    kind: Literal["word", "not", "between"]
    words: tuple[Name, ...]  # two for "between", otherwise one
    span: Span


Expression: TypeAlias = (
    Name | Number | Quantity | Vector | Listing | Call | Applied | FormalParameter | Signed
    | Sum | Product | Power | Compare | Is | Between | Within | Not | And | Or
)  # fmt: skip


# --- sentences --------------------------------------------------------------------------------


class Clause(Node, frozen=True):
    """A joining word and what follows it: ``with forceps A``, ``where x > 0 m``."""

    word: str
    value: Expression
    span: Span


class Bounds(Node, frozen=True):
    low: Expression
    high: Expression
    span: Span


class Assign(Node, frozen=True):
    """``[param|let|set] name = value [between a and b] clauses``"""

    keyword: Literal["", "param", "let", "set"]
    name: Name
    value: Expression
    bounds: Bounds | None
    clauses: tuple[Clause, ...]
    span: Span


class Definition(Node, frozen=True):
    """``let name(parameter, …) = value``: a function of numbers."""

    name: Name
    parameters: tuple[Name, ...]
    value: Expression
    span: Span


class RecordedCall(Node, frozen=True):
    """``measure(A along (0, 0, 1)) clauses``: a measure and its times."""

    call: Call
    clauses: tuple[Clause, ...]
    span: Span

    @property
    def name(self) -> Name:
        """The name of the called function or measure."""
        return self.call.function


class Function(Node, frozen=True):
    """``name of argument [and argument] = value``: a formula, or an entry of a block."""

    name: Name
    arguments: tuple[Clause, ...]  # the word of a second one is "and"
    value: Expression
    clauses: tuple[Clause, ...]
    span: Span


class Sentence(Node, frozen=True):
    """``name [is phrase] clauses``"""

    name: Name
    phrase: Predicate | None
    clauses: tuple[Clause, ...]
    span: Span


class Block(Node, frozen=True):
    """``name [is phrase] clauses { items }``"""

    name: Name
    phrase: Predicate | None
    clauses: tuple[Clause, ...]
    items: "tuple[Item, ...]"
    span: Span
    head: Span  # without the braces


class Table(Node, frozen=True):
    """``table name clauses { raw rows }``; the rows are read later, by a fast loader."""

    name: Name
    clauses: tuple[Clause, ...]
    rows: str  # one per line, single blanks, no comments
    span: Span
    rows_span: Span


class Conclusion(Node, frozen=True):
    quantity: Name
    phrase: Predicate
    span: Span


class Rule(Node, frozen=True):
    """``if condition then quantity is word and … weighing 0.5``"""

    condition: Expression
    conclusions: tuple[Conclusion, ...]
    clauses: tuple[Clause, ...]
    span: Span


class Timed(Node, frozen=True):
    """``at 0.1 s: grasp …``; either ``times`` or ``trigger`` (``when condition:``) is given."""

    times: tuple[Clause, ...]
    trigger: Expression | None
    body: "tuple[Item, ...]"
    span: Span
    head: Span


class Expect(Node, frozen=True):
    condition: Expression
    clauses: tuple[Clause, ...]
    span: Span


Item: TypeAlias = (
    Assign
    | Definition
    | RecordedCall
    | Function
    | Sentence
    | Block
    | Table
    | Rule
    | Timed
    | Expect
)


class Module(Node, frozen=True):
    """A whole file."""

    version: Number
    items: tuple[Item, ...]
    source: Source
