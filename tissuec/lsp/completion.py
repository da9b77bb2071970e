"""Completions at a place of a text: reserved words, names, words, units, files."""

from collections.abc import Collection, Iterable, Iterator
from functools import lru_cache
from pathlib import Path

from msgspec import Struct

from tissuec.compiler.learning.targets import RESULTS
from tissuec.core.names import key_of
from tissuec.core.prefixes import shown_units
from tissuec.core.units import (
    SYMBOLS,
    Dimension,
    describe,
    parse_unit,
    show,
    si_unit,
    suggested_unit,
)
from tissuec.lang import syntax as s
from tissuec.lang.parser import accepted_behind
from tissuec.lang.tokens import STRING, Token, tokens
from tissuec.lang.tree import Statement
from tissuec.lang.words import (
    CONTINUING,
    DECLARING_WORDS,
    MEANINGS,
    TIME_WORDS,
    written_name,
)
from tissuec.laws import SPRING_LAWS, VISCOSITY_LAWS
from tissuec.laws.solid import SOLID_LAWS
from tissuec.lsp import study
from tissuec.lsp.phrases import Phrase, phrase_at_end
from tissuec.lsp.prefix import block_of
from tissuec.lsp.symbols import Symbol
from tissuec.lsp.terms import BlockKind, Term
from tissuec.lsp.views import View
from tissuec.lsp.vocabulary import numbers_of_forces
from tissuec.meshes.formats import FORMATS, IMAGES
from tissuec.scene.learning.entries import ADJUSTED
from tissuec.scene.program.library import SUFFIX, Library, files_of
from tissuec.scene.reading.entries import entries_of
from tissuec.scene.reading.parts import PARTS, entries_in, parts
from tissuec.scene.tissues.laws import BY_ENTRY, LawKind


class Proposal(Struct, frozen=True):
    """A proposed replacement of a part of the text.

    Attributes:
        kind: What a term is coloured as, or a kind of names; "unit", "file", "keyword".
        insert: What is typed.
        detail: One line.
        about: Markdown.
        rank: Small ones first.
    """

    label: str
    kind: str
    insert: str
    start: int
    stop: int
    detail: str = ""
    about: str = ""
    rank: int = 0


def complete(view: View, offset: int) -> list[Proposal]:
    """Return the completions at an offset, the best first, filtered by the typed text."""
    if view.in_remark(offset):
        return []
    if view.structure.in_rows(offset):
        return []
    statement = view.structure.at(offset)
    phrase, following = phrase_at_end(statement, offset)
    if phrase.expected.files or (phrase.parts and phrase.parts[-1].kind == STRING):
        return in_quotes(view, phrase, offset)
    found = [*_of_phrase(view, phrase), *_keywords(view, phrase, following, offset)]
    return _narrowed(_readable(view, found, statement), view.source.text, offset)


def _readable(
    view: View, found: Iterable[Proposal], statement: Statement
) -> Iterator[Proposal]:
    """Yield the proposals that the grammar accepts; all if the statement is wrong before."""
    text, known = view.source.text, dict[int, frozenset[str] | None]()
    first = next((one for one in view.structure.statements if one.parts), statement)
    for one in found:
        before = [part for part in statement.parts if part.stop <= one.start]
        if before and _ends_before(before, text[before[-1].stop : one.start], one):
            continue
        kind = _kind(one.insert)
        if (number := _measured(statement, one.start)) is not None:
            # Together with its unit, a number or a closing bracket is another token.
            joined = list(tokens(f"{number.pieces[0].text} {one.insert.strip()}"))
            if len(joined) == 1:
                kind = joined[0].type
                before = [part for part in before if part.start < number.start]
        if len(before) not in known:
            known[len(before)] = accepted_behind(
                before, is_heading=statement.start <= first.start
            )
        accepted = known[len(before)]
        if accepted is None or kind in accepted:
            yield one


@lru_cache(maxsize=4096)
def _kind(text: str) -> str:
    """Return the type of the first token of a text; "" without one."""
    return next((token.type for token in tokens(text)), "")


