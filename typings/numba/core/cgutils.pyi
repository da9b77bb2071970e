"""Types of the part of ``numba.core.cgutils`` that tissuec uses."""

from llvmlite import ir

voidptr_t: ir.PointerType

def alloca_once_value(builder: ir.IRBuilder, value: ir.Value) -> ir.Value: ...
def get_or_insert_function(
    module: ir.Module, fnty: ir.FunctionType, name: str
) -> ir.Function: ...
def unpack_tuple(builder: ir.IRBuilder, tup: ir.Value) -> list[ir.Value]: ...
