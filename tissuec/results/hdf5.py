"""What h5py can do and its type stubs do not describe, as functions with types."""

import errno
from pathlib import Path
from typing import Any, Literal

import h5py
import numpy as np

from tissuec.results.journal import JournaledFile
from tissuec.results.kept_open import KeptFile

TEXT = h5py.string_dtype()
_H5PY: Any = h5py
#: Of file systems without locks, as some network ones.
_NO_LOCKS = (errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP)
_ONE_TEXT: Any = (
    _H5PY.h5t.py_create(TEXT, logical=True),
    _H5PY.h5s.create(_H5PY.h5s.SCALAR),
)


def open_file(
    what: Path | JournaledFile | KeptFile, mode: Literal["r", "r+", "w"], *, libver: Any = None
) -> h5py.File:
    """Return an open HDF5 file; without a lock where the file system has none.

    Args:
        what: A path, or an object with the methods of a binary file.
        mode: "r" to read, "r+" to change, "w" to create.
        libver: Lowest and highest version of the format; h5py's own choice by default.

    Raises:
        OSError: It cannot be opened.
    """
    try:
        return _H5PY.File(what, mode, libver=libver)
    except OSError as error:
        if error.errno not in _NO_LOCKS:
            raise
        return _H5PY.File(what, mode, libver=libver, locking=False)


def set_attribute(owner: h5py.Group, name: str, value: Any, kind: Any = None) -> None:
    """Write an attribute.

    Args:
        owner: The group or dataset.
        name: Of the attribute.
        value: Of the attribute.
        kind: Type in the file; that of the value by default.
    """
    attributes: Any = owner.attrs
    attributes.create(name, value, dtype=kind)


def add_text(owner: h5py.Dataset, name: bytes, text: str) -> None:
    """Add an attribute as ``attrs[name] = text`` does, in a third of the time.

    Args:
        name: Of the attribute.
        text: Its value.
    """
    _H5PY.h5a.create(owner.id, name, *_ONE_TEXT).write(np.array(text, dtype=TEXT))


def open_dataset(group: h5py.Group, path: str) -> Any:
    """Return a dataset without h5py's classes, which take four times as long.

    Raises:
        KeyError, ValueError: There is none.
    """
    return _H5PY.h5d.open(group.id, path.encode())


def copy_to(group: h5py.Group, path: str, file: h5py.Group, name: str) -> None:
    """Copy an object into another file.

    Args:
        group: Of the object.
        path: Of the object, from the group.
        file: The other file.
        name: Of the object there.
    """
    owner: Any = group
    owner.copy(path, file, name=name)


def change_attribute(attributes: Any, name: str, value: float) -> None:
    """Change an attribute in place, so that the file does not grow.

    Args:
        attributes: Of a group or dataset.
        name: Of the attribute.
        value: Its new value.
    """
    attributes.modify(name, value)


def external_link(file: str, path: str) -> Any:
    """Return a link to ``path`` in another file."""
    return _H5PY.ExternalLink(file, path)


def soft_link(path: str) -> Any:
    """Return a link to ``path`` in the same file."""
    return _H5PY.SoftLink(path)


def ordered_group(parent: h5py.Group, name: str) -> h5py.Group:
    """Return a new group that keeps the order in which its members are made."""
    owner: Any = parent
    return owner.create_group(name, track_order=True)


def linked_file(file: h5py.File, name: str) -> str:
    """Return the name of the file that an external link points into; "" for no such link."""
    owner: Any = file
    return getattr(owner.get(name, getlink=True), "filename", "")


def add_virtual(
    group: h5py.Group, name: str, source: Any, shape: tuple[int, ...], first: Any
) -> Any:
    """Return a new dataset that shows another one of the same file.

    Args:
        group: What it is added to.
        name: Of the new dataset.
        source: The dataset that is shown.
        shape: Of the new one.
        first: The first row of the source that each entry of the new one shows, shape (entry,).
    """
    owner: Any = group
    layout = _H5PY.VirtualLayout(shape=shape, dtype=source.dtype)
    shown = _H5PY.VirtualSource(".", source.name, shape=source.shape)
    count, rows = shape[:2]
    # As long as rows follow one another, they are shown at once.
    whole = int(np.argmin(np.append(first == rows * np.arange(count), False)))
    if whole == count and len(source) == count * rows:
        layout[...] = shown
    else:
        layout[:whole] = shown[: whole * rows]
        for entry in range(whole, count):
            layout[entry] = shown[first[entry] : first[entry] + rows]
    return owner.create_virtual_dataset(name, layout)
