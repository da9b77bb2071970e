"""Files for reading of which any number can be kept, however few a program may have open.

Results of runs are kept by the hundreds, such as in a list. Those that were not read for the
longest time are closed, and opened again when they are read.
"""

import io
import os
import threading
from collections import OrderedDict
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from _typeshed import WriteableBuffer

MOST_OPEN = 32  # of the 256 files that macOS lets a program open by default

_lock = threading.RLock()
#: What is open, by the identity of its file; what was read last comes last.
_open: "OrderedDict[int, tuple[io.FileIO, Path]]" = OrderedDict()


class KeptFile(io.RawIOBase):
    """A binary file for reading that is open while it, or few others, are used.

    Args:
        path: The file.
        keeps: Kept as long as the file, such as a folder that is removed afterwards.

    Raises:
        OSError: The file cannot be opened.
    """

    def __init__(self, path: Path, keeps: object = None):
        super().__init__()
        self._path, self._keeps, self._position = path.absolute(), keeps, 0
        with _lock:
            self._raw = self._opened()
            self._state = os.fstat(self._raw.fileno())

    def _opened(self) -> io.FileIO:
        """Open the file, and close others; the lock is held."""
        for key in list(_open)[: max(0, len(_open) + 1 - MOST_OPEN)]:
            raw, path = _open[key]
            if _is_at(os.fstat(raw.fileno()), path):
                raw.close()
                del _open[key]
        raw = io.FileIO(self._path, "r")
        _open[id(self)] = raw, self._path
        return raw

    def close(self) -> None:
        """Close the file for good."""
        with _lock:
            if (found := _open.pop(id(self), None)) is not None:
                found[0].close()
        super().close()

    def readable(self) -> bool:
        """Return True."""
        return True

    def seekable(self) -> bool:
        """Return True."""
        return True

    def tell(self) -> int:
        """Return the present place in the file [bytes]."""
        return self._position

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Go to a place in the file and return it [bytes]."""
        size = self._state.st_size
        base = {os.SEEK_SET: 0, os.SEEK_CUR: self._position, os.SEEK_END: size}[whence]
        self._position = base + offset
        return self._position

    def readinto(self, buffer: "WriteableBuffer") -> int:
        """Fill ``buffer`` from the present position; return how many bytes there were.

        Raises:
            OSError: The file was closed meanwhile, and another one is in its place now.
        """
        view = memoryview(buffer).cast("B")
        with _lock:
            if self._raw.closed:
                if not _is_at(self._state, self._path):
                    raise OSError(f'"{self._path}" was removed or replaced')
                self._raw = self._opened()
            _open.move_to_end(id(self))
            if hasattr(os, "preadv"):  # forked processes share the place in the file
                count = os.preadv(self._raw.fileno(), [view], self._position)
            else:
                self._raw.seek(self._position)
                count = self._raw.readinto(view)
        self._position += count
        return count


def _is_at(state: os.stat_result, path: Path) -> bool:
    """Return whether a file is still the one at a path."""
    try:
        return os.path.samestat(state, path.stat())
    except OSError:
        return False
