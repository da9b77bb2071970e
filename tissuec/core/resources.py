"""Where grammars and the shipped library are."""

from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent.parent


@cache
def root() -> Path:
    """Return the folder that holds ``grammars/`` and ``library/``.

    A checkout (also behind an editable install) wins over the copy inside an installed
    package, so that edits are seen at once.
    """
    checkout = PACKAGE.parent
    if (checkout / "grammars").is_dir() and (checkout / "pyproject.toml").is_file():
        return checkout
    return PACKAGE / "_data"


def grammar(name: str) -> Path:
    """Return the path of the grammar file ``name``."""
    return root() / "grammars" / name


def library() -> Path:
    """Return the folder of the shipped vocabularies, tissues and scenes."""
    return root() / "library"


def is_preset(path: Path | None) -> bool:
    """Return whether a file is one of the shipped tissues that are matter."""
    return path is not None and (library() / "matter").resolve() in path.resolve().parents
