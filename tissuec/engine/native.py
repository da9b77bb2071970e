"""Records as compiled code reads them, and compiled operations that are called by address.

A record is one table of words in memory: the address and the shape of each of its arrays, its
numbers, and the tables of the records within it. Compiled code passes its address, and reads
what it needs. So no function depends on what a scene has besides what the function asks for,
and each is compiled, and cached, by itself.
"""

import inspect
import struct
from collections.abc import Callable
from functools import cache
from typing import Annotated, Any, NamedTuple, cast, get_args, get_origin, get_type_hints

import numba
import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.core.imputils import lower_getattr_generic
from numba.core.typing.templates import AttributeTemplate, Signature, infer_getattr
from numba.extending import (
    NativeValue,
    intrinsic,
    models,
    register_model,
    typeof_impl,
    unbox,
)

from tissuec.kernels.records import Net, Operations, Solver

Record = type[Any]  # a class of ``kernels.records``
WORD = ir.IntType(64)


class Field(NamedTuple):
    """Where a field of a record is, in words from its start, and what it is."""

    place: int
    kind: types.Type
    dtype: np.dtype[Any] | None  # of the numbers of an array


class RecordType(types.Type):
    """The address of the table of a record."""

    def __init__(self, record: Record):
        self.record = record
        super().__init__(name=f"record({record.__module__}.{record.__name__})")


register_model(RecordType)(models.OpaqueModel)


@cache
def layout(record: Record) -> tuple[dict[str, Field], int]:
    """Return the fields of a record and its number of words."""
    fields: dict[str, Field] = {}
    place = 0
    for name, annotation in get_type_hints(record, include_extras=True).items():
        kind, dtype, size = _kind(annotation)
        fields[name] = Field(place, kind, dtype)
        place += size
    return fields, place


def _kind(annotation: Any) -> tuple[types.Type, "np.dtype[Any] | None", int]:
    """Return what Numba calls a type, of which numbers an array is, and its words."""
    axes = 1
    if get_origin(annotation) is Annotated:
        annotation, axes = get_args(annotation)
    if get_origin(annotation) is np.ndarray:
        dtype = np.dtype(get_args(get_args(annotation)[1])[0])
        return types.Array(numba.from_dtype(dtype), axes, "C"), dtype, 1 + axes
    scalars: dict[Any, types.Type] = {
        float: types.float64,
        int: types.int64,
        bool: types.boolean,
    }
    if annotation in scalars:
        return scalars[annotation], None, 1
    return RecordType(annotation), None, layout(annotation)[1]


class Native:
    """A record in memory.

    Args:
        record: It is kept, and with it the memory of its arrays. None within it is all zeros,
            which nothing may read.

    Raises:
        TypeError: An array is not what its record says, or not contiguous.
    """

    def __init__(self, record: Any):
        self.record = record
        self.table = np.array(_words(type(record), record), dtype=np.int64)
        self.address = self.table.ctypes.data


def _words(record: Record, values: Any) -> list[int]:
    """Return the table of a record."""
    fields, size = layout(record)
    if values is None:
        return [0] * size
    words: list[int] = []
    for (name, (_, kind, dtype)), value in zip(fields.items(), values, strict=True):
        if isinstance(kind, RecordType):
            words += _words(kind.record, value)
        elif dtype is not None:
            if value.dtype != dtype or value.ndim != kind.ndim or not value.flags.c_contiguous:
                raise TypeError(f"{record.__name__}.{name} is not {kind}")
            words.append(value.__array_interface__["data"][0])
            words += value.shape
        elif kind == types.float64:
            words += struct.unpack("q", struct.pack("d", value))
        else:
            words.append(int(value))
    return words


@typeof_impl.register(Native)
def _typeof(native: Native, context: object) -> RecordType:
    return RecordType(type(native.record))


@unbox(RecordType)
def _unbox(record: RecordType, native: Any, context: Any) -> NativeValue:
    address = context.pyapi.object_getattr_string(native, "address")
    pointer = context.pyapi.long_as_voidptr(address)
    context.pyapi.decref(address)
    return NativeValue(pointer)


@infer_getattr
class _Attributes(AttributeTemplate):
    key = RecordType

    def generic_resolve(self, record: RecordType, name: str) -> types.Type | None:
        fields, _ = layout(record.record)
        return fields[name].kind if name in fields else None


