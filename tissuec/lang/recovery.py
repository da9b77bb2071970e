"""Recovery from a syntax error: the bad statement, and where parsing resumes."""

import re
from typing import NamedTuple

_SEPARATOR = re.compile(r'"[^"\n]*"|[\n;{}]')
_BRACE = re.compile(r'"[^"\n]*"|[{}]')


class Statement(NamedTuple):
    """The stretch of text between two separators."""

    start: int
    end: int


def statement_at(text: str, begin: int, place: int) -> Statement:
    """Return the statement around ``place``, or before it if a separator stands there.

    Args:
        text: A text as laid out for the grammar.
        begin: Where a statement is known to begin, at or before ``place``.
    """
    start = begin
    for separator in _SEPARATOR.finditer(text, begin):
        if separator[0][0] == '"':
            continue
        if separator.start() >= place:
            return Statement(start, separator.start())
        start = separator.end()
    return Statement(start, len(text))


def resume_after(text: str, statement: Statement) -> tuple[str, int]:
    """Return the text without the bad statement, and the offset from which to go on.

    All before that offset has been parsed. If the statement was the head of a block, the braces
    of the block become separators, so that its items are looked at too. So do the closing
    braces of blocks that begin before it.
    """
    begin = statement.end
    if text.startswith("{", begin):
        begin += 1
    pieces: list[str] = []
    depth = 0
    done = 0
    for brace in _BRACE.finditer(text, begin):
        if brace[0] == "{":
            depth += 1
        elif brace[0] == "}" and depth:
            depth -= 1
        elif brace[0] == "}":
            pieces += text[done : brace.start()], ";"
            done = brace.end()
    return "".join((*pieces, text[done:])), begin
