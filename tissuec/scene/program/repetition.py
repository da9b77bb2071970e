"""``repeat i from 1 to 8 { … }``: statements that are written once and hold several times.

The index is replaced by its value: as a number where a number is possible, and as a word of any
name, so that ``stitch i`` becomes "stitch 1", "stitch 2" and so on. In quotes it is written in
braces, also with a number added or subtracted: ``"stitch {i}"``, ``"stitch {i + 1}"``.

Every copy has the places of what is written, with the value of the index, so that a finding
shows both.
"""

import re
from collections.abc import Iterator, Sequence
from operator import is_
from typing import Annotated, Any, TypeAlias, TypeGuard, cast

from msgspec import Struct

from tissuec.core.hints import proposal
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.core.units import SYMBOLS
from tissuec.lang import syntax as s
from tissuec.scene.reading.block_sentences import SentenceKind, SentenceReader
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.reading.findings import Findings
from tissuec.scene.reading.parts import REPEAT, declare
from tissuec.script.forms import VerbSentence
from tissuec.script.parts import ValueClause, new_name

EXAMPLE = "repeat i from 1 to 8 { … }"
Index = Annotated[s.Name, new_name("let", "index")]


class RepeatedCounting(VerbSentence, frozen=True):
    """The index of a repetition, and its first and last number."""

    index: Index
    first: Annotated[s.Expression, ValueClause("from", place="NUMBER")]
    last: Annotated[s.Expression, ValueClause("to", place="NUMBER")]


class RepeatedFor(VerbSentence, frozen=True):
    """The index of a repetition, and the list of its values."""

    index: Index
    values: Annotated[s.Expression, ValueClause("in", place="LIST")]


REPEAT_KIND = SentenceKind(
    (RepeatedCounting, RepeatedFor), examples=(EXAMPLE,), wrong=f"wrong form of {REPEAT}"
)
declare(
    REPEAT, "Repeats the statements of a block, each time with another value of an index.", 55,
    "sentence", sentences=REPEAT_KIND.forms, example=EXAMPLE,
    within=("body", "script", "output", "learn", "study", "environment"),
)  # fmt: skip
MOST = 10_000  # copies of the statements of one text
#: Words that have another meaning in conditions.
_TAKEN = ("x", "y", "z", "id", "length")
#: Fields of nodes that hold names, and no numbers.
_NAMES = frozenset(("name", "function", "quantity", "words", "listed"))
#: ``{i}`` or ``{i + 1}`` in quotes.
_IN_QUOTES = r"\{{\s*{index}\s*(?:(?P<sign>[+-])\s*(?P<number>[0-9]+)\s*)?\}}"

Value: TypeAlias = int | s.Name


def is_repeat(item: s.Item) -> TypeGuard[s.Block | s.Sentence]:
    """Return whether an item repeats others, also if it is written wrong."""
    if not isinstance(item, s.Block | s.Sentence) or item.phrase is not None:
        return False
    return item.name.key.split(" ")[0] == REPEAT


def repeated(
    items: Sequence[s.Item], findings: Findings, indices: list[s.Name] | None = None
) -> tuple[s.Item, ...]:
    """Return items with copies in place of what repeats them, also inside of blocks.

    Args:
        items: Of a text.
        indices: Takes the names of all indices.
    """
    return tuple(_Expansion(findings, [] if indices is None else indices).items(items))


