"""How the words of a scale are written: their corners, and the numerals of these."""

import math
import re
from collections.abc import Iterator, Sequence

from msgspec import Struct

from tissuec.core.prefixes import shown_units
from tissuec.core.source import Span
from tissuec.core.units import Dimension, parse_unit, si_unit
from tissuec.fuzzy.scale import Axis
from tissuec.fuzzy.sets import Gaussian
from tissuec.lang import syntax as s
from tissuec.scene.program.declarations import Declared
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.words.phrases import NamedScale

#: Degrees of the corners of shapes that do not name them.
_DEGREES = {"triangle": (0.0, 1.0, 0.0), "trapezoid": (0.0, 1.0, 1.0, 0.0)}


class WrittenNumber(Struct, frozen=True):
    """A number in the text and its coordinate."""

    node: s.Expression
    place: float


class WordForm(Struct, frozen=True):
    """A word of a scale, in the coordinate of the scale.

    Attributes:
        name: As it is spelt in the text.
        corners: Coordinates, ascending, not cut to the range; of a bell, its mean.
        degrees: Of each corner.
        bell: The bell; None for sets with corners.
        numbers: What is written of corners, or of the mean.
        sigma: What is written of the width of a bell.
        span: What is written after the equals sign; of plateaus, their sentence.
    """

    word: str
    name: str
    corners: tuple[float, ...]
    degrees: tuple[float, ...]
    bell: Gaussian | None
    numbers: tuple[WrittenNumber, ...]
    sigma: s.Expression | None
    span: Span


class ScaleForm(Struct, frozen=True):
    """A scale as it is written.

    Attributes:
        key: Name of the property or quantity, in small letters.
        words: In written order.
        evenly: The entry that lists them, if they are laid out evenly.
        block: The property or quantity.
    """

    key: str
    named: NamedScale
    words: tuple[WordForm, ...]
    evenly: s.Assign | None
    block: s.Block


def read_form(declared: Declared, named: NamedScale, scope: Scope) -> ScaleForm:
    """Return how a scale without errors is written.

    Args:
        declared: Its declaration.
        scope: Looks up names of expressions.
    """
    block = declared.item
    assert isinstance(block, s.Block)
    items = [item for item in block.items if not _is_no_word(item, block)]
    evenly = None
    match items:
        case [s.Assign(name=s.Name(key="evenly"), value=s.Listing(items=names)) as evenly]:
            words = [_even(name, named) for name in names if isinstance(name, s.Name)]
        case [s.Sentence(), *_]:
            words = [_plateau(item, named, scope) for item in _sentences(items)]
        case _:
            words = [_shape(item, named, scope) for item in items if isinstance(item, s.Assign)]
    return ScaleForm(declared.name.key, named, tuple(words), evenly, block)


def spelt(name: s.Name) -> str:
    """Return a name as a text has it, with its quotes."""
    return name.words if name.quoted is None else f'{name.words} "{name.quoted}"'.strip()


def _is_no_word(item: s.Item, block: s.Block) -> bool:
    """Return whether an entry of a quantity says something else than words do."""
    if not block.name.key.startswith("quantity ") or not isinstance(item, s.Sentence):
        return False
    return item.name.key == "applies" or (
        item.name.key == "otherwise" and item.phrase is not None
    )


def _sentences(items: Sequence[s.Item]) -> Iterator[s.Sentence]:
    return (item for item in items if isinstance(item, s.Sentence))


def _even(name: s.Name, named: NamedScale) -> WordForm:
    return _placed(name, named, (), name.span)


def _plateau(item: s.Sentence, named: NamedScale, scope: Scope) -> WordForm:
    nodes = [clause.value for clause in item.clauses]
    return _placed(item.name, named, tuple(_written(nodes, named, scope)), item.span)


def _placed(
    name: s.Name, named: NamedScale, numbers: tuple[WrittenNumber, ...], span: Span
) -> WordForm:
    """Return a word of a scale that is parted among its words: nothing leaves the range."""
    shape = named.scale.words[name.key]
    assert not isinstance(shape, Gaussian)
    # The flat parts between the ends of the range and the feet are not the word's own.
    true = [i for i, y in enumerate(shape.ys) if y > 0.0]
    own = slice(max(true[0] - 1, 0), true[-1] + 2)
    xs, ys = shape.xs[own], shape.ys[own]
    return WordForm(name.key, spelt(name), xs, ys, None, numbers, None, span)


