"""The open HDF5 file while it is written: columns that grow, and commits that hold or fail."""

import shutil
from collections.abc import Generator, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Literal, NamedTuple, cast

import h5py
import numpy as np
from numpy.typing import ArrayLike, NDArray

from tissuec.core.errors import shown_size
from tissuec.results import PlaceError, ResultError, access
from tissuec.results.datasets import TEXT, DatasetSpec, DatasetSum, crc_of, sums_as_text
from tissuec.results.hdf5 import TEXT as H5_TEXT
from tissuec.results.hdf5 import add_text, change_attribute, open_file
from tissuec.results.journal import JournaledFile
from tissuec.results.places import busy
from tissuec.results.schema import SUMS

# Newer formats carry a mark of being open, which a killed run leaves behind, and VTK reads
# neither their compressed chunks nor their virtual datasets.
LIBVER = ("earliest", "v110")
COMPRESSED: Any = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
LEAST_COMPRESSED = 1024  # numbers
# Numbers of springs and nodes from which all that repeats itself is compressed: lists of
# springs to a twentieth or less, at 100 MiB/s or more.
LARGE = 1 << 16


def sized(dataset: DatasetSpec, rows: int) -> DatasetSpec:
    """Return a column with the rows that are allocated at once where so many come together."""
    return dataset.of(chunk=LARGE) if dataset.packed and rows >= LARGE else dataset


class SomeRows(NamedTuple):
    """Rows of groups whose other rows are 0, and are not written.

    Attributes:
        data: In the unit of the column, shape (group, row, …).
        first: Where they begin in each group.
        total: How many rows a group has.
    """

    data: NDArray[Any]
    first: int
    total: int


class GrowingDataset:
    """A dataset that grows along its first axis; rows wait in memory until the next commit.

    Args:
        dataset: What the rows go to.
        crc: The CRC-32 of those that are there; None where none is kept.

    Attributes:
        rows: How many rows there are, those that wait included.
    """

    __slots__ = ("_waiting", "crc", "dataset", "rows")

    def __init__(self, dataset: h5py.Dataset, crc: int | None):
        self.dataset, self.crc = dataset, crc
        self.rows = len(dataset)
        self._waiting: list[tuple[int, NDArray[Any]]] = []

    def convert(self, values: ArrayLike) -> NDArray[Any]:
        """Return values as rows of this column, in its unit, of shape (row, …)."""
        return np.asarray(values, dtype=self.dataset.dtype)

    def append(self, rows: NDArray[Any]) -> None:
        """Add converted rows, in the unit of the column, of shape (row, …)."""
        if len(rows):
            self._waiting.append((self.rows, rows))
            self.rows += len(rows)

    def skip(self, rows: int) -> None:
        """Add rows that are 0, and take no room where they fill what is allocated at once."""
        self.rows += rows

    def write(self) -> None:
        """Hand the waiting rows to HDF5."""
        if self.rows > len(self.dataset):
            self.dataset.resize(self.rows, axis=0)
        for first, rows in _joined(self._waiting):
            self.dataset[first : first + len(rows)] = rows
            if self.crc is not None:
                self.crc = crc_of(rows, self.crc)
        self._waiting.clear()


class ColumnTable(Mapping[str, GrowingDataset]):
    """Columns that take rows together, by name."""

    def __init__(self, store: "Store", datasets: Mapping[str, DatasetSpec]):
        self._store = store
        self._columns = {name: store.column(one) for name, one in datasets.items()}

    def __getitem__(self, name: str) -> GrowingDataset:
        return self._columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def last(self, name: str) -> float:
        """Return the last number in the file of a column; minus infinity without any."""
        rows = self[name].dataset
        return float(rows[-1]) if len(rows) else -np.inf

    def append(self, rows: Mapping[str, ArrayLike]) -> None:
        """Add rows to columns: to all of them or, if one does not fit, to none.

        Args:
            rows: Rows by name, in the units of the columns, shape (row, …).
        """
        self._store.append({self[name]: data for name, data in rows.items()})