def _measured(statement: Statement, place: int) -> Token | None:
    """Return the number or bracket whose unit is, or would be, at a place."""
    before = [part for part in statement.parts if part.start < place]
    return before[-1] if before and before[-1].pieces[0].type in ("NUMBER", "RPAR") else None


def _ends_before(before: list[Token], gap: str, one: Proposal) -> bool:
    """Return whether a line end ends the statement that one would continue."""
    if "\n" not in gap or one.insert.split(" ")[0] in CONTINUING:
        return False
    signs = [part.text[0] for part in before]
    return sum(sign in "([" for sign in signs) <= sum(sign in ")]" for sign in signs)


def _narrowed(found: Iterable[Proposal], text: str, offset: int) -> list[Proposal]:
    """Return the proposals that match the text typed so far, each label once."""
    fitting: dict[str, Proposal] = {}
    for one in found:
        typed = s.key_of(text[one.start : offset])
        label = one.label.lower()
        if label.startswith(typed) or f" {typed}" in f" {label}":
            fitting.setdefault(one.label, one)
    return sorted(fitting.values(), key=lambda one: one.rank)


def _of_phrase(view: View, phrase: Phrase) -> Iterator[Proposal]:
    expected = phrase.expected
    if expected.scale:
        yield from _words(view, phrase)
    left_out = left_out_of(view, phrase)
    for symbol in _symbols(view, phrase):
        if symbol.key not in left_out:
            yield _name(symbol, phrase)
    for terms in expected.terms:
        for key, term in terms.items():
            if key not in left_out:
                yield _term(term, phrase)
    if expected.unit:
        yield from _units(phrase, expected.dimension or view.dimension_of(expected.like))


def _term(term: Term, phrase: Phrase) -> Proposal:
    return Proposal(
        term.label, term.kind, term.label + term.behind, phrase.start, phrase.stop,
        term.form, term.about, rank=1 if phrase.expected.names else 0,
    )  # fmt: skip


def _symbols(view: View, phrase: Phrase) -> list[Symbol]:
    """Return the names that are allowed in the place of a phrase."""
    kinds = phrase.expected.names
    symbols = list(view.seen_from(phrase.block, *kinds))
    if phrase.block.kind == "tissue":
        parent = [phrase.block.member] if "tissue" in kinds else []
        return [symbol for symbol in symbols if symbol.key not in parent]
    return symbols


def _name(symbol: Symbol, phrase: Phrase) -> Proposal:
    text = written_name(symbol.name)
    behind = (
        " is " if symbol.kind == "property" and phrase.block.kind in ("tissue", "rules") else ""
    )
    behind = "(" if symbol.kind == "function" else behind
    return Proposal(
        symbol.name, symbol.kind, text + behind, phrase.start, phrase.stop,
        f"{symbol.kind}, {symbol.span.place}",
    )  # fmt: skip


def _words(view: View, phrase: Phrase) -> Iterator[Proposal]:
    """Yield the words of a scale, and the hedges before them."""
    named = view.scale(phrase.expected.scale)
    if named is None:
        return
    for word, shape in named.scale.words.items():
        means = show(named.scale.axis.value_of(shape), named.dimension)
        yield Proposal(word, "word", word, phrase.start, phrase.stop, means)
        if (start := _last_word(phrase)) > phrase.start:  # after a hedge: "very so"
            yield Proposal(word, "word", word, start, phrase.statement.stop, means)
    for hedge in view.of_kind("hedge"):
        yield Proposal(
            hedge.name, "hedge", f"{hedge.name} ", phrase.start, phrase.stop, "hedge", rank=1
        )


