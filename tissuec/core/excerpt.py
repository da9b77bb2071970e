"""The line of a text that a finding is about, with carets under the place."""

import unicodedata

from tissuec.core.printable import ODD
from tissuec.core.source import Span

#: Longer lines are shown as a window of this width around the place.
_WIDEST = 160
_TAB = 4


def excerpt(span: Span) -> tuple[str, str]:
    """Return the first line of a span, and the carets that go under it."""
    line = span.source.line_text(span.line)
    start = min(span.column - 1, len(line))
    end = min(max(start + span.end - span.start, start), len(line))
    line, start, end = _window(line, start, end)
    before, marked, behind = (
        _visible(part) for part in (line[:start], line[start:end], line[end:])
    )
    return before + marked + behind, " " * _width(before) + "^" * max(_width(marked), 1)


def _window(line: str, start: int, end: int) -> tuple[str, int, int]:
    """Return the part of a long line around a stretch, and the stretch in it."""
    if len(line) <= _WIDEST:
        return line, start, end
    first = max(min(start - _WIDEST // 4, len(line) - _WIDEST), 0)
    last = first + _WIDEST
    left, right = "…" if first else "", "…" if last < len(line) else ""
    shift = len(left) - first
    return left + line[first:last] + right, start + shift, min(end, last) + shift


def _visible(text: str) -> str:
    """Return text without tabs and without what would disturb a terminal."""
    text = text.replace("\t", " " * _TAB)
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else " " if c.isspace() else ODD for c in text)


def _width(text: str) -> int:
    """Return how many columns a terminal takes for printable text."""
    if text.isascii():
        return len(text)
    return sum(
        0 if unicodedata.combining(c) else 2 if unicodedata.east_asian_width(c) in "WF" else 1
        for c in text
    )
