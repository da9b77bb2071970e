"""A vocabulary as plain data: the tables from which ``inference.js`` infers as Python does.

Sets are numbered, equal ones once: the page distinguishes words as a rule base does. All
coordinates are those of the scale (see :mod:`tissuec.fuzzy.scale`), all values are in SI units.
"""

import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from tissuec.compiler.provenance import belonging
from tissuec.core.data import as_data
from tissuec.core.prefixes import shown_units
from tissuec.core.source import Span
from tissuec.core.units import FROM_KILO, SYMBOLS, Dimension, describe, parse_unit, si_unit
from tissuec.fuzzy import rules as c
from tissuec.fuzzy.hedges import hedged, moves
from tissuec.fuzzy.rules import ConcludedQuantity
from tissuec.fuzzy.scale import Axis
from tissuec.fuzzy.sets import FAINTEST, NEGLIGIBLE, REACH, AnyShape, Gaussian, Powered, Word
from tissuec.lang import syntax as s
from tissuec.lang.walk import walk
from tissuec.lang.words import RESERVED, written_name
from tissuec.scene.program.resolved import ResolvedProgram
from tissuec.scene.tissues.evidence import KNOWN
from tissuec.scene.tissues.laws import BY_ENTRY
from tissuec.scene.tissues.quantities import QUANTITIES, TissueQuantity
from tissuec.scene.words.phrases import NamedScale, reading
from tissuec.scene.words.scales import QuantityScale
from tissuec.scene.words.vocabulary import RulesBlock

_NOT_TEXT = re.compile(r'("[^"\n]*")|#[^\n]*')
_READING = re.compile(r" \([^()]* \+ [^()]*\)$")  # "very hard (very + hard)"


def tables(words: ResolvedProgram) -> dict[str, Any]:
    """Return everything that a page needs for inference and for showing its results."""
    shapes = Shapes()
    vocabulary = words.vocabulary
    writer = _VocabularyWriter(words, shapes)
    return {
        "faintest": FAINTEST,
        "negligible": NEGLIGIBLE,
        "reach": REACH,
        "hedges": [_name(name, name) for name in vocabulary.hedges],
        "properties": [writer.property(*named) for named in vocabulary.properties.items()],
        "quantities": [writer.quantity(*scale) for scale in vocabulary.quantities.items()],
        "rules": [writer.rules(*rules) for rules in vocabulary.rules.items()],
        "shapes": shapes.rows,
        "units": {symbol: [factor, *kind] for symbol, (factor, kind) in SYMBOLS.items()},
        "reserved": sorted(RESERVED),
    }


class Shapes:
    """Sets by number; a set that equals an earlier one has its number."""

    def __init__(self) -> None:
        self.rows: list[dict[str, Any]] = []
        self._known: dict[AnyShape, int] = {}

    def number(self, shape: AnyShape) -> int:
        """Return the number of a set."""
        if shape not in self._known:
            row = self._row(shape)  # first, because a base precedes what is made of it
            self._known[shape] = len(self.rows)
            self.rows.append(row)
        return self._known[shape]

    def _row(self, shape: AnyShape) -> dict[str, Any]:
        match shape:
            case Gaussian(mean, sigma):
                return {"mean": mean, "sigma": sigma}
            case Powered(base, exponent):
                return {"base": self.number(base), "exponent": exponent}
            case _:
                return {"xs": shape.xs, "ys": shape.ys}


