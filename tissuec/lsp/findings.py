"""Findings of ``check`` in open texts, their quick fixes, and the page of all messages."""

import re
from collections.abc import Callable, Hashable, Iterable
from functools import cache, partial
from hashlib import sha256
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from msgspec import Struct

from tissuec.compiler.checks.nets import floppy, late_breaking, unstable, unstable_node
from tissuec.compiler.compile import Compiled
from tissuec.core.catalogue import reference
from tissuec.core.errors import CompileError, Diagnostic, in_order_of_text
from tissuec.core.files import write_file
from tissuec.core.hints import Edit
from tissuec.core.keeping import cache_folder
from tissuec.core.resources import library
from tissuec.core.source import Span
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
    is_whole = thorough or not (compiled.scene.studies or compiled.fit_problems)
    further = tuple(late_breaking(compiled))
    try:
        further += tuple(floppy(compiled, count))
        further += tuple(unstable(compiled, find))
    except _NotCounted:
        is_whole = False
    ordered = tuple(in_order_of_text((*warnings, *further)))
    return Checked(ordered, compiled, is_thorough=is_whole)


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


class QuickFix(Struct, frozen=True, eq=False):
    """One edit of one finding.

    Attributes:
        title: What the editor shows.
        path: The file that the edit changes.
        place: What it replaces.
        is_preferred: Whether the finding has no other edit.
    """

    title: str
    finding: Diagnostic
    path: Path
    place: Span
    text: str
    is_preferred: bool


def fixes_at(
    path: Path, first: int, last: int, checked: Iterable[Checked], documents: OpenDocuments
) -> list[QuickFix]:
    """Return the edits for findings in some lines of a file, in the order of the findings.

    Edits of shipped files, and of texts that have changed since they were checked, are left
    out.

    Args:
        path: The file.
        first, last: Lines, counted from 0; findings count that share one with them.
        checked: Findings in each open text; they may be about a file that it uses.
    """
    found: dict[tuple[str, str, str, int, int, str], QuickFix] = {}
    for finding in (one for each in checked for one in each.diagnostics):
        if finding.span is None or not _is_in(finding.span, path, first, last):
            continue
        for fix in (_fix(finding, edit, documents) for edit in finding.edits):
            if fix is not None:
                place = str(fix.path), fix.place.start, fix.place.end
                found.setdefault((finding.code, finding.message, *place, fix.text), fix)
    return list(found.values())


def _is_in(span: Span, path: Path, first: int, last: int) -> bool:
    where = span.source.path
    if where is None or where.resolve() != path.resolve():
        return False
    begin = span.line - 1
    return begin <= last and first <= begin + span.text.count("\n")


def _fix(finding: Diagnostic, edit: Edit, documents: OpenDocuments) -> QuickFix | None:
    place = edit.span
    if place is None or place.source.path is None:
        return None
    path = place.source.path
    is_shipped = library().resolve() in path.resolve().parents
    if is_shipped or documents.read(path, str(path)).text != place.source.text:
        return None
    text = " ".join(edit.text.split())
    title = f'Write "{text}"' if text else f'Remove "{place.one_line}"'
    return QuickFix(title, finding, path, place, edit.text, len(finding.edits) == 1)


_HEAD = re.compile(r"^## (\w+):", re.MULTILINE)


@cache
def _page() -> tuple[Path | None, dict[str, int]]:
    """Return where the page is, and the line of each code from 1."""
    text, folder = reference(), cache_folder()
    lines = {found[1]: text.count("\n", 0, found.start()) + 1 for found in _HEAD.finditer(text)}
    if folder is None:
        return None, lines
    path = folder / f"messages-{sha256(text.encode()).hexdigest()[:16]}.md"
    try:
        if not path.exists():
            write_file(path, text)
    except OSError:
        return None, lines
    return path, lines


def address_of(code: str) -> str | None:
    """Return the address of the documentation of a code."""
    path, lines = _page()
    return f"{path.as_uri()}#L{lines[code]}" if path is not None and code in lines else None
