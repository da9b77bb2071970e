"""Names that are declared in the files of a folder, whether they are open or not."""

import os
from collections.abc import Iterable, Iterator
from pathlib import Path

from msgspec import Struct

from tissuec.core.errors import CompileError
from tissuec.lsp.documents import OpenDocuments
from tissuec.lsp.navigation import Outlined, outline
from tissuec.scene.program.library import LARGEST_FILE, SUFFIX

#: Number of files of a folder that are read at most, and of names that are returned.
MOST_FILES, MOST_NAMES = 2000, 1000
#: Kinds of names that other parts of a text use.
_KINDS = frozenset({
    "param", "let", "function", "set", "body", "joint", "tool", "force", "tissue", "property",
    "quantity", "rules", "law", "hedge", "region", "study", "learn",
})  # fmt: skip


class FoundName(Struct, frozen=True):
    """A declared name.

    Attributes:
        path: The file.
        part: The declaration.
        within: The body of a region; empty for others.
    """

    path: Path
    part: Outlined
    within: str = ""


def names_in(
    folders: Iterable[Path], documents: OpenDocuments, query: str
) -> Iterator[FoundName]:
    """Yield names that contain the letters of a query in their order, in any case.

    Args:
        folders: Folders with files.
        documents: Open texts, which count in place of files.
        query: What is looked for; empty for all names.
    """
    wanted, many = query.casefold().replace(" ", ""), 0
    paths = [path for folder in folders for path in _files(folder)]
    for path in dict.fromkeys((*documents.opened(), *paths)):
        for found in _declared(path, documents):
            if _has(found.part.name.casefold(), wanted):
                many += 1
                yield found
                if many == MOST_NAMES:
                    return


def _files(folder: Path) -> Iterator[Path]:
    """Yield the scenes in a folder and in those inside, but for hidden ones."""
    many = 0
    for place, inner, names in os.walk(folder):
        inner[:] = sorted(name for name in inner if name[0] != "." and name != "node_modules")
        for name in sorted(names):
            path = Path(place, name)
            if path.suffix == SUFFIX:
                many += 1
                yield path
                if many == MOST_FILES:
                    return


def _declared(path: Path, documents: OpenDocuments) -> Iterator[FoundName]:
    try:
        if not documents.is_open(path) and path.stat().st_size > LARGEST_FILE:
            return
        source = documents.read(path, str(path))
    except (CompileError, OSError):
        return
    for part in outline(documents.tree(source)):
        if part.kind in _KINDS:
            yield FoundName(path, part)
        for inner in part.inner:
            if inner.kind in _KINDS:
                yield FoundName(path, inner, part.name)


def _has(name: str, letters: str) -> bool:
    """Return whether a name contains letters in their order."""
    place = 0
    for letter in letters:
        place = name.find(letter, place) + 1
        if not place:
            return False
    return True
