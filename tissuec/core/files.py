"""Files: those that a text names are read here, and whatever is written passes through here.

What is written appears at once as a whole (``replacing``), or grows in a file that nobody else
writes meanwhile (``OutputFile``). A link that is named as an output stays a link: the file that
it leads to is written.
"""

import errno
import os
import stat
import struct
from collections.abc import Generator, Sequence
from contextlib import contextmanager, suppress
from io import BufferedReader, FileIO
from pathlib import Path
from threading import RLock
from typing import Literal

try:
    import fcntl
except ImportError:  # Windows has no advisory locks of this kind
    fcntl = None

REPLACES_OPEN = os.name != "nt"  # whether the system replaces and removes files that are open
_LOCKED_BYTE = 1 << 62  # far behind any data, so that no lock of a reader meets it
_NO_LINK = getattr(os, "O_NOFOLLOW", 0)
_FLAGS = getattr(os, "O_BINARY", 0) | getattr(os, "O_CLOEXEC", 0) | _NO_LINK
_FLOCK = struct.Struct("hhqqi0q")  # kind, from where, start, length, process
_PIECE = 1 << 20  # bytes that are copied at once
_POINTER = b"version https://git-lfs.github.com/spec/"  # in place of a file in Git
POINTER = len(_POINTER)  # bytes by which such a file is known
_register: set[tuple[int, int]] = set()  # device and inode of what this process is writing
_registering = RLock()  # a file may be closed by the garbage collector


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
        OSError: It cannot be read, is larger, is no regular file, or is a pointer of Git LFS.
    """
    with open_regular(path) if regular else path.open("rb") as file:
        return read_rest(file, most)


def read_rest(file: BufferedReader, most: int) -> bytes:
    """Return the rest of an open file, from its current position.

    Args:
        most: Its largest size [bytes].

    Raises:
        OSError: It cannot be read, is larger, or is a pointer of Git LFS.
    """
    found = os.fstat(file.fileno())
    is_larger = found.st_size > most
    # Python makes room for all that is requested; only what may never end needs a limit.
    asked = -1 if stat.S_ISREG(found.st_mode) else most + 1
    data = b"" if is_larger else file.read(asked)
    if is_larger or len(data) > most:
        raise OSError(errno.EFBIG, f"it is larger than {most >> 20} MiB", str(file.name))
    if reason := not_fetched(data):
        raise OSError(errno.ENODATA, reason, str(file.name))
    return data


def not_fetched(data: bytes) -> str:
    """Return why the beginning of a file is not that of the file itself, or an empty string.

    Args:
        data: ``POINTER`` bytes or more.
    """
    if not data.startswith(_POINTER):
        return ""
    return "it is a pointer of Git LFS; to fetch the file itself: git lfs pull"


def leads_out(path: Path, folders: Sequence[Path]) -> bool:
    """Return whether a file lies in none of the folders once all links are followed."""
    place = path.resolve()
    return not any(place.is_relative_to(folder.resolve()) for folder in folders)


def _without_waiting(path: str, flags: int) -> int:
    """Open a file; a pipe without waiting for its writer."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def final_place(path: Path) -> Path:
    """Return the path of what is written for a name: of the file that a link leads to."""
    return Path(os.path.realpath(path)) if path.is_symlink() else path


@contextmanager
def replacing(path: Path, *, private: bool = False) -> Generator[Path]:
    """Yield an empty file beside a file, and put what was written to it in its place.

    Readers of the former file never see half of one; if writing fails, it stays. The new file
    has the permissions of the former. Where the name is that of a pipe or a device, it is
    yielded itself.

    Args:
        path: The file.
        private: Whether only this user may read and write the new file, whatever was there.

    Raises:
        PermissionError: The former file is not to be written to.
        OSError: The folder cannot be written to.
    """
    target, former = (path if private else final_place(path)), None
    with suppress(FileNotFoundError):
        former = None if private else target.stat()
    if former is not None:
        if not (stat.S_ISREG(former.st_mode) or target.is_dir()):
            yield path
            return
        if not os.access(target, os.W_OK):
            raise PermissionError(errno.EACCES, "Permission denied", str(path))
    mode = 0o600 if private else 0o666
    # Of a random name, and never one that is there: others may write to the folder, too.
    beside = target.with_name(f".tissuec-{os.urandom(8).hex()}{target.suffix}")
    try:
        os.close(os.open(beside, os.O_WRONLY | os.O_CREAT | os.O_EXCL | _FLAGS, mode))
        yield beside
        if former is not None:
            beside.chmod(stat.S_IMODE(former.st_mode))
        os.replace(beside, target)
    except BaseException as error:
        with suppress(OSError):
            beside.unlink(missing_ok=True)
        own = None, beside, str(beside)
        if isinstance(error, OSError) and error.errno and error.filename in own:
            error.filename, error.filename2 = str(path), None  # which the user knows
        raise


