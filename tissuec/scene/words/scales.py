"""Properties and quantities: a range, and the words for its parts."""

from collections.abc import Sequence

from msgspec import Struct

from tissuec.core.errors import Note
from tissuec.core.hints import alternatives, leaving_out, proposal
from tissuec.core.source import Span
from tissuec.core.units import LENGTH, NUMBER, Dimension, describe, show
from tissuec.fuzzy.scale import Axis, Plateau, Scale, evenly, gaps, plateaus, shaped
from tissuec.fuzzy.sets import Gaussian, Shape, points, trapezoid, triangle
from tissuec.lang import syntax as s
from tissuec.scene.reading import schema
from tissuec.scene.reading.entries import by_name, written
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.reading.parts import block, declare
from tissuec.scene.tissues.quantities import LISTED, QUANTITIES, Spread
from tissuec.scene.words.phrases import NamedScale

#: How the shapes of words are written.
SHAPES = {
    "triangle": "(a, b, c)",
    "trapezoid": "(a, b, c, d)",
    "gaussian": "(mean, sigma)",
    "points": "(x, degree, x, degree, …)",
}


_EVENLY = written(
    "evenly", "Divides the range into equal parts, one for each word.",
    "evenly = [WORD, WORD, WORD]", begins=" = [",
)  # fmt: skip
_QUANTITY_ENTRIES = by_name(
    _EVENLY,
    written(
        "applies", "The object that one value belongs to: a spring, a node, or the whole body.",
        "applies to SPREAD of LENGTH",
    ),
    written("otherwise", "The fallback word if no rule fires.", "otherwise is WORD"),
)  # fmt: skip
_WORDS = "WORD from NUMBER to NUMBER until NUMBER"
declare(
    "property", "A property that describes a tissue: a range, and words for its parts.", 11,
    forms=("property NAME from NUMBER to NUMBER on log scale",),
    example="property NAME from 0 to 1 { … }", block=block(by_name(_EVENLY), _WORDS),
    names="scales",
)  # fmt: skip
declare(
    "quantity",
    "A physical quantity that rules conclude: a range, and words for its parts.", 12,
    forms=("quantity NAME from NUMBER to NUMBER on log scale",),
    example="quantity NAME from 1 N/m to 9 N/m { … }", block=block(_QUANTITY_ENTRIES, _WORDS),
    names="scales",
)  # fmt: skip


class QuantityScale(Struct, frozen=True):
    """A quantity of a vocabulary: its words, its range of application, and its fallback.

    Attributes:
        length: Spring length that values hold for [m]; None: for every length.
        otherwise: The phrase that holds where no rule speaks; None without one.
    """

    named: NamedScale
    spread: Spread
    length: float | None
    otherwise: s.Sentence | None


