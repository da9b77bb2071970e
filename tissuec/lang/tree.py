"""The one tree of a text, right or wrong: its tokens, and its statements with their blocks.

Compiler, formatter, messages and editor read it. A statement that is wrong is a node like any
other, with its tokens, and its neighbours stay whole.
"""

from bisect import bisect_right
from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property
from itertools import pairwise

from msgspec import Struct, field

from tissuec.core.errors import Diagnostic
from tissuec.core.source import Source
from tissuec.lang.rows import Rows
from tissuec.lang.tokens import KEYWORD, LINE, Token, tokens

#: Types of tokens that have been reported, and that the grammar does not see.
_REPORTED = frozenset({"OPEN_QUOTE", "ODD", "STRAY"})


class Statement(Struct, eq=False):
    """The part between two separators.

    Attributes:
        outer: The head of the block around it; None at the top.
        start: Offset after the separator before it.
        parts: Its tokens, without comments and line ends.
        stop: Offset of the separator after it.
        close: Offset after the closing brace of its block; ``stop`` without one.
        is_behind_block: Whether it follows the brace of a block without a separator.
        is_head: Whether a block, or a table that is closed, follows.
        items: Of the block that it is the head of.
        rows: Of the table that it is the head of, closed or not.
    """

    outer: "Statement | None"
    start: int
    parts: list[Token] = field(default_factory=list[Token])
    stop: int = 0
    close: int = 0
    is_behind_block: bool = False
    is_head: bool = False
    items: "list[Statement]" = field(default_factory=lambda: [])
    rows: Rows | None = None

    @property
    def readable(self) -> list[Token]:
        """Return the tokens that the grammar sees."""
        return [part for part in self.parts if part.type not in _REPORTED]

    @property
    def sentence(self) -> list[Token]:
        """Return the tokens that the grammar sees, and the brace of a block."""
        brace = Token("LBRACE", "{", self.stop, self.stop + 1)
        return [*self.readable, brace] if self.is_head else self.readable

    @property
    def words(self) -> list[str]:
        """Return the words with which it begins, in small letters; quotes are left off."""
        found: list[str] = []
        for part in self.parts:
            if not part.is_name and not (part.kind == KEYWORD and not found):
                break
            found.append(part.text.strip('"').lower())
        return found

    @property
    def chain(self) -> "list[Statement]":
        """Return the heads of the blocks around it, the outermost first."""
        heads: list[Statement] = []
        outer = self.outer
        while outer is not None:
            heads.append(outer)
            outer = outer.outer
        return heads[::-1]

    @property
    def is_language(self) -> bool:
        """Return whether it gives the version of the language."""
        return [part.type for part in self.readable] == ["LANGUAGE", "NUMBER"]

    @property
    def is_table(self) -> bool:
        """Return whether raw rows can follow it."""
        types = [part.type for part in self.readable]
        return types[:1] == ["TABLE"] or ("IS", "TABLE") in pairwise(types)


class Tree(Struct, frozen=True, eq=False, dict=True):
    """A text in statements.

    Attributes:
        tokens: All of it, comments and line ends too; the rows of a table are one token.
        statements: In order, those without a token too; heads before the items of their block.
        problems: What is wrong with characters, quotes and brackets, in order.
        is_sound: Whether brackets are so few, and the text so short, that it can be parsed.
    """

    source: Source
    tokens: Sequence[Token]
    statements: Sequence[Statement]
    problems: Sequence[Diagnostic]
    is_sound: bool

    @property
    def items(self) -> list[Statement]:
        """Return the statements outside of all blocks."""
        return [one for one in self.statements if one.outer is None]

    @property
    def comments(self) -> Iterator[Token]:
        """Yield every comment, in order."""
        rows = {one.rows.start: one.rows for one in self.statements if one.rows}
        for token in self.tokens:
            if token.type == "COMMENT":
                yield token
            elif token.type == "ROWS":
                yield from (one for one in rows[token.start].comments if one.stop <= token.stop)

    # --- places -------------------------------------------------------------------------------

    @cached_property
    def lexemes(self) -> list[Token]:
        """Return the tokens, those of rows of tables one by one."""
        return [one for token in self.tokens for one in self._lexemes(token)]

    def _lexemes(self, token: Token) -> Iterable[Token]:
        rows = token.type == "ROWS"
        return tokens(self.source.text, token.start, token.stop) if rows else (token,)

    @cached_property
    def _starts(self) -> list[int]:
        return [one.start for one in self.statements]

    def at(self, offset: int) -> Statement:
        """Return the statement at, or just before, an offset; an empty one on an empty line."""
        found = self.statements[max(bisect_right(self._starts, offset) - 1, 0)]
        if not found.parts or offset >= (first := found.parts[0].start):
            return found
        end = self.source.text.find("\n", offset, first)
        start = self.source.text.rfind("\n", found.start, offset) + 1
        return found if end < 0 else Statement(found.outer, start or found.start, [], end, end)

    def in_rows(self, offset: int) -> bool:
        """Return whether an offset lies among the rows of a table."""
        rows = self.at(max(offset - 1, 0)).rows
        return rows is not None and rows.start <= offset <= rows.end

    def lexeme_at(self, offset: int) -> Token | None:
        """Return the token under an offset; at a border, a word before a sign."""
        hits = [part for part in self.lexemes_around(offset) if part.kind != LINE]
        return min(
            hits, key=lambda part: not (part.is_name or part.kind == KEYWORD), default=None
        )

    def lexemes_around(self, offset: int) -> Iterator[Token]:
        """Yield the tokens that hold an offset or end there."""
        place = bisect_right(self.lexemes, offset, key=lambda part: part.start)
        for part in self.lexemes[max(place - 2, 0) : place]:
            if part.start <= offset <= part.stop:
                yield part
