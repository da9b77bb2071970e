"""The pages that hold generated parts."""

from collections.abc import Mapping
from pathlib import Path

from docs.reference import commands, curves, language, results, vocabulary
from tissuec.core.markdown import places, replace_places
from tissuec.core.resources import grammar
from tissuec.lsp import vscode as editor


def pages(folder: Path) -> dict[Path, str]:
    """Return the texts of the pages of a folder and of those below it."""
    return {page: page.read_text(encoding="utf-8") for page in sorted(folder.rglob("*.md"))}


def contents(texts: Mapping[Path, str]) -> dict[str, str]:
    """Return every generated part by the name of its place.

    A member of a family stands at a place of its own, such as "verb cut", where a page has
    one, and otherwise at the place for those without one, such as "any other verb".
    """
    homes = {place: page.name for page, text in texts.items() for place in places(text)}
    parts = language.parts() | commands.parts() | vocabulary.parts() | curves.parts()
    parts |= results.parts()
    parts |= {name: text for name, text in language.block_parts().items() if name in homes}
    for word, sections in language.members().items():
        own = {name: text for name, text in sections.items() if f"{word} {name}" in homes}
        parts |= {f"{word} {name}": text for name, text in own.items()}
        others = {name: text for name, text in sections.items() if name not in own}
        parts[f"any other {word}"] = language.joined(others)
    verbs = {name.removeprefix("verb "): page for name, page in homes.items()}
    return parts | {"verbs": language.verb_table(verbs)}


def outdated(folder: Path) -> dict[Path, str]:
    """Return the pages of a folder that should read otherwise, with what they should be."""
    texts = pages(folder)
    generated = contents(texts)
    fresh = {page: replace_places(text, generated) for page, text in texts.items()}
    return {page: text for page, text in fresh.items() if text != texts[page]}


def unused(folder: Path) -> set[str]:
    """Return the generated parts that no page of a folder shows."""
    texts = pages(folder)
    return set(contents(texts)).difference(*map(places, texts.values()))


def outdated_grammars() -> dict[Path, str]:
    """Return the files for editors that should read otherwise, with what they should be."""
    wanted = {grammar(f"vscode/{name}"): text for name, text in editor.contents().items()}
    return {path: text for path, text in wanted.items() if _text_of(path) != text}


def _text_of(path: Path) -> str:
    return path.read_text(encoding="utf-8") if path.exists() else ""
