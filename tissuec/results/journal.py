"""A file with atomic commits, which survive a kill of the writer at any moment.

HDF5 rewrites blocks in place, in any order, so a process that dies between two of
those writes leaves a file that may not open. Here every write stays in memory until `commit`:

1. new bytes are written behind the old end of the file, where nothing refers to them yet;
2. changed pages are written behind those, followed by a trailer with a checksum (the journal);
3. the changed pages are written to their places;
4. the file is cut to its new length, which removes the journal.

Each step waits until the one before it is on the disk, so that this order holds for a machine
that loses its power, too. A file that dies before the end of step 2 holds the old state, and
later the new one: opening it here applies the journal. Readers that know nothing of journals
see a whole file except during step 3. No step but the first two needs space, so a full disk
costs no more than the state that was about to be written.
"""

import io
import os
import struct
import zlib
from collections.abc import Iterator
from contextlib import suppress
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from tissuec.core.files import OutputFile

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer, WriteableBuffer

PAGE = 4096
TOGETHER = 256  # pages that are written at once
MAGIC = b"tisjrnl1"
_RUN = struct.Struct("<QQ")  # offset, length
_TRAILER = struct.Struct("<8sQQI")  # magic, size of the new state, length of the runs, checksum

#: A place in the file, and the pages that stand there one after another.
Run = tuple[int, list[bytearray]]


