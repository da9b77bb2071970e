"""Names of result files, and whether one can be written before a run spends its time."""

import os
import shutil
from collections.abc import Generator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import mkdtemp

from tissuec.core.files import final_place
from tissuec.results import PlaceError

SUFFIX = ".vtkhdf"
_MARK = ".partial"
_LONGEST_SHOWN = 200  # characters of a path in a message


def partial_path(path: Path) -> Path:
    """Return where a result is written until it is complete; itself if it says so already.

    Where the name is a link, this and the complete result are beside the file it leads to.
    """
    path = final_place(path)
    return path if _is_marked(path) else path.with_name(f"{path.stem}{_MARK}{path.suffix}")


def final_path(path: Path) -> Path:
    """Return the name of the complete result, from that name or the partial one."""
    path = final_place(path)
    if not _is_marked(path):
        return path
    if path.suffix == _MARK:
        return path.with_suffix("")
    return path.with_name(f"{path.stem.removesuffix(_MARK)}{path.suffix}")


def _is_marked(path: Path) -> bool:
    """Return whether a name is that of a partial result, with or without a suffix behind it."""
    return path.suffix == _MARK or (path.stem.endswith(_MARK) and path.stem != _MARK)


def make_folder(folder: Path) -> None:
    """Create a folder for results, unless there is one.

    Raises:
        PlaceError: The folder cannot be created.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise PlaceError(f'cannot make the folder "{folder}": {reason}') from error


def check_name(path: Path) -> None:
    """Find out whether the system accepts the names of a result and of its partial file.

    Raises:
        PlaceError: They are too long, or have characters that names cannot have.
    """
    try:
        for name in (path, path.with_name(f"{path.stem}{_MARK}{path.suffix}")):
            with suppress(FileNotFoundError, NotADirectoryError, PermissionError):
                os.lstat(name)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        written = str(path) if len(str(path)) < _LONGEST_SHOWN else f"{str(path)[:60]}…"
        raise PlaceError(f'cannot write "{written}": {reason.lower()}') from error


def check_place(path: Path) -> None:
    """Find out whether a result can be written to ``path``.

    Raises:
        PlaceError: The folder is missing or closed, or the name belongs to a folder.
    """
    folder = path.parent
    if not folder.exists():
        raise PlaceError(
            f'cannot write "{path}": the folder "{folder}" does not exist; create it'
        )
    if not folder.is_dir():
        raise PlaceError(f'cannot write "{path}": "{folder}" is not a folder')
    if path.is_dir():
        raise PlaceError(f'cannot write "{path}": it is a folder; give the name of a file')
    if not os.access(folder, os.W_OK | os.X_OK):
        raise PlaceError(
            f'cannot write "{path}": no permission to write to the folder "{folder}"'
        )


def busy(partial: Path) -> str:
    """Return that another run is writing an unfinished result, and what to do."""
    final = final_path(partial)
    return (
        f'cannot write "{final}": another run is writing it; wait for its end, or write to '
        f"another file: -o other{final.suffix}"
    )


def temporary_folder() -> Path:
    """Return a new folder for a temporary result."""
    return Path(mkdtemp(prefix="tissuec-"))


@contextmanager
def result_place(out: str | os.PathLike[str] | None, name: str) -> Generator[Path]:
    """Give the path of a result; a temporary one is removed if anything fails.

    Args:
        out: The path, if one is given.
        name: What the text of the scene is called.

    Raises:
        PlaceError: Its folder cannot be created.
    """
    if out is not None:
        check_name(Path(out))
        make_folder(Path(out).parent)
        yield Path(out)
        return
    folder = temporary_folder()
    try:
        yield folder / Path(name).with_suffix(SUFFIX).name
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise
