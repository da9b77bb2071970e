"""The first comment of every file that learning writes, which identifies it."""

from pathlib import Path

from tissuec.core.version import __version__

_BEGIN = "# Learned by tissuec"
_LOOKED_AT = 4096  # bytes


def mark(scene: str, fit_problem: str, seed: int) -> str:
    """Return the first comment: by what, of which scene and fit problem, with which seed."""
    return f"{_BEGIN} {__version__} from {scene}, learn {fit_problem}, seed {seed}"


def is_ours(path: Path) -> bool:
    """Return whether learning wrote a file: whether its first comment says so.

    Raises:
        OSError: The file cannot be read.
    """
    with path.open("rb") as file:
        head = file.read(_LOOKED_AT).decode("utf-8", errors="replace")
    comments = (line for line in head.splitlines() if line.startswith("#"))
    return next(comments, "").startswith(f"{_BEGIN} ")