def _shape(item: s.Assign, named: NamedScale, scope: Scope) -> WordForm:
    call = item.value
    assert isinstance(call, s.Call)
    nodes, kind = [argument.value for argument in call.arguments], call.function.key
    shape = named.scale.words[item.name.key]
    name, span = spelt(item.name), call.span
    if isinstance(shape, Gaussian):
        numbers = tuple(_written(nodes[:1], named, scope))
        return WordForm(
            item.name.key, name, (shape.mean,), (1.0,), shape, numbers, nodes[1], span
        )
    degrees = _DEGREES.get(kind) or tuple(float(scope.number(y).amount) for y in nodes[1::2])
    numbers = tuple(_written(nodes[::2] if kind == "points" else nodes, named, scope))
    corners = tuple(number.place for number in numbers)
    return WordForm(item.name.key, name, corners, degrees, None, numbers, None, span)


def _written(
    nodes: Sequence[s.Expression], named: NamedScale, scope: Scope
) -> Iterator[WrittenNumber]:
    for node in nodes:
        value = float(scope.number(node).amount)
        yield WrittenNumber(node, named.scale.axis.coordinate(value))


_NUMERAL = re.compile(r"[0-9]+(\.[0-9]+)?([eE][+-]?[0-9]+)?")
_MOST_DIGITS = 17  # that a float can represent
_SAME = 15  # digits that survive a change of units

#: As a part of the smallest gap: what a rounded place may differ by.
CLOSE = 1e-11


class Numerals:
    """Numerals for the places of one scale.

    A place that is written several times gets the same numeral everywhere, so that corners that
    are shared stay shared in the text.

    Args:
        gap: The smallest distance between places, in the coordinate.
        close: Allowed deviation of a written place, as a part of the gap.
    """

    def __init__(self, axis: Axis, dimension: Dimension, gap: float, close: float = CLOSE):
        self._axis = axis
        self._dimension = dimension
        self._near = max(close * gap, axis.rounding)
        #: Numerals with the sizes of their units, by place.
        self._written: dict[float, tuple[str, float]] = {}

    def place(self, place: float, node: s.Expression | None = None) -> str:
        """Return a coordinate as a number with its unit, that of ``node`` if it has one."""
        value = math.exp(place) if self._axis.log else place
        factor, unit = self._unit(value, node)
        if place not in self._written:
            texts = _numerals(value / factor)
            close = (t for t in texts if self._is_close(float(t) * factor, place))
            self._written[place] = next(close, texts[-1]), factor
        text, written_in = self._written[place]
        if written_in != factor:
            text = f"{float(text) * written_in / factor:.{_SAME}g}"
        return text + unit

    def value(self, place: float) -> float:
        """Return the value of the numeral at a place."""
        text, factor = self._written[place]
        return float(text) * factor

    def width(self, value: float, node: s.Expression) -> str:
        """Return a positive number with its unit, to nearly all digits."""
        factor, unit = self._unit(value, node)
        texts = _numerals(value / factor)
        close = (t for t in texts if abs(float(t) * factor - value) <= CLOSE * value)
        return next(close, texts[-1]) + unit

    def _is_close(self, value: float, place: float) -> bool:
        if self._axis.log:
            return value > 0.0 and abs(math.log(value) - place) <= self._near
        return abs(value - place) <= self._near

    def _unit(self, value: float, node: s.Expression | None) -> tuple[float, str]:
        """Return the size of a unit and how it is written after a number."""
        match node:
            case s.Signed(operand=s.Number() | s.Quantity() as operand):
                return self._unit(value, operand)
            case s.Number():
                return 1.0, ""
            case s.Quantity(unit=unit, span=span):
                return parse_unit(unit).factor, _NUMERAL.sub("", span.text, count=1)
            case _:
                known = shown_units(si_unit(self._dimension))
                chosen = ([one for one in known if one.size <= abs(value)] or known[:1])[-1]
                return chosen.size, f" {chosen.unit}".rstrip()


def _numerals(value: float) -> list[str]:
    """Return a number with more and more digits; the last one is exact."""
    texts = [f"{value:.{digits}g}" for digits in range(3, _MOST_DIGITS)]
    return [*texts, repr(float(value))]