def _units(phrase: Phrase, dimension: Dimension | None) -> Iterator[Proposal]:
    """Yield units of a dimension; of all dimensions where it is not known."""
    if dimension is None:
        known = [symbol for symbol in SYMBOLS if "µ" not in symbol and "μ" not in symbol]
    else:
        known = _of_dimension(dimension)
    for rank, unit in enumerate(known):
        found = parse_unit(unit)
        detail = f"{found.factor:g} {si_unit(found.dimension)}".strip()
        about = describe(found.dimension)
        yield Proposal(unit, "unit", unit, phrase.start, phrase.stop, detail, about, rank)


def _of_dimension(dimension: Dimension) -> list[str]:
    """Return the units of a dimension, those that people are shown first."""
    # A number cannot be followed by the 1 of 1/s.
    unit = si_unit(dimension)
    shown = [one.unit for one in shown_units(unit)]
    listed = [*shown, suggested_unit(dimension), unit]
    simple = (
        symbol
        for symbol, (_, other) in SYMBOLS.items()
        if other == dimension and "µ" not in symbol and "μ" not in symbol
    )
    return [unit for unit in dict.fromkeys((*listed, *simple)) if unit and unit[0] != "1"]


def _keywords(
    view: View, phrase: Phrase, following: list[str], offset: int
) -> Iterator[Proposal]:
    """Yield reserved words: those that begin a statement, or that continue one."""
    last = _last_word(phrase)
    is_first = all(part.start >= last for part in phrase.statement.parts)
    if is_first:
        block = block_of(phrase.statement)
        starting = {
            "": ("param", "let", "set", "expect", "table"),
            "script": (*TIME_WORDS, "when"),
            "study": ("expect",),
        }
        for word in starting.get(block.kind, ()):
            yield _keyword(word, last, offset)
        if block.kind == "" and "language" not in view.source.text[: phrase.statement.start]:
            yield _keyword("language", last, offset, "language 1")
        return
    if phrase.parts or not phrase.expected.declares:
        for word in following:
            yield _keyword(word, last, offset)


def _last_word(phrase: Phrase) -> int:
    """Return where the last word begins, which may be still to come."""
    end = phrase.statement.stop
    return phrase.parts[-1].start if phrase.parts and phrase.parts[-1].stop == end else end


def _keyword(word: str, start: int, stop: int, insert: str = "") -> Proposal:
    about = PARTS[word].about if word in PARTS else MEANINGS.get(word, "")
    rank = 2 if word not in DECLARING_WORDS else 0
    return Proposal(word, "keyword", insert or f"{word} ", start, stop, about, about, rank)


#: Number of files beside a scene that are listed at most.
MOST_FILES = 1000
#: Endings of files with numbers.
TABLES = (".csv",)
#: Of files with measurements; all of them hold tables, or are results.
MEASURED = (".csv", ".tsv", ".txt", *RESULTS)


def in_quotes(view: View, phrase: Phrase, offset: int) -> list[Proposal]:
    """Return files that can be named between quotes.

    Args:
        phrase: The words in quotes, or the place for them.
        offset: The place up to which they are typed.
    """
    quote = phrase.parts[-1] if phrase.parts and phrase.parts[-1].kind == STRING else None
    kind = phrase.expected.files
    if not kind:
        return []
    start = quote.start + 1 if quote else offset
    stop = (
        max(quote.stop - (len(quote.text) > 1 and quote.text[-1] == '"'), start)
        if quote
        else offset
    )
    names = _used(view) if kind == "use" else _numbers(view, kind)
    wrap = "{}" if quote else '"{}"'
    typed = view.source.text[start:offset]
    return [
        Proposal(name, "file", wrap.format(name), start, max(stop, offset), where)
        for name, where in names
        if name.startswith(typed)
    ]


def _used(view: View) -> Iterator[tuple[str, str]]:
    """Yield the names that ``use`` accepts, each with its place."""
    library = Library.of(view.source, view.documents.libraries)
    for name, path in files_of(library.folders):
        if not name.startswith("scenes/"):
            yield name, str(path)
    own = view.source.path.resolve() if view.source.path else None
    for name, path in files_of((library.beside,)):
        if path.resolve() != own and "/" not in name:
            yield f"./{name}", str(path)


