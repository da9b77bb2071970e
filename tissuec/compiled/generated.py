"""Kernels that are made on the machine of the user, for what a scene has."""

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING, Any

import llvmlite.binding as llvm

from tissuec.compiled.loading import machine_code

if TYPE_CHECKING:
    from tissuec.compiled.loops.items import LoopText


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
        found = self._write(self.name)
        code = machine_code(self.name, found.text.encode(), lambda: _linked(found))
        return int(code.get_function_address(self.name))

    def __call__(self, time: float, *arguments: Any) -> None:
        """Run the function.

        Args:
            time: [s].
            arguments: Its vectors, and the record of its items.
        """
        from tissuec.compiled.calls import kernel_on  # which knows of this class

        *vectors, record = arguments
        kernel_on(self, record, len(vectors))(time, *vectors)


def _linked(found: "LoopText") -> str:
    """Return the text of a module with all that the function calls."""
    if not found.called:
        return found.text
    from tissuec.compiled import mathematics  # which costs time at each start

    declared = mathematics.declarations(found.called, found.lanes)
    module: Any = llvm.parse_assembly(f"{declared}\n{found.text}")
    own = mathematics.defined(found.called, found.lanes)
    module.link_in(llvm.parse_assembly(own))
    return str(module)