def write_file(path: Path, content: str | bytes) -> None:
    """Put a text, as UTF-8 with the ends of lines that it has, or bytes in place of a file.

    Raises:
        OSError: It cannot be written; what was there stays.
    """
    data = content.encode() if isinstance(content, str) else content
    with replacing(path) as beside:
        beside.write_bytes(data)


class OutputFile(FileIO):
    """A file open for reading and writing, which nobody else writes until it is closed.

    Others are threads of this process as well as other processes.

    Args:
        path: The file; the last part of the path must not be a link.
        mode: "create" empties a file that is there, "update" needs one, and "append" writes
            behind its end.

    Raises:
        BlockingIOError: Somebody else is writing it.
        OSError: It cannot be opened, or is a link.
    """

    def __init__(self, path: Path, mode: Literal["create", "update", "append"]):
        self._key: tuple[int, int] | None = None
        self._path = path
        create = 0 if mode == "update" else os.O_CREAT
        while True:
            super().__init__(
                path,
                "a+" if mode == "append" else "r+",
                opener=lambda name, flags: _opened(name, flags | create),
            )
            try:
                self._take()
                if os.path.samestat(os.fstat(self.fileno()), path.stat()):
                    break
            except FileNotFoundError:
                pass  # it was removed or renamed before it was locked
            except BaseException:
                self.close()
                raise
            self.close()
        # Emptied only now: somebody else may have been writing it.
        if mode == "create":
            self.truncate(0)
        self.seek(0)

    def _take(self) -> None:
        """Enter the file in the register of this process, and lock it against others."""
        status = os.fstat(self.fileno())
        key = status.st_dev, status.st_ino
        with _registering:
            if key in _register:
                raise BlockingIOError(errno.EAGAIN, "it is being written already")
            _register.add(key)
        self._key = key
        _lock(self)

    def close(self) -> None:
        """Close the file, so that others may write it."""
        super().close()
        key, self._key = self._key, None
        if key is not None:
            with _registering:
                _register.discard(key)

    def release(self) -> None:
        """Close the file, and remove it if it is empty."""
        if self.closed:
            return
        if self.seek(0, os.SEEK_END):
            self.close()
        else:
            self.close_as(None)

    def replaced(self, content: bytes) -> "OutputFile":
        """Replace the file at once by one with other content, which is returned, open.

        Raises:
            OSError: It cannot be written; what was there stays.
        """
        new: OutputFile | None = None
        with replacing(self._path) as beside:
            beside.write_bytes(content)
            if REPLACES_OPEN:  # so that there is no moment in which nobody has the file
                new = OutputFile(beside, "append")
                new._path = self._path
            else:
                self.close()
        self.close()
        return new or OutputFile(self._path, "append")

    def close_as(self, path: Path | None) -> None:
        """Close the file under another name, or remove it.

        A file that somebody else has removed or replaced meanwhile is written again.

        Args:
            path: The other name, whose former file is replaced; None for none.

        Raises:
            OSError: That is not possible; the file is closed and keeps its name.
        """
        try:
            if REPLACES_OPEN and not self._is_there():
                self._copy_to(path)
            elif REPLACES_OPEN:  # before somebody else may write it
                _rename(self._path, path)
        finally:
            self.close()
        if not REPLACES_OPEN:
            _rename(self._path, path)

    def _is_there(self) -> bool:
        """Return whether the path still leads to this file."""
        with suppress(FileNotFoundError):
            return os.path.samestat(os.fstat(self.fileno()), self._path.stat())
        return False

    def _copy_to(self, path: Path | None) -> None:
        """Write the content to another file, which is replaced; none if there is no path."""
        if path is None:
            return
        with replacing(path) as beside, beside.open("wb") as copy:
            self.seek(0)
            while piece := self.read(_PIECE):
                copy.write(piece)


def _opened(path: str, flags: int) -> int:
    """Open a file that must not be a link."""
    try:
        return os.open(path, flags | _NO_LINK, 0o666)
    except OSError as error:
        if error.errno == errno.ELOOP:
            raise OSError(errno.ELOOP, "it is a link; remove it", path) from None
        raise


def _rename(path: Path, other: Path | None) -> None:
    if other is None:
        path.unlink(missing_ok=True)
    else:
        os.replace(path, other)


def _lock(file: FileIO) -> None:
    """Keep other processes from writing a file; does nothing where there are no locks.

    Raises:
        BlockingIOError: Another process is writing it.
    """
    if fcntl is None:
        return
    try:
        if hasattr(fcntl, "F_OFD_SETLK"):  # which no other file of this process lets go
            wanted = _FLOCK.pack(fcntl.F_WRLCK, os.SEEK_SET, _LOCKED_BYTE, 1, 0)
            fcntl.fcntl(file, fcntl.F_OFD_SETLK, wanted)
        else:
            fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, _LOCKED_BYTE)
    except OSError as error:
        if error.errno in (errno.EAGAIN, errno.EACCES):
            raise BlockingIOError(errno.EAGAIN, "another process is writing it") from None
