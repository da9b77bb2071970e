"""Edits of texts at spans; everything between them is unchanged."""

from collections.abc import Iterable
from typing import NamedTuple

from tissuec.core.source import Source, Span


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
