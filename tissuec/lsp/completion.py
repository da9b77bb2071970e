"""Completions at a place of a text: reserved words, names, words, units."""

from collections.abc import Iterable, Iterator
from functools import lru_cache

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
from tissuec.lsp.blocks import block_of
from tissuec.lsp.file_names import in_quotes
from tissuec.lsp.phrases import Phrase, phrase_at_end
from tissuec.lsp.proposal import Proposal
from tissuec.lsp.symbols import Symbol
from tissuec.lsp.terms import Term
from tissuec.lsp.views import View
from tissuec.lsp.written import left_out_of
from tissuec.scene.reading.parts import PARTS


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
