"""A syntax error as facts: statement, tokens, the wrong token, and accepted tokens."""

import re
from collections.abc import Iterator
from contextlib import suppress
from itertools import islice
from typing import Any, NamedTuple

from lark import Lark, Token, UnexpectedCharacters, UnexpectedInput, UnexpectedToken

from tissuec.core.source import Source, Span
from tissuec.lang.grammar import tokens
from tissuec.lang.recovery import Statement, statement_at

#: The type of a stand-in token for a character that begins no token.
CHARACTER = "CHARACTER"

#: What may be written as a unit, whether there are such units or not.
_UNIT = re.compile(r"\w+(\^-?[0-9]+)?([*/·]\w+(\^-?[0-9]+)?)*")

#: As many tokens behind the wrong one are looked at.
_ENOUGH = 100

#: Types of tokens that end a statement and belong to no statement.
ENDS = frozenset({"_NL", "$END", "RBRACE"})


class Mistake(NamedTuple):
    """The place at which the grammar could not continue.

    Attributes:
        source: The text.
        statement: The bad statement.
        before: Its tokens up to the wrong one.
        found: The wrong token.
        after: The tokens of the statement behind the wrong one.
        accepted: Types of tokens that could have stood in its place.
    """

    source: Source
    statement: Statement
    before: tuple[Token, ...]
    found: Token
    after: tuple[Token, ...]
    accepted: frozenset[str]

    @property
    def previous(self) -> str:
        """Return the type of the token before the wrong one, or an empty string."""
        return self.before[-1].type if self.before else ""

    @property
    def next(self) -> str:
        """Return the type of the token behind the wrong one, or an empty string."""
        return self.after[0].type if self.after else ""

    @property
    def first(self) -> str:
        """Return the type of the first token of the statement."""
        return self.before[0].type if self.before else self.found.type

    @property
    def unit(self) -> Span | None:
        """Return the words behind a number or vector that were to be its unit, if any."""
        if self.found.type != "WORD" or self.previous not in ("NUMBER", "QUANTITY", "RPAR"):
            return None
        start = self.found.start_pos or 0
        unit = _UNIT.match(self.source.text, start)
        return Span(self.source, start, unit.end()) if unit else None

    @property
    def can_end(self) -> bool:
        """Return whether the statement could have ended before the wrong token."""
        return bool(self.accepted & ENDS)

    @property
    def behind(self) -> Span:
        """Return the empty place behind the token before the wrong one."""
        end = (self.before[-1].end_pos if self.before else self.found.start_pos) or 0
        return Span(self.source, end, end)

    @property
    def blank(self) -> Span:
        """Return what stands between the wrong token and the one before it."""
        return Span(self.source, self.behind.start, self.span(self.found).start)

    @property
    def line_before(self) -> str:
        """Return what stands before the wrong token on its line."""
        span = self.span(self.found)
        return span.source.line_text(span.line)[: span.column - 1]

    def holds(self, kind: str) -> bool:
        """Return whether a token of this type stands before the wrong one."""
        return any(token.type == kind for token in self.before)

    def span(self, token: Token) -> Span:
        """Return the place of a token, within the text."""
        end = len(self.source.text)
        return Span(self.source, min(token.start_pos or 0, end), min(token.end_pos or 0, end))

    def text(self, first: Token, last: Token) -> str:
        """Return what is written from one token to another, with single blanks."""
        written = self.source.text[first.start_pos : last.end_pos]
        lines = (
            line.split("#")[0] if '"' not in line else line for line in written.split("\n")
        )
        return " ".join(" ".join(lines).split())


def mistake_of(
    error: UnexpectedInput, lark: Lark, source: Source, text: str, begin: int
) -> Mistake:
    """Return the facts of an error.

    Args:
        error: The error of the parser.
        lark: The parser.
        source: The source.
        text: The text as laid out for the parser.
        begin: Offset in the text at which parsing began.
    """
    found = _found(error, text)
    place = found.start_pos or 0
    statement = statement_at(text, begin, place)
    before = tuple(_readable(lark, text, statement.start, place))
    rest = _readable(lark, text, place, statement.end)
    after = tuple(token for token in islice(rest, _ENOUGH) if token.start_pos != place)
    untyped: Any = error
    accepted: frozenset[str] = frozenset(untyped.interactive_parser.accepts())
    return Mistake(source, statement, before, found, after, accepted)


def _found(error: UnexpectedInput, text: str) -> Token:
    untyped: Any = error  # Lark leaves what it holds without types
    if isinstance(error, UnexpectedToken) and untyped.token.type != "$END":
        return untyped.token
    if isinstance(error, UnexpectedCharacters):
        place = int(untyped.pos_in_stream or 0)
        return Token(CHARACTER, text[place], place, end_pos=place + 1)
    return Token("$END", "", len(text), end_pos=len(text))


def _readable(lark: Lark, text: str, start: int, end: int) -> Iterator[Token]:
    """Yield the tokens of a stretch, as far as they can be told."""
    with suppress(UnexpectedCharacters):
        yield from tokens(lark, text, start, end)
