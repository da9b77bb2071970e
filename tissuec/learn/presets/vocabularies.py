"""Vocabularies whose words moved or whose rules were revised, as files beside a preset."""

from collections.abc import Mapping
from pathlib import Path, PurePosixPath

from msgspec import Struct

from tissuec.core.source import Source
from tissuec.lang import syntax as s
from tissuec.lang.parser import parse
from tissuec.lang.printer import format_source
from tissuec.scene.model import Scene
from tissuec.scene.program.declarations import VOCABULARY
from tissuec.scene.program.library import SUFFIX, belongs_to_scenes


class WrittenVocabularies(Struct, frozen=True):
    """Texts of vocabularies.

    Attributes:
        texts: By the names of files beside the preset.
        files: These names by those that the scene has for the sources.
    """

    texts: Mapping[str, str]
    files: Mapping[str, str]

    @property
    def uses(self) -> list[str]:
        """Return the lines that use them."""
        return [f'use "./{name.removesuffix(SUFFIX)}"' for name in self.texts]


def vocabularies(
    texts: Mapping[str, str], scene: Scene, target: Path, mark: str
) -> WrittenVocabularies:
    """Return the files of new vocabularies.

    Args:
        texts: New texts of whole sources, by the names that the scene has for them.
        target: Where the preset goes, whose name none of them may have.
        mark: Their first comment.
    """
    found: dict[str, str] = {}
    files: dict[str, str] = {}
    for name, text in texts.items():
        file = free_name(PurePosixPath(name).name, {target.name, *found})
        whole = parse(Source(name, text))
        if any(map(belongs_to_scenes, whole.items)):
            file = free_name(f"{Path(file).stem}_words{SUFFIX}", {target.name, *found})
            text = words_alone(whole)
        found[file] = marked(text, mark)
        files[name] = file
    return WrittenVocabularies(found, files)


def free_name(name: str, taken: set[str]) -> str:
    """Return a name of a file that is not taken, like ``name``."""
    stem, free, number = Path(name).stem, name, 1
    while free in taken:
        number += 1
        free = f"{stem}_{number}{SUFFIX}"
    return free


def words_alone(module: s.Module) -> str:
    """Return the vocabulary of the file of a scene, without what only scenes have.

    Tissues stay behind: those that are learnt are written in full.

    Args:
        module: The text.
    """
    kept = [item.span.text for item in module.items if is_of_words(item)]
    text = "\n".join(["language 1", "", *kept, ""])
    return format_source(Source(module.source.name, text))


def is_of_words(item: s.Item) -> bool:
    """Return whether an item is a part of a vocabulary, or a number that it may need."""
    match item:
        case s.Assign(keyword=keyword) if keyword in ("param", "let"):
            return True
        case s.Sentence() | s.Assign() | s.Block():
            first = item.name.key.split(" ")[0] if item.name.words else ""
            return first in (*VOCABULARY, "use")
        case _:
            return False


def marked(text: str, mark: str) -> str:
    """Return a text with comments after its first line, which states the language.

    Args:
        text: The text.
        mark: Lines of comments.
    """
    lines = text.split("\n")
    first = next(k for k, line in enumerate(lines) if line.startswith("language"))
    return "\n".join([*lines[first : first + 1], mark, *lines[:first], *lines[first + 1 :]])
