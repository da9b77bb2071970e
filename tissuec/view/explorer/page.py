"""One self-contained page for a vocabulary: no network, no library, nothing to install."""

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from html import escape
from importlib.resources import files
from math import isfinite
from pathlib import Path
from typing import Any

from tissuec.compiler.provenance import shown_value
from tissuec.core import palette, resources
from tissuec.core.errors import CompileError, TissueError
from tissuec.core.names import key_of
from tissuec.core.units import UnitError, parse_unit, si_unit
from tissuec.core.version import __version__
from tissuec.lang.words import written_name
from tissuec.pipeline import read_words
from tissuec.scene.model import AssignedQuantity, PropertyFact, Tissue
from tissuec.scene.program.imports import load, read_source
from tissuec.scene.program.library import SUFFIX, Library
from tissuec.scene.program.resolved import ResolvedProgram
from tissuec.scene.reading.findings import Findings
from tissuec.scene.request import Request
from tissuec.scene.resolve import resolve_words
from tissuec.scene.words.vocabulary import RulesBlock
from tissuec.view.explorer.tables import short_place, tables

#: One program, in this order.
SCRIPTS = (
    "inference.js", "numbers.js", "stress.js", "drawing.js", "facts.js", "curve.js",
    "controls.js", "results.js", "surface.js", "texts.js", "explorer.js",
)  # fmt: skip
PARTS = ("shell.html", "explorer.css")

#: Of what is true, and of what comes out.
_LIGHT = {
    "ink": palette.INK, "grid": palette.GRID, "paper": palette.PAPER,
    "lit": palette.SERIES[0], "result": palette.SERIES[1],
}  # fmt: skip
_DARK = {
    "ink": palette.INK_DARK, "grid": palette.GRID_DARK, "paper": palette.PAPER_DARK,
    "lit": palette.SERIES[4], "result": palette.SERIES[5],
}  # fmt: skip


def document(request: Request) -> dict[str, Any]:
    """Return the contents of the page of a vocabulary, as plain data.

    Raises:
        CompileError: The text is wrong.
        TissueError: It has no rules.
    """
    words, _ = read_words(request)
    source = request.source
    if not words.vocabulary.rules:
        raise TissueError(f'"{source.name}" has no rules, so its words have no results')
    path = source.path or Path(source.name)
    return {
        "title": path.stem.replace("_", " "),
        "file": path.name,
        "about": words.declarations.metadata.about,
        "use": _used_as(path, words),
        "colours": {"amount": palette.AMOUNT},
        **tables(words),
        "presets": presets(words, Library.of(source, request.libraries), request.libraries),
    }


def render(page: Mapping[str, Any]) -> str:
    """Return the HTML of a document."""
    data = json.dumps(page, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    parts = {
        "title": escape(page["title"]),
        "about": escape(page["about"]),
        "version": __version__,
        "colours": _colours(),
        "style": _file(PARTS[1]),
        "code": "\n".join(map(_file, SCRIPTS)),
        "data": data.replace("<", "\\u003c"),  # so that no text can end the script
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda found: parts[found[1]], _file(PARTS[0]))


def _used_as(path: Path, words: ResolvedProgram) -> str:
    """Return the name after ``use`` that brings the rules; empty for a scene."""
    declarations = words.declarations
    if declarations.single or declarations.of("body"):
        return ""
    place, library = path.resolve().with_suffix(""), resources.library().resolve()
    is_shipped = place.is_relative_to(library)
    return place.relative_to(library).as_posix() if is_shipped else f"./{path.stem}"


def _colours() -> str:
    """Return the colours as CSS: of the system, or as chosen on the page."""
    light, dark = _theme("light", _LIGHT), _theme("dark", _DARK)
    amount = f":root {{ --amount: {', '.join(palette.AMOUNT)} }}"
    by_system = f"@media (prefers-color-scheme: dark) {{ :root {{ {dark} }} }}"
    told = f':root[data-theme="light"] {{ {light} }}\n:root[data-theme="dark"] {{ {dark} }}'
    return "\n".join([amount, f":root {{ {light} }}", by_system, told])


def _theme(name: str, colours: Mapping[str, str]) -> str:
    listed = "; ".join(f"--{key}: {colour}" for key, colour in colours.items())
    return f"color-scheme: {name}; {listed}"


def _file(name: str) -> str:
    return files("tissuec.view.explorer").joinpath(name).read_text(encoding="utf-8")


_NUMBER = r"[+-]?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?"
_LITERAL = re.compile(rf"({_NUMBER}) ?([^\d\s+.-][^\s]*)?")
_GIVEN = re.compile(rf"[^=]*= ?({_LITERAL.pattern}(?: per {_LITERAL.pattern})?)")


def presets(
    words: ResolvedProgram, library: Library, libraries: Sequence[Path]
) -> list[dict[str, Any]]:
    """Return the tissues described by the rules of a program, its own ones first.

    Args:
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
    """Yield the content of a file of a library, unless it is a scene or has mistakes."""
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
    """Return a number that replaces what rules say, as a complete form."""
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
