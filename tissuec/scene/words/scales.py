"""Properties and quantities: a range, and the words for its parts."""

from collections.abc import Sequence
from typing import Annotated, Any

from msgspec import Struct

from tissuec.core.errors import Note
from tissuec.core.hints import alternatives, leaving_out, proposal
from tissuec.core.source import Span
from tissuec.core.units import LENGTH, NUMBER, Dimension, describe, show
from tissuec.fuzzy.scale import Axis, Plateau, Scale, evenly, gaps, plateaus, shaped
from tissuec.fuzzy.sets import Gaussian, Shape, points, trapezoid, triangle
from tissuec.lang import syntax as s
from tissuec.scene.reading import schema
from tissuec.scene.reading.block_sentences import SentenceKind, SentenceReader
from tissuec.scene.reading.entries import by_name, written
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.reading.parts import block, declare
from tissuec.scene.tissues.quantities import LISTED, QUANTITIES, Spread
from tissuec.scene.words.phrases import NamedScale
from tissuec.script.forms import VerbForm, VerbSentence
from tissuec.script.parts import (
    WORD,
    FlagPart,
    NameClause,
    NumberClause,
    Placeholder,
    UnionClause,
    ValueClause,
    new_name,
)

#: What one value can belong to.
SPREADS = ("each spring", "each node", "whole body")
Word = Annotated[s.Name, NameClause("", places=(WORD,))]
#: How the shapes of words are written.
SHAPES = {
    "triangle": "(a, b, c)",
    "trapezoid": "(a, b, c, d)",
    "gaussian": "(mean, sigma)",
    "points": "(x, degree, x, degree, …)",
}


class EvenlyWords(VerbSentence, frozen=True):
    """The words of parts of a range that are equally long."""

    words: Annotated[
        s.Name,
        UnionClause("=", places=(WORD,), count=3, example="= [low, medium, high]"),
    ]


class AppliesWords(VerbSentence, frozen=True):
    """What one value belongs to, and the length of a spring that it holds for [m]."""

    spread: Annotated[s.Name, NameClause("to", places=(Placeholder("SPREAD", words=SPREADS),))]
    length: Annotated[float | None, NumberClause("of", LENGTH, what="length of a spring")]


class OtherwiseWords(VerbSentence, frozen=True):
    """The word where no rule speaks."""

    word: Annotated[s.Name, NameClause("is", places=(Placeholder("WORD"),))]


EVENLY_KIND, APPLIES_KIND, OTHERWISE_KIND = map(
    SentenceKind, ((EvenlyWords,), (AppliesWords,), (OtherwiseWords,))
)
_EVENLY = written(
    "evenly", "Divides the range into equal parts, one for each word.", EvenlyWords,
    begins=" = [",
)  # fmt: skip
_QUANTITY_ENTRIES = by_name(
    _EVENLY,
    written(
        "applies", "The object that one value belongs to: a spring, a node, or the whole body.",
        AppliesWords,
    ),
    written("otherwise", "The fallback word if no rule fires.", OtherwiseWords),
)  # fmt: skip


class PlateauBetween(VerbSentence, frozen=True):
    """A word in the middle of a range."""

    word: Word
    low: Annotated[s.Expression, ValueClause("from", place="NUMBER")]
    high: Annotated[s.Expression, ValueClause("to", place="NUMBER")]


class PlateauUntil(VerbSentence, frozen=True):
    """The first word of a range."""

    word: Word
    high: Annotated[s.Expression, ValueClause("until", place="NUMBER")]


class PlateauFrom(VerbSentence, frozen=True):
    """The last word of a range."""

    word: Word
    low: Annotated[s.Expression, ValueClause("from", place="NUMBER")]


class ShapedWord(VerbSentence, frozen=True):
    """A word with a shape of its own."""

    word: Word
    shape: Annotated[
        s.Expression, ValueClause("=", places=(Placeholder("SHAPE"),), place="SHAPE")
    ]


PLATEAUS = SentenceKind(
    (PlateauBetween, PlateauUntil, PlateauFrom),
    examples=("soft until 0.15; medium from 0.4 to 0.6; hard from 0.85",),
    wrong="wrong form of a plateau",
)
SHAPED = SentenceKind((ShapedWord,))


class PropertyWords(VerbSentence, frozen=True):
    """A property and its range."""

    name: Annotated[s.Name, new_name("property")]
    low: Annotated[s.Expression, ValueClause("from", place="NUMBER")]
    high: Annotated[s.Expression, ValueClause("to", place="NUMBER")]
    is_log: Annotated[bool, FlagPart("on log scale", about="Use the logarithm of the values.")]


class QuantityWords(PropertyWords, frozen=True):
    """A quantity and its range."""

    name: Annotated[s.Name, new_name("quantity")]


