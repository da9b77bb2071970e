"""Semantic tokens: the category of each part of a text, for colours."""

from collections.abc import Iterator
from typing import Literal, TypeAlias

from tissuec.core.source import Source
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
from tissuec.lang.tree import Tree
from tissuec.lang.tree_builder import tree_of
from tissuec.lsp import terms
from tissuec.lsp.phrases import Phrase, phrases

#: ``part`` begins a part of a text (body, script), ``entry`` an entry of a block, ``verb`` an
#: order; ``measure`` is measured or computed; ``word`` is chosen behind "is".
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
    tree = tree_of(Source("text", text))
    words = dict(_words(tree))
    found: list[tuple[int, int, Kind]] = []
    for part in (piece for token in tree.lexemes for piece in token.pieces):
        if part.kind not in (LINE, ODD):
            kind = words.get(part.start) or _PLAIN.get(part.kind, "name")
            found.append((part.start, part.stop, kind))
    return found


def _words(tree: Tree) -> Iterator[tuple[int, Kind]]:
    """Yield what words stand for, by their offsets."""
    for statement in tree.statements:
        for phrase in phrases(statement):
            kind = kind_of(phrase)
            for part in phrase.parts:
                if part.kind == WORD or (part.kind == KEYWORD and kind == "word"):
                    yield part.start, kind


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