class _VocabularyWriter:
    """Writes the parts of one vocabulary."""

    def __init__(self, words: ResolvedProgram, shapes: Shapes):
        self.words = words
        self.shapes = shapes

    def property(self, key: str, named: NamedScale) -> dict[str, Any]:
        return {
            **self._scale("property", key, named),
            "cannot_be_said": _cannot_be_said(key),
            "words": [self._word(word, named) for word in named.scale.words],
        }

    def quantity(self, key: str, scale: QuantityScale) -> dict[str, Any]:
        quantity, named = QUANTITIES[key], scale.named
        scales = self._scale("quantity", key, named)
        if key != "prestress":
            scales["ends"] = [quantity.show(scales[end], digits=6) for end in ("low", "high")]
        return {
            **scales,
            "shown_units": shown_units_of(quantity),
            "belonging": belonging(scale.spread, scale.length),
            "spread": scale.spread,
            "without": _without(quantity.default),
            "words": [
                {"word": word, "shape": self.shapes.number(shape)}
                for word, shape in named.scale.words.items()
            ],
        }

    def _scale(self, kind: str, key: str, named: NamedScale) -> dict[str, Any]:
        axis = named.scale.axis
        unit = _unit(self.words.declarations.of(kind)[key].item, named.dimension)
        factor = parse_unit(unit).factor if unit else 1.0
        return {
            **_name(key, named.name),
            "low": axis.low,
            "high": axis.high,
            "ends": [f"{end / factor:.6g} {unit}".rstrip() for end in (axis.low, axis.high)],
            "log": axis.log,
            "bounds": axis.bounds,
            "rounding": axis.rounding,
            "unit": unit,
            "factor": factor,
            "dimension": named.dimension,
            "kind": describe(named.dimension),
        }

    def _word(self, word: str, named: NamedScale) -> dict[str, Any]:
        """Return a word and, for each hedge that moves it, the word so hedged."""
        axis, shape = named.scale.axis, named.scale.words[word]
        hedges = self.words.vocabulary.hedges
        turned = {
            name: self._meaning(f"{name} {word}", hedged([hedge], shape, axis), axis)
            for name, hedge in hedges.items()
            if moves(hedge, shape, axis)
            and reading(f"{name} {word}", named.scale.words, hedges) == ((name,), word)
        }
        return {"word": word, **self._meaning(word, shape, axis), "hedged": turned}

    def _meaning(self, phrase: str, shape: AnyShape, axis: Axis) -> dict[str, Any]:
        number = self.shapes.number(shape)
        return {"phrase": written_name(phrase), "shape": number, "value": axis.value_of(shape)}

    # --- rules --------------------------------------------------------------------------------

    def rules(self, key: str, rules: RulesBlock) -> dict[str, Any]:
        block = self.words.declarations.of("rules")[key].item
        assert isinstance(block, s.Block)
        texts = [item for item in block.items if isinstance(item, s.Rule)]
        base = rules.base
        return {
            **_name(key, rules.name),
            "operators": as_data(base.operators),
            "otherwise": {
                name: self._concluded(quantity.otherwise)
                for name, quantity in base.quantities.items()
                if quantity.otherwise is not None
            },
            "rules": [
                {
                    "place": short_place(item.span),
                    "parts": list(_parts(item)),
                    "condition": self._condition(rule.condition),
                    "weight": rule.weight,
                    "conclusions": [
                        {"quantity": said.quantity}
                        | self._concluded(_within(said.word, base.quantities[said.quantity]))
                        for said in rule.conclusions
                    ],
                }
                for rule, item in zip(base.rules, texts, strict=True)
            ],
        }

    def _condition(self, condition: c.Condition) -> list[Any]:
        match condition:
            case c.Is(property, word):
                return ["is", property, self.shapes.number(word.shape)]
            case c.Not(operand):
                return ["not", self._condition(operand)]
            case c.And(operands):
                return ["and", *map(self._condition, operands)]
            case c.Or(operands):
                return ["or", *map(self._condition, operands)]

    def _concluded(self, word: Word) -> dict[str, Any]:
        number = self.shapes.number(word.shape)
        return {"word": _READING.sub("", word.text), "shape": number}


def _within(word: Word, quantity: ConcludedQuantity) -> Word:
    """Return a concluded word with the part of its set that lies in the range."""
    assert not isinstance(word.shape, Powered)
    return Word(word.text, word.shape.within(*quantity.axis.bounds))


def _name(key: str, text: str) -> dict[str, str]:
    return {"key": key, "name": text, "written": written_name(text)}


def shown_units_of(quantity: TissueQuantity) -> list[tuple[float | str, ...]]:
    """Return sizes and names of the units in which values are shown, the smallest first.

    A third number is the smallest value in a unit, instead of its size.
    """
    if quantity.name == "prestress":
        return [(0.01, "%")]
    if quantity.unit:
        return [(1.0, quantity.unit), (1e3, f"k{quantity.unit}", FROM_KILO)]
    return [(one.size, one.unit) for one in shown_units(si_unit(quantity.dimension))]


def _unit(item: s.Item, dimension: Dimension) -> str:
    """Return the unit in which the range of a scale is written, or an SI unit."""
    units = (
        part.unit for part in walk(getattr(item, "clauses", ())) if isinstance(part, s.Quantity)
    )
    fitting = (unit for unit in units if parse_unit(unit).dimension == dimension)
    return next(fitting, si_unit(dimension))


def _without(default: float | None) -> str:
    """Return the default of a quantity; empty where a net needs a number."""
    return "" if default is None else "0" if default == 0.0 else "none"


def _cannot_be_said(key: str) -> str:
    """Return why no tissue can be described by a property, because of its name."""
    begins_evidence = key.split(" ")[0] == KNOWN
    if key in QUANTITIES or key in BY_ENTRY or key in ("about", "described") or begins_evidence:
        return f'in a tissue, "{key}" is an entry of another kind'
    return ""


def _parts(rule: s.Rule) -> Iterator[tuple[str, str]]:
    """Yield a rule as written on one line, part by part, each with what it is.

    "is" and "not" are tests, in the order of the atoms of its condition; "then" is a
    conclusion; the rest, "", stands between them.
    """
    source, at = rule.span.source, rule.span.start
    for kind, span in (*_tests(rule.condition), *(("then", d.span) for d in rule.conclusions)):
        yield "", _line(Span(source, at, span.start))
        yield kind, _line(span)
        at = span.end
    yield "", _line(Span(source, at, rule.span.end))


def _tests(condition: s.Expression) -> Iterable[tuple[str, Span]]:
    for part in walk(condition):
        if isinstance(part, s.Is):
            yield ("not" if part.phrase.kind == "not" else "is"), part.span


def _line(span: Span) -> str:
    """Return text on one line without remarks; blanks at its ends stay, as one each."""
    text = _NOT_TEXT.sub(lambda found: found[1] or " ", span.text)
    return re.sub(r"\s+", " ", text)


def short_place(span: Span) -> str:
    """Return file and line without folders, which mean nothing to the receiver of a page."""
    return f"{Path(span.source.name).name}:{span.line}"
