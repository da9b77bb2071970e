"""The pages that hold generated parts."""

from pathlib import Path

from docs.reference import commands, language
from tissuec.core.markdown import places, replace_places
from tissuec.core.resources import grammar
from tissuec.lsp import vscode as editor


def contents() -> dict[str, str]:
    """Return every generated part of every page by its name."""
    return language.parts() | commands.parts()


def outdated(folder: Path) -> dict[Path, str]:
    """Return the pages of a folder that should read otherwise, with what they should be."""
    generated = contents()
    fresh: dict[Path, str] = {}
    for page in sorted(folder.glob("*.md")):
        text = page.read_text(encoding="utf-8")
        if places(text) and (new := replace_places(text, generated)) != text:
            fresh[page] = new
    return fresh


def unused(folder: Path) -> set[str]:
    """Return the generated parts that no page of a folder shows."""
    shown = [places(page.read_text(encoding="utf-8")) for page in folder.glob("*.md")]
    return set(contents()).difference(*shown)


def outdated_grammars() -> dict[Path, str]:
    """Return the files for editors that should read otherwise, with what they should be."""
    wanted = {grammar(f"vscode/{name}"): text for name, text in editor.contents().items()}
    return {path: text for path, text in wanted.items() if _text_of(path) != text}


def _text_of(path: Path) -> str:
    return path.read_text(encoding="utf-8") if path.exists() else ""
