"""The first line, ``language 1``: which version of the language a text is written in."""

import re

from tissuec.core.errors import CompileError, Diagnostic, Edit, Hint, did_you_mean, insertion
from tissuec.core.source import Source, Span

#: The version of the language that this compiler reads.
VERSION = 1

_GAP = re.compile(r"[\n; \t]*")
_HEADING = re.compile(r"language[ \t]+([0-9]+(?:\.[0-9]+)*)(?![\w.])")
_REST = re.compile(r"[^\n;]*")
_FIRST = re.compile(r"\w+|[^\w\n]|")


def check_heading(source: Source, text: str) -> Diagnostic | None:
    """Return the error of the first line, if there is one.

    Args:
        text: The text as laid out for the grammar.

    Raises:
        CompileError: The text is written in another version, so that nothing more can be said.
    """
    start = len(_GAP.match(text)[0])  # type: ignore[index]  # matches any text
    heading = _HEADING.match(text, start)
    if heading is None:
        return _no_heading(source, text, start)
    if heading[1] == str(VERSION):
        return None
    message = f"language {heading[1]} is not supported"
    hint = f'this release reads "language {VERSION}"'
    raise CompileError([Diagnostic("TIS118", message, Span(source, *heading.span(1)), hint)])


def _no_heading(source: Source, text: str, start: int) -> Diagnostic:
    first = _FIRST.match(text, start)
    assert first is not None  # it matches nothing at the end
    span = Span(source, min(start, len(source.text)), min(first.end(), len(source.text)))
    if first[0].lower() == "language" and first[0] != "language":
        message = f'"{first[0]}" is a reserved word; write it in lower case'
        return Diagnostic(
            "TIS103", message, span, Hint(f'write "language {VERSION}"', Edit("language"))
        )
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


def first_line(text: str, source: Source) -> Edit:
    """Return the edit that puts a line below the version of the language."""
    heading = _HEADING.search(source.text)
    return insertion(f"\n{text}", Span(source, 0, heading.end() if heading else 0))


def last_line(text: str, source: Source) -> Edit:
    """Return the edit that puts a line at the end of a text."""
    end = len(source.text.rstrip())
    return insertion(f"\n{text}", Span(source, end, end))
