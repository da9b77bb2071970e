"""A syntax error as facts: statement, tokens, the wrong token, and accepted tokens."""

import re
from itertools import islice, takewhile
from typing import NamedTuple

from tissuec.core.errors import Diagnostic
from tissuec.core.source import Source, Span
from tissuec.lang.tokens import Token
from tissuec.lang.tree import Statement

#: The type of a token for a character that begins no token.
CHARACTER = "CHARACTER"

#: What may be written as a unit, whether there are such units or not.
_UNIT = re.compile(r"\w+(\^-?[0-9]+)?([*/·]\w+(\^-?[0-9]+)?)*")

#: Number of tokens after the wrong one that are examined.
_ENOUGH = 100

#: Types of tokens that end a statement and belong to no statement.
ENDS = frozenset({"LINE", "$END", "RBRACE"})

_BRACES = {"{": "LBRACE", "}": "RBRACE"}
#: Line ends and semicolons after a statement, and comments between them.
_SEPARATORS = re.compile(r"[\n;](?:[\n; \t]|#[^\n]*)*")


class Mistake(NamedTuple):
    """The place at which the grammar could not continue.

    Attributes:
        source: The text.
        statement: The bad statement.
        before: Its tokens up to the wrong one.
        found: The wrong token.
        after: The tokens of the statement after the wrong one.
        accepted: Types of tokens that are allowed in its place.
    """

    source: Source
    statement: Statement
    before: tuple[Token, ...]
    found: Token
    after: tuple[Token, ...]
    accepted: frozenset[str]

    @classmethod
    def at(
        cls, statement: Statement, source: Source, place: int, accepted: frozenset[str]
    ) -> "Mistake":
        """Return the facts of a mistake.

        Args:
            place: How many of its tokens precede the wrong one.
            accepted: Types of tokens that are allowed there.
        """
        parts = statement.readable
        found = parts[place] if place < len(parts) else end_of(statement, source)
        rest = () if found.type == CHARACTER else islice(parts, place + 1, place + _ENOUGH)
        after = tuple(takewhile(lambda token: token.type != CHARACTER, rest))
        if not place:
            accepted |= ENDS  # an empty statement is none
        return cls(source, statement, tuple(parts[:place]), found, after, accepted)

    @property
    def previous(self) -> str:
        """Return the type of the token before the wrong one, or an empty string."""
        return self.before[-1].type if self.before else ""

    @property
    def next(self) -> str:
        """Return the type of the token after the wrong one, or an empty string."""
        return self.after[0].type if self.after else ""

    @property
    def first(self) -> str:
        """Return the type of the first token of the statement."""
        return self.before[0].type if self.before else self.found.type

    @property
    def unit(self) -> Span | None:
        """Return the words after a number or vector that were to be its unit, if any."""
        if self.found.type != "WORD" or self.previous not in ("NUMBER", "QUANTITY", "RPAR"):
            return None
        unit = _UNIT.match(self.source.text, self.found.start)
        return Span(self.source, *unit.span()) if unit else None

    @property
    def can_end(self) -> bool:
        """Return whether the statement could have ended before the wrong token."""
        return bool(self.accepted & ENDS)

    @property
    def behind(self) -> Span:
        """Return the empty place after the token before the wrong one."""
        end = self.before[-1].stop if self.before else self.found.start
        return Span(self.source, end, end)

    @property
    def blank(self) -> Span:
        """Return the text between the wrong token and the one before it."""
        return Span(self.source, self.behind.start, self.span(self.found).start)

    @property
    def line_before(self) -> str:
        """Return the text before the wrong token on its line."""
        span = self.span(self.found)
        return span.source.line_text(span.line)[: span.column - 1]

    @property
    def words_before(self) -> str:
        """Return the words directly before the wrong token."""
        words = takewhile(lambda token: token.type == "WORD", reversed(self.before))
        return " ".join(word.text for word in [*words][::-1])

    def finding(
        self, code: str, message: str, hint: str, at: Token | None = None
    ) -> Diagnostic:
        """Return a finding about a token.

        Args:
            code: Of the diagnostic.
            message: What is wrong.
            hint: What to write instead.
            at: The token; by default the wrong one.
        """
        return Diagnostic(code, message, self.span(at or self.found), hint)

    def holds(self, kind: str) -> bool:
        """Return whether a token of this type precedes the wrong one."""
        return any(token.type == kind for token in self.before)

    def span(self, token: Token) -> Span:
        """Return the place of a token."""
        return Span(self.source, token.start, token.stop)

    def text(self, first: Token, last: Token) -> str:
        """Return the text from one token to another, with single blanks."""
        written = self.source.text[first.start : last.stop]
        lines = (
            line.split("#")[0] if '"' not in line else line for line in written.split("\n")
        )
        return " ".join(" ".join(lines).split())


def end_of(statement: Statement, source: Source) -> Token:
    """Return the separator after a statement."""
    sign = source.text[statement.stop : statement.stop + 1]
    if sign in _BRACES:
        return Token(_BRACES[sign], sign, statement.stop, statement.stop + 1)
    if found := _SEPARATORS.match(source.text, statement.stop):
        return Token("LINE", found[0], *found.span())
    end = len(source.text)
    return Token("$END", "", end, end)
