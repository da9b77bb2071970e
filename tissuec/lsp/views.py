"""Meanings of names in an open text, as far as it and its imports can be read."""

import re
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path

from msgspec import Struct, field

from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.core.units import Dimension
from tissuec.lang import syntax as s
from tissuec.lang.tokens import COMMENT
from tissuec.lang.tree import Statement, Tree
from tissuec.lsp.documents import Lenient, OpenDocuments
from tissuec.lsp.expected import ONE_NAMESPACE
from tissuec.lsp.phrases import Phrase, phrases
from tissuec.lsp.symbols import Symbol, symbols_of
from tissuec.lsp.terms import BlockKind
from tissuec.scene.model import Tissue
from tissuec.scene.program.imports import Program, load
from tissuec.scene.program.repetition import REPEAT
from tissuec.scene.program.resolved import ResolvedProgram
from tissuec.scene.reading.findings import Findings
from tissuec.scene.resolve import resolve_words
from tissuec.scene.words.phrases import NamedScale


class View(Struct, frozen=True, eq=False, dict=True):
    """A text, its imports, and the meanings of its names.

    Attributes:
        source: The text.
        program: None where not even that much is known.
        words: Numbers, vocabulary and tissues, as far as they are right.
    """

    source: Source
    documents: OpenDocuments
    program: Program | None
    words: ResolvedProgram | None
    _phrases: dict[int, list[Phrase]] = field(default_factory=dict[int, list[Phrase]])

    @property
    def structure(self) -> Tree:
        return self.documents.tree(self.source)

    # --- names --------------------------------------------------------------------------------

    @cached_property
    def symbols(self) -> dict[tuple[str, str, str], Symbol]:
        """Return all declarations, by kind, enclosing declaration and key."""
        found: dict[tuple[str, str, str], Symbol] = {}
        for one in symbols_of(self.words.declarations) if self.words is not None else ():
            found.setdefault((one.kind, one.within, one.key), one)
        return found

    def of_kind(self, *kinds: str) -> list[Symbol]:
        """Return the names of some kinds or sorts, in the order of declaration."""
        return [
            symbol
            for symbol in self.symbols.values()
            if symbol.kind in kinds or not set(kinds).isdisjoint(symbol.sorts)
        ]

    def named(self, kinds: tuple[str, ...], key: str, block: BlockKind) -> Symbol | None:
        """Return the meaning of a name in a block.

        Args:
            kinds: Kinds of names, of which it is one.
            key: The name, as names are compared.
        """
        found = (symbol for symbol in self.seen_from(block, *kinds) if symbol.key == key)
        return next(found, None)

    def seen_from(self, block: BlockKind, *kinds: str) -> Iterator[Symbol]:
        """Yield the names of some kinds that a block can use: not the columns of others."""
        for symbol in self.of_kind(*kinds):
            if symbol.kind != "column" or symbol.within == block.member:
                yield symbol

    def scale(self, name: str) -> NamedScale | None:
        """Return the scale of a property or quantity."""
        if self.words is None:
            return None
        vocabulary = self.words.vocabulary
        quantity = vocabulary.quantities.get(name)
        return vocabulary.properties.get(name) or (quantity.named if quantity else None)

    def dimension_of(self, key: str) -> Dimension | None:
        """Return the dimension of a number by its lower-case name, None if it is unknown."""
        value = self.words.constants.definitions.values.get(key) if self.words else None
        return value.dimension if value is not None else None

    def tissue(self, key: str) -> Tissue | None:
        """Return a tissue by its lower-case name, None if it is unknown."""
        return self.words.tissues.get(key) if self.words else None

    # --- places -------------------------------------------------------------------------------

    def phrases_of(self, statement: Statement) -> list[Phrase]:
        """Return the phrases of a statement."""
        if statement.start not in self._phrases:
            self._phrases[statement.start] = phrases(statement)
        return self._phrases[statement.start]

    def all_phrases(self) -> Iterator[Phrase]:
        """Yield the phrases of all statements."""
        for statement in self.structure.statements:
            yield from self.phrases_of(statement)

    def phrase_at(self, offset: int) -> Phrase | None:
        """Return the phrase under an offset, or the one that ends there."""
        for place in (offset, max(offset - 1, 0)):
            for phrase in self.phrases_of(self.structure.at(place)):
                if phrase.start <= offset <= phrase.stop:
                    return phrase
        return None

    def symbol_of(self, phrase: Phrase) -> Symbol | None:
        """Return the symbol that a phrase refers to or declares."""
        expected, key = phrase.expected, phrase.key
        if expected.declares:
            within = ""
            if expected.declares == "word":
                within = phrase.block.member if phrase.block.kind else ""
            if expected.declares in ("region", "column"):
                within = phrase.block.member
            symbol = self.symbols.get((expected.declares, within, key))
            if symbol is not None or phrase.term is None:
                return symbol
        if phrase.term is not None and not (expected.names and self._is_own(key)):
            return None
        kinds = _kinds_of(phrase)
        return self.named(kinds, key, phrase.block) if kinds else None

    def symbols_at(self, offset: int) -> list[tuple[Symbol, int, int]]:
        """Return the declarations that the name at an offset refers to, and its place.

        A name with an index refers to several: in ``repeat i in [left, right]``, "i tube" is
        "left tube" and "right tube".
        """
        if (hit := self.symbol_at(offset)) is not None:
            return [hit]
        phrase = self.phrase_at(offset)
        if phrase is None or phrase.term is not None or not phrase.expected.names:
            return []
        heads = self.structure.at(phrase.start).chain
        indices = {head.words[1] for head in heads if head.words[:1] == [REPEAT]}
        words = phrase.key.split(" ")
        if indices.isdisjoint(words):
            return []
        pattern = " ".join(".+" if word in indices else re.escape(word) for word in words)
        found = self.seen_from(phrase.block, *_kinds_of(phrase))
        return [
            (one, phrase.start, phrase.stop) for one in found if re.fullmatch(pattern, one.key)
        ]

    def _is_own(self, key: str) -> bool:
        """Return whether a text declares a number of its own under the name of a constant."""
        return key == "pi" and bool({("param", "", key), ("let", "", key)} & set(self.symbols))

    def words_of(self, phrase: Phrase) -> Iterator[tuple[Symbol, int, int]]:
        """Yield the hedges and the word of a phrase that describes, with their places."""
        scale = self.scale(phrase.expected.scale)
        if scale is None or not phrase.parts:
            return
        parts = phrase.parts
        for count in range(len(parts)):
            rest = s.key_of(" ".join(part.text.strip('"') for part in parts[count:]))
            if rest not in scale.scale.words:
                continue
            for part in parts[:count]:
                hedge = self.symbols.get(("hedge", "", part.text.lower()))
                if hedge is not None:
                    yield hedge, part.start, part.stop
            word = self.symbols.get(("word", s.key_of(scale.name), rest))
            if word is not None:
                yield word, parts[count].start, parts[-1].stop
            return

    def occurrences(self) -> Iterator[tuple[Symbol, int, int]]:
        """Yield every name of the text with its place."""
        for phrase in self.all_phrases():
            if not phrase.parts:
                continue
            if phrase.expected.scale:
                yield from self.words_of(phrase)
            elif (symbol := self.symbol_of(phrase)) is not None:
                yield symbol, phrase.start, phrase.stop

    def symbol_at(self, offset: int) -> tuple[Symbol, int, int] | None:
        """Return the name at an offset and its place."""
        phrase = self.phrase_at(offset)
        if phrase is None or not phrase.parts:
            return None
        if phrase.expected.scale:
            hits = (hit for hit in self.words_of(phrase) if hit[1] <= offset <= hit[2])
            return next(hits, None)
        symbol = self.symbol_of(phrase)
        return (symbol, phrase.start, phrase.stop) if symbol else None

    def in_remark(self, offset: int) -> bool:
        """Return whether an offset lies in a comment."""
        return any(
            part.kind == COMMENT and part.start < offset
            for part in self.structure.lexemes_around(offset)
        )


def _kinds_of(phrase: Phrase) -> tuple[str, ...]:
    """Return the kinds of names that a phrase can refer to."""
    kinds = phrase.expected.names
    return (*kinds, *ONE_NAMESPACE) if set(kinds) & set(ONE_NAMESPACE) else kinds


def view_of(documents: OpenDocuments, path: Path) -> View | None:
    """Return the view of an open text; None where it is no text at all."""
    try:
        source = documents.read(path, str(path))
    except CompileError:
        return None
    files = Lenient(documents)
    try:
        program = load(source, documents.libraries, Findings(), files)
    except CompileError:
        program = None
    used = tuple(module.source for module in program.modules) if program else (source,)
    return documents.memory.recall(
        ("view", source, used), lambda: View(source, documents, program, _words(program))
    )


def _words(program: Program | None) -> ResolvedProgram | None:
    """Return numbers, vocabulary and tissues of a program; None if it has two vocabularies."""
    if program is None:
        return None
    try:
        words = resolve_words(program, Findings())
        words.constants.evaluate_all()
    except CompileError:
        return None
    return words
