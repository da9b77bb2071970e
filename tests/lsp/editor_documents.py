"""Texts that an editor has open, with marks where something is asked."""

from pathlib import Path

from tissuec.core.resources import library, root
from tissuec.lsp.documents import OpenDocuments
from tissuec.lsp.views import View, view_of

LIBRARY = sorted(library().glob("*/*.tis"))
SCENES = Path(__file__).parent.parent / "scenes"
GOOD = sorted((SCENES / "good").glob("*.tis"))
BAD = sorted((SCENES / "bad").glob("*.tis"))
#: A mark in a text; where it stands is asked.
MARK = "‸"


def asked(
    text: str, path: Path = Path("scene.tis"), documents: OpenDocuments | None = None
) -> tuple[View, int]:
    """Return the view of a text without its mark, and where that was."""
    documents = documents or OpenDocuments()
    documents.put(path, text.replace(MARK, "", 1))
    view = view_of(documents, path)
    assert view is not None
    return view, text.index(MARK)


def shipped(name: str) -> str:
    """Return the text of a file of the library."""
    return (root() / "library" / name).read_text(encoding="utf-8")
