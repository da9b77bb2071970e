"""What precedes a place: the block, joining words, and brackets that are open."""

import re
from collections.abc import Iterable
from contextlib import suppress

from tissuec.core.names import key_of
from tissuec.core.units import Dimension, parse_unit
from tissuec.lang.tokens import KEYWORD, SIGN, UNIT, Token
from tissuec.lang.tree import Statement
from tissuec.lang.words import JOINING_WORDS, TIME_WORDS
from tissuec.lsp.terms import BlockKind
from tissuec.scene.reading.parts import REPEAT, entries_in, parts
from tissuec.script.measures import MEASURES
from tissuec.script.measures.statistics import STATISTICS
from tissuec.script.verbs import VERBS

#: What is written like a measure, too.
_MEASURED = frozenset((*MEASURES, *STATISTICS, "count", "positions", "error"))
_CLAUSES = frozenset((*TIME_WORDS, *JOINING_WORDS))
#: After these a word is chosen.
_CHOOSING = re.compile(r"\bis( not| between( and)?)?$")


class Prefix:
    """The tokens of a statement up to a place, and the brackets and clauses they open.

    Attributes:
        block: The block of the statement.
        head: The first word of the statement, of an order: the verb.
        subject: The phrase before "is", or "=".
        object: Literal words after a verb or entry, such as "spring constant".
        openers: Reserved words and "=" so far, without those of measures.
        calls: What each open bracket belongs to.
        commas: How many there are in each of them.
        is_order: Whether the statement is an order.
        dimension: Of the first unit or measure.
    """

    def __init__(self, block: BlockKind):
        self.block = block
        self.tokens: list[Token] = []
        self.head = self.subject = self.object = ""
        self.openers: list[str] = []
        self.calls: list[str] = []
        self.commas: list[int] = []
        self.is_order = block == BlockKind("script", "inner")
        self.dimension: Dimension | None = None

    def take(self, token: Token) -> None:
        """Go on by one token."""
        if token.kind == KEYWORD:
            self._keyword(token.text)
        elif token.kind == UNIT:
            with suppress(ValueError, ArithmeticError):
                self.dimension = self.dimension or parse_unit(token.text).dimension
        elif token.kind == SIGN:
            self._sign(token.text)
        self.tokens.append(token)

    def _keyword(self, word: str) -> None:
        self.head = self.head if self.tokens else word
        if not self.in_measure:
            self.openers.append(word)

    def _sign(self, sign: str) -> None:
        if sign in "([":
            is_call = sign == "(" and self.tokens and self.tokens[-1].is_name
            self.calls.append(self.last_words() if is_call else sign)
            self.commas.append(0)
        elif sign in ")]" and self.calls:
            self.calls.pop()
            self.commas.pop()
        elif sign == "=":
            self.openers.append(sign)
        elif sign == "," and self.commas:
            self.commas[-1] += 1
        elif sign == ":" and self.block.kind == "script":
            self.head, self.is_order = "", True
            self.openers.clear()

    def last_words(self, before: int | None = None) -> str:
        """Return the words directly before the end, or before the token of a number."""
        stop = start = len(self.tokens) if before is None else before
        while start and self.tokens[start - 1].is_name:
            start -= 1
        return key_of(" ".join(token.text for token in self.tokens[start:stop]))

    # --- what it says -------------------------------------------------------------------------

    @property
    def last(self) -> Token | None:
        """Return the last token."""
        return self.tokens[-1] if self.tokens else None

    @property
    def texts(self) -> list[str]:
        """Return the tokens as they are written."""
        return [token.text for token in self.tokens]

    @property
    def call(self) -> str:
        """Return the name before the innermost open bracket; the bracket itself without a name,
        "" outside of brackets."""
        return self.calls[-1] if self.calls else ""

    @property
    def in_measure(self) -> bool:
        """Return whether the bracket of a measure is open."""
        return any(call in _MEASURED for call in self.calls)

    @property
    def clause(self) -> str:
        """Return the last joining word; "" after a condition."""
        since = self.openers[self.openers.index("where") :] if self.has("where") else None
        words = (word for word in reversed(self.openers) if word in _CLAUSES)
        return "" if since is not None else next(words, "")

    @property
    def seen(self) -> list[str]:
        """Return the joining words so far."""
        return [word for word in self.openers if word in _CLAUSES]

    @property
    def is_choosing(self) -> bool:
        """Return whether a word is chosen here: after "is", "is not", "is between"."""
        return _CHOOSING.search(" ".join(self.openers)) is not None

    @property
    def has_verb(self) -> bool:
        """Return whether an order has begun with its verb."""
        return self.is_order and self.head in VERBS

    def has(self, opener: str) -> bool:
        """Return whether a reserved word, or "=", precedes."""
        return opener in self.openers


def block_of(statement: Statement) -> BlockKind:
    """Return the block that contains a statement."""
    block = BlockKind()
    for head in statement.chain:
        block = inside(head, block)
    return block


def inside(head: Statement, outer: BlockKind) -> BlockKind:
    """Return the block that a head begins."""
    words = head.words
    first = words[0] if words else ""
    if first == REPEAT:
        return outer
    if outer.kind == "script":
        return BlockKind("script", "inner")
    if not outer.kind:
        part = parts("named", "single").get(first)
        if part is None:
            return BlockKind("unknown")
        chooser = part.block.chooser if part.block is not None else ""
        return BlockKind(first, _chosen(head.items, chooser) or " ".join(words[1:]))
    text = " ".join(words)
    for name, entry in entries_in(*outer).items():
        block = entry.inside
        if block is not None and f"{text} ".startswith(f"{name} "):
            by_word = bool(entry.members)
            member = _behind_is(head) if by_word else _chosen(head.items, block.chooser)
            return BlockKind(name, member)
    return BlockKind("unknown")


def _behind_is(statement: Statement) -> str:
    """Return the words after ``is``."""
    texts = [part.text for part in statement.parts]
    if "is" not in texts:
        return ""
    behind = statement.parts[texts.index("is") + 1 :]
    words: list[str] = []
    for part in behind:
        if not part.is_name:
            break
        words.append(part.text)
    return key_of(" ".join(words))


def _chosen(items: Iterable[Statement], entry: str) -> str:
    """Return the choice for an entry among the items of a block; empty if there is none."""
    return next((_behind_is(item) for item in items if entry in item.words[:1]), "")