class Store:
    """An HDF5 file whose flushed content survives a kill and a full disk.

    Attributes:
        compresses: Whether columns that are read in parts are compressed.

    Args:
        path: The file.
        mode: "create" for an empty file, "update" to continue one.

    Raises:
        PlaceError: Another run is writing it.
        ResultError: The file cannot be opened for writing.
    """

    def __init__(self, path: Path, mode: Literal["create", "update"]):
        self.path = path
        self.columns: dict[str, GrowingDataset] = {}
        self.waiting = 0  # [byte]
        self.compresses = False
        self._sums: dict[str, DatasetSum] = {}
        self._open(mode)

    def _open(self, mode: Literal["create", "update"]) -> None:
        self._is_new = mode == "create"
        self._made: set[str] = set()  # datasets
        self._groups: dict[str, h5py.Group] = {}
        try:
            self._disk = JournaledFile(self.path, mode)
        except BlockingIOError as error:
            raise PlaceError(busy(self.path)) from error
        except OSError as error:
            raise ResultError(f'cannot write "{self.path}": {error.strerror}') from error
        try:
            self.file = open_file(self._disk, "w" if mode == "create" else "r+", libver=LIBVER)
        except OSError as error:
            self._disk.close()
            raise ResultError(f'cannot write to "{self.path}": {error}') from error

        if mode == "update":
            self._sums = access.read_sums(self.file, str(self.path))

    @property
    def content(self) -> access.ResultGroup:
        """Return the contents of the last commit, for reading."""
        return access.ResultGroup(self.file, str(self.path), self._sums)

    def __contains__(self, path: str) -> bool:
        """Return whether there is a dataset at ``path``."""
        return path in self._made or (not self._is_new and path in self.file)

    def label(self, path: str, **attributes: str | int | bool) -> None:
        """Give a group or dataset attributes."""
        found = self.file[path].attrs
        for name, value in attributes.items():
            if name in found and not isinstance(value, str):
                change_attribute(found, name, value)
            elif name not in found or found[name] != value:
                found[name] = value

    def remove(self, path: str) -> None:
        """Remove a dataset, or a group with all that it holds."""
        del self.file[path]
        self._groups.clear()
        within = f"{path}/"
        for member in [one for one in self._sums if f"{one}/".startswith(within)]:
            del self._sums[member]
            self._made.discard(member)

    def truncate(self, path: str, rows: int) -> None:
        """Cut a growing dataset, before it is opened as a column."""
        dataset = self._growing(path)
        if len(dataset) == rows:
            return
        crc = self._sums[path].crc
        crc = None if crc is None else crc_of(access.array(self.content, path)[:rows])
        dataset.resize(rows, axis=0)
        self._sums[path] = DatasetSum(str(dataset.dtype), dataset.shape, crc)

    def _growing(self, path: str) -> h5py.Dataset:
        """Return a dataset that can grow; ResultError if another one has its place."""
        found: Any = access.dataset(self.content, path).raw
        if not found.chunks or found.maxshape[0] is not None:
            access.damaged(str(self.path), f'"{path}" cannot grow')
        return found

    def group(self, path: str) -> h5py.Group:
        """Return the group at ``path``, made if need be."""
        if path not in self._groups:
            self._groups[path] = self.file.require_group(path)
        return self._groups[path]

    def _make(self, dataset: DatasetSpec, **kind: Any) -> h5py.Dataset:
        """Add a dataset, as h5py makes it from arguments."""
        parent, _, name = dataset.path.rpartition("/")
        made = self.group(parent or "/").create_dataset(name, **kind)
        describe(made, dataset.unit, dataset.text)
        self._made.add(dataset.path)
        return made

    def column(self, column: DatasetSpec) -> GrowingDataset:
        """Return the column of a declaration; a new one if there is none."""
        path = column.path
        if path in self:
            dataset = self._growing(path)
        else:
            is_large = column.packed == "large" and column.chunk >= LARGE
            compress = is_large or (column.in_parts and self.compresses)
            dataset = self._make(
                column,
                shape=(0, *column.row),
                # HDF5 wants room in every chunk, also for rows without any number.
                maxshape=(None, *(length or None for length in column.row)),
                chunks=(column.chunk, *(max(1, length) for length in column.row)),
                dtype=H5_TEXT if column.kind == TEXT else column.kind,
                fletcher32=column.in_parts,
                **(COMPRESSED if compress else {}),
            )
        found = self._sums.get(path)
        crc = found.crc if found else None if column.in_parts else 0
        grown = self.columns[path] = GrowingDataset(dataset, crc)
        return grown

    def array(self, dataset: DatasetSpec, value: object) -> None:
        """Write a dataset as a whole: entries, a text, or a list of texts.

        A previous one is replaced. One of the same shape and type is overwritten in place, so
        that the file does not grow when the same things are written again.
        """
        if dataset.kind == TEXT and not isinstance(value, str):
            self._texts(dataset, list(cast("Sequence[str]", value)))
            return
        data = _fixed_text(value) if isinstance(value, str) else _entries(dataset, value)
        path = dataset.path
        former = self.file.get(path) if path in self else None
        self._sums[path] = DatasetSum(str(data.dtype), data.shape, crc_of(data))
        kind = data.shape, data.dtype
        if isinstance(former, h5py.Dataset) and (former.shape, former.dtype) == kind:
            former[()] = data
            return
        if former is not None:
            del self.file[path]
        least = {"large": LARGE, "most": 0}.get(dataset.packed, np.inf)
        compress = data.size >= LEAST_COMPRESSED and len(data) >= least
        self._make(dataset, data=data, **(COMPRESSED if compress else {}))

    def _texts(self, dataset: DatasetSpec, texts: Sequence[str]) -> None:
        size = (len(texts),)
        self._make(dataset, data=texts, dtype=H5_TEXT, shape=size)
        crc = crc_of(np.array(texts, dtype=object))
        self._sums[dataset.path] = DatasetSum("object", size, crc)

    def arrays(self, group: Mapping[str, DatasetSpec], **values: object) -> None:
        """Write datasets of a group as wholes, by name."""
        for name, value in values.items():
            self.array(group[name], value)

    def append(self, rows: Mapping[GrowingDataset, ArrayLike | SomeRows]) -> None:
        """Add rows to columns: to all of them or, if one does not fit, to none.

        Args:
            rows: Rows by column, in the unit of the column, shape (row, …).
        """
        converted: list[tuple[GrowingDataset, NDArray[Any], SomeRows | None]] = []
        for column, values in rows.items():
            some = values if isinstance(values, SomeRows) else None
            data = column.convert(values if some is None else some.data)
            converted.append((column, data, some))
        for column, data, some in converted:
            self.waiting += data.nbytes
            if some is None:
                column.append(data)
                continue
            for group in data:
                column.skip(some.first)
                column.append(group)
                column.skip(some.total - some.first - len(group))

    def write(self) -> None:
        """Hand all waiting rows to HDF5, without committing them."""
        with self._clear_errors():
            for column in self.columns.values():
                column.write()
        self.waiting = 0

    @contextmanager
    def _clear_errors(self) -> Generator[None]:
        try:
            yield
        except Exception as error:
            cause = self._disk.failure or error
            if not isinstance(cause, OSError):
                raise
            raise ResultError(f'cannot write "{self.path}": {cause}') from cause

    def commit(self) -> None:
        """Make all that was written the state that the file holds.

        Raises:
            ResultError: There is no space; the file holds what the last commit left.
        """
        with self._clear_errors():
            self._write_sums()
            self.file.flush()
        self._commit()

    def _write_sums(self) -> None:
        """Write what there is to know of all datasets."""
        for path, column in self.columns.items():
            kind = str(column.dataset.dtype)
            self._sums[path] = DatasetSum(kind, column.dataset.shape, column.crc)
        self.array(SUMS[""], sums_as_text(self._sums))
        del self._sums[SUMS.path]

    def _commit(self) -> None:
        needed = self._disk.pending
        try:
            self._disk.commit()
        except OSError as error:
            raise ResultError(_no_space(self.path, needed, error)) from error

    def rollback(self) -> None:
        """Discard all uncommitted changes, and open the file again as it is on the disk."""
        self.abandon()
        self.columns.clear()
        self.waiting = 0
        self._open("update")

    def abandon(self, *, remove: bool = False) -> None:
        """Close the file as the last commit left it, or remove it."""
        with suppress(OSError, RuntimeError):  # HDF5 may miss what was never written
            self.file.close()
        if remove:
            with suppress(OSError):
                self._disk.close_as(None)
        self._disk.close()

    def close(self, name: Path | None = None) -> None:
        """Commit everything and close the file.

        Args:
            name: Another name for it. If the file was removed, it is written again.

        Raises:
            ResultError: As for `commit`.
            OSError: It cannot be renamed.
        """
        self.write()
        try:
            with self._clear_errors():
                self._write_sums()
                self.file.close()  # in memory: the commit brings it to the disk
            self._commit()
            self._disk.close_as(name or self.path)
        finally:
            self._disk.close()

    def row_counts(self) -> dict[str, int]:
        """Return how many rows each column has."""
        return {path: column.rows for path, column in self.columns.items()}


