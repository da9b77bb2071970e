"""Tissues to start from: those of the file itself, and of libraries that use its rules."""

import re
from collections.abc import Iterator, Sequence
from contextlib import suppress
from math import isfinite
from pathlib import Path
from typing import Any

from tissuec.compiler.provenance import shown_value
from tissuec.core.errors import CompileError
from tissuec.core.names import key_of
from tissuec.core.units import UnitError, parse_unit, si_unit
from tissuec.lang.words import written_name
from tissuec.scene.findings import Findings
from tissuec.scene.imports import load, read_source
from tissuec.scene.library import SUFFIX, Library
from tissuec.scene.model import AssignedQuantity, PropertyFact, Tissue
from tissuec.scene.resolve import resolve_words
from tissuec.scene.resolved import ResolvedProgram
from tissuec.scene.vocabulary import RulesBlock
from tissuec.view.explorer.tables import short_place

_NUMBER = r"[+-]?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?"
_LITERAL = re.compile(rf"({_NUMBER}) ?([^\d\s+.-][^\s]*)?")
_GIVEN = re.compile(rf"[^=]*= ?({_LITERAL.pattern}(?: per {_LITERAL.pattern})?)")


def presets(
    words: ResolvedProgram, library: Library, libraries: Sequence[Path]
) -> list[dict[str, Any]]:
    """Return the tissues described by the rules of a program, its own ones first.

    Args:
        words: The resolved program.
        library: Folders in which ``use`` finds files.
        libraries: Folders of ``--library``.
    """
    found = [_preset(tissue, words, "") for tissue in words.tissues.values()]
    for name, path in library.files():
        for used in _used_words(path, name, libraries):
            own = (t for t in used.tissues.values() if t.span.source.name == f"{name}{SUFFIX}")
            alike = (t for t in own if _have_same_rules(t, used, words))
            found += [_preset(tissue, used, name) for tissue in alike]
    named = {(preset["name"], preset["place"]): preset for preset in reversed(found) if preset}
    return list(reversed(named.values()))


def _used_words(path: Path, name: str, libraries: Sequence[Path]) -> Iterator[ResolvedProgram]:
    """Yield what a file of a library says, unless it is a scene or has mistakes."""
    with suppress(CompileError):
        source = read_source(path, f"{name}{SUFFIX}")
        if "tissue" not in source.text or "use" not in source.text:
            return
        findings = Findings()
        program = load(source, libraries, findings)
        if not program.is_scene:
            words = resolve_words(program, findings)
            findings.raise_errors()
            yield words


def _have_same_rules(tissue: Tissue, used: ResolvedProgram, words: ResolvedProgram) -> bool:
    theirs, ours = _rules(tissue, used), _rules(tissue, words)
    return theirs is not None and ours is not None and _is_copy(theirs, ours)


def _rules(tissue: Tissue, words: ResolvedProgram) -> RulesBlock | None:
    return words.vocabulary.rules.get(key_of(tissue.vocabulary))


def _is_copy(one: RulesBlock, other: RulesBlock) -> bool:
    """Return whether two blocks of rules are the same lines of the same file, or of a copy."""
    first, second = one.span, other.span
    return first.start == second.start and first.source.text == second.source.text


def _preset(tissue: Tissue, words: ResolvedProgram, file: str) -> dict[str, Any]:
    """Return a tissue as plain data; empty if no rules describe it."""
    if not tissue.vocabulary:
        return {}
    properties = words.vocabulary.properties
    dimensions = {key: named.dimension for key, named in properties.items()}
    written = [given for given in tissue.given.values() if given.how == "written"]
    return {
        "name": tissue.name,
        "written": written_name(tissue.name),
        "about": tissue.about,
        "place": short_place(tissue.span),
        "file": file,
        "rules": key_of(tissue.vocabulary),
        "facts": {
            fact.property: _fact(fact, si_unit(dimensions[fact.property]))
            for fact in tissue.facts
        },
        "numbers": [_number(given) for given in written],
        "laws": list(tissue.written_laws),
    }


def _fact(fact: PropertyFact, unit: str) -> dict[str, Any]:
    """Return ``is`` a phrase or ``=`` a number, as a text without names has it."""
    is_number = "=" in re.sub(r'"[^"]*"', "", fact.span.text)
    text = fact.written if not is_number or _is_literal(fact.written) else ""
    text = text or f"{fact.number!r} {unit}".rstrip()
    return {"sign": "=" if is_number else "is", "text": text, "value": fact.number}


def _number(given: AssignedQuantity) -> dict[str, Any]:
    """Return a number that replaces what rules say, in a form that stands by itself."""
    quantity = given.quantity
    if given.value == quantity.none:
        text = "is none"
    elif (found := _GIVEN.fullmatch(given.span.one_line)) and _is_literal(found[1]):
        text = f"= {found[1]}"
    else:
        text = f"= {given.value!r} {si_unit(quantity.dimension)}".rstrip()
        text += "" if given.length is None else f" per {given.length!r} m"
    return {
        "quantity": key_of(quantity.name),
        "text": text,
        "value": given.value if isfinite(given.value) else None,
        "shown": shown_value(given),
    }


def _is_literal(text: str) -> bool:
    """Return whether a text is a number with its unit, rather than a calculation."""
    for part in text.split(" per "):
        found = _LITERAL.fullmatch(part)
        try:
            if found is None or (found[2] and not parse_unit(found[2])):
                return False
        except UnitError:
            return False
    return True
