"""Semantic tokens: the category of each part of a text, for colours."""

from functools import partial
from typing import Literal, TypeAlias

from tissuec.core.keeping import Memory
from tissuec.core.source import Source
from tissuec.lang.known_statements import key_of_tokens
from tissuec.lang.tokens import (
    COMMENT,
    KEYWORD,
    LINE,
    NUMBER,
    ODD,
    SIGN,
    STRING,
    UNIT,
    WORD,
)
from tissuec.lang.tree import Statement, Tree
from tissuec.lang.tree_builder import tree_of
from tissuec.lsp import terms
from tissuec.lsp.phrases import Phrase, phrases
from tissuec.lsp.prefix import block_of
from tissuec.lsp.terms import BlockKind

#: ``part`` begins a part of a text (body, script), ``entry`` an entry of a block, ``verb`` an
#: order; ``measure`` is measured or computed; ``word`` is chosen after "is".
Kind: TypeAlias = Literal[
    "comment", "string", "number", "unit", "keyword", "part", "entry", "verb", "measure",
    "word", "name", "sign",
]  # fmt: skip
KINDS: tuple[Kind, ...] = (
    "comment", "string", "number", "unit", "keyword", "part", "entry", "verb", "measure",
    "word", "name", "sign",
)  # fmt: skip
_PLAIN: dict[str, Kind] = {
    COMMENT: "comment", STRING: "string", NUMBER: "number", UNIT: "unit", KEYWORD: "keyword",
    SIGN: "sign",
}  # fmt: skip


def tokens(text: str) -> list[tuple[int, int, Kind]]:
    """Return start, stop and kind of each part of a text, right or wrong, in order.

    Blanks, and characters that no sentence can hold, belong to no part.
    """
    return tokens_of(tree_of(Source("text", text)), Memory(0))


def tokens_of(tree: Tree, known: Memory) -> list[tuple[int, int, Kind]]:
    """Return start, stop and kind of each part of a text, as ``tokens``.

    Args:
        known: What the words of statements mean, by the block and the tokens of each; those of
            this text are added.
    """
    words: dict[int, Kind] = {}
    for statement in tree.statements:
        if statement.parts:
            block = block_of(statement)
            key = block, key_of_tokens(statement.parts)
            found = known.recall(key, partial(_words, statement, block))
            first = statement.parts[0].start
            words.update([(first + place, kind) for place, kind in found])
    coloured: list[tuple[int, int, Kind]] = []
    for part in (piece for token in tree.lexemes for piece in token.pieces):
        if part.kind not in (LINE, ODD):
            kind = words.get(part.start) or _PLAIN.get(part.kind, "name")
            coloured.append((part.start, part.stop, kind))
    return coloured


def _words(statement: Statement, block: BlockKind) -> list[tuple[int, Kind]]:
    """Return the kinds of the words of a statement, with their offsets in it."""
    first, found = statement.parts[0].start, list[tuple[int, Kind]]()
    for phrase in phrases(statement, block):
        kind = kind_of(phrase)
        for part in phrase.parts:
            if part.kind == WORD or (part.kind == KEYWORD and kind == "word"):
                found.append((part.start - first, kind))
    return found


def kind_of(phrase: Phrase) -> Kind:
    """Return the category of the words of a phrase."""
    if phrase.expected.scale:
        return "word"
    if phrase.term is not None:
        return _OF_TERMS[phrase.term.kind]
    if phrase.expected.names == ("property",) or phrase.expected.names == ("quantity",):
        return "entry"
    return "word" if phrase.expected.declares == "word" else "name"


_OF_TERMS: dict[str, Kind] = {
    terms.PART: "part", terms.ENTRY: "entry", terms.VERB: "verb", terms.MEASURE: "measure",
    terms.CHOICE: "word", terms.KEYWORD: "keyword", terms.VARIABLE: "name",
}  # fmt: skip
