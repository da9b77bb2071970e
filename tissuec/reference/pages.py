"""The pages that hold generated parts."""

from pathlib import Path

from tissuec.reference import commands, language
from tissuec.reference.markdown import places, replace_places


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
