"""Meanings of names in an open text, as far as it and its imports can be read."""

from collections.abc import Iterable, Iterator
from functools import cached_property
from pathlib import Path

from msgspec import Struct, field

from tissuec.core.errors import CompileError
from tissuec.core.source import Source, Span
from tissuec.core.units import Dimension
from tissuec.lang import syntax as s
from tissuec.lang.tokens import COMMENT
from tissuec.lang.tree import Statement, Tree
from tissuec.lsp.documents import Desk, Lenient
from tissuec.lsp.expected import ONE_NAMESPACE
from tissuec.lsp.phrases import Phrase, phrases
from tissuec.lsp.terms import Block
from tissuec.scene.declarations import Declared, without
from tissuec.scene.findings import Findings
from tissuec.scene.imports import Program, load
from tissuec.scene.model import Tissue
from tissuec.scene.resolve import ResolvedProgram, resolve_words
from tissuec.scene.words import NamedScale
from tissuec.script.tools import INSTRUMENTS


class Symbol(Struct, frozen=True):
    """A name and where it is declared.

    Attributes:
        kind: "param", "body", "property", "region", "word" and so on.
        within: For a word its property or quantity, for a region its body, for a column of a
            table its study; by key.
        sorts: Of a set what it holds, "nodes" or "springs"; of a tool its kind, and "holding"
            if it can hold nodes. All that it may be while that is not written.
    """

    kind: str
    name: str
    span: Span
    within: str = ""
    sorts: tuple[str, ...] = ()

    @property
    def key(self) -> str:
        return s.key_of(self.name)


class View(Struct, frozen=True, eq=False, dict=True):
    """A text, its imports, and the meanings of its names.

    Attributes:
        source: The text.
        program: None where not even that much can be told.
        words: Numbers, vocabulary and tissues, as far as they are right.
    """

    source: Source
    desk: Desk
    program: Program | None
    words: ResolvedProgram | None
    _phrases: dict[int, list[Phrase]] = field(default_factory=dict[int, list[Phrase]])

    @property
    def structure(self) -> Tree:
        return self.desk.tree(self.source)

    # --- names --------------------------------------------------------------------------------

    @cached_property
    def symbols(self) -> dict[tuple[str, str, str], Symbol]:
        """Return all declarations, by kind, enclosing declaration and key."""
        found: dict[tuple[str, str, str], Symbol] = {}
        for kind, declared in self._declared():
            name, sorts = declared.name, _sorts(declared, self.words)
            symbol = Symbol(kind, name.text, name.span, "", sorts)
            found.setdefault((kind, "", symbol.key), symbol)
            for inner in _inside(kind, declared):
                found.setdefault((inner.kind, inner.within, inner.key), inner)
        return found

    def _declared(self) -> Iterator[tuple[str, Declared]]:
        if self.words is not None:
            for kind, names in self.words.declarations.named.items():
                for declared in names.values():
                    yield kind, declared

    def of_kind(self, *kinds: str) -> list[Symbol]:
        """Return the names of some kinds or sorts, in the order of declaration."""
        return [
            symbol
            for symbol in self.symbols.values()
            if symbol.kind in kinds or not set(kinds).isdisjoint(symbol.sorts)
        ]

    def named(self, kinds: tuple[str, ...], key: str, block: Block) -> Symbol | None:
        """Return the meaning of a name in a block.

        Args:
            kinds: Kinds of names, of which it is one.
            key: The name, as names are compared.
            block: The block.
        """
        found = (symbol for symbol in self.seen_from(block, *kinds) if symbol.key == key)
        return next(found, None)

    def seen_from(self, block: Block, *kinds: str) -> Iterator[Symbol]:
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
        kinds = expected.names
        if set(kinds) & set(ONE_NAMESPACE):
            kinds = (*kinds, *ONE_NAMESPACE)
        return self.named(kinds, key, phrase.block) if kinds else None

    def _is_own(self, key: str) -> bool:
        """Return whether a text declares a number of its own under the name of a constant."""
        return key == "pi" and bool({("param", "", key), ("let", "", key)} & set(self.symbols))

    def words_of(self, phrase: Phrase) -> Iterator[tuple[Symbol, int, int]]:
        """Yield the hedges and the word of a phrase that describes, and where they stand."""
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
        """Yield every name of the text with where it stands."""
        for phrase in self.all_phrases():
            if not phrase.parts:
                continue
            if phrase.expected.scale:
                yield from self.words_of(phrase)
            elif (symbol := self.symbol_of(phrase)) is not None:
                yield symbol, phrase.start, phrase.stop

    def symbol_at(self, offset: int) -> tuple[Symbol, int, int] | None:
        """Return the name at an offset and where it stands."""
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