_FREE = (*PLATEAUS.forms, *SHAPED.forms)
HEADS = {
    "property": SentenceKind((PropertyWords,)), "quantity": SentenceKind((QuantityWords,)),
}  # fmt: skip
declare(
    "property", "A property that describes a tissue: a range, and words for its parts.", 11,
    sentences=HEADS["property"].forms, example="property NAME from 0 to 1 { … }",
    block=block(by_name(_EVENLY), *_FREE), names="scales",
)  # fmt: skip
declare(
    "quantity",
    "A physical quantity that rules conclude: a range, and words for its parts.", 12,
    sentences=HEADS["quantity"].forms, example="quantity NAME from 1 N/m to 9 N/m { … }",
    block=block(_QUANTITY_ENTRIES, *_FREE), names="scales",
)  # fmt: skip


class QuantityScale(Struct, frozen=True):
    """A quantity of a vocabulary: its words, its range of application, and its fallback.

    Attributes:
        length: Spring length that values hold for [m]; None: for every length.
        otherwise: What holds where no rule speaks; None without it.
    """

    named: NamedScale
    spread: Spread
    length: float | None
    otherwise: OtherwiseWords | None


class _PlateauReader(SentenceReader):
    """Reads a word that holds fully in a part of the range."""

    def choose(self) -> VerbForm:
        for form in self.forms:
            if self.clauses.keys() == {word for word, *_ in form.clauses if word}:
                return form
        self.reject_form()