class _Expansion:
    """The copies of one text."""

    def __init__(self, findings: Findings, indices: list[s.Name]):
        self.findings, self.indices = findings, indices
        self.copies = 0

    def items(self, items: Sequence[s.Item]) -> Iterator[s.Item]:
        """Yield items without repetitions."""
        for item in items:
            if is_repeat(item):
                with self.findings.item():
                    yield from self._copies(item)
            else:
                yield self._without(item)

    def _without(self, item: s.Item) -> s.Item:
        """Return an item without repetitions inside; itself if it has none."""
        inner = item.items if isinstance(item, s.Block) else None
        inner = item.body if isinstance(item, s.Timed) else inner
        if inner is None:
            return item
        found = tuple(self.items(inner))
        if len(found) == len(inner) and all(map(is_, found, inner)):
            return item
        if isinstance(item, s.Block):
            return replace(item, items=found)
        assert isinstance(item, s.Timed)
        return replace(item, body=found)

    def _copies(self, item: s.Block | s.Sentence) -> Iterator[s.Item]:
        reader = SentenceReader(REPEAT, REPEAT_KIND, item, Scope(self.findings))
        if not isinstance(item, s.Block):
            reader.reject_form()
        said: RepeatedCounting | RepeatedFor = reader.get()
        if " " in said.index.words or not said.index.words:
            reader.reject_form()
        index = self._index(said.index)
        values = self._values(said, reader)
        self.copies += len(values) * len(item.items)
        if self.copies > MOST:
            self.findings.reject(
                "TIS116", f"this makes more than {MOST} copies of statements", item.head,
                hint="repeat less",
            )  # fmt: skip
        for value in values:
            one = _Copy(index, value)
            yield from self.items(tuple(one.of(inner) for inner in item.items))

    def _index(self, name: s.Name) -> str:
        is_unit = name.text in SYMBOLS
        if is_unit or name.key in _TAKEN:
            self.findings.reject(
                "TIS507" if is_unit else "TIS312",
                f'"{name.text}" is {"a unit" if is_unit else "used in conditions"} and cannot '
                "be an index",
                name.span,
                hint="choose another word, such as i",
            )
        self.indices.append(name)
        return name.key

    def _values(
        self, said: RepeatedCounting | RepeatedFor, reader: SentenceReader
    ) -> list[Value]:
        """Return the values of the index, in order."""
        if isinstance(said, RepeatedFor):
            items = said.values.items if isinstance(said.values, s.Listing) else ()
            if not items:
                reader.reject_form()
            return [one if isinstance(one, s.Name) else self._whole(one) for one in items]
        first, last = self._whole(said.first), self._whole(said.last)
        if first > last:
            place = reader.clauses["from"].span.to(reader.clauses["to"].span)
            self.findings.reject(
                "TIS308", f"there is no number from {first} to {last}", place,
                hint=proposal(f"from {last} to {first}"),
            )  # fmt: skip
        if last - first >= MOST:
            message = f"at most {MOST} repetitions are possible"
            self.findings.reject("TIS116", message, said.span)
        return list(range(first, last + 1))

    def _whole(self, node: s.Expression) -> int:
        match node:
            case s.Number(value=value) if value == int(value):
                return int(value)
            case s.Signed(operand=s.Number(value=value)) if value == int(value):
                return -int(value)
            case _:
                self.findings.reject(
                    "TIS312", "repetitions are counted with whole numbers", node.span,
                    hint="write the number itself, such as 8",
                )  # fmt: skip


class _Copy(Struct, frozen=True):
    """One value of an index.

    Attributes:
        index: The word that it replaces.
        value: A number or a word.
    """

    index: str
    value: Value

    @property
    def text(self) -> str:
        return self.value.text if isinstance(self.value, s.Name) else str(self.value)

    def of(self, item: s.Item) -> s.Item:
        """Return a copy of an item."""
        return cast(s.Item, self._node(item))

    def _node(self, node: Any, *, names: bool = False) -> Any:
        match node:
            case Span():
                said = f"{self.index} = {self.text}"
                return replace(
                    node, repetition=", ".join(filter(None, [said, node.repetition]))
                )
            case s.Name():
                return self._name(node, names=names)
            case tuple():
                parts = cast(tuple[Any, ...], node)
                return tuple(self._node(part, names=names) for part in parts)
            case s.Node():
                fields = {name: getattr(node, name) for name in node.__struct_fields__}
                return replace(
                    node,
                    **{
                        name: self._node(part, names=name in _NAMES)
                        for name, part in fields.items()
                    },
                )
            case _:
                return node

    def _name(self, name: s.Name, *, names: bool) -> s.Expression:
        """Return a name with the value in place of the index; a number for the index alone."""
        span = self._node(name.span)
        if name.key == self.index and name.quoted is None and not names:
            if isinstance(self.value, s.Name):
                return replace(self.value, span=span)
            number = s.Number(float(abs(self.value)), span)
            return s.Signed(number, span) if self.value < 0 else number
        words = " ".join(
            self.text if word.lower() == self.index else word for word in name.words.split(" ")
        )
        quoted = None if name.quoted is None else self._in_quotes(name.quoted)
        listed = tuple(self._name(one, names=True) for one in name.listed)
        return s.Name(words, quoted, span, cast(tuple[s.Name, ...], listed))

    def _in_quotes(self, text: str) -> str:
        def value(found: re.Match[str]) -> str:
            if isinstance(self.value, s.Name):
                return found[0] if found["sign"] else self.text
            by = int(found["number"] or 0)
            return str(self.value - by if found["sign"] == "-" else self.value + by)

        pattern = _IN_QUOTES.format(index=re.escape(self.index))
        return re.sub(pattern, value, text, flags=re.IGNORECASE)
