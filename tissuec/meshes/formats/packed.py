"""Contents of files that are larger than the files: compressed, or repeated by reference.

A few kilobytes may stand for any number of gigabytes, so everything that unfolds does so within
the room of its file.
"""

import bz2
import lzma
import zlib
from collections.abc import Callable, Mapping
from typing import Any

from tissuec.meshes.formats import FormatError

LARGEST = 2 << 30  # bytes of the contents of a file, unfolded
GZIP = b"\x1f\x8b"  # how files that gzip compressed begin
_STEP = 1 << 14  # bytes that are unpacked at once: what follows a stream is copied each time
_DICTIONARY = 1 << 28  # bytes; the strongest usual setting of LZMA takes a quarter of it
_METHODS: Mapping[str, Callable[[], Any]] = {
    "gzip": lambda: zlib.decompressobj(zlib.MAX_WBITS | 16),
    "zlib": zlib.decompressobj,
    "bzip2": bz2.BZ2Decompressor,
    "LZMA": lambda: lzma.LZMADecompressor(memlimit=_DICTIONARY),
}


class Room:
    """How much the contents of one file may take in all.

    Args:
        size: [bytes].
    """

    def __init__(self, size: int = LARGEST):
        self._size = self._left = size

    def take(self, size: int, what: str = "contents") -> int:
        """Return the size of further contents, for which there is room.

        Args:
            size: [bytes].
            what: What they are, for the message.

        Raises:
            FormatError: They do not fit, or their size is negative.
        """
        if size < 0:
            raise FormatError(f"the size of its {what} is negative")
        self._left -= size
        if self._left < 0:
            raise FormatError(f"its {what} take more than {self._size >> 20} MiB")
        return size


def unpacked(data: bytes, method: str, most: int) -> bytes:
    """Return the first bytes of compressed data.

    Args:
        data: As the method writes it. Several streams may follow each other, and anything else
            may follow the last of them.
        method: "gzip", "zlib", "bzip2" or "LZMA".
        most: As many bytes are returned, or fewer if there are no more.

    Raises:
        FormatError: The data is not that of the method, or is damaged or truncated.
    """
    found, view, at = bytearray(), memoryview(data), 0
    stream = _METHODS[method]()
    while len(found) < most and at < len(view):
        if stream.eof:
            if view[at : at + 2] != view[:2]:
                break
            stream = _METHODS[method]()
        piece = view[at : at + _STEP]
        try:
            found += stream.decompress(piece, most - len(found))
        except (zlib.error, lzma.LZMAError, OSError, EOFError):
            raise FormatError(
                f"its compressed data is damaged, or was not made by {method}"
            ) from None
        at += len(piece) - len(stream.unused_data)
    if not stream.eof and len(found) < most:
        raise FormatError("its compressed data is truncated")
    return bytes(found)
