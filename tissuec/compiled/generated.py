"""Kernels that are made on the machine of the user, for what a scene has."""

from collections.abc import Callable
from functools import cached_property
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
        code = linked_code(self.name, self._write(self.name))
        return int(code.get_function_address(self.name))

    def __call__(self, time: float, *arguments: Any) -> None:
        """Run the function.

        Args:
            time: [s].
            arguments: Its vectors, and the record of its items.
        """
        *vectors, record = arguments
        kernel_on(self, record, len(vectors))(time, *vectors)


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
