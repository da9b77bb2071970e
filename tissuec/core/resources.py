"""Where grammars, the shipped library and the user's cache are."""

import os
import tempfile
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


@cache
def cache_folder() -> Path | None:
    """Return a folder of this user's own for compiled grammars and kernels, or None.

    Both are loaded as code, so a folder that others may write to is not used.
    """
    from platformdirs import user_cache_path

    own = user_cache_path("tissuec", appauthor=False)
    user = getattr(os, "getuid", lambda: "user")()
    for folder in (own, Path(tempfile.gettempdir()) / f"tissuec-cache-{user}"):
        try:
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            if _is_ours(folder):
                return folder
        except OSError:
            continue
    return None


def _is_ours(folder: Path) -> bool:
    """Return whether this user alone can write to a folder, and does so now."""
    if hasattr(os, "getuid"):
        status = folder.stat()
        if status.st_uid != os.getuid() or status.st_mode & 0o022:
            return False
    with tempfile.TemporaryFile(dir=folder):
        return True
