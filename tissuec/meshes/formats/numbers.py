"""A sequence of numbers in a file, as text or in binary."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tissuec.meshes.formats import Floats, FormatError, Indices

LARGEST = 2.0**53  # up to here floating-point numbers hold every whole number


class NumberStream:
    """Numbers that are taken one after the other.

    Args:
        data: The bytes of the numbers, and of whatever follows in a binary file.
        order: "<" or ">" for binary numbers with their lowest or highest byte first; "" for
            text.
    """

    def __init__(self, data: bytes, order: str = ""):
        self._data, self._order, self.used = data, order, 0
        self._values = np.zeros(0) if order else as_floats(data.split())

    @property
    def left(self) -> int:
        """Return how many numbers of a text are left."""
        return len(self._values) - self.used

    def take(self, count: int, kind: str) -> NDArray[Any]:
        """Return the next numbers in the units of the file, shape (count,).

        Args:
            count: How many.
            kind: Their type in binary, such as "i4".

        Raises:
            FormatError: There are not as many.
        """
        if self._order:
            size = count * np.dtype(kind).itemsize
            return np.frombuffer(self._bytes(size), self._order + kind)
        if count > self.left or count < 0:
            raise FormatError(f"it is truncated: {count - self.left} numbers are missing")
        self.used += count
        return self._values[self.used - count : self.used]

    def table(self, rows: int, columns: Sequence[tuple[str, int]]) -> list[NDArray[Any]]:
        """Return the next rows in the units of the file: shape (row, width) for each column.

        Args:
            rows: How many.
            columns: Of each column the type in binary, such as "i4", and the width.
        """
        if not self._order:
            widths = [width for _, width in columns]
            values = self.take(rows * sum(widths), "f8").reshape(rows, sum(widths))
            return np.split(values, np.cumsum(widths)[:-1], axis=1)
        fields = [
            (f"f{k}", self._order + kind, (width,)) for k, (kind, width) in enumerate(columns)
        ]
        record = np.dtype(fields)
        found = np.frombuffer(self._bytes(rows * record.itemsize), record)
        return [found[name] for name, *_ in fields]

    def _bytes(self, size: int) -> bytes:
        missing = size - (len(self._data) - self.used)
        if missing > 0 or size < 0:
            raise FormatError(f"it is truncated: {missing} bytes are missing")
        self.used += size
        return self._data[self.used - size : self.used]

    def whole(self, count: int, kind: str = "i4") -> Indices:
        """Return the next numbers, which must be whole numbers."""
        return as_whole(self.take(count, kind))

    def one(self, kind: str = "i4") -> int:
        """Return the next number, which must be a whole number."""
        return int(self.whole(1, kind)[0])


def as_floats(words: list[bytes] | list[str]) -> Floats:
    """Return words as numbers.

    Raises:
        FormatError: One of them is no number.
    """
    try:
        return np.array(words).astype(float) if words else np.zeros(0)
    except ValueError as error:
        raise FormatError(f"a number cannot be read: {error}") from None


def as_whole(values: NDArray[Any]) -> Indices:
    """Return dimensionless numbers of any type and shape as whole numbers.

    Raises:
        FormatError: One of them is none, or is too large to be a number of a node.
    """
    if values.dtype.kind in "iu" and values.dtype.itemsize < 8:
        return values.astype(np.int64)
    with np.errstate(invalid="ignore"):
        wrong = ~(np.abs(values.astype(float)) < LARGEST)
        wrong |= values != np.rint(values)
    if wrong.any():
        raise FormatError(f"{values[wrong][0]:g} is not the number of a node or cell")
    return values.astype(np.int64)
