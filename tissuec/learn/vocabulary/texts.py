"""The text of a vocabulary whose words moved: numbers are replaced at their spans."""

from collections.abc import Iterable, Iterator
from itertools import pairwise
from math import expm1
from typing import NamedTuple

import numpy as np

from tissuec.core.source import Source, Span
from tissuec.fuzzy.scale import Scale
from tissuec.fuzzy.sets import Gaussian
from tissuec.lang import syntax as s
from tissuec.learn.vocabulary.scale_texts import CLOSE, Numerals, WordForm
from tissuec.learn.vocabulary.scales import MovingScale
from tissuec.model.network import Floats


class TextEdit(NamedTuple):
    """A stretch of a text and what comes in its place."""

    span: Span
    text: str


def apply(edits: Iterable[TextEdit]) -> dict[str, str]:
    """Return the new text of every source that is edited, by its name.

    Edits do not overlap; those of one place stay in their order.
    """
    by_source: dict[Source, list[TextEdit]] = {}
    for edit in edits:
        by_source.setdefault(edit.span.source, []).append(edit)
    return {source.name: _edited(source, some) for source, some in by_source.items()}


def _edited(source: Source, edits: list[TextEdit]) -> str:
    pieces: list[str] = []
    place = 0
    for edit in sorted(edits, key=lambda one: (one.span.start, one.span.end)):
        assert edit.span.start >= place
        pieces += source.text[place : edit.span.start], edit.text
        place = edit.span.end
    return "".join((*pieces, source.text[place:]))


def line_of(span: Span) -> tuple[int, int]:
    """Return where the lines that a span touches begin and end, without the last line end."""
    text = span.source.text
    end = text.find("\n", span.end)
    return text.rfind("\n", 0, span.start) + 1, len(text) if end < 0 else end


def indentation(span: Span) -> str:
    """Return the blanks at the beginning of the line on which a span begins."""
    start = line_of(span)[0]
    line = span.source.text[start : span.start]
    return line[: len(line) - len(line.lstrip(" \t"))]


def scale_edits(scale: MovingScale, theta: Floats, close: float = CLOSE) -> Iterator[TextEdit]:
    """Yield the edits that write a scale whose words moved.

    Args:
        theta: Parameters that move it, dimensionless, shape (number,).
        close: Allowed deviation of a written place, as a part of the smallest gap.
    """
    yield from _ScaleEdits(scale, theta, close).edits()


class _ScaleEdits:
    """Writes one scale."""

    def __init__(self, scale: MovingScale, theta: Floats, close: float):
        self.form = scale.form
        self.knots = scale.knots
        self.added = scale.added
        self.moves = scale.knots.moves(theta[: scale.knots.size])[0]
        self.moved: Scale = scale.scale(theta)
        named = scale.form.named
        gap = min(b - a for a, b in pairwise(np.array(self.knots.places) + self.moves))
        self.numerals = Numerals(named.scale.axis, named.dimension, gap, close)

    def edits(self) -> Iterator[TextEdit]:
        if self.form.evenly is not None:
            yield self._in_full(self.form.evenly)
            return
        for word in self.form.words:
            if word.word in self.added:
                yield TextEdit(word.span, self._points(word))
                continue
            for number in word.numbers:
                if self.knots.index(number.place) in self.knots.movable:
                    text = self.numerals.place(self._now(number.place), number.node)
                    yield TextEdit(number.node.span, text)
            if word.bell is not None and word.sigma is not None:
                yield from self._width(word, word.sigma)

    def _now(self, place: float) -> float:
        """Return where a corner is that the expert has at ``place``."""
        return place + float(self.moves[self.knots.index(place)])

    def _width(self, word: WordForm, node: s.Expression) -> Iterator[TextEdit]:
        """Yield the texts of the width of a bell, in values and not in coordinates."""
        bell, axis = self.moved.words[word.word], self.form.named.scale.axis
        assert isinstance(bell, Gaussian)
        if bell == word.bell:
            return
        if not axis.log:
            yield TextEdit(node.span, self.numerals.width(bell.sigma, node))
            return
        mean = axis.from_scale(bell.mean)
        if self.knots.index(word.corners[0]) in self.knots.movable:
            mean = self.numerals.value(self._now(word.corners[0]))
        yield TextEdit(node.span, self.numerals.width(mean * expm1(bell.sigma), node))

    def _points(self, word: WordForm) -> str:
        pairs = (
            f"{self._place(x)}, {y:.15g}"
            for x, y in zip(word.corners, word.degrees, strict=True)
        )
        return f"points({', '.join(pairs)})"

    # --- scales that were laid out evenly -----------------------------------------------------

    def _in_full(self, entry: s.Assign) -> TextEdit:
        """Return shapes in place of a list of words, each on a line of its own."""
        shapes = [f"{word.name} = {self._shape(word)}" for word in self.form.words]
        text, start, end = entry.span.source.text, entry.span.start, entry.span.end
        blanks = indentation(entry.span)
        if not text[line_of(entry.span)[0] : start].strip():
            return TextEdit(entry.span, f"\n{blanks}".join(shapes))
        # The block is on one line, which has no room for them.
        start -= len(text[:start]) - len(text[:start].rstrip(" \t"))
        rest = text[end:].lstrip(" \t")
        after = f"\n{blanks}" if rest.startswith("}") else ""
        if after:
            end = len(text) - len(rest)
        lines = "".join(f"\n{blanks}  {shape}" for shape in shapes)
        return TextEdit(Span(entry.span.source, start, end), lines + after)

    def _shape(self, word: WordForm) -> str:
        xs, ys = word.corners, word.degrees
        if ys == (0.0, 1.0, 0.0):
            return f"triangle({', '.join(map(self._place, xs))})"
        low, high = self.form.named.scale.axis.bounds
        ends = [low] * (xs[0] == low and ys[0] == 1.0), [high] * (ys[-1] == 1.0)
        return f"trapezoid({', '.join(map(self._place, (*ends[0], *xs, *ends[1])))})"

    def _place(self, place: float) -> str:
        """Return a corner; the ends of the range as these are written."""
        low, high = self.form.named.scale.axis.bounds
        ends = {clause.word: clause.value for clause in self.form.block.clauses}
        if place in (low, high):
            return ends["from" if place == low else "to"].span.text
        return self.numerals.place(self._now(place), ends["from"])
