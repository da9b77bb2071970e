"""Reading of results: every fault of the file becomes a ResultError that names it.

A file lists the type, the size and the checksum of each dataset. Types and sizes are compared
with the datasets when the file is opened, before anything is read or memory is allocated;
checksums are compared when data is read.
"""

import json as plain
from collections.abc import Generator, Iterator, Mapping
from contextlib import contextmanager
from math import prod
from typing import Any, NoReturn, TypeVar, cast

import h5py
import numpy as np
from numpy.typing import NDArray

from tissuec.results import ResultError, hdf5
from tissuec.results.datasets import TEXT, DatasetSpec, DatasetSum, crc_of, sums_of_text
from tissuec.results.finite import all_numbers
from tissuec.results.schema import SUMS

T = TypeVar("T", str, int, float, bool)
#: What h5py raises where a file is not as HDF5 demands.
FAULTS = (
    OSError, KeyError, ValueError, TypeError, RuntimeError, IndexError, OverflowError,
    AttributeError, MemoryError,
)  # fmt: skip
_MOST_COMPRESSED = 1100  # times; what gzip can do at most is 1032
_WITH_GAPS = "/VTKHDF/CellData/"  # rows of cells without numbers, which are not written


class ResultGroup:
    """A group of a result, or the whole file.

    Args:
        group: It is, as h5py has it.
        name: Of the file, for messages.
        sums: Type, size and checksum of each dataset, by its path.
    """

    def __init__(self, group: h5py.Group, name: str, sums: Mapping[str, DatasetSum]):
        self.raw, self.file, self.sums = group, name, sums

    def __contains__(self, path: str) -> bool:
        with reading(self.file, path):
            return path in self.raw

    def __iter__(self) -> Iterator[str]:
        with reading(self.file, self.path):
            return iter([str(name) for name in self.raw])

    @property
    def path(self) -> str:
        """Return the path of the group in the file."""
        return str(self.raw.name or "/")

    def member(self, path: str) -> "ResultGroup | Dataset":
        """Return the member at ``path``; ResultError if there is none."""
        full = path if path.startswith("/") else f"{self.path.rstrip('/')}/{path}"
        with reading(self.file, full):
            found = self.raw.get(path)
            if isinstance(found, h5py.Group):
                return ResultGroup(found, self.file, self.sums)
            if isinstance(found, h5py.Dataset) and found.shape is not None:
                return Dataset(found, full, self.file, self.sums.get(full))
        damaged(self.file, f'"{full}" is missing')


class Dataset:
    """A dataset of a result, read when it is indexed.

    Attributes:
        dtype, shape: Of its numbers.
        path: Its place in the file.
    """

    def __init__(self, dataset: h5py.Dataset, path: str, file: str, known: DatasetSum | None):
        self.raw, self.path, self.file, self._known = dataset, path, file, known
        self.dtype = dataset.dtype
        self.shape: tuple[int, ...] = dataset.shape

    def __len__(self) -> int:
        return self.shape[0] if self.shape else damaged(self.file, f'"{self.path}" has no rows')

    def __getitem__(self, index: Any) -> Any:
        """Return a part of it, without a look at the checksum."""
        with reading(self.file, self.path):
            return self.raw[index]

    def whole(self) -> NDArray[Any]:
        """Return the whole dataset, in its unit and shape, after a test of the checksum."""
        data = np.asarray(self[()])
        if self._known and self._known.crc not in (None, crc_of(data)):
            damaged(self.file, f'"{self.path}" has changed since it was written')
        return data

    def finite(self, start: int, stop: int) -> NDArray[Any]:
        """Return the rows from ``start`` to ``stop``, in the unit and shape of the dataset.

        A row that is missing or not finite is reported as damage.
        """
        data = self[start:stop]
        if len(data) < stop - start or not all_numbers(data):
            damaged(self.file, f'"{self.path}" is incomplete')
        return data


def check_structure(file: ResultGroup) -> None:
    """Hold the kinds and sizes that a file states against those of its datasets."""
    for path, known in file.sums.items():
        with reading(file.file, path):
            found = _opened(file, path)
            kind, is_there = str(found.dtype), _is_there(found)
        if (kind, found.shape) != (known.kind, known.shape):
            damaged(file.file, f'"{path}" has another type or size than was written')
        if not is_there and not path.startswith(_WITH_GAPS):
            damaged(file.file, f'"{path}" is larger than the file')


def _is_there(found: Any) -> bool:
    """Return whether the file has room for as many numbers as a dataset declares."""
    size, stored = prod(found.shape) * found.dtype.itemsize, found.get_storage_size()
    filters = found.get_create_plist().get_nfilters() if size > stored else 0
    return size <= stored * (_MOST_COMPRESSED if filters > 1 else 1)  # one is the checksum


def _opened(file: ResultGroup, path: str) -> Any:
    """Return a dataset as h5py's lower layer has it."""
    try:
        return hdf5.open_dataset(file.raw, path)
    except (KeyError, ValueError):  # which say less of what is wrong
        return dataset(file, path).raw.id


