"""Canonical layout of a text, for ``tissuec fmt``.

Line breaks and comments stay where they are. Blanks, indentation, signs of units and needless
semicolons take one form each. What the text means stays the same, and a second pass changes
nothing.
"""

from collections.abc import Iterator
from typing import NamedTuple

from tissuec.core.source import Source
from tissuec.core.units import canonical_unit
from tissuec.lang.parser import parse_tree
from tissuec.lang.rows import blank_comments, quoted_rows
from tissuec.lang.tokens import Token
from tissuec.lang.tree import Tree
from tissuec.lang.tree_builder import tree_of

_STEP = "  "


class PrintedPiece(NamedTuple):
    """A piece to print: a token, a comment, or the rows of a table on one line."""

    kind: str  # type of the token, "COMMENT", "ROWS" or "SEMICOLON"
    text: str
    start: int
    end: int
    begins: bool  # whether it begins a statement or a row


def format_source(source: Source) -> str:
    """Return the text in canonical layout.

    Raises:
        CompileError: The text has mistakes; only text that parses can be laid out.
    """
    tree = tree_of(source)
    parse_tree(tree)
    pieces = _with_comments(_needed([*_pieces(tree)], source.text), [*tree.comments])
    return "".join(_printed(pieces, source.text)) + "\n"


# --- pieces -----------------------------------------------------------------------------------


def _pieces(tree: Tree) -> Iterator[PrintedPiece]:
    """Yield all of a text but line ends and comments."""
    first = {one.parts[0].start for one in tree.statements if one.parts}
    for token in tree.tokens:
        if token.type == "ROWS":
            yield from _row_pieces(token)
        elif token.type not in ("LINE", "COMMENT"):
            begins = token.start in first or token.type == "RBRACE"
            yield PrintedPiece(token.type, _spelling(token), token.start, token.stop, begins)


def _spelling(token: Token) -> str:
    """Return a token as it is printed: one blank before a unit, one form of its signs."""
    first, *unit = token.pieces
    return " ".join((first.text, *(canonical_unit(part.text) for part in unit)))


def _row_pieces(rows: Token) -> Iterator[PrintedPiece]:
    """Yield the rows of a table, those of one line together."""
    start, places, lines = rows.start, list[int](), list[str]()
    for line in blank_comments(rows.text).split("\n"):
        kept = line.strip("; \t")
        if kept:
            places.append(start + line.index(kept))
            lines.append(kept)
        start += len(line) + 1
    for place, line, printed in zip(places, lines, _aligned(lines), strict=True):
        yield PrintedPiece("ROWS", printed, place, place + len(line), begins=True)


def _aligned(lines: list[str]) -> list[str]:
    """Return the rows of a table, in columns where each line is one row."""
    if any(";" in line or '"' in line for line in lines):
        return ["; ".join(" ".join(row) for row in quoted_rows(line)) for line in lines]
    rows = [line.split() for line in lines]
    widths: dict[int, int] = {}
    for row in rows:
        for column, cell in enumerate(row):
            widths[column] = max(widths.get(column, 0), len(cell))
    return [" ".join(cell.rjust(widths[i]) for i, cell in enumerate(row)) for row in rows]


def _needed(pieces: list[PrintedPiece], text: str) -> Iterator[PrintedPiece]:
    """Yield all pieces but semicolons that separate nothing."""
    previous = None
    for piece, following in zip(pieces, [*pieces[1:], None], strict=True):
        if piece.kind == "SEMICOLON":
            if (
                previous is None
                or following is None
                or following.kind in ("SEMICOLON", "RBRACE")
            ):
                continue
            if previous.kind == "LBRACE" or "\n" in text[previous.end : following.start]:
                continue
        yield piece
        previous = piece


def _with_comments(
    pieces: Iterator[PrintedPiece], comments: list[Token]
) -> Iterator[PrintedPiece]:
    """Yield pieces and comments; a comment begins a statement if what follows it does."""
    waiting = list(reversed(comments))
    for piece in pieces:
        while waiting and waiting[-1].start < piece.start:
            yield _comment_piece(waiting.pop(), begins=piece.begins)
        yield piece
    while waiting:
        yield _comment_piece(waiting.pop(), begins=True)


def _comment_piece(comment: Token, *, begins: bool) -> PrintedPiece:
    return PrintedPiece("COMMENT", comment.text.rstrip(), comment.start, comment.stop, begins)


# --- printing ---------------------------------------------------------------------------------


def _printed(pieces: Iterator[PrintedPiece], text: str) -> Iterator[str]:
    """Yield pieces with the space before each."""
    depth = 0
    before = previous = None
    for piece in pieces:
        lines = text.count("\n", previous.end, piece.start) if previous else 0
        if lines:
            yield "\n" * min(lines, 2) + _indentation(piece, depth)
        elif previous and piece.kind == "COMMENT":
            yield "  "
        elif previous and blank_between(
            before.kind if before else "", previous.kind, piece.kind
        ):
            yield " "
        yield piece.text
        depth += {"LBRACE": 1, "RBRACE": -1}.get(piece.kind, 0)
        if previous is None or previous.kind != "COMMENT":
            before = previous
        previous = piece


def _indentation(piece: PrintedPiece, depth: int) -> str:
    """Return the blanks before the first piece of a line."""
    if piece.kind == "RBRACE":
        return _STEP * (depth - 1)
    continued = not piece.begins and piece.kind not in ("RPAR", "RSQB", "RPAR_UNIT")
    return _STEP * (depth + continued)


_OPENING = frozenset({"LPAR", "LSQB"})
_CLOSING = frozenset({"COMMA", "SEMICOLON", "COLON", "RPAR", "RSQB", "RPAR_UNIT"})
_SIGNS = frozenset({"PLUS", "MINUS"})

#: After one of these a sign joins two operands; elsewhere it belongs to the next one.
_OPERAND_ENDS = frozenset(
    {"WORD", "STRING", "NUMBER", "QUANTITY", "STEPS", "RPAR", "RPAR_UNIT", "RSQB"}
)


def blank_between(before: str, previous: str, following: str) -> bool:
    """Return whether a blank separates two neighbours.

    Args:
        before: Kind of the token before ``previous``; empty at the beginning.
        previous: Kind of the left neighbour.
        following: Kind of the right neighbour.
    """
    if previous in _OPENING or following in _CLOSING:
        return False
    if following == "LPAR" and previous in ("WORD", "STRING"):
        return False  # a call
    if "CIRCUMFLEX" in (previous, following):
        # Without a blank, "3 m ^ 2" would become the unit m^2.
        return (previous if following == "CIRCUMFLEX" else before) in ("QUANTITY", "RPAR_UNIT")
    return previous not in _SIGNS or before in _OPERAND_ENDS
