"""The raw rows of a table: where they end, and their normal form."""

import re
from typing import NamedTuple

from tissuec.core.source import Source
from tissuec.lang.tokens import Token

#: A cell or the end of a row.
CELL = re.compile(r'"[^"\n]*"?|[\n;]|[^ \t\n;"]+')
_PART = re.compile(r'"[^"\n]*"?|#[^\n]*|[{}]')


class Rows(NamedTuple):
    """The text between the braces of a table.

    Attributes:
        start: Offset of the first character after the opening brace.
        end: Offset of the closing brace, or of the place where it is missing.
        comments: The remarks among the rows.
        open_quote: Offset of a quote that its line does not close, or None.
    """

    start: int
    end: int
    comments: tuple[Token, ...]
    open_quote: int | None


def find_rows(source: Source, start: int) -> Rows:
    """Return the rows that begin at ``start``; their text is not split."""
    comments: list[Token] = []
    open_quote = None
    for part in _PART.finditer(source.text, start):
        sign = part[0]
        if sign in "{}":
            return Rows(start, part.start(), tuple(comments), open_quote)
        if sign[0] == "#":
            comments.append(Token("COMMENT", sign, *part.span()))
        elif len(sign) == 1 or sign[-1] != '"':
            open_quote = part.start() if open_quote is None else open_quote
    return Rows(start, len(source.text), tuple(comments), open_quote)


def blank_comments(text: str) -> str:
    """Return rows with blanks in place of comments, so that offsets stay true."""
    if "#" not in text:
        return text
    return _PART.sub(lambda part: " " * len(part[0]) if part[0][0] == "#" else part[0], text)


def canonical_rows(text: str) -> str:
    """Return rows without comments: one per line, single blanks between cells.

    Only whole-text replacements, because a table may have a million rows.
    """
    text = blank_comments(text)
    if '"' in text:
        return "\n".join(" ".join(row) for row in quoted_rows(text))
    text = text.replace(";", "\n").replace("\t", " ")
    # Runs of blanks halve in each round.
    while "  " in text:
        text = text.replace("  ", " ")
    text = text.replace(" \n", "\n").replace("\n ", "\n")
    while "\n\n" in text:
        text = text.replace("\n\n", "\n")
    return text.strip(" \n")


def quoted_rows(text: str) -> list[list[str]]:
    """Return the cells of every row that is not empty, quoted cells with their quotes."""
    rows: list[list[str]] = [[]]
    for cell in CELL.findall(text):
        if cell in ("\n", ";"):
            rows.append([])
        else:
            rows[-1].append(cell)
    return [row for row in rows if row]
