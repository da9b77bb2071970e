"""The table of datasets in a result file: kind, shape and checksum of each.

The table is written with each commit. Numbers of frames have no checksum here, because they are
read in parts: HDF5 keeps one of each of their chunks.
"""

import json
import zlib
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray


class DatasetSum(NamedTuple):
    """Kind, shape and checksum of a dataset.

    Attributes:
        kind: Of its numbers, as NumPy names it; "object" for texts of any length.
        shape: Its size.
        crc: The CRC-32 of its content; None where it is read in parts.
    """

    kind: str
    shape: tuple[int, ...]
    crc: int | None


def crc_of(data: NDArray[Any], former: int = 0) -> int:
    """Return the CRC-32 of numbers or texts of any shape and unit.

    Args:
        data: The numbers or texts.
        former: CRC-32 of what comes before them.
    """
    if data.dtype.kind not in "OSU":
        return zlib.crc32(np.ascontiguousarray(data).data, former)
    for text in data.reshape(-1).tolist():
        content = text.encode() if isinstance(text, str) else text
        former = zlib.crc32(content, zlib.crc32(len(content).to_bytes(8), former))
    return former


def sums_as_text(sums: Mapping[str, DatasetSum]) -> str:
    """Return the table as text that begins with its own CRC-32."""
    text = json.dumps(sums)
    return f"{zlib.crc32(text.encode()):08x} {text}"


def sums_of_text(text: str) -> dict[str, DatasetSum]:
    """Return the table of checksums.

    Raises:
        ValueError: The text does not have its own checksum.
    """
    crc, _, table = text.partition(" ")
    if f"{zlib.crc32(table.encode()):08x}" != crc:
        raise ValueError("the table of checksums has changed since it was written")
    return {
        path: DatasetSum(kind, tuple(shape), crc)
        for path, (kind, shape, crc) in json.loads(table).items()
    }
