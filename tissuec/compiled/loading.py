"""Machine code of this processor, from LLVM's intermediate representation.

What was made once is kept in the user's cache, under a digest of all that it depends on.
"""

import ctypes
import hashlib
import json
import lzma
import os
import time as clock
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite
import llvmlite.binding as llvm

from tissuec.core.keeping import recalled
from tissuec.core.resources import PACKAGE

SHIPPED = PACKAGE / "compiled" / "shipped"
ENDING = ".ll.xz"
#: A digest of the sources of what is shipped, and the operations that each method calls.
INDEX = SHIPPED / "index.json"
#: Functions of the C library that code may call: for memory, and where the processor has no
#: instruction for them. Their results are exact, so all libraries agree.
CALLED = (
    "calloc", "ceil", "floor", "fma", "fmod", "free", "memcpy", "memmove", "memset", "rint",
)  # fmt: skip
#: Environment variable: a processor, by LLVM's name, whose instructions code shall use.
PROCESSOR = "TISSUEC_PROCESSOR"
# Of optimisation: loops are vectorised, and all takes half of the time of level 3, for code
# that is 5 % slower on the smallest nets and no slower on others.
LEVEL = 1
LEFT_ALONE = "optnone"  # says of a function that it is optimised already
translating = False  # whether something is, which takes a second
_spent = 0.0  # time of the processor that it has taken so far [s]
_KEPT: list[Any] = []  # what owns machine code, which must outlive all that calls it


@cache
def address(bundle: str, name: str) -> int:
    """Return where a function of a shipped bundle is in memory."""
    return int(_bundle(bundle).get_function_address(name))


@cache
def index() -> Any:
    """Return the ``INDEX`` of the shipped bundles."""
    return json.loads(INDEX.read_text(encoding="utf-8"))


def called_by(bundle: str) -> frozenset[str]:
    """Return the operations of a net that a loop over steps calls."""
    return frozenset(index()["calls"][bundle])


@cache
def is_shipped(bundle: str) -> bool:
    """Return whether there is a bundle of this name."""
    return _path(bundle).is_file()


def time_of_translating() -> float:
    """Return the time of the processor that translating kernels has taken so far [s]."""
    return _spent


def _path(bundle: str) -> Path:
    return SHIPPED / f"{bundle}{ENDING}"


@cache
def _bundle(name: str) -> Any:
    packed = _path(name).read_bytes()
    return machine_code(name, packed, lambda: lzma.decompress(packed).decode())


def machine_code(name: str, identity: bytes, text: Callable[[], str]) -> Any:
    """Return the functions of a module, loaded from the cache or made.

    Args:
        name: For people who look into the cache.
        identity: Tells the module from all others.
        text: Returns its intermediate representation, if it has to be translated.
    """
    machine, processor = _target()
    key = hashlib.sha256(processor + b"\0" + identity).hexdigest()[:24]
    code = recalled(f"kernels/{name}-{key}.o", lambda: _translated(text(), machine))
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    _KEPT.append(engine)
    return engine


@cache
def _target() -> tuple[Any, bytes]:
    """Return the processor, for LLVM, and as part of a digest.

    It is this one, or the one of LLVM's names that ``PROCESSOR`` says.
    """
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    name, features = os.environ.get(PROCESSOR), ""
    if not name:
        name = llvm.get_host_cpu_name()
        with suppress(RuntimeError):  # not known of every processor
            features = llvm.get_host_cpu_features().flatten()
    target = llvm.Target.from_default_triple()
    machine = target.create_target_machine(cpu=name, features=features, opt=LEVEL, jit=True)
    _add_mathematics()
    parts = (name, features, target.triple, llvmlite.__version__, str(LEVEL))
    return machine, "\0".join(parts).encode()


def _add_mathematics() -> None:
    """Tell LLVM where the functions of the C library are that kernels call."""
    library = ctypes.cdll.ucrtbase if os.name == "nt" else ctypes.CDLL(None)
    for name in CALLED:
        found = ctypes.cast(getattr(library, name), ctypes.c_void_p).value
        llvm.add_symbol(name, found)


def _translated(text: str, machine: Any) -> bytes:
    """Return the object file of a module, optimised."""
    global translating, _spent
    translating, began = True, clock.process_time()
    try:
        return _optimised(text, machine)
    finally:
        translating = False
        _spent += clock.process_time() - began


def _optimised(text: str, machine: Any) -> bytes:
    module = llvm.parse_assembly(text)
    module.triple, module.data_layout = machine.triple, str(machine.target_data)
    options = llvm.create_pipeline_tuning_options(speed_level=LEVEL)
    options.loop_vectorization = options.slp_vectorization = True
    builder = llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)
    if LEFT_ALONE in text:
        # When machine code is made, it would mean: made quickly, and slow.
        module = llvm.parse_assembly(str(module).replace(f" {LEFT_ALONE}", ""))
    return bytes(machine.emit_object(module))
