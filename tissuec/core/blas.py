"""BLAS on one thread, in commands and in calls from Python.

Matrices are small or sparse: threads cost more than they bring, and sums would depend on how
many processors there are. NumPy and SciPy each bring OpenBLAS along, which reads an environment
variable when it is loaded, and has a function for later. A user who sets the variable decides.
"""

import os
import sys
from collections.abc import Callable, Iterator
from functools import wraps
from pathlib import Path
from threading import Lock
from typing import NamedTuple, ParamSpec, TypeVar

VARIABLE = "OPENBLAS_NUM_THREADS"
#: Modules that the libraries of NumPy and SciPy are loaded with.
_LOADED_WITH = ("numpy.linalg._umath_linalg", "scipy.linalg._fblas", "scipy.linalg.cython_blas")
#: What the functions of OpenBLAS are called, depending on how it was built.
_NAMES = tuple(
    f"{prefix}{{}}{suffix}"
    for prefix in ("scipy_openblas_", "openblas_")
    for suffix in ("64_", "", "_64")
)
P = ParamSpec("P")
Result = TypeVar("Result")


class _Library(NamedTuple):
    """The functions of a library that return and set the number of threads."""

    threads: Callable[[], int]
    set_threads: Callable[[int], None]
    processors: Callable[[], int]


class _Held:
    """What is held to one thread now.

    Attributes:
        depth: Calls under way, perhaps of several threads.
        is_ours: Whether the variable was not set before.
        before: Numbers of threads of libraries, by the address of a function.
    """

    def __init__(self) -> None:
        self.lock, self.depth, self.is_ours = Lock(), 0, False
        self.before: dict[int, int] = {}


_held = _Held()


def _files() -> Iterator[str]:
    """Yield files through which the functions of libraries that are loaded can be found."""
    for name in _LOADED_WITH:
        path = getattr(sys.modules.get(name), "__file__", None)
        if path is None:
            continue
        yield path  # Linux and macOS also search what a module needs
        if os.name == "nt":
            package = name.partition(".")[0]
            beside = Path(str(sys.modules[package].__file__)).parents[1] / f"{package}.libs"
            yield from map(str, beside.glob("*openblas*.dll"))


def _libraries() -> dict[int, _Library]:
    """Return the libraries that are loaded, by the address of a function."""
    found: dict[int, _Library] = {}
    for path in _files():
        import ctypes  # late: commands begin without NumPy

        for form in _NAMES:
            try:
                module = ctypes.CDLL(path)
                functions = [
                    getattr(module, form.format(verb))
                    for verb in ("get_num_threads", "set_num_threads", "get_num_procs")
                ]
            except (AttributeError, OSError):  # it is another library
                continue
            address = ctypes.cast(functions[0], ctypes.c_void_p).value or 0
            found[address] = _Library(*functions)
    return found


def hold_to_one_thread() -> None:
    """Have BLAS use one thread, until as many calls of ``release`` follow."""
    with _held.lock:
        _held.depth += 1
        if _held.depth > 1 or VARIABLE in os.environ:
            return
        os.environ[VARIABLE] = "1"  # for libraries that are loaded meanwhile, and for workers
        for address, library in _libraries().items():
            _held.before[address] = library.threads()
            library.set_threads(1)
        _held.is_ours = True


def release() -> None:
    """Let BLAS use as many threads as before."""
    with _held.lock:
        _held.depth -= 1
        if _held.depth > 0 or not _held.is_ours:
            return
        os.environ.pop(VARIABLE, None)
        for address, library in _libraries().items():
            before = _held.before.get(address)  # None if it was loaded meanwhile
            library.set_threads(library.processors() if before is None else before)
        _held.before.clear()
        _held.is_ours = False


def on_one_thread(function: Callable[P, Result]) -> Callable[P, Result]:
    """Have a function of ours call BLAS on one thread, whatever its caller uses."""

    @wraps(function)
    def held(*arguments: P.args, **named: P.kwargs) -> Result:
        hold_to_one_thread()
        try:
            return function(*arguments, **named)
        finally:
            release()

    return held