class ScaleReader:
    """Reads one ``property`` or ``quantity`` block."""

    def __init__(self, kind: str, name: s.Name, item: s.Item, scope: Scope):
        assert isinstance(item, s.Block)
        self.kind, self.name = kind, name
        self.block = item
        self.scope = scope
        self.findings = scope.findings

    def property(self) -> NamedScale:
        """Return the words of a property."""
        return self._scale(self.block.items)

    def quantity(self) -> QuantityScale:
        """Return a quantity with its range of application and its ``otherwise``."""
        if self.name.key not in QUANTITIES:
            self.findings.reject(
                "TIS205",
                f'"{self.name.text}" is not a quantity of a spring net',
                self.name.span,
                hint=alternatives(self.name.key, LISTED, what="quantities"),
            )
        quantity = QUANTITIES[self.name.key]
        applies, otherwise, words = self._parts()
        if quantity.is_of_matter:
            spread, length = self._of_matter(applies)
        elif applies is None:
            self.findings.reject(
                "TIS304",
                f'quantity {self.name.text} needs "applies to"',
                self.block.head,
                hint=schema.missing(f"applies to {quantity.spreads[0]}", self.block.head),
            )
        else:
            spread, length = self._applies(applies)
        named = self._scale(words)
        if named.dimension != quantity.dimension:
            self.findings.reject(
                "TIS502",
                f"{self.name.text} is {describe(quantity.dimension)}; "
                f"this range is {describe(named.dimension)}",
                self._range(),
            )
        return QuantityScale(named, spread, length, otherwise)

    def _parts(self) -> tuple[s.Sentence | None, OtherwiseWords | None, list[s.Item]]:
        """Return the sentences with "applies" and "otherwise", if any, and the words."""
        applies: s.Sentence | None = None
        otherwise: OtherwiseWords | None = None
        words: list[s.Item] = []
        for item in self.block.items:
            match item:
                case s.Sentence(name=s.Name(key="applies")):
                    applies = item
                case s.Assign(name=s.Name(key="applies")):
                    hint = proposal(f"applies to {item.value.span.text}")
                    message = '"applies" is followed by "to", not by "="'
                    self.findings.reject("TIS312", message, item.span, hint=hint)
                case s.Sentence() | s.Assign() if item.name.key == "otherwise":
                    otherwise = self._said("otherwise", OTHERWISE_KIND, item)
                case s.Sentence(clauses=()) if hint := schema.chosen(item, ("otherwise",)):
                    message = '"otherwise" is followed by "is" and a word'
                    self.findings.reject("TIS312", message, item.span, hint=hint)
                case _:
                    words.append(item)
        return applies, otherwise, words

    def _of_matter(self, applies: s.Sentence | None) -> tuple[Spread, None]:
        """Return the spread of a quantity of matter, which must not write "applies to"."""
        if applies is not None:
            self.findings.reject(
                "TIS305",
                f"{self.name.text} belongs to matter, not to springs or nodes",
                applies.span,
                hint=leaving_out('remove "applies to"', applies.span),
            )
        return "matter", None

    def _applies(self, item: s.Sentence) -> tuple[Spread, float | None]:
        quantity = QUANTITIES[self.name.key]
        said: AppliesWords = self._said("applies", APPLIES_KIND, item)
        key = said.spread.key
        spread: Spread | None = next((one for one in quantity.spreads if key == one), None)
        if spread is None:
            choices = list(quantity.spreads) + (
                ["each spring of 1 mm"] if quantity.scales else []
            )
            self.findings.reject(
                "TIS305",
                f"{self.name.text} must apply to one of: {', '.join(choices)}",
                item.span,
            )
        if said.length is not None and not quantity.scales:
            self.findings.reject(
                "TIS305",
                f"{self.name.text} does not depend on the length of a spring",
                item.clauses[-1].span,
            )
        return spread, said.length

    def _said(self, entry: str, kind: SentenceKind, item: s.Assign | s.Sentence) -> Any:
        return SentenceReader(entry, kind, item, self.scope).get()

    # --- the scale ----------------------------------------------------------------------------

    def _scale(self, items: Sequence[s.Item]) -> NamedScale:
        axis, dimension = self._axis()
        try:
            scale = self._words(items, axis, dimension)
        except ValueError as error:
            self.findings.reject(
                "TIS308", str(error), items[0].span if items else self.block.head
            )
        for low, high in gaps(scale):
            self.findings.add(
                "W201",
                f"no word covers the part of {self.name.text} from {show(low, dimension)} "
                f"to {show(high, dimension)}",
                self._range(),
                hint="make the neighbouring words wider, or add a word",
            )
        return NamedScale(self.name.text, scale, dimension, self.block.head)

    def _axis(self) -> tuple[Axis, Dimension]:
        reader = SentenceReader(self.kind, HEADS[self.kind], self.block, self.scope)
        said: PropertyWords = reader.get()
        low, high = self.scope.number(said.low), self.scope.number(said.high)
        self.scope.expect(high, low.dimension, said.high.span, what="the end of the range")
        ends = float(low.amount), float(high.amount)
        try:
            return Axis(self.name.text, *ends, log=said.is_log), low.dimension
        except ValueError as error:
            self.findings.reject("TIS308", str(error), self._range())

    def _range(self) -> Span:
        """Return the span of the range after the name: from … to …"""
        clauses = self.block.clauses
        return clauses[0].span.to(clauses[-1].span) if clauses else self.block.head

    def _words(self, items: Sequence[s.Item], axis: Axis, dimension: Dimension) -> Scale:
        match items:
            case [s.Assign(name=s.Name(key="evenly")) as item]:
                words = self._said("evenly", EVENLY_KIND, item).words.listed
                self._once([(word.text, word.span) for word in words])
                return evenly(axis, [word.key for word in words])
            case [s.Sentence(), *_]:
                parts = [self._plateau(item, dimension) for item in items]
                self._once(
                    [(part.word, item.span) for part, item in zip(parts, items, strict=True)]
                )
                return plateaus(axis, parts)
            case [s.Assign(), *_]:
                shapes = [self._shape(item, dimension) for item in items]
                self._once(
                    [(word, item.span) for (word, _), item in zip(shapes, items, strict=True)]
                )
                return shaped(axis, dict(shapes))
            case _:
                self.findings.reject(
                    "TIS304",
                    f"{self.name.text} has no words",
                    self.block.head,
                    hint=schema.missing("evenly = [low, medium, high]", self.block.head),
                )

    def _once(self, words: Sequence[tuple[str, Span]]) -> None:
        """Reject a word that is declared a second time."""
        first: dict[str, Span] = {}
        for word, span in words:
            key = s.key_of(word)
            if key in first:
                self.findings.reject(
                    "TIS503",
                    f'"{word}" is defined twice',
                    span,
                    notes=(Note("first here", first[key]),),
                )
            first[key] = span

    def _plateau(self, item: s.Item, dimension: Dimension) -> Plateau:
        if not isinstance(item, s.Sentence):
            self.findings.reject(
                "TIS306", "plateaus and other shapes cannot be mixed", item.span
            )
        said: Any = _PlateauReader("", PLATEAUS, item, self.scope).get()
        ends = (getattr(said, name, None) for name in ("low", "high"))
        numbers = (None if end is None else self._number(end, dimension) for end in ends)
        return Plateau(said.word.key, *numbers)

    def _shape(self, item: s.Item, dimension: Dimension) -> tuple[str, Shape]:
        said: ShapedWord | None = None
        if isinstance(item, s.Assign):
            said = self._said("", SHAPED, item)
        call = said.shape if said is not None else None
        if said is None or not isinstance(call, s.Call) or call.function.key not in SHAPES:
            self.findings.reject(
                "TIS312", f"a word must be a shape: {', '.join(SHAPES)}", item.span
            )
        kind, span = call.function.key, call.span
        nodes = [argument.value for argument in call.arguments]
        form = SHAPES[kind]
        is_whole = (
            len(nodes) % 2 == 0 if kind == "points" else len(nodes) == form.count(",") + 1
        )
        if not is_whole:
            self.findings.reject("TIS312", f"write a {kind} as {kind}{form}", span)
        try:
            return said.word.key, self._build(kind, nodes, dimension)
        except ValueError as error:
            self.findings.reject("TIS308", f"{kind}{form}: {error}", span)

    def _build(self, kind: str, nodes: Sequence[s.Expression], dimension: Dimension) -> Shape:
        if kind == "points":
            xs = [self._number(node, dimension) for node in nodes[::2]]
            degrees = [self._number(node, NUMBER) for node in nodes[1::2]]
            return points(list(zip(xs, degrees, strict=True)))
        make = {"triangle": triangle, "trapezoid": trapezoid, "gaussian": Gaussian}[kind]
        return make(*[self._number(node, dimension) for node in nodes])

    def _number(self, node: s.Expression, dimension: Dimension) -> float:
        value = self.scope.number(node)
        self.scope.expect(value, dimension, node.span, what=f"a value of {self.name.text}")
        return float(value.amount)