def _numbers(view: View, kind: str) -> Iterator[tuple[str, str]]:
    """Yield mesh files, or tables, beside a scene and in libraries."""
    library = Library.of(view.source, view.documents.libraries)
    endings = {"table": TABLES, "rows": TABLES, "data": MEASURED, "hold out": MEASURED}.get(
        kind, (*FORMATS, *IMAGES)
    )
    for folder in dict.fromkeys((library.beside, *library.folders)):
        for path in _some_files(folder):
            if path.name.lower().endswith(endings):
                yield path.relative_to(folder).as_posix(), str(path)


def _some_files(folder: Path) -> list[Path]:
    try:
        found = [*folder.glob("*"), *folder.glob("*/*")]
    except OSError:
        return []
    return sorted(path for path in found[:MOST_FILES] if path.suffix != SUFFIX)


def left_out_of(view: View, phrase: Phrase) -> Collection[str]:
    """Return keys of words that are not allowed in the place of a phrase.

    These are entries that the block has once and that another statement writes, properties of
    a tissue without a vocabulary, what to adjust of laws and forces that a text has not, and
    entries that cannot vary because no block has them.
    """
    statement, block = phrase.statement, phrase.block
    if block.kind == "learn" and statement.words[:1] == ["adjust"]:
        return _adjusted_elsewhere(view)
    if phrase.expected.terms == (study.varied(),):
        return _entries_elsewhere(view)
    if any(part.start < phrase.start for part in statement.parts):
        return ()
    beside = statement.outer.items if statement.outer else view.structure.statements
    known = [*_once(block), *(_properties(view) if block.kind == "tissue" else ())]
    written = (key_of(" ".join(one.words)) for one in beside if one.start != statement.start)
    # The longest, for some entries begin with another one.
    begun = {max(_beginning(text, known), key=len, default="") for text in written}
    if block.kind in ("tissue", "law"):
        begun |= {name for name, law in BY_ENTRY.items() if begun & _names_of(law)}
    if block.kind == "tissue" and "described" not in begun and not _is_like(statement):
        begun |= set(_properties(view))
    return begun


def _names_of(law: LawKind) -> set[str]:
    """Return the entries that write a law, of which a tissue has one."""
    return {law.word, *(form.name for form in law.forms)}


def _is_like(statement: Statement) -> bool:
    """Return whether the tissue around a statement inherits from another one."""
    return statement.outer is not None and any(
        part.text == "like" for part in statement.outer.parts
    )


def _beginning(text: str, known: Iterable[str]) -> Iterable[str]:
    return (key for key in known if f"{text} ".startswith(f"{key} "))


def _once(block: BlockKind) -> Collection[str]:
    """Return the entries that a block, or the text outside of blocks, may have only once."""
    if not block.kind:
        return parts("single")
    return [name for name, entry in entries_in(*block).items() if not entry.repeats]


def _properties(view: View) -> list[str]:
    return [symbol.key for symbol in view.of_kind("property")]


def _entries_elsewhere(view: View) -> Collection[str]:
    """Return entries that could vary in other scenes, but not in this one."""
    if view.words is None:
        return ()
    named = {symbol.key for symbol in view.of_kind("param", "property")}
    return study.varied().keys() - study.varying(view.words) - named


def _adjusted_elsewhere(view: View) -> Collection[str]:
    """Return constants of laws that no tissue of the text has, and numbers of forces."""
    if view.words is None or not view.words.tissues:
        return ()
    laws = [
        law for tissue in view.words.tissues.values() for law in tissue.written_laws.values()
    ]
    own = {name for law in laws if law.law is not None for name in entries_of(type(law.law))}
    families = (SPRING_LAWS, VISCOSITY_LAWS, SOLID_LAWS)
    every = {name for family in families for law in family.values() for name in entries_of(law)}
    of_forces = set(numbers_of_forces())
    if any(view.of_kind("force")):
        own |= of_forces
    return (every | of_forces) - own - set(ADJUSTED)
