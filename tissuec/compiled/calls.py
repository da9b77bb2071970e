"""Compiled operations on nets, called from Python by their addresses.

Compiled code takes an array as a structure by value. LLVM passes the parts of one as arguments
by themselves, one after the other, whatever C does with structures on a system: the owner of
the memory and the object of Python, both none here, the number of numbers and the size of one,
where they are, the shape, and the strides.
"""

import ctypes
from collections.abc import Callable
from typing import Any

import numpy as np

from tissuec.compiled.tables import Field, place_of, signature
from tissuec.kernels import banded, scalar
from tissuec.kernels.records import Net, Operations
from tissuec.laws import code

#: What compiled operations are made from, but for those of laws. Of some there are other forms.
FUNCTIONS: dict[str, Callable[..., Any]] = {
    name: getattr(banded if name in ("assemble", "solve") else scalar, name)
    for name in Operations._fields
    if name not in code.ARGUMENTS
}
_RESULTS = {None: None, float: ctypes.c_double, bool: ctypes.c_uint8}


class Operation:
    """An operation that takes a net as a ``RecordTable``, and finds its address there.

    It is no function, so that ``engine.binding`` leaves it as it is.

    Raises:
        TypeError: An array is not what the operation takes, or not contiguous.
    """

    def __init__(self, name: str):
        self.__name__ = name
        self._fields, result = signature(FUNCTIONS[name])
        self._tells = result is bool
        self._net = [field.kind for field in self._fields.values()].index(Net)
        kinds = [kind for field in self._fields.values() for kind in _kinds(field)]
        self._kind = ctypes.CFUNCTYPE(_RESULTS[result], *kinds)
        self._found: dict[int, Callable[..., Any]] = {}

    def __call__(self, *values: Any) -> Any:
        words: list[float] = []
        for (name, field), value in zip(self._fields.items(), values, strict=True):
            if field.kind is float:
                words.append(value)
            elif field.kind is not np.ndarray:
                words.append(value.address)
            else:
                place = place_of(value, field, f"{name} of {self.__name__}")
                words += (0, 0, value.size, value.itemsize, place, *value.shape, *value.strides)
        address = getattr(values[self._net].operations, self.__name__)
        result = (self._found.get(address) or self._at(address))(*words)
        # Of the byte, one bit is the answer, and the others may be anything.
        return bool(result & 1) if self._tells else result

    def _at(self, address: int) -> Callable[..., Any]:
        """Return the operation at an address, and keep it."""
        if not address:
            raise TypeError(f"the net has nothing that {self.__name__} is needed for")
        self._found[address] = self._kind(address)
        return self._found[address]


def _kinds(field: Field) -> list[Any]:
    """Return the types of the words of an argument."""
    address, size = ctypes.c_void_p, ctypes.c_ssize_t
    if field.kind is np.ndarray:
        return [address, address, size, size, address] + 2 * field.axes * [size]
    return [ctypes.c_double if field.kind is float else address]


OPERATIONS = {name: Operation(name) for name in FUNCTIONS}
