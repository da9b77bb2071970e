"""Reading files that a text names, regular ones only and up to a size, and replacing files."""

import errno
import os
import stat
from collections.abc import Generator, Sequence
from contextlib import contextmanager, suppress
from io import BufferedReader, FileIO
from pathlib import Path

try:
    import fcntl
except ImportError:  # Windows has no advisory locks of this kind
    fcntl = None

_LOCKED_BYTE = 1 << 62  # far behind any data, so that no lock of a reader meets it


def open_regular(path: Path) -> BufferedReader:
    """Return a file, open for reading.

    Raises:
        OSError: It cannot be opened, or is a pipe or a device, which may never end.
    """
    file = open(path, "rb", opener=_without_waiting)  # noqa: SIM115  # the caller closes it
    if stat.S_ISREG(os.fstat(file.fileno()).st_mode):
        return file
    file.close()
    raise OSError(errno.EINVAL, "it is not a regular file", str(path))


def read_bytes(path: Path, most: int, *, regular: bool = True) -> bytes:
    """Return the contents of a file.

    Args:
        path: The file.
        most: Largest size [bytes].
        regular: Whether it must be a regular file; a pipe that a user names is read to its end.

    Raises:
        OSError: It cannot be read, is larger, or is no regular file.
    """
    with open_regular(path) if regular else path.open("rb") as file:
        found = os.fstat(file.fileno())
        is_larger = found.st_size > most
        # Python makes room for all that is asked for; only what may never end needs a limit.
        asked = -1 if stat.S_ISREG(found.st_mode) else most + 1
        data = b"" if is_larger else file.read(asked)
    if is_larger or len(data) > most:
        raise OSError(errno.EFBIG, f"it is larger than {most >> 20} MiB", str(path))
    return data


def leads_out(path: Path, folders: Sequence[Path]) -> bool:
    """Return whether a file lies in none of the folders once all links are followed."""
    place = path.resolve()
    return not any(place.is_relative_to(folder.resolve()) for folder in folders)


def _without_waiting(path: str, flags: int) -> int:
    """Open a file; a pipe without waiting for its writer."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


@contextmanager
def replacing(path: Path) -> Generator[Path]:
    """Yield a place beside a file, and put what was written there in the place of the file.

    Who looks at the former file meanwhile never sees half of one; if writing fails, it stays.
    """
    beside = path.with_name(f"{path.name}.new")
    try:
        yield beside
        os.replace(beside, path)
    except BaseException:
        with suppress(OSError):
            beside.unlink(missing_ok=True)
        raise


def lock(file: FileIO) -> None:
    """Keep other processes from writing a file; does nothing where there are no locks.

    Raises:
        BlockingIOError: Another process is writing it.
    """
    if fcntl is None:
        return
    try:
        fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, _LOCKED_BYTE)
    except OSError as error:
        if error.errno in (errno.EAGAIN, errno.EACCES):
            raise BlockingIOError(errno.EAGAIN, "another process is writing it") from None
