"""Findings of ``check`` in an open text, and in those that it uses."""

from collections.abc import Callable, Hashable
from functools import partial
from hashlib import sha256
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from msgspec import Struct

from tissuec.compiler.checks.coarse_bodies import coarse
from tissuec.compiler.checks.nets import floppy, late_breaking, unstable, unstable_node
from tissuec.compiler.compile import Compiled
from tissuec.core.errors import CompileError, Diagnostic
from tissuec.lsp.documents import Memory, OpenDocuments
from tissuec.mechanics.state import State
from tissuec.model.topology import FloppyModes, floppy_modes
from tissuec.pipeline import check_request, ignored
from tissuec.scene.reading.findings import Findings
from tissuec.scene.request import Request


class Checked(Struct, frozen=True, eq=False):
    """Findings in a text.

    Attributes:
        compiled: The scene in arrays; None of a text that is wrong, or is no scene.
        is_thorough: Whether checks that take time were made as well.
    """

    diagnostics: tuple[Diagnostic, ...]
    compiled: Compiled | None
    is_thorough: bool


class _NotCounted(Exception):
    """Counting would take time now."""


def check(
    documents: OpenDocuments,
    path: Path,
    *,
    thorough: bool = True,
    resolved: Callable[[Findings], None] = ignored,
) -> Checked:
    """Return the findings of ``tissuec check`` for an open text.

    Args:
        documents: The open texts.
        path: The text.
        thorough: Whether to make checks that take time; earlier findings of such checks on the
            same net are returned in any case.
        resolved: Called with the findings so far once all names are resolved.
    """
    try:
        source = documents.read(path, str(path))
        request = Request(source, libraries=documents.libraries, files=documents)
        compiled, warnings = check_request(
            request, thorough=False, levels=thorough, resolved=resolved
        )
    except CompileError as error:
        return Checked(error.diagnostics, None, is_thorough=True)
    if compiled is None:
        return Checked(warnings, None, is_thorough=True)
    count = partial(_modes, documents.nets, thorough)
    find = unstable_node if thorough else _not_now
    is_whole = thorough or not compiled.scene.studies
    further = (*late_breaking(compiled), *coarse(compiled))
    try:
        further += tuple(floppy(compiled, count))
        further += tuple(unstable(compiled, find))
    except _NotCounted:
        return Checked((*warnings, *further), compiled, is_thorough=False)
    return Checked((*warnings, *further), compiled, is_thorough=is_whole)


def _not_now(_: State) -> NoReturn:
    raise _NotCounted


def _modes(memory: Memory, thorough: bool, *arrays: np.ndarray[Any, Any]) -> FloppyModes:
    """Return the floppy modes of a net, which are counted once."""

    def count() -> FloppyModes:
        if not thorough:
            raise _NotCounted
        return floppy_modes(*arrays)

    return memory.recall(("modes", _digest(arrays)), count)


def _digest(arrays: tuple[np.ndarray[Any, Any], ...]) -> Hashable:
    digest = sha256()
    for array in arrays:
        digest.update(f"{array.shape}{array.dtype}".encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.digest()
