"""One self-contained page for a vocabulary: no network, no library, nothing to install."""

import json
import re
from collections.abc import Mapping
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Any

from tissuec.core import palette, resources
from tissuec.core.errors import TissueError
from tissuec.core.version import __version__
from tissuec.pipeline import read_words
from tissuec.scene.library import Library
from tissuec.scene.request import Request
from tissuec.scene.resolved import ResolvedProgram
from tissuec.view.explorer.presets import presets
from tissuec.view.explorer.tables import tables

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
    """Return the name behind ``use`` that brings the rules; empty for a scene."""
    declarations = words.declarations
    if declarations.single or declarations.of("body"):
        return ""
    place, library = path.resolve().with_suffix(""), resources.library().resolve()
    is_shipped = place.is_relative_to(library)
    return place.relative_to(library).as_posix() if is_shipped else f"./{path.stem}"


def _colours() -> str:
    """Return the colours as CSS: as the system has it, or as the page is told."""
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
