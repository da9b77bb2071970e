"""The datasets and groups of a result file: their declarations, and their checksums.

The table is written with each commit. Numbers of frames have no checksum here, because they are
read in parts: HDF5 keeps one of each of their chunks.
"""

import json
import zlib
from collections.abc import Iterator, Mapping
from math import prod
from typing import Any, Literal, NamedTuple, Self

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.structs import replace

TEXT = "text"
FLOAT = "float"  # f8, or f4 where a scene asks for single precision
CHUNK = 256  # rows that are allocated at once
FEW = 32  # the same where most files have few rows


class DatasetSpec(Struct, frozen=True):
    """A dataset, or all that differ in names only.

    Path, text and unit have places for these names, such as ``{name}``.

    Attributes:
        axes: What is counted along each axis, or the fixed length of one; one value or text
            has none.
        text: What it contains.
        unit: In SI; "" without one.
        kind: Of its entries, as NumPy names it, `TEXT` or `FLOAT`.
        chunk: Rows that are allocated at once where rows come during a run; 0 where all is
            written at once.
        in_parts: Whether it is read in parts: then HDF5 keeps a checksum of each chunk.
        packed: What is compressed: nothing, that of "large" nets, or "most", which is all but
            the smallest.
        path: In the file.
    """

    axes: tuple[str | int, ...]
    text: str
    unit: str = ""
    kind: str = "f8"
    chunk: int = 0
    in_parts: bool = False
    packed: Literal["", "large", "most"] = ""
    path: str = ""

    @property
    def row(self) -> tuple[int, ...]:
        """Return the shape of a row."""
        return tuple(axis for axis in self.axes[1:] if isinstance(axis, int))

    @property
    def row_bytes(self) -> int:
        """Return the size of a row [bytes]."""
        return prod(self.row) * np.dtype(self.kind).itemsize

    def of(
        self,
        *,
        row: tuple[int, ...] | None = None,
        kind: str = "",
        chunk: int = 0,
        **names: str,
    ) -> Self:
        """Return the dataset with names in their places; places without a name remain.

        Args:
            row: Another shape of a row.
            kind: Another type of its entries.
            chunk: Another number of rows that are allocated at once.
            **names: What takes the places in path, text and unit.
        """
        texts = self.path, self.text, self.unit
        if names:  # otherwise they may already hold names with braces
            texts = tuple(one.format_map(_Names(names)) for one in texts)
        path, text, unit = texts
        return replace(
            self,
            path=path,
            text=text,
            unit=unit,
            axes=self.axes if row is None else (*self.axes[:1], *row),
            kind=kind or self.kind,
            chunk=chunk or self.chunk,
        )


class _Names(dict[str, str]):
    """Names by their places; a place without a name remains."""

    def __missing__(self, place: str) -> str:
        return f"{{{place}}}"


class GroupSpec(Mapping[str, DatasetSpec]):
    """The datasets of a group by name.

    Attributes:
        path: Of the group.
        about: What it contains.
        when: Which files have it; "" if all have.

    Args:
        datasets: By name, or by path from the group; "" is the group itself, as one dataset.
        chunk, packed: Of all datasets that do not say their own.
    """

    def __init__(
        self,
        path: str,
        about: str,
        datasets: Mapping[str, DatasetSpec],
        *,
        when: str = "",
        chunk: int = 0,
        packed: Literal["", "large", "most"] = "",
    ):
        self.path, self.about, self.when = path, about, when
        self._datasets = {
            name: replace(
                one,
                path=f"{path}/{name}".rstrip("/"),
                chunk=one.chunk or chunk,
                packed=one.packed or packed,
            )
            for name, one in datasets.items()
        }

    def __getitem__(self, name: str) -> DatasetSpec:
        return self._datasets[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._datasets)

    def __len__(self) -> int:
        return len(self._datasets)

    def of(self, **changes: Any) -> dict[str, DatasetSpec]:
        """Return all datasets with names in their places; see `DatasetSpec.of`."""
        return {name: one.of(**changes) for name, one in self.items()}


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
