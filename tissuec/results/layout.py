"""Which files are ours: the mark that every result file carries, and the check of it."""

from pathlib import Path

import h5py

from tissuec.results import access
from tissuec.results.errors import ResultError
from tissuec.results.journal import JournaledFile, has_journal
from tissuec.results.places import partial_path

LAYOUT_VERSION = 1
_MARK = "layout_version"


def mark_layout(file: h5py.File) -> None:
    """Mark a new file as a result of this layout."""
    file.create_group("tissuec").attrs[_MARK] = LAYOUT_VERSION


def open_result(path: Path) -> h5py.File:
    """Return the result file at ``path``, open for reading.

    Raises:
        ResultError: There is none, or it is truncated, or no result, or of another layout.
    """
    if not path.is_file():
        raise ResultError(_missing(path))
    try:
        # A file whose last change was cut short is read through its journal.
        file = h5py.File(JournaledFile(path, "read") if has_journal(path) else path, "r")
    except OSError as error:
        raise ResultError(f'cannot read "{path}": {_reason(error)}') from error
    try:
        _check_mark(file, path)
    except ResultError:
        file.close()
        raise
    return file


def _check_mark(file: h5py.File, path: Path) -> None:
    group = file.get("tissuec")
    if not isinstance(group, h5py.Group) or _MARK not in group.attrs:
        raise ResultError(f'"{path}" is an HDF5 file, but no result of tissuec')
    version = int(access.attribute(group, _MARK))
    if version != LAYOUT_VERSION:
        raise ResultError(
            f'"{path}" has layout {version}, and this tissuec reads layout {LAYOUT_VERSION}; '
            "read it with the version that wrote it, or run the scene again"
        )


def _missing(path: Path) -> str:
    partial = partial_path(path)
    if partial != path and partial.is_file():
        return f'there is no file "{path}", but an unfinished one: "{partial}"'
    return f'there is no file "{path}"'


def _reason(error: OSError) -> str:
    text = str(error)
    if "truncated file" in text:
        return "it is truncated: its end is missing, such as after a copy that was cut short"
    if "signature not found" in text:
        return "it is no HDF5 file"
    return error.strerror or text
