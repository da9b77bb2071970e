"""Hover texts: values in SI units with their origin, and meanings of names."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from msgspec import Struct

from tissuec.compiler.provenance import cited, explain_tissue
from tissuec.core.catalogue import CODES
from tissuec.core.errors import Diagnostic, counted
from tissuec.core.markdown import code, fenced
from tissuec.core.source import Span
from tissuec.core.units import describe, parse_unit, show, si_unit
from tissuec.lang import syntax as s
from tissuec.lang.tokens import COMMENT, KEYWORD, Token, tokens
from tissuec.lang.words import MEANINGS
from tissuec.lsp.phrases import Phrase
from tissuec.lsp.symbols import Symbol
from tissuec.lsp.views import View
from tissuec.scene.model import Tissue
from tissuec.scene.reading.parts import PARTS

if TYPE_CHECKING:
    from tissuec.compiler.compile import Compiled


class Hover(Struct, frozen=True):
    """Markdown about a stretch of a text."""

    text: str
    start: int
    stop: int


def hover(
    view: View,
    offset: int,
    compiled: "Compiled | None" = None,
    diagnostics: tuple[Diagnostic, ...] = (),
) -> Hover | None:
    """Return the information about a place of a text.

    Args:
        offset: The place.
        compiled: The scene in arrays, if the text has no errors: then sets are counted.
        diagnostics: Findings; their codes are explained at their places.
    """
    found = _meaning(view, offset, compiled)
    codes = list(_explained_codes(view, offset, diagnostics))
    if not codes:
        return found
    parts = [found.text] if found else []
    start, stop = (found.start, found.stop) if found else (offset, offset)
    return Hover("\n\n---\n\n".join([*parts, *codes]), start, stop)


def _meaning(view: View, offset: int, compiled: "Compiled | None") -> Hover | None:
    part = view.structure.lexeme_at(offset)
    if part is None or view.in_remark(offset):
        return None
    if part.type in ("NUMBER", "QUANTITY", "RPAR_UNIT"):
        return _number(part, offset)
    phrase = view.phrase_at(offset)
    if part.kind == KEYWORD and (phrase is None or phrase.term is None):
        about = PARTS[part.text].about if part.text in PARTS else MEANINGS.get(part.text)
        return Hover(f"{code(part.text)}: {about}", part.start, part.stop) if about else None
    if phrase is None or not phrase.parts:
        return None
    if found := view.symbols_at(offset):
        _, start, stop = found[0]
        texts = (_of_symbol(view, symbol, phrase, compiled) for symbol, *_ in found)
        return Hover("\n\n---\n\n".join(texts), start, stop)
    if phrase.term is None:
        return None
    return Hover(_of_term(view, phrase), phrase.start, phrase.stop)


def _explained_codes(
    view: View, offset: int, diagnostics: tuple[Diagnostic, ...]
) -> Iterator[str]:
    """Yield the explanations of the codes of findings at an offset."""
    for finding in diagnostics:
        span = finding.span
        if span is None or span.source is not view.source or finding.code not in CODES:
            continue
        if span.start <= offset <= max(span.end, span.start + 1):
            entry = CODES[finding.code]
            yield f"**{finding.code}: {entry.title}**\n\n{entry.text}"


# --- numbers ----------------------------------------------------------------------------------


def _number(part: Token, offset: int) -> Hover | None:
    """Return a number in SI units, or what the unit of a vector measures."""
    first, *units = part.pieces
    if not units:
        return None
    (unit,) = units
    try:
        size, dimension = parse_unit(unit.text)
    except (ValueError, OverflowError):
        return None
    if first.text == ")":
        text = f"{code(unit.text)} is {_si(size, si_unit(dimension))}: {describe(dimension)}"
        return Hover(text, unit.start, unit.stop) if offset >= unit.start else None
    value = float(first.text) * size
    text = f"{code(part.text)} is {_si(value, si_unit(dimension))}: {describe(dimension)}"
    return Hover(text, part.start, part.stop)


def _si(value: float, unit: str) -> str:
    return code(f"{value:.10g} {unit}".strip())


# --- words of the language --------------------------------------------------------------------


def _of_term(view: View, phrase: Phrase) -> str:
    term = phrase.term
    assert term is not None
    head = f"**{term.label}**" + (f"  {code(term.form)}" if term.form else "")
    parts = [head, term.about]
    tissue = view.tissue(phrase.block.member) if phrase.block.kind == "tissue" else None
    if tissue is not None and phrase.key in tissue.given:
        parts.append(_given(view, tissue, phrase.key))
    return "\n\n".join(part for part in parts if part)


def _given(view: View, tissue: Tissue, quantity: str) -> str:
    """Return the value of one quantity of a tissue, and the lines that gave it."""
    (explained,) = (e for e in explain_tissue(tissue) if s.key_of(e.quantity) == quantity)
    given = tissue.given[quantity]
    spans = [fired.span for fired in given.fired] or [given.span]
    lines = [
        f"{explained.quantity} of {tissue.name}: {code(explained.shown)} ({explained.how})"
    ]
    for reason, span in zip(explained.reasons, spans, strict=True):
        said = f"{reason.said}: " if reason.said else ""
        facts = f" ({reason.facts})" if reason.facts else ""
        lines.append(f"- {said}{code(span.one_line)}{facts}, {_place(view, span)}")
    return "\n".join(lines)


# --- names ------------------------------------------------------------------------------------


def _of_symbol(view: View, symbol: Symbol, phrase: Phrase, compiled: "Compiled | None") -> str:
    """Return the meaning of a name and where it is declared."""
    parts = [f"**{symbol.name}**, {_kind(symbol)}, {_place(view, symbol.span)}"]
    parts += _facts(view, symbol, phrase, compiled)
    remark = _remark(symbol)
    return "\n\n".join(part for part in (*parts, remark) if part)


def _place(view: View, span: Span) -> str:
    """Return the place of something, in short."""
    return f"line {span.line}" if span.source is view.source else span.place


def _kind(symbol: Symbol) -> str:
    if symbol.kind == "word":
        return f"a word for {symbol.within}"
    of = {"region": "a region of", "column": "a column of study"}.get(symbol.kind)
    return f"{of} {symbol.within}" if of else symbol.kind


def _remark(symbol: Symbol) -> str:
    """Return the comment after a declaration."""
    line = symbol.span.source.line_text(symbol.span.line)
    parts = [part for part in tokens(line) if part.kind == COMMENT]
    return parts[0].text.lstrip("# ") if parts else ""


def _facts(
    view: View, symbol: Symbol, phrase: Phrase, compiled: "Compiled | None"
) -> Iterator[str]:
    match symbol.kind:
        case "param" | "let":
            yield from _value(view, symbol)
        case "tissue":
            yield from _tissue(view, symbol)
        case "property" | "quantity":
            yield from _scale(view, symbol, phrase)
        case "word":
            yield from _word(view, symbol)
        case "set" | "body" | "joint":
            yield from _drawn(view, symbol, compiled)
        case "region" | "column" | "function" | "rules" | "law" | "tool" | "force" | "hedge":
            yield fenced(symbol.span.source.line_text(symbol.span.line).strip(), "tis")
        case _:
            pass


def _declared(view: View, symbol: Symbol) -> s.Item | None:
    if view.words is None:
        return None
    declared = view.words.declarations.of(symbol.kind).get(symbol.key)
    return declared.item if declared else None


def _written(item: s.Item | None) -> str:
    """Return the head of what declares a name, as it is written."""
    if item is None:
        return ""
    span: Span = item.head if isinstance(item, s.Block) else item.span
    return fenced(span.one_line, "tis")


def _value(view: View, symbol: Symbol) -> Iterator[str]:
    yield _written(_declared(view, symbol))
    value = view.words.constants.definitions.values.get(symbol.key) if view.words else None
    if value is None:
        return
    if value.is_vector:
        yield f"{code(str(value))}: {describe(value.dimension)}, a vector"
    else:
        shown = _si(float(value.amount), si_unit(value.dimension))
        yield f"{code(str(value))} = {shown}: {describe(value.dimension)}"


def _tissue(view: View, symbol: Symbol) -> Iterator[str]:
    tissue = view.tissue(symbol.key)
    if tissue is None:
        return
    yield tissue.about
    facts = [
        f"- {fact.property} is {fact.written} ({fact.number:.4g}), {_place(view, fact.span)}"
        for fact in tissue.facts
    ]
    if facts:
        yield "\n".join(facts)
    yield "\n\n".join(_given(view, tissue, quantity) for quantity in tissue.given)
    laws = [
        f"- {word}: {code(law.name)}, {_place(view, law.span)}"
        for word, law in tissue.written_laws.items()
    ]
    known = [
        f"- known {one.quantity.name}: {code(one.shown)}, {cited(one)}, "
        f"{_place(view, one.span)}"
        for one in tissue.known
    ]
    known += [
        f"- known {one.name}: {code(one.shown)}, {cited(one)}, {_place(view, one.span)}"
        for one in tissue.curves
    ]
    missing = [f"- {name}: none, {reason}" for name, reason in tissue.gaps.items()]
    yield "\n".join([*laws, *known, *missing])


def _scale(view: View, symbol: Symbol, phrase: Phrase) -> Iterator[str]:
    """Yield the range and the words of a scale; in a tissue, also its value."""
    tissue = view.tissue(phrase.block.member) if phrase.block.kind == "tissue" else None
    for fact in tissue.facts if tissue else ():
        if fact.property == symbol.key:
            yield f"{fact.written} has the value {code(f'{fact.number:.4g}')}"
    if tissue is not None and symbol.key in tissue.given:
        yield _given(view, tissue, symbol.key)
    named = view.scale(symbol.key)
    if named is None:
        return
    yield _written(_declared(view, symbol))
    means = (
        f"- {word}: {show(named.scale.axis.value_of(shape), named.dimension)}"
        for word, shape in named.scale.words.items()
    )
    yield "\n".join(means)


def _word(view: View, symbol: Symbol) -> Iterator[str]:
    named = view.scale(symbol.within)
    shape = named.scale.words.get(symbol.key) if named else None
    if named is None or shape is None:
        return
    axis = named.scale.axis
    means, low, high = (
        code(show(value, named.dimension))
        for value in (axis.value_of(shape), *axis.reach_of(shape))
    )
    yield f"value {means}, range {low} to {high}"


def _drawn(view: View, symbol: Symbol, compiled: "Compiled | None") -> Iterator[str]:
    """Yield how a set, body or joint is written, and how much is in it."""
    yield _written(_declared(view, symbol))
    if compiled is None:
        return
    network, groups = compiled.network, compiled.groups
    for part in network.parts:
        if s.key_of(part.name) == symbol.key:
            yield str(part.size)
    if symbol.kind == "set" and (chosen := groups.sets.values.get(symbol.key)) is not None:
        yield counted(len(chosen.indices), "spring" if chosen.are_lines else "node")
