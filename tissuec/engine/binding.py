"""Binding: the same stepping code over other operations, interpreted or compiled.

A function of ours is copied with some of its global names replaced; so are the functions it
calls. Numba is imported only here, and only when something is compiled. Compiled code is cached
in a folder named after a digest of all sources that it can come from, because Numba itself does
not notice that a function called from another file has changed.
"""

import hashlib
import os
from collections.abc import Callable, Mapping
from dis import get_instructions
from functools import cache
from pathlib import Path
from types import FunctionType
from typing import Any, Literal

from tissuec.core.resources import PACKAGE, cache_folder, digest_of

Function = Callable[..., Any]
#: Called by Python, by its address, or by compiled code that it becomes a part of.
Role = Literal["entry", "linked", "part"]
#: What compiled code is made from; laws are told apart by the names of their functions.
SOURCES = (
    "engine/binding.py",
    "engine/drive.py",
    "integrators/*.py",
    "kernels/*.py",
    "laws/code.py",
)
#: What this process has compiled or loaded: from which function, and under which name.
_COMPILED: dict[tuple[Function, str], Function] = {}


class Binder:
    """Copies functions together with what they call.

    Args:
        replaced: Global names and what they shall mean: functions (bound in turn) or constants.
        compiled: Whether they are compiled, each by itself.
        kept: Whether compiled code is kept for other processes.
    """

    def __init__(
        self, replaced: Mapping[str, Any], *, compiled: bool = False, kept: bool = True
    ):
        self._replaced, self._compiled, self._kept = replaced, compiled, kept
        self._foreign = {
            name
            for name, each in replaced.items()
            if isinstance(each, FunctionType) and not (_is_shipped(each) or _is_of_law(each))
        }
        self._bound: dict[tuple[Function, Role], tuple[Function, frozenset[str]]] = {}

    def bind(self, function: Function, role: Role = "entry") -> Function:
        """Return a copy of a function under the replaced names."""
        return self._bind(function, role)[0]

    def names(self, function: Function) -> frozenset[str]:
        """Return which of the replaced names a function uses, directly or not."""
        return self._bind(function, "entry")[1]

    def _bind(self, function: Function, role: Role) -> tuple[Function, frozenset[str]]:
        """Return the copy and which replacements it depends on, directly or not."""
        if (function, role) in self._bound:
            return self._bound[function, role]
        assert isinstance(function, FunctionType)
        names = dict(function.__globals__)
        depends: set[str] = set()
        for name in _globals_of(function):
            if name in self._replaced:
                names[name] = self._replaced[name]
                depends.add(name)
            value = names.get(name)
            if isinstance(value, FunctionType) and value.__module__.startswith("tissuec."):
                names[name], further = self._bind(value, "part")
                depends |= further
        copy = FunctionType(function.__code__, names, function.__name__)
        copy.__module__ = function.__module__
        copy.__qualname__ = f"{function.__name__}_{self._variant(depends, role)}"
        result = copy
        if self._compiled:
            key = function, copy.__qualname__
            # The folder of the cache tells versions of our own sources apart, and no others.
            cached = self._kept and _is_shipped(function) and not depends & self._foreign
            result = _COMPILED[key] = _COMPILED.get(key) or _jit(copy, role, cached)
        self._bound[function, role] = (result, frozenset(depends))
        return self._bound[function, role]

    def _variant(self, depends: set[str], role: Role) -> str:
        """Return a name for the replacements in use; Numba's cache tells variants by name."""
        parts: list[str] = [role]
        for name in sorted(depends):
            value = self._replaced[name]
            shown = f"{value.__module__}.{value.__name__}" if callable(value) else repr(value)
            parts.append(f"{name}={shown}")
        return hashlib.sha256(" ".join(parts).encode()).hexdigest()[:12]


def _globals_of(function: FunctionType) -> list[str]:
    """Return the names that a function loads from its module, in order of appearance."""
    found = (i.argval for i in get_instructions(function) if i.opname == "LOAD_GLOBAL")
    return list(dict.fromkeys(found))


@cache
def kernel_folder() -> Path | None:
    """Return the folder for compiled code of exactly these sources, None without a place."""
    base = os.environ.get("NUMBA_CACHE_DIR") or cache_folder()
    if base is None:
        return None
    return Path(base) / f"kernels-{digest_of(SOURCES)[:16]}"


def _is_shipped(function: FunctionType) -> bool:
    """Tell whether a function comes from a file of this package."""
    return Path(function.__code__.co_filename).is_relative_to(PACKAGE)


def _is_of_law(function: FunctionType) -> bool:
    """Tell whether a function was written for spring laws, whose digest is in its name."""
    return function.__code__.co_filename.endswith(" of laws>")


def _jit(function: FunctionType, role: Role, cached: bool) -> Function:
    """Return a function compiled on its first call, or loaded from the cache."""
    import numba
    from numba.core import config as settings

    config: Any = settings  # what it knows is set while it is imported
    folder = kernel_folder()
    before = config.CACHE_DIR
    config.CACHE_DIR = str(folder or "")
    try:
        # Only contraction of a b + c: anything more would break the tests for NaN. Kernels
        # allocate nothing, so they need no counting of references, which took a quarter of
        # the time of stepping a small net. Wrappers that take Python's objects are left out
        # where only compiled code calls.
        return numba.njit(
            error_model="numpy",
            fastmath={"contract"},
            _nrt=False,
            no_cpython_wrapper=role != "entry",
            no_cfunc_wrapper=role != "linked",
            cache=cached and folder is not None,
        )(function)
    finally:
        config.CACHE_DIR = before