def _joined(
    waiting: Sequence[tuple[int, NDArray[Any]]],
) -> Iterator[tuple[int, NDArray[Any]]]:
    """Yield places with rows, those together that follow one another."""
    first = 0
    while first < len(waiting):
        (place, rows), stop = waiting[first], first + 1
        end = place + len(rows)
        while stop < len(waiting) and waiting[stop][0] == end:
            end += len(waiting[stop][1])
            stop += 1
        several = [each for _, each in waiting[first:stop]]
        yield place, rows if len(several) == 1 else np.concatenate(several)
        first = stop


def _entries(dataset: DatasetSpec, value: object) -> NDArray[Any]:
    """Return the entries of a dataset in its type."""
    return np.asarray(value, dtype=dataset.kind or None)


def _fixed_text(text: str) -> NDArray[Any]:
    """Return a text that can be overwritten by others of about its length.

    HDF5 gives back the space neither of texts of variable length nor of text attributes, so
    that a text written again and again has a fixed length, filled up with zeros.
    """
    data = text.encode()
    return np.array(data, dtype=h5py.string_dtype(length=512 * (len(data) // 512 + 1)))


def describe(dataset: h5py.Dataset, unit: str, description: str) -> None:
    """Write the two attributes that every dataset has to a new dataset.

    Args:
        description: What it contains.
    """
    for name, text in ((b"unit", unit), (b"description", description)):
        add_text(dataset, name, text)


def member_name(name: str) -> str:
    """Return ``name`` as the name of one member of a group: no path, no "this folder"."""
    plain = name.replace("%", "%25").replace("/", "%2F").replace("\0", "%00")
    return plain if plain.strip(".") else plain.replace(".", "%2E")


def _no_space(path: Path, needed: int, error: OSError) -> str:
    if error.errno is None:
        return f'cannot write "{path}": {error}'
    free = shutil.disk_usage(path.parent).free
    message = (
        f'cannot write "{path}": {error.strerror}; {shown_size(needed)} are needed, '
        f"{shown_size(free)} are free on that disk"
    )
    if not path.stat().st_size:
        return message
    return (
        f"{message}. The file keeps what was written before: free space and run again; "
        "--resume "
        "continues from the last checkpoint, if there is one"
    )
