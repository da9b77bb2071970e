"""Records in the form that compiled code reads.

A record is one table of words in memory: the address and the shape of each of its arrays, its
numbers, and the tables of the records within it. Compiled code gets its address, and reads what
it needs. So no function depends on what a scene has besides the inputs of the function.
"""

import struct
from array import array as plain_array
from collections.abc import Callable, Sequence
from ctypes import addressof, c_char
from functools import cache
from math import prod
from typing import (
    Annotated,
    Any,
    NamedTuple,
    TypeAlias,
    TypeVar,
    cast,
    get_args,
    get_origin,
)

import numpy as np
from msgspec import Struct
from msgspec.structs import astuple

from tissuec.kernels.records import Floats

Record: TypeAlias = type[Any]  # a class of ``kernels.records``
R = TypeVar("R")
_Nothing = c_char * 0  # where it is counts
LINE = 8  # numbers in a line of the cache


class RecordField(NamedTuple):
    """A field of a record: its offset in words, and its type."""

    place: int
    kind: Record  # float, int, bool, np.ndarray, or a record
    dtype: "np.dtype[Any] | None" = None  # of the numbers of an array
    axes: int = 0
    what: str = ""  # what it is called if it is wrong


@cache
def layout(record: Record) -> tuple[dict[str, RecordField], int]:
    """Return the fields of a record and its number of words."""
    fields: dict[str, RecordField] = {}
    place = 0
    for name, annotation in _annotations(record).items():
        fields[name] = _field(place, annotation, f"{record.__name__}.{name}")
        place += _size(fields[name])
    return fields, place


def _field(place: int, annotation: Any, what: str) -> RecordField:
    axes = 1
    if get_origin(annotation) is Annotated:
        annotation, axes = get_args(annotation)
    if get_origin(annotation) is np.ndarray:
        dtype = np.dtype(get_args(get_args(annotation)[1])[0])
        return RecordField(place, np.ndarray, dtype, axes, what)
    return RecordField(place, annotation)


def signature(function: Callable[..., Any]) -> tuple[dict[str, RecordField], type | None]:
    """Return the arguments of a function, each as a field, and its result."""
    hints = _annotations(function)
    result = hints.pop("return")
    fields = {
        name: _field(0, annotation, f"{name} of {function.__name__}")
        for name, annotation in hints.items()
    }
    return fields, result


def _annotations(of: Any) -> dict[str, Any]:
    """Return the annotations of a function or of a record without a base.

    ``typing.get_type_hints`` would also read names in quotes, of which there are none, and
    takes ten times as long.
    """
    return dict(of.__annotations__)


def place_of(array: Any, field: RecordField) -> int:
    """Return where the numbers of an array are in memory.

    Raises:
        TypeError: It is not what the field is to hold, or not contiguous.
    """
    flags = array.flags
    if not (array.dtype == field.dtype and array.ndim == field.axes and flags.c_contiguous):
        raise TypeError(
            f"{field.what} is no contiguous array with {field.axes} axes of {field.dtype}"
        )
    if flags.writeable:  # six times as fast
        return addressof(_Nothing.from_buffer(array))
    return int(array.__array_interface__["data"][0])


def aligned_zeros(*shape: int) -> Floats:
    """Return zeros that begin where a line of the cache of a processor does.

    What a vector instruction reads or stores across two lines takes twice as long.

    Returns:
        Zeros in any unit, of a shape.
    """
    size = prod(shape)
    room = np.zeros(size + LINE - 1)
    begin = -room.__array_interface__["data"][0] // room.itemsize % LINE
    return room[begin : begin + size].reshape(shape)


def _size(field: RecordField) -> int:
    """Return the words of a field."""
    if field.kind is np.ndarray:
        return 1 + field.axes
    if field.kind is object:
        return 0  # for Python only
    return 1 if field.kind in (float, int, bool) else layout(field.kind)[1]


class RecordTable:
    """A record in memory, whose fields are also those of this object.

    Args:
        record: It is kept, and with it the memory of its arrays. What is within it may be a
            table itself, which spares making one; None is all zeros, which nothing may read.

    Raises:
        TypeError: An array is not what its record says, or not contiguous.
    """

    def __init__(self, record: object):
        self.record = record
        self.called: tuple[Any, ...] = ()  # what is kept for it, too
        self.words = plain_array("q", _words(type(record), record))
        self.address = self.words.buffer_info()[0]

    def __getattr__(self, name: str) -> Any:
        return getattr(self.record, name)

    def read_back(self) -> None:
        """Set the numbers of the record, which has nothing else, to those of the table."""
        record = type(self.record)
        codec = _numbers(record)
        assert codec is not None
        for name, number in zip(layout(record)[0], codec.unpack(self.words), strict=True):
            setattr(self.record, name, number)


def tabulated(record: R) -> R:
    """Return a table of a record, which replaces it in other records and elsewhere."""
    return cast(R, RecordTable(record))


@cache
def _numbers(record: Record) -> struct.Struct | None:
    """Return a packer of the values of a record; None if it has anything but numbers."""
    kinds = [field.kind for field in layout(record)[0].values()]
    if not all(kind in (float, int, bool) for kind in kinds):
        return None
    return struct.Struct("".join("d" if kind is float else "q" for kind in kinds))


def _words(record: Record, values: Any) -> Sequence[int]:
    """Return the table of a record."""
    fields, size = layout(record)
    if values is None:
        return [0] * size
    if isinstance(values, Struct):
        values = astuple(values)
    if (codec := _numbers(record)) is not None:
        return plain_array("q", codec.pack(*values))
    words: list[int] = []
    for field, value in zip(fields.values(), values, strict=True):
        if field.dtype is not None:
            words.append(place_of(value, field))
            words += value.shape
        elif field.kind is float:
            words += struct.unpack("q", struct.pack("d", value))
        elif field.kind in (int, bool):
            words.append(int(value))
        elif isinstance(value, RecordTable):
            words += value.words
        elif field.kind is not object:
            words += _words(field.kind, value)
    return words
