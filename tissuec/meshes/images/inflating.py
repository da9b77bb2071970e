"""Decompression of files that may unfold into more than fits into memory."""

import zlib

from tissuec.meshes.formats import FormatError

GZIP = b"\x1f\x8b"  # how such files begin


def inflated(data: bytes, most: int) -> bytes:
    """Return the first bytes of what gzip compressed.

    Args:
        data: As gzip writes it.
        most: As many bytes are returned, or fewer if there are no more.

    Raises:
        FormatError: The data is not that of gzip, or is damaged or truncated.
    """
    found = bytearray()
    # Files may be joined, and what follows them may be of another kind.
    while len(found) < most and (data.startswith(GZIP) or not found):
        stream = zlib.decompressobj(zlib.MAX_WBITS | 16)
        try:
            found += stream.decompress(data, most - len(found))
        except zlib.error:
            raise FormatError(
                "its compressed data is damaged, or was not made by gzip"
            ) from None
        if not stream.eof and len(found) < most:
            raise FormatError("its compressed data is truncated")
        data = stream.unused_data
    return bytes(found)