class ScaleReader:
    """Reads one ``property`` or ``quantity`` block."""

    def __init__(self, name: s.Name, item: s.Item, scope: Scope):
        assert isinstance(item, s.Block)
        self.name = name
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

    def _parts(self) -> tuple[s.Sentence | None, s.Sentence | None, list[s.Item]]:
        """Return the sentences with "applies" and "otherwise", if any, and the words."""
        applies: s.Sentence | None = None
        otherwise: s.Sentence | None = None
        words: list[s.Item] = []
        for item in self.block.items:
            match item:
                case s.Sentence(name=s.Name(key="applies")):
                    applies = item
                case s.Assign(name=s.Name(key="applies")):
                    hint = proposal(f"applies to {item.value.span.text}")
                    message = '"applies" is followed by "to", not by "="'
                    self.findings.reject("TIS312", message, item.span, hint=hint)
                case s.Sentence(name=s.Name(key="otherwise")) if item.phrase is not None:
                    otherwise = item
                case s.Assign(name=s.Name(key="otherwise"), value=value) if not isinstance(
                    value, s.Call
                ):
                    schema.refuse_sign(item, self.scope, example="otherwise is WORD")
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
        words = {clause.word: clause for clause in item.clauses}
        target = words["to"].value if "to" in words else None
        if (
            not isinstance(target, s.Name)
            or target.key not in quantity.spreads
            or set(words) - {"to", "of"}
        ):
            choices = list(quantity.spreads) + (
                ["each spring of 1 mm"] if quantity.scales else []
            )
            self.findings.reject(
                "TIS305",
                f"{self.name.text} must apply to one of: {', '.join(choices)}",
                item.span,
            )
        length = None
        if "of" in words:
            if not quantity.scales:
                self.findings.reject(
                    "TIS305",
                    f"{self.name.text} does not depend on the length of a spring",
                    words["of"].span,
                )
            value = self.scope.number(words["of"].value)
            self.scope.expect(
                value, LENGTH, words["of"].value.span, what="the length of a spring"
            )
            length = float(value.amount)
        return next(spread for spread in quantity.spreads if spread == target.key), length

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
        words = {clause.word: clause for clause in self.block.clauses}
        if (
            not {"from", "to"} <= set(words)
            or set(words) - {"from", "to", "on"}
            or len(words) < len(self.block.clauses)
        ):
            self.findings.reject(
                "TIS312",
                "write a range as: from 0 to 1, or from 1 N to 9 N on log scale",
                self.block.head,
            )
        low, high = (self.scope.number(words[word].value) for word in ("from", "to"))
        self.scope.expect(
            high, low.dimension, words["to"].value.span, what="the end of the range"
        )
        log = "on" in words
        if log and words["on"].value.span.text.lower() != "log scale":
            self.findings.reject(
                "TIS305", 'only "on log scale" is allowed here', words["on"].span
            )
        try:
            return Axis(
                self.name.text, float(low.amount), float(high.amount), log=log
            ), low.dimension
        except ValueError as error:
            self.findings.reject("TIS308", str(error), self._range())

    def _range(self) -> Span:
        """Return the span of the range after the name: from … to …"""
        clauses = self.block.clauses
        return clauses[0].span.to(clauses[-1].span) if clauses else self.block.head

    def _words(self, items: Sequence[s.Item], axis: Axis, dimension: Dimension) -> Scale:
        match items:
            case [s.Assign(name=s.Name(key="evenly"), value=s.Listing(items=names))]:
                words = [name for name in names if isinstance(name, s.Name)]
                if len(words) < len(names):
                    self.findings.reject(
                        "TIS312",
                        "evenly needs a list of words: [soft, medium, hard]",
                        items[0].span,
                    )
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
        numbers = {
            clause.word: self._number(clause.value, dimension) for clause in item.clauses
        }
        match sorted(numbers):
            case ["until"]:
                return Plateau(item.name.key, None, numbers["until"])
            case ["from"]:
                return Plateau(item.name.key, numbers["from"], None)
            case ["from", "to"]:
                return Plateau(item.name.key, numbers["from"], numbers["to"])
            case _:
                self.findings.reject(
                    "TIS312",
                    "write plateaus as: "
                    "soft until 0.15; medium from 0.4 to 0.6; hard from 0.85",
                    item.span,
                )

    def _shape(self, item: s.Item, dimension: Dimension) -> tuple[str, Shape]:
        if (
            not isinstance(item, s.Assign)
            or not isinstance(item.value, s.Call)
            or item.value.function.key not in SHAPES
        ):
            self.findings.reject(
                "TIS312", f"a word must be a shape: {', '.join(SHAPES)}", item.span
            )
        kind, span = item.value.function.key, item.value.span
        nodes = [argument.value for argument in item.value.arguments]
        form = SHAPES[kind]
        is_whole = (
            len(nodes) % 2 == 0 if kind == "points" else len(nodes) == form.count(",") + 1
        )
        if not is_whole:
            self.findings.reject("TIS312", f"write a {kind} as {kind}{form}", span)
        try:
            return item.name.key, self._build(kind, nodes, dimension)
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
