"""Loops that threads share, in compiled code, for ``kernels.thread_loops.share``."""

from pathlib import Path
from typing import Any

import llvmlite.binding as llvm
from llvmlite import ir
from numba.core import cgutils, types
from numba.core.typing.templates import Signature
from numba.extending import intrinsic

from tissuec.compiled.numba_types import read_word
from tissuec.compiled.record_tables import layout
from tissuec.kernels.records import Team

WORD, POINTER, NOTHING = ir.IntType(64), cgutils.voidptr_t, ir.VoidType()
#: How threads wait for one another; linked into each bundle. Those of a run call two functions.
TEAM = (Path(__file__).parent / "team.ll").read_text(encoding="utf-8")
CALLED_BY_THREADS = frozenset(("dismiss", "serve"))
# Numba loads what it has translated, which nobody calls: any place will do.
llvm.add_symbol("share_loop", 1)


@intrinsic
def share(context: Any, team: Any, function: Any, arguments: Any) -> tuple[Signature, Any]:
    """Call a function for every part, or once for all nodes if there is one thread.

    Args:
        context: Typing context of Numba.
        team: Type of the team.
        function: Type of the function.
        arguments: Type of its arguments.
    """
    return types.none(team, function, arguments), _generate


def _generate(context: Any, builder: Any, signature: Signature, values: Any) -> Any:
    team, _, arguments = values
    part = _part(context, builder, *signature.args[1:])
    packed = cgutils.alloca_once_value(builder, arguments)
    packed = builder.bitcast(packed, POINTER)
    fields, _ = layout(Team)
    threads = read_word(builder, team, fields["threads"].place)
    alone = builder.icmp_signed("<=", threads, WORD(1))
    with builder.if_else(alone) as (directly, together):
        with directly:
            builder.call(part, [WORD(0), WORD(1), packed])
        with together:
            words = builder.inttoptr(read_word(builder, team, fields["words"].place), POINTER)
            called = ir.FunctionType(NOTHING, [POINTER, part.type, POINTER])
            shared = cgutils.get_or_insert_function(builder.module, called, "share_loop")
            builder.call(shared, [words, part, packed])
    return context.get_dummy_value()


def _part(context: Any, builder: Any, function: Any, arguments: Any) -> Any:
    """Return a function of part, parts, and where all other arguments are."""
    wanted = (types.int64, types.int64, *arguments)
    own = function.get_call_type(context.typing_context, wanted, {})
    compiled = function.dispatcher.overloads[tuple(own.args)]
    context.active_code_library.add_linking_library(compiled.library)
    kind = ir.FunctionType(NOTHING, [WORD, WORD, POINTER])
    name = f"part.{compiled.fndesc.mangled_name}.{len(builder.module.functions)}"
    part = ir.Function(builder.module, kind, name)
    part.linkage = "internal"
    inner = ir.IRBuilder(part.append_basic_block("entry"))
    number, count, place = part.args
    stored = context.get_value_type(arguments).as_pointer()
    others = cgutils.unpack_tuple(inner, inner.load(inner.bitcast(place, stored)))
    given = [number, count, *others]
    context.call_internal_no_propagate(inner, compiled.fndesc, own, given)
    inner.ret_void()
    return part
