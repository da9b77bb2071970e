"""Diagnostics about a text, and the exceptions that carry them."""

import re
import unicodedata
from collections.abc import Iterable
from typing import Any, Literal

from msgspec import Struct
from msgspec.structs import force_setattr

from tissuec.core.data import ODD, printable
from tissuec.core.hints import Edit, Hint
from tissuec.core.source import Span

_RED, _YELLOW, _BLUE, _BOLD = "\033[1;31m", "\033[1;33m", "\033[1;34m", "\033[1m"
_PLAIN = "\033[0m"


_LONGEST = 200  # characters of a message whose quotes are left as they are
_LONG_QUOTE = re.compile(r'"([^"]{60})[^"]{40,}"')


class Note(Struct, frozen=True):
    """A remark on a diagnostic; with a span it points at a second place."""

    message: str
    span: Span | None = None


class Diagnostic(Struct, frozen=True):
    """One finding about the text: what, where, and what to do about it."""

    code: str  # stable and documented, such as "TIS502"; warnings begin with "W"
    message: str
    span: Span | None  # None only where there is no text, such as a file that is missing
    hint: str = ""
    notes: tuple[Note, ...] = ()

    def __post_init__(self) -> None:
        # What is quoted may be a text of any length; the excerpt shows where it is.
        if len(self.message) > _LONGEST:
            force_setattr(self, "message", _LONG_QUOTE.sub(r'"\1…"', self.message))

    @property
    def severity(self) -> Literal["error", "warning"]:
        """Return "warning" for codes that begin with W, otherwise "error"."""
        return "warning" if self.code.startswith("W") else "error"

    @property
    def remarks(self) -> tuple[Note, ...]:
        """Return the notes, with the repetition that a finding is from."""
        repetition = self.span.repetition if self.span else ""
        return (*self.notes, Note(f"where {repetition}")) if repetition else self.notes

    @property
    def edits(self) -> tuple[Edit, ...]:
        """Return the edits that the hint proposes, each with its place."""
        if self.span is None or not isinstance(self.hint, Hint):
            return ()
        return tuple(edit.at(self.span) for edit in self.hint.edits)

    def __str__(self) -> str:
        return render(self)


class TissueError(Exception):
    """Base of every error that tissuec raises on purpose; its message can be shown anywhere."""

    def __str__(self) -> str:
        return printable(super().__str__())


class CompileError(TissueError):
    """The text does not describe a scene; holds every finding, not just the first.

    As text it is all of them, each with the place that it is about.
    """

    def __init__(self, diagnostics: Iterable[Diagnostic]):
        self.diagnostics = tuple(diagnostics)
        super().__init__(self.diagnostics)

    def __str__(self) -> str:
        return "\n\n".join(map(str, self.diagnostics))


class SimulationError(TissueError):
    """The run diverged or could not continue; the message names the spring, time and line."""


class ExpectationError(TissueError):
    """An expectation of the scene does not hold; the message gives the measured value."""


class TissueWarning(UserWarning):
    """A warning for callers from Python, which ``strict`` makes an error."""


def render(diagnostic: Diagnostic, *, color: bool = False) -> str:
    """Return a diagnostic as text: headline, place, excerpt, hint and notes."""
    message, hint = printable(diagnostic.message), printable(diagnostic.hint)
    tone = _RED if diagnostic.severity == "error" else _YELLOW
    paint = _paint if color else _leave
    head = paint(f"{diagnostic.severity}[{diagnostic.code}]", tone)
    lines = [f"{head}: {paint(message, _BOLD)}"]
    span = diagnostic.span
    gutter = " " * (len(str(span.line)) if span else 1)
    if span:
        code, carets = excerpt(span)
        bar = paint("|", _BLUE)
        lines.append(f"  {paint('-->', _BLUE)} {printable(span.place)}:{span.column}")
        lines.append(f"{gutter} {bar}")
        lines.append(f"{paint(str(span.line), _BLUE)} {bar} {code}".rstrip())
        lines.append(f"{gutter} {bar} {paint(carets, tone)}")
    if hint:
        lines.append(f"{gutter} {paint('=', _BLUE)} hint: {hint}")
    lines += (
        f"{gutter} {paint('=', _BLUE)} note: {printable(_note(n, span))}"
        for n in diagnostic.remarks
    )
    return "\n".join(lines)


def _paint(text: str, tone: str) -> str:
    return f"{tone}{text}{_PLAIN}"


def _leave(text: str, _tone: str) -> str:
    return text


def _note(note: Note, main: Span | None) -> str:
    elsewhere = note.span and (main is None or note.span.place != main.place)
    return f"{note.message} at {note.span.place}" if note.span and elsewhere else note.message


def in_order_of_text(diagnostics: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Return diagnostics by file and place, those without a place first."""
    return sorted(
        diagnostics,
        key=lambda d: (d.span.source.name, d.span.start) if d.span else ("", 0),
    )


def as_dict(diagnostic: Diagnostic) -> dict[str, Any]:
    """Return a diagnostic as plain values for JSON; lines and columns count from 1."""
    return {
        "code": diagnostic.code,
        "severity": diagnostic.severity,
        "message": diagnostic.message,
        **_place(diagnostic.span),
        "hint": str(diagnostic.hint),
        "edits": [{"text": edit.text, **_place(edit.span)} for edit in diagnostic.edits],
        "notes": [
            {"message": note.message, **_place(note.span)} for note in diagnostic.remarks
        ],
    }


def _place(span: Span | None) -> dict[str, Any]:
    if span is None:
        return dict.fromkeys(("file", "line", "column", "end_line", "end_column"))
    end = Span(span.source, span.end, span.end)
    return {
        "file": span.source.name,
        "line": span.line,
        "column": span.column,
        "end_line": end.line,
        "end_column": end.column,
    }


def counted(number: int, what: str) -> str:
    """Return a number and noun: ``1 spring``, ``2 passes``, ``2 media``, ``2 tetrahedra``."""
    if what.endswith(("um", "hedron")) and number != 1:
        return f"{number} {what[:-2]}a"
    ending = "es" if what.endswith(("s", "x", "ch", "sh")) else "s"
    return f"{number} {what}{'' if number == 1 else ending}"


def enumerated(names: Iterable[str], joined: str) -> str:
    """Return names as a list in a sentence: ``a``, ``a or b``, ``a, b or c``.

    Args:
        names: At least one.
        joined: The word before the last: "or" or "and".
    """
    *others, last = names
    return f"{', '.join(others)} {joined} {last}" if others else last


def shown_size(count: int) -> str:
    """Return a number of bytes: ``1.2 MB``."""
    for factor, unit in ((1e9, "GB"), (1e6, "MB"), (1e3, "kB")):
        if count >= factor:
            return f"{count / factor:.3g} {unit}"
    return counted(count, "byte")


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
