"""Members of an open HDF5 file by path, with their kind made sure of."""

from typing import Any, NoReturn, TypeVar

import h5py
from numpy.typing import NDArray

from tissuec.results.errors import ResultError

T = TypeVar("T", h5py.Dataset, h5py.Group)


def dataset(parent: h5py.Group, path: str) -> h5py.Dataset:
    """Return the dataset at ``path``; ResultError if there is none."""
    return _member(parent, path, h5py.Dataset)


def group(parent: h5py.Group, path: str) -> h5py.Group:
    """Return the group at ``path``; ResultError if there is none."""
    return _member(parent, path, h5py.Group)


def array(parent: h5py.Group, path: str) -> NDArray[Any]:
    """Return all numbers of a dataset."""
    return dataset(parent, path)[:]


def text(parent: h5py.Group, path: str) -> str:
    """Return the text that a dataset holds."""
    return str(dataset(parent, path).asstr()[()])


def texts(parent: h5py.Group, path: str) -> list[str]:
    """Return the list of texts that a dataset holds."""
    return [str(entry) for entry in dataset(parent, path).asstr()[:]]


def attribute(member: h5py.Dataset | h5py.Group, name: str) -> Any:
    """Return an attribute; ResultError if there is none."""
    if name not in member.attrs:
        raise ResultError(f'"{member.file.filename}" is damaged: "{member.name}" lacks {name}')
    return member.attrs[name]


def damaged(file: h5py.File, flaw: str) -> NoReturn:
    """Raise the error that tells what is wrong with a file."""
    raise ResultError(f'"{file.filename}" is damaged: {flaw}')


def _member(parent: h5py.Group, path: str, kind: type[T]) -> T:
    member = parent.get(path)
    if not isinstance(member, kind):
        missing = f"{(parent.name or '').rstrip('/')}/{path.lstrip('/')}"
        raise ResultError(f'"{parent.file.filename}" is damaged: "{missing}" is missing')
    return member
