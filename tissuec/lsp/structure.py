"""The statements of a text and the blocks around each, also in texts with errors."""

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from itertools import pairwise

from msgspec import Struct, field

from tissuec.lang.words import CONTINUING
from tissuec.lsp.tokens import COMMENT, KEYWORD, LINE, STRING, WORD, Lexeme, lexemes

_CLOSING = {"(": ")", "[": "]"}
_ENDS = frozenset("{};")
_CONTINUES = frozenset(CONTINUING)


class Statement(Struct, eq=False):
    """The text between two separators.

    Attributes:
        parts: Its lexemes, without comments.
        outer: The head of the block that it stands in; None at the top.
        items: Of the block that it is the head of.
        start: Offset behind the separator before it.
        stop: Offset of the separator behind it.
        close: Offset behind the closing brace of its block; ``stop`` without one.
        is_head: Whether a block follows.
    """

    parts: list[Lexeme]
    outer: "Statement | None"
    start: int
    stop: int
    close: int
    is_head: bool = False
    items: "list[Statement]" = field(default_factory=lambda: [])

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
    def is_table(self) -> bool:
        """Return whether the block behind it holds raw rows."""
        texts = [part.text for part in self.parts]
        return texts[:1] == ["table"] or any(
            pair == ("is", "table") for pair in pairwise(texts)
        )


class Structure(Struct, frozen=True, eq=False):
    """A text in statements.

    Attributes:
        lexemes: All of it, comments and line ends too.
        statements: In order, those without a word too; heads before the items of their block.
    """

    text: str
    lexemes: Sequence[Lexeme]
    statements: Sequence[Statement]
    starts: Sequence[int]

    def at(self, offset: int) -> Statement:
        """Return the statement at, or just before, an offset."""
        return self.statements[max(bisect_right(self.starts, offset) - 1, 0)]

    def lexeme_at(self, offset: int) -> Lexeme | None:
        """Return the lexeme under an offset; at a border, a word before a sign."""
        hits = [part for part in self.lexemes_around(offset) if part.kind != LINE]
        return min(
            hits, key=lambda part: part.kind not in (WORD, STRING, KEYWORD), default=None
        )

    def lexemes_around(self, offset: int) -> Iterator[Lexeme]:
        """Yield the lexemes that hold an offset or end there."""
        place = bisect_right(self.lexemes, offset, key=lambda part: part.start)
        for part in self.lexemes[max(place - 2, 0) : place]:
            if part.start <= offset <= part.stop:
                yield part

    def remark_behind(self, offset: int) -> str:
        """Return the comment that ends the line of an offset, without its sign."""
        for part in self.lexemes:
            if part.start >= offset and part.kind == COMMENT:
                return "" if "\n" in self.text[offset : part.start] else part.text[1:].strip()
        return ""


def structure_of(text: str) -> Structure:
    """Return a text in statements."""
    found = list(lexemes(text))
    statements = _Reader(text, found, _closed_brackets(found)).read()
    return Structure(text, found, statements, [one.start for one in statements])


def _closed_brackets(found: Sequence[Lexeme]) -> set[int]:
    """Return the offsets of round and square brackets that are closed before any brace.

    In others line ends count, so that a bracket that is being typed swallows no line below.
    """
    closed: set[int] = set()
    waiting: list[Lexeme] = []
    for part in found:
        if part.kind != "sign":
            continue
        if part.text in _CLOSING:
            waiting.append(part)
        elif part.text in "{}":
            waiting.clear()
        elif waiting and part.text == _CLOSING[waiting[-1].text]:
            closed |= {waiting.pop().start, part.start}
    return closed


class _Reader:
    """One pass over the lexemes of a text."""

    def __init__(self, text: str, found: Sequence[Lexeme], closed: set[int]):
        self.text, self.found, self.closed = text, found, closed
        self.statements: list[Statement] = []
        self.heads: list[Statement] = []
        self.parts: list[Lexeme] = []
        self.start = 0

    def read(self) -> list[Statement]:
        depth = 0
        for index, part in enumerate(self.found):
            if part.kind == LINE:
                if depth == 0 and not self._goes_on(index):
                    self._end(part.start, part.stop)
            elif part.kind == "sign" and part.text in _ENDS:
                if part.text != ";" or depth == 0:
                    self._separator(part)
            elif part.kind != COMMENT:
                if part.start in self.closed:
                    depth += 1 if part.text in _CLOSING else -1
                self.parts.append(part)
        self._end(len(self.text), len(self.text))
        for head in self.heads:
            head.close = len(self.text)
        return self.statements

    def _separator(self, part: Lexeme) -> None:
        statement = self._end(part.start, part.stop)
        if part.text == "{":
            statement.is_head = True
            self.heads.append(statement)
        elif part.text == "}" and self.heads:
            self.heads.pop().close = part.stop

    def _end(self, stop: int, following: int) -> Statement:
        """Enter the statement that ends at ``stop``; the next one begins at ``following``."""
        outer = self.heads[-1] if self.heads else None
        statement = Statement(self.parts, outer, self.start, stop, stop)
        self.statements.append(statement)
        if outer is not None:
            outer.items.append(statement)
        self.parts, self.start = [], following
        return statement

    def _goes_on(self, index: int) -> bool:
        """Return whether the next line with a word on it begins with a joining word."""
        for part in self.found[index + 1 :]:
            if part.kind not in (LINE, COMMENT):
                return part.kind == KEYWORD and part.text in _CONTINUES and bool(self.parts)
        return False