class JournaledFile(io.RawIOBase):
    """A binary file whose writes become visible all at once.

    Attributes:
        recovered: Whether the last commit was cut short, and its journal was taken over.
        failure: Why the file cannot be read any more, which no commit survives.

    Args:
        path: The file.
        mode: "create" empties an existing file; "update" and "read" take over a journal.

    Raises:
        OSError: The file cannot be opened.
        BlockingIOError: Somebody else is writing it.
    """

    def __init__(self, path: Path, mode: Literal["create", "update", "read"]):
        super().__init__()
        self._raw = io.FileIO(path, "r") if mode == "read" else OutputFile(path, mode)
        self._pages: dict[int, bytearray] = {}
        self._tail = bytearray()
        self._position = 0
        self.failure: OSError | None = None
        self._is_read = mode == "read"
        self._kept = self._size = self._raw.seek(0, os.SEEK_END)
        self.recovered = self._load_journal()
        if self.failure is not None:
            self._raw.close()
            raise self.failure

    def readable(self) -> bool:
        """Return True."""
        return True

    def writable(self) -> bool:
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
        base = {os.SEEK_SET: 0, os.SEEK_CUR: self._position, os.SEEK_END: self._size}[whence]
        self._position = base + offset
        return self._position

    def readinto(self, buffer: "WriteableBuffer") -> int:
        """Fill ``buffer`` from the present position; return how many bytes there were."""
        view = memoryview(buffer).cast("B")
        start = self._position
        stop = self._position = max(start, min(start + len(view), self._size))
        split = max(start, min(stop, self._kept))
        self._read_kept(start, view[: split - start])
        view[split - start : stop - start] = self._tail[split - self._kept : stop - self._kept]
        return stop - start

    def write(self, data: "ReadableBuffer") -> int:
        """Change bytes from the present position on, in memory."""
        view = memoryview(data).cast("B")
        start, stop = self._position, self._position + len(view)
        if start > self._size:
            self.truncate(start)
        split = max(start, min(stop, self._kept))
        self._write_kept(start, view[: split - start])
        if split < stop:
            self._tail[split - self._kept : stop - self._kept] = view[split - start :]
        self._position, self._size = stop, max(stop, self._size)
        return len(view)

    def truncate(self, size: int | None = None) -> int:
        """Make the next state ``size`` bytes long, filled with zeros where it grows."""
        former, self._size = self._size, self._position if size is None else size
        if former < self._kept < self._size or former < self._size <= self._kept:
            # What was cut away does not reappear: it remains in the file until the commit.
            self._write_kept(former, memoryview(bytes(min(self._size, self._kept) - former)))
        tail = max(0, self._size - self._kept)
        del self._tail[tail:]
        self._tail.extend(bytes(tail - len(self._tail)))
        return self._size

    @property
    def pending(self) -> int:
        """Return how many bytes the next `commit` writes at most."""
        return len(self._tail) + 2 * sum(map(len, self._pages.values()))

    def commit(self) -> None:
        """Make the present state the one that the file holds.

        Raises:
            OSError: It could not be written, such as on a full disk; the file holds the
                former state, and another `commit` tries again. Or what it held could not be
                read, or another program has cut it.
        """
        if self.failure is None and os.fstat(self._raw.fileno()).st_size < self._kept:
            self.failure = OSError("another program has cut it")
        if self.failure is not None:
            raise self.failure
        if not self.pending and self._size == self._kept:
            return
        runs = self._runs()
        try:
            end = max(self._put_tail(), self._kept)
            self._sync()
            if runs:
                for part in _journal(runs, self._size):
                    end = self._put(end, part)
                self._sync()
        except OSError:
            with suppress(OSError):
                self._raw.truncate(self._kept)
            raise
        for offset, pages in runs:
            place = offset
            for part in _joined(pages):
                place = self._put(place, part)
        if runs:
            self._sync()
        self._raw.truncate(self._size)
        self._kept, self._pages, self._tail = self._size, {}, bytearray()

    def _sync(self) -> None:
        """Wait until what was written is on the disk, not only in the system's memory."""
        os.fsync(self._raw.fileno())

    def close(self) -> None:
        """Close the file; uncommitted changes are discarded."""
        self._raw.close()
        super().close()

    def close_as(self, path: Path | None) -> None:
        """Close the file under another name, or remove it; see ``OutputFile``."""
        assert isinstance(self._raw, OutputFile)
        try:
            self._raw.close_as(path)
        finally:
            self.close()

    def _read_kept(self, start: int, view: memoryview) -> None:
        """Read from the disk; a writer gets zeros where that fails, and hears it at a commit.

        HDF5 does not survive errors of a file that it writes: objects that are freed later
        refer to what it has given up, and Python ends with a segmentation fault.
        """
        filled = 0
        try:
            self._raw.seek(start)
            while filled < len(view):
                count = self._raw.readinto(view[filled:])
                if not count:
                    end = start + len(view)
                    raise OSError(f"it ends before byte {end}: another program has cut it")
                filled += count
        except OSError as error:
            if self._is_read:
                raise
            self.failure = self.failure or error
            view[filled:] = bytes(len(view) - filled)
        if not self._pages:
            return
        for number in range(start // PAGE, -(-(start + len(view)) // PAGE)):
            page = self._pages.get(number)
            if page is not None:
                low = max(start, number * PAGE)
                high = min(start + len(view), number * PAGE + len(page))
                view[low - start : high - start] = page[
                    low - number * PAGE : high - number * PAGE
                ]

    def _write_kept(self, start: int, view: memoryview) -> None:
        done = 0
        while done < len(view):
            number, within = divmod(start + done, PAGE)
            page = self._page(number)
            count = min(len(page) - within, len(view) - done)
            page[within : within + count] = view[done : done + count]
            done += count

    def _page(self, number: int) -> bytearray:
        page = self._pages.get(number)
        if page is None:
            page = bytearray(min(PAGE, self._kept - number * PAGE))
            self._read_kept(number * PAGE, memoryview(page))
            self._pages[number] = page
        return page

    def _runs(self) -> list[Run]:
        """Return the changed stretches of the kept part, neighbours joined, in file order."""
        runs: list[Run] = []
        former = -2
        for number in sorted(self._pages):
            if number != former + 1:
                runs.append((number * PAGE, []))
            runs[-1][1].append(self._pages[number])
            former = number
        return runs

    def _put(self, offset: int, data: bytes | bytearray) -> int:
        """Write all of ``data`` at ``offset``; return where it ends."""
        self._raw.seek(offset)
        with memoryview(data) as view:
            done = 0
            while done < len(view):
                done += self._raw.write(view[done:])
        return offset + len(data)

    def _put_tail(self) -> int:
        """Write what comes behind the old end; return where it ends.

        The first page of a new file comes last: until then it begins with zeros.
        """
        if self._kept:
            return self._put(self._kept, self._tail)
        end = self._put(min(PAGE, len(self._tail)), self._tail[PAGE:])
        self._sync()
        self._put(0, self._tail[:PAGE])
        return end

    def _load_journal(self) -> bool:
        """Take over the state of a commit that was cut short; return whether there was one."""
        end = self._kept - _TRAILER.size
        if end < 0:
            return False
        trailer = bytearray(_TRAILER.size)
        self._read_kept(end, memoryview(trailer))
        magic, size, length, checksum = _TRAILER.unpack(trailer)
        if magic != MAGIC or length > end:
            return False
        runs = bytearray(length)
        self._read_kept(end - length, memoryview(runs))
        if zlib.crc32(runs, size & 0xFFFFFFFF) != checksum:
            return False
        start = 0
        while start < length:
            offset, count = _RUN.unpack_from(runs, start)
            start += _RUN.size
            self._write_kept(offset, memoryview(runs)[start : start + count])
            start += count
        self._size = size
        return True


def has_journal(path: Path) -> bool:
    """Return whether the last commit to the file was cut short; OSError if it is unreadable."""
    with JournaledFile(path, "read") as file:
        return file.recovered


def _journal(runs: list[Run], size: int) -> Iterator[bytes]:
    """Yield the parts of a journal."""
    checksum, length = size & 0xFFFFFFFF, 0
    for offset, pages in runs:
        header = _RUN.pack(offset, sum(map(len, pages)))
        for part in chain([header], _joined(pages)):
            checksum, length = zlib.crc32(part, checksum), length + len(part)
            yield part
    yield _TRAILER.pack(MAGIC, size, length, checksum)


def _joined(pages: list[bytearray]) -> Iterator[bytes]:
    """Yield pages joined, not so many at once that they take much memory."""
    for first in range(0, len(pages), TOGETHER):
        yield b"".join(pages[first : first + TOGETHER])