def read_sums(file: h5py.File, name: str) -> dict[str, DatasetSum]:
    """Return the table of datasets in a file.

    Raises:
        ValueError: The table is larger than the file; it becomes a ``ResultError``.
    """
    found = dataset(ResultGroup(file, name, {}), SUMS.path)
    with reading(name, SUMS.path):
        if not _is_there(found.raw.id):
            raise ValueError("it is larger than the file")
        return sums_of_text(_decoded(found.raw[()]))


def dataset(parent: ResultGroup, path: str) -> Dataset:
    """Return the dataset at ``path``; ResultError if there is none."""
    found = parent.member(path)
    return found if isinstance(found, Dataset) else damaged(parent.file, f'"{path}" is a group')


def group(parent: ResultGroup, path: str) -> ResultGroup:
    """Return the group at ``path``; ResultError if there is none."""
    found = parent.member(path)
    return (
        found
        if isinstance(found, ResultGroup)
        else damaged(parent.file, f'"{path}" is not a group')
    )


def groups(parent: ResultGroup) -> list[ResultGroup]:
    """Return the groups in a group in the order of their numbers."""
    return sorted(
        (group(parent, name) for name in parent), key=lambda one: attribute(one, "number", int)
    )


def groups_below(parent: ResultGroup) -> list[str]:
    """Return the paths of all groups within a group."""
    found: list[str] = []
    with reading(parent.file, parent.path):
        parent.raw.visititems(
            lambda path, member: found.append(path) if isinstance(member, h5py.Group) else None
        )
    return found


def array(parent: ResultGroup, path: str) -> NDArray[Any]:
    """Return all entries of a dataset, with the unit and shape of the dataset."""
    return dataset(parent, path).whole()


def number(parent: ResultGroup, path: str) -> float:
    """Return the one number that a dataset holds."""
    data = array(parent, path)
    with reading(parent.file, path):
        return float(data)


def text(parent: ResultGroup, path: str) -> str:
    """Return the text that a dataset holds."""
    data = array(parent, path)
    with reading(parent.file, path):
        return _decoded(data[()])


def texts(parent: ResultGroup, path: str) -> list[str]:
    """Return the list of texts that a dataset holds."""
    data = array(parent, path)
    with reading(parent.file, path):
        return [_decoded(entry) for entry in data]


class Contents(dict[str, Any]):
    """Contents of datasets by name: lists of texts, and arrays; what is missing is damage."""

    def __init__(self, parent: ResultGroup, datasets: Mapping[str, DatasetSpec]):
        super().__init__(
            (name, texts(parent, one.path) if one.kind == TEXT else array(parent, one.path))
            for name, one in datasets.items()
            if one.path in parent
        )
        self._parent, self._datasets = parent, datasets

    def __missing__(self, name: str) -> NoReturn:
        damaged(self._parent.file, f'"{self._datasets[name].path}" is missing')

    @property
    def whole(self) -> dict[str, Any]:
        """Return the contents of all datasets; none of them may be missing."""
        return {name: self[name] for name in self._datasets}

    def rows(self, *names: str) -> Iterator[tuple[Any, ...]]:
        """Yield the rows of some datasets, as plain values."""
        return zip(*map(self._plain, names), strict=True)

    def _plain(self, name: str) -> list[Any]:
        found = self[name]
        return cast("list[Any]", found if isinstance(found, list) else found.tolist())


def json(parent: ResultGroup, path: str) -> Any:
    """Return the contents of a text of JSON."""
    written = text(parent, path)
    with reading(parent.file, path):
        return plain.loads(written)


def attribute(member: Dataset | ResultGroup, name: str, kind: type[T]) -> T:
    """Return an attribute; ResultError if there is none of that type.

    Args:
        name: Name of the attribute.
    """
    with reading(member.file, member.path):
        value = _python(member.raw.attrs.get(name))
    if type(value) is not kind:
        damaged(member.file, f'"{member.path}" lacks {name}')
    return cast(T, value)


def _python(value: Any) -> object:
    """Return a number or a text of h5py as one of Python."""
    found = cast("np.generic[Any]", value).item() if isinstance(value, np.generic) else value
    return found.decode() if isinstance(found, bytes) else found


def attribute_or(member: Dataset | ResultGroup, name: str, default: T) -> T:
    """Return an attribute converted to the type of a default; the default if it is missing.

    Args:
        name: Name of the attribute.
    """
    with reading(member.file, member.path):
        value: Any = member.raw.attrs.get(name, default)
        return type(default)(value.decode() if isinstance(value, bytes) else value)


def damaged(file: str, flaw: str) -> NoReturn:
    """Report a damaged file.

    Raises:
        ResultError: Always.
    """
    raise ResultError(f'"{file}" is damaged: {flaw}')


@contextmanager
def reading(file: str, path: str) -> Generator[None]:
    """Convert every error of reading to one that names the file.

    Raises:
        ResultError: HDF5 or a text cannot be read.
    """
    try:
        yield
    except FAULTS as error:
        reason = str(error).partition("\n")[0].strip("'\"") or type(error).__name__
        raise ResultError(f'"{file}" is damaged: "{path}" cannot be read ({reason})') from error


def _decoded(data: Any) -> str:
    if not isinstance(data, bytes | str):
        raise TypeError("it is not a text")
    return data if isinstance(data, str) else data.decode()
