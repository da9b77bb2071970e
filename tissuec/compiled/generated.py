"""Kernels that are made on the machine of the user, for what a scene has."""

import hashlib
import pickle
from collections.abc import Callable
from functools import cache, cached_property, partial
from io import BytesIO
from typing import TYPE_CHECKING, Any

import llvmlite.binding as llvm

from tissuec.compiled.calls import kernel_on
from tissuec.compiled.loading import machine_code
from tissuec.core.resources import PACKAGE

if TYPE_CHECKING:
    from tissuec.compiled.loops.frame import LoopText


_MATHEMATICS = PACKAGE / "compiled" / "mathematics.py"


class GeneratedKernel:
    """A function whose text is written when it is needed.

    Attributes:
        name: Of the function.
    """

    def __init__(self, name: str, write: "Callable[[str], LoopText]"):
        self.name = self.__name__ = name
        self._write = write

    @cached_property
    def address(self) -> int:
        """Return where the function is in memory."""
        kept = _described(self._write)
        if kept is None:
            code = linked_code(self.name, self._write(self.name))
        else:
            code = machine_code(self.name, kept, lambda: _linked(self._write(self.name)))
        return int(code.get_function_address(self.name))

    def __call__(self, time: float, *arguments: Any) -> None:
        """Run the function.

        Args:
            time: [s].
            arguments: Its vectors, and the record of its items.
        """
        *vectors, record = arguments
        kernel_on(self, record, len(vectors))(time, *vectors)


class _Describing(pickle.Pickler):
    """Pickles values of classes of this package, and no others."""

    def reducer_override(self, obj: Any) -> Any:
        """Raise PicklingError for what other packages define, and for graphs, which grow."""
        own = obj if isinstance(obj, type) or hasattr(obj, "__qualname__") else type(obj)
        if own.__module__.split(".")[0] not in _KNOWN or own.__module__ == _GRAPHS:
            raise pickle.PicklingError(own.__module__)
        return NotImplemented


_KNOWN = ("tissuec", "builtins", "functools", "msgspec")
_GRAPHS = "tissuec.autodiff.graph"


def _described(write: "Callable[[str], LoopText]") -> bytes | None:
    """Return a key of the text that a function writes, without writing it; None without one.

    It consists of the name and the arguments of the function, and of the state of the files of
    this package.
    """
    if not isinstance(write, partial):
        return None
    found = BytesIO()
    try:
        pickler = _Describing(found)
        pickler.fast = True  # no memo, so that it does not count which parts are one object
        pickler.dump(write)
    # What contains itself is a ValueError or a RecursionError, by its depth.
    except (pickle.PicklingError, AttributeError, TypeError, ValueError, RecursionError):
        return None
    return found.getvalue() + _state_of_files()


@cache
def _state_of_files() -> bytes:
    """Return bytes that change with any file that the texts of functions depend on."""
    every = sorted(path for name in _FOLDERS for path in (PACKAGE / name).rglob("*.py"))
    states = ((path.name, (own := path.stat()).st_mtime_ns, own.st_size) for path in every)
    return hashlib.sha256(repr(list(states)).encode()).digest()


_FOLDERS = ("autodiff", "compiled", "core", "forces", "geometry", "laws", "model")


def linked_code(name: str, found: "LoopText") -> Any:
    """Return the functions of a text, with all that they call, from the cache or made.

    Args:
        name: For people who look into the cache.
    """
    return machine_code(name, _identity(found), lambda: _linked(found))


def _identity(found: "LoopText") -> bytes:
    """Return the bytes by which the code of a function is found in the cache."""
    own = found.text.encode()
    return own + _MATHEMATICS.read_bytes() if found.called else own


def _linked(found: "LoopText") -> str:
    """Return the text of a module with all that the function calls."""
    if not found.called:
        return found.text
    from tissuec.compiled import mathematics  # which costs time at each start

    groups = {
        lanes: tuple(name for name, own in found.called if own == lanes)
        for _, lanes in found.called
    }
    declared = "\n".join(mathematics.declarations(each, k) for k, each in groups.items())
    module: Any = llvm.parse_assembly(f"{declared}\n{found.text}")
    for lanes, names in groups.items():
        module.link_in(llvm.parse_assembly(mathematics.defined(names, lanes)))
    return str(module)
