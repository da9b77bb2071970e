"""The mark that every result file carries, and the check of it."""

import errno
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import cast

import h5py

from tissuec.core.files import POINTER, OutputFile, not_fetched, open_regular
from tissuec.core.hints import nearby_file
from tissuec.results import ForeignFileError, PlaceError, ResultError, access
from tissuec.results.hdf5 import linked_file, open_file
from tissuec.results.journal import JournaledFile, has_journal
from tissuec.results.kept_open import KeptFile
from tissuec.results.places import (
    SUFFIX,
    busy,
    check_name,
    check_place,
    final_path,
    make_folder,
    partial_path,
)
from tissuec.results.schema import MANIFEST

LAYOUT_VERSION = 4
VIEW = "tissuec_view"
"""Marks files that show a surface of a result, with the name of the surface."""
BLOCKS = "tissuec_blocks"
"""Marks blocks files, with the name of the result."""
OpensComplete = Callable[[Path], KeptFile]
_MARK = "layout_version"
_SIGNATURE = b"\x89HDF\r\n\x1a\n"


def mark_layout(file: h5py.File) -> None:
    """Mark a new file as a result of this layout."""
    file.create_group("tissuec").attrs[_MARK] = LAYOUT_VERSION


def open_result(path: Path, through: OpensComplete | None = None) -> access.ResultGroup:
    """Return the result file at ``path``, open for reading, also during its run.

    Args:
        path: The file.
        through: Opens a complete one; by default, HDF5 does, which is faster.

    Raises:
        ResultError: There is none, or it is truncated, or no result, or of another layout.
    """
    while True:
        before = _state(path)
        if before is None:
            raise ResultError(_missing(path))
        try:
            return _open_whole(path, through)
        except ResultError:
            if _state(path) == before:
                raise  # otherwise it was looked at in the middle of a change


def _state(path: Path) -> tuple[int, int] | None:
    """Return a mark that changes whenever a file is written; None if there is no file."""
    if not path.is_file():
        return None
    with suppress(OSError):
        state = path.stat()
        return state.st_mtime_ns, state.st_size
    return None


def _open_whole(path: Path, through: OpensComplete | None) -> access.ResultGroup:
    try:
        file = _open(path, through)
    except OSError as error:
        raise ResultError(f'cannot read "{path}": {_reason(error, path)}') from error
    try:
        with access.reading(str(path), "/"):
            _check_mark(file, path)
        result = access.ResultGroup(file, str(path), access.read_sums(file, str(path)))
        access.check_structure(result)
    except BaseException:
        file.close()
        raise
    return result


def check_replaceable(path: Path) -> None:
    """Check that a run to ``path`` replaces nothing but results, of whatever layout.

    An unfinished result may be one whose first write was cut short, which nothing reads.

    Raises:
        PlaceError: Something else has the name of the result, or that of the unfinished one,
            or another run is writing it.
    """
    partial = partial_path(path)
    _check_free(partial)
    for place in (partial, final_path(partial)):
        is_ours = _is_empty(place) or _is_result(place)
        if place.exists() and not is_ours and not (place == partial and _is_torn(place)):
            raise PlaceError(
                f'cannot write "{place}": it exists and is not a result of tissuec; give '
                "another file, or remove it"
            )


def reserved(path: Path) -> OutputFile:
    """Return the unfinished result of a run that is to be written later.

    Until it is closed, nobody else writes that result.

    Raises:
        PlaceError: It cannot be written there, or another run is writing it.
    """
    check_name(path)
    make_folder(path.parent)
    check_place(path)
    check_replaceable(path)
    partial = partial_path(path)
    try:
        return OutputFile(partial, "append")
    except BlockingIOError as error:
        raise PlaceError(busy(partial)) from error
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise PlaceError(f'cannot write "{partial}": {reason}') from error


def _check_free(partial: Path) -> None:
    """Check that nobody is writing an unfinished result; PlaceError."""
    try:
        OutputFile(partial, "update").close()
    except FileNotFoundError:
        pass
    except BlockingIOError as error:
        raise PlaceError(busy(partial)) from error
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise PlaceError(f'cannot write "{partial}": {reason}') from error


def _is_empty(path: Path) -> bool:
    """Return whether a file has no content, as a run that was killed at once leaves it."""
    return path.is_file() and not path.stat().st_size


def _is_torn(path: Path) -> bool:
    """Return whether a file is one whose first write was cut short.

    It begins with zeros, as the first page comes last, or like HDF5 without being a whole one.
    """
    if not path.is_file():
        return False
    with path.open("rb") as file:
        head = file.read(len(_SIGNATURE))
    if not any(head):
        return True
    try:
        _open(path).close()
    except OSError:
        return _SIGNATURE.startswith(head.rstrip(b"\0"))
    return False


def _is_result(path: Path) -> bool:
    try:
        with _open(path) as file:
            return _is_marked(file)
    except OSError:
        return False


def _open(path: Path, through: OpensComplete | None = None) -> h5py.File:
    """Open a file for reading; one whose last change was cut short through its journal."""
    if has_journal(path):
        return open_file(JournaledFile(path, "read"), "r")
    if through is not None and path == final_path(path):
        return open_file(through(path), "r")
    return open_file(path, "r")


def _is_marked(file: h5py.File) -> bool:
    group = file.get("tissuec")
    return isinstance(group, h5py.Group) and _MARK in group.attrs


def _check_mark(file: h5py.File, path: Path) -> None:
    if VIEW in file.attrs:
        name = access.attribute(access.ResultGroup(file, str(path), {}), VIEW, str)
        raise ResultError(
            f'"{path}" is the ParaView file for the surface of {name} in '
            f'"{linked_file(file, "VTKHDF")}"; use that file'
        )
    if BLOCKS in file.attrs:
        name = access.attribute(access.ResultGroup(file, str(path), {}), BLOCKS, str)
        raise ResultError(
            f'"{path}" contains the blocks of "{name}" for ParaView; use that file'
        )
    if not _is_marked(file):
        raise ForeignFileError(f'"{path}" is an HDF5 file, but not a result of tissuec')
    version = int(cast(int, file["tissuec"].attrs[_MARK]))
    if version != LAYOUT_VERSION:
        writer = access.ResultGroup(file, str(path), {})
        by = access.attribute_or(access.dataset(writer, MANIFEST.path), "tissuec", "unknown")
        raise ResultError(
            f'"{path}" has layout {version} (of tissuec {by}), but this version of tissuec '
            f"reads layout {LAYOUT_VERSION}; "
            "read it with the version that wrote it, or run the scene again"
        )


def _missing(path: Path) -> str:
    if path.is_dir():
        return f'"{path}" is a folder; give a result file'
    partial = partial_path(path)
    if partial != path and partial.is_file():
        return f'there is no file "{path}", but an unfinished result: "{partial}"'
    hint = nearby_file(path, SUFFIX)
    return f'there is no file "{path}"' + (f"; {hint}" if hint else "")


def _reason(error: OSError, path: Path) -> str:
    text = str(error)
    if error.errno == errno.EAGAIN:
        return "another program is writing it"
    if "truncated file" in text:
        return "it is truncated, for example by an interrupted copy"
    if "signature not found" in text:
        if _is_empty(path) or _is_torn(path):
            return "it is still empty: its run has just begun or was killed at the start"
        if path.suffix == ".tis":
            return f"it is a scene; run it first: tissuec run {path}"
        with suppress(OSError), open_regular(path) as file:
            if reason := not_fetched(file.read(POINTER)):
                return reason
        return "it is not an HDF5 file"
    return error.strerror or text
