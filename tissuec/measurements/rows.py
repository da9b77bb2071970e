"""The rows of data that count, each known by its line, and diagnostics that quote them."""

from collections.abc import Generator, Sequence
from contextlib import contextmanager
from typing import NoReturn

import numpy as np
from msgspec import Struct, field

from tissuec.core.errors import CompileError, Diagnostic
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.core.text_tables.table import TextTable
from tissuec.core.units import LENGTH, TIME, show
from tissuec.model.network import Floats, Indices
from tissuec.script.fit_problem import Data, Fit

#: More names would hide the message.
_MOST_NAMED = 30


class Complaints(Struct, frozen=True):
    """All errors of one file.

    Attributes:
        is_alone: Whether it is the only file of its learn block.
    """

    data: Data
    is_alone: bool = True
    found: list[Diagnostic] = field(default_factory=list[Diagnostic])

    @property
    def file(self) -> str:
        return self.data.path.name

    def reject(
        self, code: str, message: str, span: Span | None = None, hint: str = ""
    ) -> NoReturn:
        """Report an error, at the name of the file if no other place is given.

        Args:
            code: Code of the diagnostic.
            message: What is wrong.
            span: Place in the text.
            hint: How to fix it.

        Raises:
            CompileError: Always.
        """
        raise CompileError([Diagnostic(code, message, span or self.data.span, hint)])

    @contextmanager
    def part(self) -> Generator[None]:
        """Collect the errors of one part, and continue with the next."""
        try:
            yield
        except CompileError as error:
            told = {(one.message, one.span) for one in self.found}
            self.found.extend(d for d in error.diagnostics if (d.message, d.span) not in told)

    def settle(self) -> None:
        """Report all errors so far.

        Raises:
            CompileError: There are errors.
        """
        if self.found:
            raise CompileError(self.found)


#: What to do with files of which each has something else.
TWO_MACHINES = (
    "every file needs the columns of all fits; use a learn block for each machine, or, if "
    "both measured one motion, put its rows into one table with empty cells"
)


def first_few(names: Sequence[str]) -> list[str]:
    """Return names for a hint, not more than can be read."""
    return [*names[:_MOST_NAMED], *(["…"] if len(names) > _MOST_NAMED else [])]


class DataRows(Struct, frozen=True, eq=False):
    """The rows of a table.

    Attributes:
        places: Times [s], or displacements [m] if there is no time, shape (row,).
        values: As they are written, shape (row, column); the first column is that of
            ``places``.
        number: Of each row in the text, from 0, shape (row,).
        span: Where the column of ``places`` is named.
        timed: Whether there is a time.
    """

    table: TextTable
    complaints: Complaints
    places: Floats
    values: Floats
    number: Indices
    span: Span
    timed: bool

    @classmethod
    def of(
        cls, table: TextTable, complaints: Complaints, places: Floats, values: Floats,
        span: Span, timed: bool,
    ) -> "DataRows":  # fmt: skip
        """Return the rows that have values.

        Args:
            places: Times [s], or displacements [m], shape (row,).
            values: Cells in the units of the text, shape (row, column).
            span: Place at which the column of ``places`` is named.
            timed: Whether there is a time.

        Raises:
            CompileError: There is none, or one with values but without a time.
        """
        no_place = np.isnan(places)
        says = ~np.isnan(values[:, 1:]).all(axis=1)
        if (no_place & says).any():
            row = int(np.flatnonzero(no_place & says)[0])
            what = "time" if timed else "displacement"
            complaints.reject("TIS313", f"{table.place(row)} has no {what}", span)
        rows = np.flatnonzero(~no_place)
        if not len(rows):
            hint = f"the columns are {', '.join(table.names)}"
            message = f"{table.file} contains no row of numbers"
            complaints.reject("TIS313", message, span, hint)
        return cls(table, complaints, places[rows], values[rows], rows, span, timed)

    def in_order(self) -> "DataRows":
        """Return the rows of a table that has one for each time; displacements are sorted.

        Raises:
            CompileError: The times do not ascend.
        """
        if not self.timed:
            order = np.argsort(self.places, kind="stable")
            parts = {
                name: getattr(self, name)[order] for name in ("places", "values", "number")
            }
            return replace(self, **parts)
        wrong = np.flatnonzero(np.diff(self.places) <= 0.0)
        if len(wrong):
            self._reject_order(int(wrong[0]))
        return self

    def _reject_order(self, row: int) -> NoReturn:
        before, behind = self.places[row], self.places[row + 1]
        if before == behind:
            problem = f"have the same time, {self._shown(row)}"
            hint = "remove one of them; for one row per node, also name the column of the nodes"
        else:
            problem = f"do not ascend: {show(behind, TIME)} comes after {show(before, TIME)}"
            hint = "sort the rows by time, each time once"
        where = self.table.places(*self.number[[row, row + 1]].tolist())
        self.complaints.reject("TIS313", f"{where} {problem}", self.span, hint)

    def _shown(self, row: int) -> str:
        return show(float(self.places[row]), TIME if self.timed else LENGTH, digits=6)

    def once(self, fit: Fit, columns: Floats) -> tuple[Floats, Floats]:
        """Return each time once with its values, in a table of several rows for each time.

        Args:
            columns: Of the fit in SI units, shape (column, row).

        Returns:
            Times [s], shape (time,), and columns, shape (column, time).

        Raises:
            CompileError: Two rows of one time have different values.
        """
        times, at = np.unique(self.places, return_inverse=True)
        merged = np.full((len(columns), len(times)), np.nan)
        for line, column in zip(merged, columns, strict=True):
            known = np.flatnonzero(~np.isnan(column))
            first = np.full(len(times), -1)
            # Of several that are put into one place the last one stays: the uppermost.
            first[at[known[::-1]]] = known[::-1]
            line[first >= 0] = column[first[first >= 0]]
            differs = known[column[known] != line[at[known]]]
            if len(differs):
                self.reject_twice(int(first[at[differs[0]]]), int(differs[0]), fit.text)
        return times, merged

    def reject_twice(self, row: int, other: int, what: str) -> NoReturn:
        """Report that two rows give a value for the same quantity at the same time.

        Args:
            row: Index of one row.
            other: Index of the other.
            what: Name of the quantity.
        """
        where = self.table.places(*self.number[[row, other]].tolist())
        message = f"{where} both give {what} at {self._shown(row)}"
        hint = "remove one of them"
        self.complaints.reject("TIS313", message, self.span, hint)


#: Longer runs of multiples than whole numbers can count are those of a wrong unit.
_MOST = 2.0**62
#: By which part of a multiple a row in the middle between two may be off.
_ROUNDING = 1e-9


def nearest_rows(times: Floats, every: float | None) -> Indices:
    """Return the rows whose times are nearest to the multiples of a time, ascending.

    Each row belongs to the multiple that it is nearest to, the lower one of two; of those of
    one multiple the nearest is taken, so none twice, and a multiple with no row near has none.
    Nothing is interpolated and nothing averaged: the values are those that were measured, with
    their noise.

    Args:
        times: Ascending [s], shape (row,).
        every: [s]; None: all rows.
    """
    if every is None or not len(times):
        return np.arange(len(times))
    multiple = np.clip(np.ceil(times / every - 0.5 - _ROUNDING), -_MOST, _MOST)
    off = np.abs(times - multiple * every)
    order = np.lexsort((off, multiple))
    _, first = np.unique(multiple[order], return_index=True)
    return np.sort(order[first])
