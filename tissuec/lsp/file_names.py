"""Names of files between quotes: what ``use`` can name, meshes, and tables."""

from collections.abc import Iterator
from pathlib import Path

from tissuec.compiler.learning.targets import RESULTS
from tissuec.lang.tokens import STRING
from tissuec.lsp.phrases import Phrase
from tissuec.lsp.proposal import Proposal
from tissuec.lsp.views import View
from tissuec.meshes.formats import FORMATS
from tissuec.meshes.formats.conversion import IMAGES
from tissuec.scene.program.library import SUFFIX, Library, files_of

#: Number of files beside a scene that are listed at most.
MOST_FILES = 1000
#: Endings of files with numbers.
TABLES = (".csv",)
#: Of files with measurements; all of them hold tables, or are results.
MEASURED = (".csv", ".tsv", ".txt", *RESULTS)


def in_quotes(view: View, phrase: Phrase, offset: int) -> list[Proposal]:
    """Return files that can be named between quotes.

    Args:
        view: The text.
        phrase: The words in quotes, or the place for them.
        offset: The place up to which they are typed.
    """
    quote = phrase.parts[-1] if phrase.parts and phrase.parts[-1].kind == STRING else None
    kind = phrase.expected.files
    if not kind:
        return []
    start = quote.start + 1 if quote else offset
    stop = (
        max(quote.stop - (len(quote.text) > 1 and quote.text[-1] == '"'), start)
        if quote
        else offset
    )
    names = _used(view) if kind == "use" else _numbers(view, kind)
    wrap = "{}" if quote else '"{}"'
    typed = view.source.text[start:offset]
    return [
        Proposal(name, "file", wrap.format(name), start, max(stop, offset), where)
        for name, where in names
        if name.startswith(typed)
    ]


def _used(view: View) -> Iterator[tuple[str, str]]:
    """Yield the names that ``use`` accepts, each with its place."""
    library = Library.of(view.source, view.documents.libraries)
    for name, path in files_of(library.folders):
        if not name.startswith("scenes/"):
            yield name, str(path)
    own = view.source.path.resolve() if view.source.path else None
    for name, path in files_of((library.beside,)):
        if path.resolve() != own and "/" not in name:
            yield f"./{name}", str(path)


def _numbers(view: View, kind: str) -> Iterator[tuple[str, str]]:
    """Yield mesh files, or tables, beside a scene and in libraries."""
    library = Library.of(view.source, view.documents.libraries)
    endings = {"table": TABLES, "rows": TABLES, "data": MEASURED, "hold out": MEASURED}.get(
        kind, (*FORMATS, *IMAGES)
    )
    for folder in dict.fromkeys((library.beside, *library.folders)):
        for path in _some_files(folder):
            if path.name.lower().endswith(endings):
                yield path.relative_to(folder).as_posix(), str(path)


def _some_files(folder: Path) -> list[Path]:
    try:
        found = [*folder.glob("*"), *folder.glob("*/*")]
    except OSError:
        return []
    return sorted(path for path in found[:MOST_FILES] if path.suffix != SUFFIX)
