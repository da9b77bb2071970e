"""The first line, ``language 1``: which version of the language a text is written in."""

import re

from tissuec.core.errors import CompileError, Diagnostic, Note
from tissuec.core.hints import Edit, Hint, did_you_mean, insertion, removal
from tissuec.core.source import Source, Span
from tissuec.lang.tree import Statement

#: The version of the language that this compiler reads.
VERSION = 1

_VERSION = re.compile(r"[0-9]+(?:\.[0-9]+)*(?![\w.])")
_HEADING = re.compile(rf"language[ \t]+{_VERSION.pattern}")
_REST = re.compile(r"[^\n;]*")
_FIRST = re.compile(r"\w+|[^\w\n]|")


def check_heading(
    source: Source, first: Statement | None, later: Statement | None = None
) -> Diagnostic | None:
    """Return the error of the first line, if there is one.

    Args:
        first: Its first statement, if it has any.
        later: A statement below that gives the version of the language.

    Raises:
        CompileError: The text is written in another version, so that nothing more can be said.
    """
    parts = first.readable if first else []
    version = None
    if len(parts) > 1 and parts[0].type == "LANGUAGE":
        version = _VERSION.match(source.text, parts[1].start)
    if version is None:
        start = parts[0].start if parts else first.stop if first else len(source.text)
        return _late_heading(source, start, later) if later else _no_heading(source, start)
    if version[0] == str(VERSION):
        return None
    message = f"language {version[0]} is not supported"
    hint = f'this release reads "language {VERSION}"'
    raise CompileError([Diagnostic("TIS118", message, Span(source, *version.span()), hint)])


def _no_heading(source: Source, start: int) -> Diagnostic:
    first = _FIRST.match(source.text, start)
    assert first is not None  # it matches nothing at the end
    span = Span(source, start, first.end())
    message = "the first line must give the version of the language"
    heading = f"language {VERSION}"
    is_meant = bool(did_you_mean(first[0], ["language"]))
    line = Span(source, 0, 0)
    if is_meant:
        rest = _REST.match(source.text, span.end)
        assert rest is not None  # it matches nothing at the end
        line = Span(source, 0, span.end + len(rest[0]))
    edit = Edit(heading if is_meant else f"{heading}\n", line)
    return Diagnostic(
        "TIS117", message, span, Hint(f'write "{heading}" as the first line', edit)
    )


def _late_heading(source: Source, start: int, later: Statement) -> Diagnostic:
    """Return the error of a version below other statements."""
    text = source.text
    first = _FIRST.match(text, start)
    assert first is not None  # it matches nothing at the end
    span = Span(source, start, first.end())
    place = Span(source, later.parts[0].start, later.parts[-1].stop)
    without = removal(place).span
    assert without is not None  # a removal has a place
    above = Span(source, 0, without.end)
    heading = f"language {VERSION}"
    moved = Edit(f"{heading}\n{text[: without.start]}", above)
    message = "the first line must give the version of the language"
    hint = Hint(f'write "{heading}" as the first line instead', moved)
    return Diagnostic("TIS117", message, span, hint, (Note("it is here", place),))


def first_line(text: str, source: Source) -> Edit:
    """Return the edit that puts a line below the version of the language."""
    heading = _HEADING.search(source.text)
    return insertion(f"\n{text}", Span(source, 0, heading.end() if heading else 0))


def last_line(text: str, source: Source) -> Edit:
    """Return the edit that puts a line at the end of a text."""
    end = len(source.text.rstrip())
    return insertion(f"\n{text}", Span(source, end, end))