@lower_getattr_generic(RecordType)
def _read(context: Any, builder: Any, record: RecordType, pointer: Any, name: str) -> Any:
    """Read a field; arrays count no references, as their record keeps them."""
    place, kind, dtype = layout(record.record)[0][name]
    if isinstance(kind, RecordType):
        return builder.bitcast(_place(builder, pointer, place), cgutils.voidptr_t)
    value = _word(builder, pointer, place)
    if dtype is None:
        if kind == types.float64:
            return builder.bitcast(value, ir.DoubleType())
        return value if kind == types.int64 else builder.trunc(value, ir.IntType(1))
    axes = cast(types.Array, kind).ndim
    shape = [_word(builder, pointer, place + 1 + axis) for axis in range(axes)]
    strides, count = [], WORD(dtype.itemsize)
    for length in reversed(shape):
        strides.insert(0, count)
        count = builder.mul(count, length)
    array = context.make_array(kind)(context, builder)
    data = builder.inttoptr(value, context.get_data_type(kind.dtype).as_pointer())
    context.populate_array(
        array,
        data=builder.bitcast(data, array.data.type),
        shape=shape,
        strides=strides,
        itemsize=WORD(dtype.itemsize),
        meminfo=None,
    )
    return array._getvalue()


def _place(builder: Any, pointer: Any, index: int) -> Any:
    """Return the address of a word of a table."""
    table = builder.bitcast(pointer, WORD.as_pointer())
    return builder.gep(table, [WORD(index)], source_etype=WORD)


def _word(builder: Any, pointer: Any, index: int) -> Any:
    """Read a word of a table."""
    loaded = builder.load(_place(builder, pointer, index))
    # Nobody writes into a table while compiled code runs: loops need not read it again.
    loaded.set_metadata("invariant.load", builder.module.add_metadata([]))
    return loaded


NUMBER, TRUTH, NOTHING = types.float64, types.boolean, types.none
WHOLE = types.int32
FLAT, TABLE = types.Array(NUMBER, 1, "C"), types.Array(NUMBER, 2, "C")
NET, SOLVER = RecordType(Net), RecordType(Solver)
#: The operations on a net, as C calls them; fields of ``records.Operations``.
_SPRING = NUMBER(WHOLE, NUMBER, NUMBER, NUMBER, NET)
_DASHPOT = NUMBER(WHOLE, NUMBER, NUMBER, NUMBER, NUMBER, NET)
_EFFECT = NOTHING(NUMBER, FLAT, FLAT, FLAT, FLAT, NET)
SIGNATURES: dict[str, Signature] = {
    "assemble": TRUTH(NUMBER, FLAT, FLAT, NET, SOLVER),
    "bend_of_passed": NUMBER(FLAT, FLAT, FLAT, FLAT, NUMBER, TABLE, TABLE, NET),
    "blow": _EFFECT,
    "brake": _DASHPOT,
    "brake_by_e": _DASHPOT,
    "brake_side": _DASHPOT,
    "brake_slope": _DASHPOT,
    "fold": _EFFECT,
    "press": _EFFECT,
    "pull": _SPRING,
    "side": _SPRING,
    "slope": _SPRING,
    "springs": TRUTH(FLAT, FLAT, FLAT, FLAT, NET),
    "touch": _EFFECT,
    "find_sides": NOTHING(NUMBER, FLAT, FLAT, TABLE, NET),
    "force": TRUTH(NUMBER, FLAT, FLAT, FLAT, FLAT, NET),
    "greatest_force": NUMBER(FLAT, NET),
    "greatest_inner_force": NUMBER(NUMBER, FLAT, FLAT, FLAT, NET),
    "kinetic": NUMBER(FLAT, NET),
    "peaks": TRUTH(FLAT, FLAT, FLAT, NUMBER, NET),
    "place": NOTHING(NUMBER, FLAT, FLAT, NET),
    "slack": NUMBER(FLAT, FLAT, NET),
    "solve": TRUTH(FLAT, NET, SOLVER),
    "tension": NOTHING(FLAT, FLAT, FLAT, NET),
}


@cache
def caller(name: str) -> Callable[..., Any]:
    """Return what calls an operation of the net that it is given, in compiled code."""
    signature = SIGNATURES[name]
    place = layout(Net)[0]["operations"].place + layout(Operations)[0][name].place

    def generate(context: Any, builder: Any, _: Signature, arguments: Any) -> Any:
        kinds = [context.get_value_type(kind) for kind in signature.args]
        result = context.get_value_type(signature.return_type)
        operation = ir.FunctionType(result, kinds).as_pointer()
        address = _word(builder, arguments[signature.args.index(NET)], place)
        return builder.call(builder.inttoptr(address, operation), arguments)

    def typed(context: object, *arguments: object) -> tuple[Signature, Any]:
        return signature, generate

    # Numba wants one name for each argument.
    names = ["context", *(f"argument_{k}" for k in range(len(signature.args)))]
    kind = inspect.Parameter.POSITIONAL_OR_KEYWORD
    parameters = [inspect.Parameter(each, kind) for each in names]
    vars(typed)["__signature__"] = inspect.Signature(parameters)
    return intrinsic(typed)


def address_of(function: Any, name: str) -> int:
    """Return where an operation of this name is in memory; compile it if need be.

    Args:
        function: As ``numba.njit`` returns it.
    """
    signature = SIGNATURES[name]
    function.compile(signature)
    made = function.overloads[tuple(signature.args)]
    return int(made.library.get_pointer_to_function(made.fndesc.llvm_cfunc_wrapper_name))
