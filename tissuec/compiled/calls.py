"""Compiled functions, called from Python by their addresses.

Compiled code takes an array as a structure by value. LLVM passes the parts of one as arguments
by themselves, one after the other, whatever C does with structures on a system: the owner of
the memory and the object of Python, both none here, the number of numbers and the size of one,
where they are, the shape, and the strides.
"""

import ctypes
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cache, cached_property
from inspect import signature as parameters
from typing import Any

import numpy as np

from tissuec.compiled.bundles import BUNDLES, of_field
from tissuec.compiled.loading import address, is_shipped
from tissuec.compiled.record_tables import RecordField, RecordTable, place_of, signature
from tissuec.kernels import stages, vectors
from tissuec.kernels.records import Net

_RESULTS = {None: None, float: ctypes.c_double, bool: ctypes.c_uint8}


class Shipped:
    """A function of a bundle.

    ``compiled.binding`` leaves it unchanged, because it is not a Python function. Records are
    passed as they are or as ``RecordTable``. Other threads run during a call.

    Args:
        made_from: What it was translated from.
        bundle: Where it is.

    Raises:
        TypeError: An array is not what the function takes, or not contiguous.
    """

    def __init__(self, made_from: Callable[..., Any], bundle: str):
        self.__name__, self._bundle = made_from.__name__, bundle
        self._fields, self._result = signature(made_from)

    def __call__(self, *values: Any) -> Any:
        words, _kept = self._words(self._fields.values(), values)
        result = self._function(values)(*words)
        # Of the byte, one bit is the answer, and the others may be anything.
        return bool(result & 1) if self._result is bool else result

    def of_first(self, *values: Any) -> Callable[..., Any]:
        """Return the function of its first arguments, which are numbers, given all others.

        That spares looking where arrays are each time, which may take longer than the function.
        """
        fields = list(self._fields.values())[-len(values) :]
        words, kept = self._words(fields, values)
        function = self._function(values)

        def call(*first: float, _kept: object = (values, kept)) -> Any:
            return function(*first, *words)

        return call

    def _words(
        self, fields: Iterable[RecordField], values: Sequence[Any]
    ) -> tuple[list[float], list[RecordTable]]:
        """Return the arguments of the function in C, and objects to keep until it returns."""
        tables: list[RecordTable] = []
        words: list[float] = []
        for field, value in zip(fields, values, strict=True):
            if field.kind in (float, int):
                words.append(value)
            elif field.dtype is not None:
                place = place_of(value, field)
                words += (0, 0, value.size, value.itemsize, place, *value.shape, *value.strides)
            else:
                tables.append(value if isinstance(value, RecordTable) else RecordTable(value))
                words.append(tables[-1].address)
        return words, tables

    def _function(self, values: Sequence[Any]) -> Callable[..., Any]:
        """Return the function for C, given its arguments."""
        return self._shipped

    @cached_property
    def _shipped(self) -> Callable[..., Any]:
        return self._kind(address(self._bundle, self.__name__))

    @cached_property
    def _kind(self) -> Any:
        kinds = [kind for field in self._fields.values() for kind in _kinds(field)]
        return ctypes.CFUNCTYPE(_RESULTS[self._result], *kinds)


def first_of(function: Callable[..., Any], *values: Any) -> Callable[..., Any]:
    """Return a function of its first arguments, which are numbers, given all others.

    It may be a ``Shipped`` one, see ``Shipped.of_first``, or one in Python.
    """
    if isinstance(function, Shipped):
        return function.of_first(*values)
    return lambda *first: function(*first, *values)


class NetOperation(Shipped):
    """An operation on nets, whose address the net has."""

    def __init__(self, made_from: Callable[..., Any]):
        super().__init__(made_from, "")
        self._net = [field.kind for field in self._fields.values()].index(Net)
        self._found: dict[int, Callable[..., Any]] = {}

    def _function(self, values: Sequence[Any]) -> Callable[..., Any]:
        """Return the function at the address that the net has; raises TypeError without one."""
        place = getattr(values[self._net].operations, self.__name__)
        if not place:
            raise TypeError(f"the net has nothing that {self.__name__} is needed for")
        if place not in self._found:
            self._found[place] = self._kind(place)
        return self._found[place]

    def by(self, function: Callable[..., Any], *records: Any) -> "InPython":
        """Return a Python function with the same arguments, for compiled code to call.

        Args:
            records: The net and the other records that it takes.
        """
        return InPython(function, tuple(self._fields.values()), records, self._result)


def _is_record(field: RecordField) -> bool:
    return field.kind not in (float, int, np.ndarray)


def _kinds(field: RecordField) -> list[Any]:
    """Return the types of the words of an argument."""
    pointer, size = ctypes.c_void_p, ctypes.c_ssize_t
    if field.kind is np.ndarray:
        return [pointer, pointer, size, size, pointer] + 2 * field.axes * [size]
    return [{float: ctypes.c_double, int: ctypes.c_int64}.get(field.kind, pointer)]


