"""Records and operations as Numba understands them."""

import inspect
from collections.abc import Callable
from functools import cache
from typing import Any, cast

import numba
from llvmlite import ir
from numba.core import cgutils, types
from numba.core.imputils import lower_getattr_generic, lower_setattr_generic
from numba.core.typing.templates import AttributeTemplate, Signature, infer_getattr
from numba.extending import NativeValue, intrinsic, models, register_model, typeof_impl, unbox

from tissuec.compiled.record_tables import Record, RecordField, RecordTable, layout, signature
from tissuec.kernels.records import Net, Operations, Progress

WORD = ir.IntType(64)
NUMBER, WHOLE, NOTHING = types.float64, types.int32, types.none
SCALARS: dict[Any, types.Type] = {float: NUMBER, int: types.int64, bool: types.boolean}
#: Records whose numbers compiled code changes.
CHANGED = (Progress,)


class RecordType(types.Type):
    """The address of the table of a record."""

    def __init__(self, record: Record):
        self.record = record
        super().__init__(name=f"record({record.__module__}.{record.__name__})")


register_model(RecordType)(models.OpaqueModel)


def kind_of(field: RecordField) -> types.Type:
    """Return the Numba type of a field."""
    if field.dtype is not None:
        return types.Array(numba.from_dtype(field.dtype), field.axes, "C")
    return SCALARS.get(field.kind) or RecordType(field.kind)


@typeof_impl.register(RecordTable)
def _typeof(table: RecordTable, context: object) -> RecordType:
    return RecordType(type(table.record))


@unbox(RecordType)
def _unbox(record: RecordType, table: Any, context: Any) -> NativeValue:
    address = context.pyapi.object_getattr_string(table, "address")
    pointer = context.pyapi.long_as_voidptr(address)
    context.pyapi.decref(address)
    return NativeValue(pointer)


@infer_getattr
class _Attributes(AttributeTemplate):
    key = RecordType

    def generic_resolve(self, record: RecordType, name: str) -> types.Type | None:
        fields, _ = layout(record.record)
        return kind_of(fields[name]) if name in fields else None


@lower_getattr_generic(RecordType)
def _read(context: Any, builder: Any, record: RecordType, pointer: Any, name: str) -> Any:
    """Read a field; arrays count no references, as their record keeps them."""
    field = layout(record.record)[0][name]
    place, kind = field.place, kind_of(field)
    if isinstance(kind, RecordType):
        return builder.bitcast(_place(builder, pointer, place), cgutils.voidptr_t)
    value = read_word(builder, pointer, place, changes=record.record in CHANGED)
    if field.dtype is None:
        if kind == types.float64:
            return builder.bitcast(value, ir.DoubleType())
        return value if kind == types.int64 else builder.trunc(value, ir.IntType(1))
    array_type = cast(types.Array, kind)
    shape = [read_word(builder, pointer, place + 1 + axis) for axis in range(field.axes)]
    strides: list[ir.Value] = []
    count: ir.Value = WORD(field.dtype.itemsize)
    for length in reversed(shape):
        strides.insert(0, count)
        count = builder.mul(count, length)
    array = context.make_array(array_type)(context, builder)
    data = builder.inttoptr(value, context.get_data_type(array_type.dtype).as_pointer())
    context.populate_array(
        array,
        data=builder.bitcast(data, array.data.type),
        shape=shape,
        strides=strides,
        itemsize=WORD(field.dtype.itemsize),
        meminfo=None,
    )
    return array._getvalue()


@lower_setattr_generic(RecordType)
def _write(context: Any, builder: Any, sig: Signature, given: Any, name: str) -> None:
    """Change a number."""
    record, kind = sig.args
    if record.record not in CHANGED or kind not in (NUMBER, SCALARS[int]):
        raise TypeError(f"compiled code does not change {name} of {record}")
    pointer, value = given
    place = _place(builder, pointer, layout(record.record)[0][name].place)
    builder.store(builder.bitcast(value, WORD), place)


def _place(builder: Any, pointer: Any, index: int) -> Any:
    """Return the address of a word of a table."""
    table = builder.bitcast(pointer, WORD.as_pointer())
    return builder.gep(table, [WORD(index)], source_etype=WORD)


def read_word(builder: Any, pointer: Any, index: int, *, changes: bool = False) -> Any:
    """Emit the load of a word of a table.

    Args:
        pointer: Address of the table.
        index: Index of the word.
        changes: Whether compiled code may write into the table.
    """
    loaded = builder.load(_place(builder, pointer, index))
    if not changes:  # loops need not read it again
        loaded.set_metadata("invariant.load", builder.module.add_metadata([]))
    return loaded


NET = RecordType(Net)
_SPRING = NUMBER(WHOLE, NUMBER, NUMBER, NUMBER, NET)
_DASHPOT = NUMBER(WHOLE, NUMBER, NUMBER, NUMBER, NUMBER, NET)
#: Laws of springs, as C calls them; fields of ``records.Operations``.
OF_LAWS = {
    **dict.fromkeys(("pull", "side", "slope"), _SPRING),
    **dict.fromkeys(("brake", "brake_by_e", "brake_side", "brake_slope"), _DASHPOT),
}


def as_compiled(function: Callable[..., Any]) -> Signature:
    """Return the signature that follows from the annotations of a function."""
    arguments, result = signature(function)
    returned = NOTHING if result is None else SCALARS[result]
    return returned(*(kind_of(field) for field in arguments.values()))


@cache
def caller(name: str, own: Signature) -> Callable[..., Any]:
    """Compiled code that calls an operation of a net by the address in the net.

    Args:
        name: A field of ``records.Operations``.
    """
    place = layout(Net)[0]["operations"].place + layout(Operations)[0][name].place

    def generate(context: Any, builder: Any, _: Signature, arguments: Any) -> Any:
        kinds = [context.get_value_type(kind) for kind in own.args]
        result = context.get_value_type(own.return_type)
        operation = ir.FunctionType(result, kinds).as_pointer()
        address = read_word(builder, arguments[own.args.index(NET)], place)
        return builder.call(builder.inttoptr(address, operation), arguments)

    return _typed(own, generate)


@cache
def field_caller(vectors: int = 4) -> Callable[..., Any]:
    """Return the call of a loop of a field, by the addresses of the loop and of its table.

    Args:
        vectors: How many it takes; a kernel takes positions, velocities, forces and powers.
    """
    array = types.Array(NUMBER, 1, "C")
    own = NOTHING(types.int64, types.int64, NUMBER, *[array] * vectors)

    def generate(context: Any, builder: Any, _: Signature, arguments: Any) -> Any:
        address, table, *others = arguments
        kinds = [context.get_value_type(kind) for kind in own.args[2:]]
        result = context.get_value_type(own.return_type)
        kernel = ir.FunctionType(result, [*kinds, cgutils.voidptr_t]).as_pointer()
        given = [*others, builder.inttoptr(table, cgutils.voidptr_t)]
        return builder.call(builder.inttoptr(address, kernel), given)

    return _typed(own, generate)


def _typed(own: Signature, generate: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function that compiled code can call, from its generator."""

    def typed(context: object, *arguments: object) -> tuple[Signature, Any]:
        return own, generate

    # Numba wants one name for each argument.
    names = ["context", *(f"argument_{k}" for k in range(len(own.args)))]
    kind = inspect.Parameter.POSITIONAL_OR_KEYWORD
    parameters = [inspect.Parameter(each, kind) for each in names]
    vars(typed)["__signature__"] = inspect.Signature(parameters)
    return intrinsic(typed)
