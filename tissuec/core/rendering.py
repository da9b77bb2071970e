"""Diagnostics as text, with an excerpt of the source."""

import unicodedata
from typing import TYPE_CHECKING

from tissuec.core.printable import ODD, printable
from tissuec.core.source import Span

if TYPE_CHECKING:
    from tissuec.core.errors import Diagnostic, Note

#: Longer lines are shown as a window of this width around the place.
_WIDEST = 160
_TAB = 4

_RED, _YELLOW, _BLUE, _BOLD, _PLAIN = (
    "\033[1;31m",
    "\033[1;33m",
    "\033[1;34m",
    "\033[1m",
    "\033[0m",
)


def render(diagnostic: "Diagnostic", *, color: bool = False) -> str:
    """Return a diagnostic as text: headline, place, excerpt, hint and notes."""
    message, hint = printable(diagnostic.message), printable(diagnostic.hint)
    tone = _RED if diagnostic.severity == "error" else _YELLOW
    paint = _paint if color else _leave
    head = paint(f"{diagnostic.severity}[{diagnostic.code}]", tone)
    lines = [f"{head}: {paint(message, _BOLD)}"]
    span = diagnostic.span
    gutter = " " * (len(str(span.line)) if span else 1)
    if span:
        code, carets = _excerpt(span)
        bar = paint("|", _BLUE)
        lines.append(f"  {paint('-->', _BLUE)} {printable(span.place)}:{span.column}")
        lines.append(f"{gutter} {bar}")
        lines.append(f"{paint(str(span.line), _BLUE)} {bar} {code}".rstrip())
        lines.append(f"{gutter} {bar} {paint(carets, tone)}")
    if hint:
        lines.append(f"{gutter} {paint('=', _BLUE)} hint: {hint}")
    lines += (
        f"{gutter} {paint('=', _BLUE)} note: {printable(_note(n, span))}"
        for n in diagnostic.notes
    )
    return "\n".join(lines)


def _paint(text: str, tone: str) -> str:
    return f"{tone}{text}{_PLAIN}"


def _leave(text: str, _tone: str) -> str:
    return text


def _note(note: "Note", main: Span | None) -> str:
    elsewhere = note.span and (main is None or note.span.place != main.place)
    return f"{note.message} at {note.span.place}" if note.span and elsewhere else note.message


def _excerpt(span: Span) -> tuple[str, str]:
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