#: What loops over steps do with vectors, where they run as Python.
VECTORS = {
    name: Shipped(getattr(module, name), bundle)
    for bundle, module in (("stages", stages), ("vectors", vectors))
    for name in BUNDLES[bundle]
}


# --- kernels of fields -----------------------------------------------------------------------

_NUMBER = RecordField(0, float)
_VECTOR = RecordField(0, np.ndarray, np.dtype(float), 1)


@cache
def _of_fields(vectors: int) -> Any:
    """Return the type of a loop of a field, which takes time, some vectors and a table."""
    return ctypes.CFUNCTYPE(
        None, ctypes.c_double, *(vectors * _kinds(_VECTOR)), ctypes.c_void_p
    )


class InPython:
    """A function that is not shipped, such as a loop of a field, which compiled code calls.

    It is slow, but needs no compiler. An error in it cannot pass through compiled code: from
    then on, all arrays but positions and velocities, which come first, are filled with NaN, and
    ``failure`` is the exception.

    Args:
        made_from: The function; see ``tissuec.forces.Field.kernel``.
        fields: Its arguments: numbers, arrays of them, and records.
        records: The records that it takes, one of each type.
        result: Type of what it returns.

    Attributes:
        address: Its address in memory.

    Raises:
        TypeError: It takes a record that is not given.
    """

    def __init__(
        self,
        made_from: Callable[..., Any],
        fields: Sequence[RecordField],
        records: Sequence[Any],
        result: type | None = None,
    ):
        self._records: dict[type, Any] = {type(record): record for record in records}
        if any(_is_record(one) and one.kind not in self._records for one in fields):
            raise TypeError(f"{made_from.__name__} takes more records")
        self._made_from, self._fields = made_from, fields
        self.failure: BaseException | None = None
        kinds = [kind for field in fields for kind in _kinds(field)]
        self._called = ctypes.CFUNCTYPE(_RESULTS[result], *kinds)(self._call)
        self.address = ctypes.cast(self._called, ctypes.c_void_p).value or 0

    def _call(self, *words: Any) -> Any:
        values = list(self._values(words))
        if self.failure is None:
            try:
                return self._made_from(*values)
            except BaseException as error:  # an interrupt is not to be lost either
                self.failure = error
        arrays = [v for v, one in zip(values, self._fields, strict=True) if one.dtype]
        for array in arrays[2:]:
            array[:] = np.nan
        return False

    def _values(self, words: Sequence[Any]) -> Iterator[Any]:
        """Yield the arguments; arrays are views."""
        place = 0
        for field in self._fields:
            own = words[place : place + len(_kinds(field))]
            place += len(own)
            if field.dtype is not None:
                count, start, shape = own[2], own[4], own[5 : 5 + field.axes]
                memory = (ctypes.c_char * (count * field.dtype.itemsize)).from_address(start)
                yield np.frombuffer(memory, field.dtype).reshape(shape)
            else:
                yield self._records[field.kind] if _is_record(field) else own[0]


def kernel_address(kernel: Callable[..., None], table: RecordTable) -> int:
    """Return where a loop of a field is: compiled, or as Python if it is not shipped.

    Args:
        table: What it will be given; it keeps what has to be kept.
    """
    if made := getattr(kernel, "address", None):  # see ``compiled.generated``
        return made
    bundle = of_field(kernel)
    if kernel.__module__.startswith("tissuec.forces.") and is_shipped(bundle):
        return address(bundle, kernel.__name__)
    vectors = len(parameters(kernel).parameters) - 2
    fields = (_NUMBER, *(vectors * (_VECTOR,)), RecordField(0, type(table.record)))
    called = InPython(kernel, fields, (table.record,))
    table.called = (*table.called, called)
    return called.address


def kernel_on(
    kernel: Callable[..., None], record: Any, vectors: int = 4
) -> Callable[..., None]:
    """Return the kernel of a field of all arguments but the last one, a record.

    Args:
        vectors: How many vectors it takes.
    """
    table = RecordTable(record)
    function = _of_fields(vectors)(kernel_address(kernel, table))
    kind = _VECTOR._replace(what=f"a vector of {kernel.__name__}")

    def call(time: float, *vectors: Any) -> None:
        words: list[int] = []
        for vector in vectors:
            place = place_of(vector, kind)
            words += (0, 0, vector.size, vector.itemsize, place, vector.size, vector.itemsize)
        function(time, *words, table.address)
        raise_failure(table)

    return call


def raise_failure(table: RecordTable) -> None:
    """Raise the error of a loop that was called back as Python, if there was one, once."""
    found = [called.failure for called in table.called if called.failure is not None]
    for called in table.called:
        called.failure = None
    if found:
        raise found[0]
