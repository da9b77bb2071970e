"""The first picture of a page, which is there before its script has run, and without it."""

import struct
from base64 import b64encode
from zlib import compress, crc32

import numpy as np
from numpy.typing import NDArray

from tissuec.view.player.film import PlayerData
from tissuec.view.player.node_values import FieldValues
from tissuec.view.player.options import Options
from tissuec.view.player.picture import Painter

LARGEST = 30_000  # bytes, 40 kB in a page
_SIZES = ((640, 400), (480, 300), (320, 200))  # [px]


def still(film: PlayerData, options: Options, field: FieldValues | None = None) -> str:
    """Return the initial moment of a film as the address of a picture that contains it.

    Args:
        film: What there is.
        options: Options of the player.
        field: What colours the skin; its tissues if None.
    """
    time = film.times[0] if options.time is None else options.time
    at = film.moment_at(time)
    data = b""
    for size in _SIZES:
        data = png(Painter(film, options, size, "", field=field).scene(at))
        if len(data) <= LARGEST:
            break
    return f"data:image/png;base64,{b64encode(data).decode()}"


def png(pixels: NDArray[np.uint8]) -> bytes:
    """Return a picture as a PNG file.

    Pages do not need the packages that plots need, Pillow among them. Each byte is stored as
    the difference to the pixel on its left, filter 1 of PNG (ISO/IEC 15948), which suits
    shaded surfaces.

    Args:
        pixels: Red, green, blue from the top left, shape (height, width, 3).
    """
    height, width, _ = pixels.shape
    change = pixels.copy()
    change[:, 1:] -= pixels[:, :-1]
    lines = np.ones((height, 1 + 3 * width), dtype=np.uint8)
    lines[:, 1:] = change.reshape(height, -1)
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    chunks = ((b"IHDR", head), (b"IDAT", compress(lines.tobytes(), 9)), (b"IEND", b""))
    parts = (
        struct.pack(">I", len(data)) + name + data + struct.pack(">I", crc32(name + data))
        for name, data in chunks
    )
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)
