"""Records as compiled code reads them.

A record is one table of words in memory: the address and the shape of each of its arrays, its
numbers, and the tables of the records within it. Compiled code gets its address, and reads what
it needs. So no function depends on what a scene has besides what the function asks for.
"""

import struct
from functools import cache
from typing import Annotated, Any, NamedTuple, TypeAlias, get_args, get_origin, get_type_hints

import numpy as np

Record: TypeAlias = type[Any]  # a class of ``kernels.records``


class Field(NamedTuple):
    """Where a field of a record is, in words from its start, and what it is."""

    place: int
    kind: Record  # float, int, bool, np.ndarray, or a record
    dtype: "np.dtype[Any] | None" = None  # of the numbers of an array
    axes: int = 0


@cache
def layout(record: Record) -> tuple[dict[str, Field], int]:
    """Return the fields of a record and its number of words."""
    fields: dict[str, Field] = {}
    place = 0
    for name, annotation in get_type_hints(record, include_extras=True).items():
        fields[name] = _field(place, annotation)
        place += _size(fields[name])
    return fields, place


def _field(place: int, annotation: Any) -> Field:
    axes = 1
    if get_origin(annotation) is Annotated:
        annotation, axes = get_args(annotation)
    if get_origin(annotation) is np.ndarray:
        dtype = np.dtype(get_args(get_args(annotation)[1])[0])
        return Field(place, np.ndarray, dtype, axes)
    return Field(place, annotation)


def _size(field: Field) -> int:
    """Return the words of a field."""
    if field.kind is np.ndarray:
        return 1 + field.axes
    return 1 if field.kind in (float, int, bool) else layout(field.kind)[1]


class Table:
    """A record in memory.

    Args:
        record: It is kept, and with it the memory of its arrays. None within it is all zeros,
            which nothing may read.

    Raises:
        TypeError: An array is not what its record says, or not contiguous.
    """

    def __init__(self, record: Any):
        self.record = record
        self.words = np.array(_words(type(record), record), dtype=np.int64)
        self.address = self.words.ctypes.data


def _words(record: Record, values: Any) -> list[int]:
    """Return the table of a record."""
    fields, size = layout(record)
    if values is None:
        return [0] * size
    words: list[int] = []
    for (name, field), value in zip(fields.items(), values, strict=True):
        if field.kind is np.ndarray:
            is_right = value.dtype == field.dtype and value.ndim == field.axes
            if not (is_right and value.flags.c_contiguous):
                shape = f"{field.axes} axes of {field.dtype}"
                raise TypeError(f"{record.__name__}.{name} is no contiguous array with {shape}")
            words.append(value.__array_interface__["data"][0])
            words += value.shape
        elif field.kind is float:
            words += struct.unpack("q", struct.pack("d", value))
        elif field.kind in (int, bool):
            words.append(int(value))
        else:
            words += _words(field.kind, value)
    return words