def view_of(desk: Desk, path: Path) -> View | None:
    """Return the view of an open text; None where it is no text at all."""
    try:
        source = desk.read(path, str(path))
    except CompileError:
        return None
    files = Lenient(desk)
    try:
        program = load(source, desk.libraries, Findings(), files)
    except CompileError:
        program = None
    used = tuple(module.source for module in program.modules) if program else (source,)
    return desk.memory.recall(
        ("view", source, used), lambda: View(source, desk, program, _words(program))
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


def _sorts(declared: Declared, words: ResolvedProgram | None) -> tuple[str, ...]:
    """Return the sorts of a set or tool."""
    sets = words.declarations.named.get("set", {}) if words else {}
    joints = words.declarations.named.get("joint", {}) if words else {}
    for _ in range(len(sets) + 1):  # sets that hold each other in a circle have no end
        match declared.item:
            case s.Assign(keyword="set", value=s.Name(key="nodes" | "springs" as sort)):
                return (sort,)
            case s.Assign(keyword="set", value=s.Listing(items=(s.Name(key=key), *_))):
                if key not in sets:
                    return ("springs",) if key in joints else ("nodes",)
                declared = sets[key]
            case s.Assign(keyword="set"):
                break
            case s.Block(name=name, items=items) if name.words.startswith("tool"):
                return _sorts_of_tool(items)
            case _:
                return ()
    return ("nodes", "springs")


def _sorts_of_tool(items: Iterable[s.Item]) -> tuple[str, ...]:
    said = (
        item.phrase.words[0].key
        for item in items
        if isinstance(item, s.Sentence) and item.name.key == "kind" and item.phrase
    )
    kind = next(said, "")
    kinds = (kind,) if kind in INSTRUMENTS else tuple(INSTRUMENTS)
    return kinds if kind == "scissors" else (*kinds, "holding")


def _inside(kind: str, declared: Declared) -> Iterator[Symbol]:
    """Yield the words of a scale, the regions of a body, or the columns of a study."""
    if not isinstance(declared.item, s.Block):
        return
    within = declared.name.key
    for item in declared.item.items:
        if kind in ("property", "quantity"):
            for name in _words_in(item):
                yield Symbol("word", name.text, name.span, within)
        elif kind == "study" and isinstance(item, s.Assign):
            name = without(item.name, "measure")
            if name is not None:
                yield Symbol("column", name.text, name.span, within)
        elif kind == "body" and isinstance(item, s.Block):
            first, _, rest = item.name.words.partition(" ")
            if first.lower() == "region" and (rest or item.name.quoted):
                text = rest or item.name.quoted or ""
                start = item.name.span.start + item.name.span.text.find(text, len(first))
                span = Span(item.name.span.source, start, item.name.span.end)
                yield Symbol("region", text, span, within)


def _words_in(item: s.Item) -> Iterator[s.Name]:
    match item:
        case s.Assign(name=s.Name(key="evenly"), value=s.Listing(items=names)):
            yield from (name for name in names if isinstance(name, s.Name))
        case s.Sentence(name=s.Name(key="applies" | "otherwise")):
            pass
        case s.Assign(name=name) | s.Sentence(name=name):
            yield name
        case _:
            pass
