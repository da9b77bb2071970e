"""The file of a table during its study: each row is written when it is known.

A study that is run again takes over the rows whose digests are the same, and does the rest.
A table with rows that it cannot take over stays as it is, unless its end is requested.
"""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Self

from tissuec.core.errors import counted
from tissuec.core.files import OutputFile, final_place
from tissuec.core.structs import replace
from tissuec.results import PlaceError, ResultError
from tissuec.results.places import check_place
from tissuec.scene.study.model import called
from tissuec.studies.table import DIED, Row, StudyHead, rows_of
from tissuec.studies.table_files import is_table
from tissuec.studies.table_text import MARK, as_csv, parse_rows, row_line


class Journal:
    """A table under way; use it in a ``with`` statement.

    Args:
        path: The table.
        head: Of the study.
        digests: Of each of its runs.
        fresh: Whether to begin again.
        known: Rows that are known from elsewhere, by their runs.

    Attributes:
        rows: All rows so far, by the numbers of their runs.

    Raises:
        PlaceError: The table cannot be written there, is that of another study, or another
            study is writing it.
    """

    def __init__(
        self, path: Path, head: StudyHead, digests: Sequence[str], *, fresh: bool,
        known: Mapping[int, Row] | None = None,
    ):  # fmt: skip
        check_place(path)
        if not is_table(path):
            raise PlaceError(
                f'"{path}" does not end with .csv or .h5, the formats of tables; for example: '
                f"-o {path.stem}.csv"
            )
        self.path, self.head = path, head
        self.rows: dict[int, Row] = {}
        self._file: OutputFile | None = None
        try:
            self._file = OutputFile(final_place(path), "append")
            taken = self._taken_over(self._file.readall(), digests, fresh=fresh)
            self.rows = {**(known or {}), **taken}
            self._write()
        except BlockingIOError as error:
            raise PlaceError(
                f'cannot write "{path}": another study is writing it; wait for its end, or '
                f"{_way_out(path)}"
            ) from error
        except OSError as error:
            self.close()
            raise PlaceError(_failure(path, error)) from error
        except PlaceError:
            self.close()
            raise

    def _taken_over(
        self, data: bytes, digests: Sequence[str], *, fresh: bool
    ) -> dict[int, Row]:
        """Return the rows of the file that hold for this study, by their runs."""
        if not data or (fresh and data.startswith(MARK.encode())):
            return {}
        try:
            head, rows = parse_rows(data, self.path)
        except ResultError as error:
            raise PlaceError(f"{error}; remove it, or {_way_out(self.path)}") from error
        return _matching(self.path, head, rows, self.head, digests)

    def _write(self) -> None:
        """Write what is known so far, in the order of the design."""
        assert self._file is not None
        rows = (self.rows[run] for run in sorted(self.rows))
        self._file = self._file.replaced(as_csv(self.head, rows).encode())

    def add(self, row: Row) -> None:
        """Write the row of a run.

        Raises:
            ResultError: It cannot be written, such as on a full disk.
        """
        assert self._file is not None
        line = row_line(row).encode()
        try:
            whole = self._file.write(line) == len(line)
        except OSError as error:
            raise ResultError(_failure(self.path, error)) from error
        if not whole:
            raise ResultError(f'cannot write "{self.path}": no space is left')
        self.rows[row.run] = row

    def finish(self) -> None:
        """Put the rows into the order of the design.

        Raises:
            ResultError: It cannot be written.
        """
        try:
            self._write()
        except OSError as error:
            raise ResultError(_failure(self.path, error)) from error

    def close(self) -> None:
        """Let others write the file."""
        if self._file is not None:
            self._file.close()
            self._file = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *failure: object) -> None:
        self.close()


def rows_in_hdf5(
    path: Path, head: StudyHead, digests: Sequence[str], *, fresh: bool
) -> dict[int, Row]:
    """Return the rows of a table in HDF5 that hold for a study, by their runs.

    Args:
        path: The table, which need not exist.
        digests: Of each of its runs.
        fresh: Whether to discard the rows of any study.

    Raises:
        PlaceError: The file is no table, that of another study, or cannot be written.
    """
    from tissuec.studies.table_hdf5 import read_hdf5

    check_place(path)
    if not path.exists():
        return {}
    try:
        table = read_hdf5(path)
    except ResultError as error:
        raise PlaceError(f"{error}; remove it, or {_way_out(path)}") from error
    return {} if fresh else _matching(path, table.head, rows_of(table), head, digests)


def _matching(
    path: Path, head: StudyHead, rows: Iterable[Row], own: StudyHead, digests: Sequence[str]
) -> dict[int, Row]:
    """Return the rows of a table that hold for a study, by their runs.

    Args:
        path: What messages call the table.
        head, rows: What it holds.
        digests: Of each of its runs.
    """
    way_out = f"{_way_out(path)}; --fresh discards the table"
    if (head.name, head.scene) != (own.name, own.scene):
        raise PlaceError(
            f'"{path}" is the table of {called(head.name)} of {head.scene}; {way_out}'
        )
    places: dict[str, list[int]] = {}
    for run, digest in enumerate(digests):
        places.setdefault(digest, []).append(run)
    rows = [row for row in rows if row.outcome != DIED]
    others = sum(row.digest not in places for row in rows)
    if others:
        raise PlaceError(
            f'"{path}" has {counted(others, "run")} with other values, or of another text of '
            f"the scene or version of tissuec; {way_out}"
        )
    return {run: replace(row, run=run) for row in rows for run in places[row.digest]}


def _way_out(path: Path) -> str:
    return f"write to another file: -o other{path.suffix.lower()}"


def _failure(path: Path, error: OSError) -> str:
    return f'cannot write "{path}": {(error.strerror or str(error)).lower()}'
