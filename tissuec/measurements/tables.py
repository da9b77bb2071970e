"""Tables as text: selection of columns, and evaluation of their rows."""

import re
from collections.abc import Mapping, Sequence
from math import isclose
from typing import NoReturn

import numpy as np
from msgspec import Struct

from tissuec.core.errors import counted
from tissuec.core.hints import Edit, Hint, alternatives
from tissuec.core.source import Span
from tissuec.core.text_tables.columns import GAP, BadRow, gap_mark
from tissuec.core.text_tables.dialect import Dialect, decoded, is_count
from tissuec.core.text_tables.table import TextTable
from tissuec.core.units import LENGTH, TIME, Dimension, UnitError, describe, si_unit
from tissuec.measurements.experiment import Series, nodes_of, owners
from tissuec.measurements.rows import (
    TWO_MACHINES,
    Complaints,
    DataRows,
    first_few,
    nearest_rows,
)
from tissuec.model.network import Floats, Indices, Network
from tissuec.script.fit_problem import DataAxis, DataColumn, Fit

_LETTER = re.compile(r"(?:^|[\s_/])[^\W\d_]$")


class Wanted(Struct, frozen=True, eq=False):
    """The columns that are read; the first of them is the axis.

    Attributes:
        numbers: Of them in the table, from 0, each once.
        spans: Where each is named.
        factor: What one of the unit of the axis is in SI.
        places: Of the columns of fits among these.
    """

    numbers: Sequence[int]
    spans: Sequence[Span]
    factor: float
    places: Mapping[DataColumn, int]


def find_columns(
    dialect: Dialect, axis: DataAxis, fits: Sequence[Fit], complaints: Complaints
) -> Wanted:
    """Return the columns that an axis and fits name.

    Raises:
        CompileError: The table has not all of them; every missing one is reported.
    """
    header = _Header(dialect, complaints)
    numbers, spans, factor = [dialect.clock], [complaints.data.span], 1.0
    places: dict[DataColumn, int] = {}
    with complaints.part():
        if axis.column is None:
            factor = header.first_unit(axis)
        else:
            numbers[0], spans[0] = header.find(axis.column), axis.column.span
            factor = axis.column.unit
            header.check_unit(axis.column, numbers[0], TIME if axis.nodes is None else LENGTH)
    for fit in fits:
        with complaints.part():
            if not fit.columns:
                header.reject_unnamed(fit)
        for column in fit.columns:
            with complaints.part():
                number = header.find(column)
                if not (is_long(fit) and column is fit.columns[0]):  # ids have no unit
                    header.check_unit(column, number, fit.dimension)
                if number not in numbers:
                    numbers.append(number)
                    spans.append(column.span)
                places[column] = numbers.index(number)
    complaints.settle()
    return Wanted(numbers, spans, factor, places)


class _Header:
    """The names of the columns of a table."""

    def __init__(self, dialect: Dialect, complaints: Complaints):
        self.names, self.is_named, self.dialect = dialect.names, dialect.named, dialect
        self.complaints = complaints

    @property
    def begin(self) -> str:
        """Return the end of a hint that says where the table begins, if there is text above."""
        if not self.dialect.above:
            return ""
        return (
            f"  (the table begins in line {self.dialect.above + 1}; the lines above are text)"
        )

    def find(self, column: DataColumn) -> int:
        """Return the number of a column; one that no name is may be its number from 1."""
        name = column.name.strip()
        count = self.names.count(name)
        if count > 1:
            self._reject_several(column, name, count)
        if count:
            return self.names.index(name)
        if name.isdecimal() and 1 <= int(name) <= len(self.names):
            return int(name) - 1
        listed = first_few([one for one in self.names if one])
        what = "columns" if self.is_named else "there is no header; columns are numbered"
        hint = alternatives(name, listed, what=what)
        is_alone = self.complaints.is_alone or hint.edits
        other = "" if is_alone else f"  ({TWO_MACHINES})"
        self.complaints.reject(
            "TIS301",
            f'{self.complaints.file} has no column "{name}"',
            column.span,
            hint=Hint(f"{hint}{self.begin}{other}", *hint.edits),
        )

    def _reject_several(self, column: DataColumn, name: str, count: int) -> NoReturn:
        """Reject a name that several columns have."""
        places = [f'"{n}"' for n, one in enumerate(self.names, 1) if one == name]
        known = [place for place in places if place.strip('"') not in self.names]
        hint = Hint(
            f"name one by its number: {' or '.join(first_few(places))}"
            if known
            else "give the columns different names in the file",
            *(
                Edit(place, old=f'"{name}"')
                for place in known
                if f'"{name}"' in column.span.text
            ),
        )
        message = f'{self.complaints.file} has {count} columns "{name}"'
        self.complaints.reject("TIS307", message, column.span, hint)

    def check_unit(self, column: DataColumn, number: int, dimension: Dimension) -> None:
        """Reject a name, or a row of units, that contradicts the unit in the sentence.

        A factor before the unit is taken as written, so it never contradicts the file.

        Args:
            column: As the scene names it; by its number, whatever its name says holds.
            number: Its place in the table, from 0.
            dimension: Of what it holds.
        """
        try:
            unit = self.dialect.unit(number)
        except UnitError:
            return  # brackets hold many things, such as (filtered)
        name = self.names[number]
        if unit is None or column.name.strip() != name:
            return
        is_same = isclose(unit.factor * column.factor, column.unit, rel_tol=1e-12)
        if is_same and unit.dimension == dimension:
            return
        is_letter = not any(self.dialect.units) and _LETTER.search(name) is not None
        if is_letter and (len(name) == 1 or unit.dimension != dimension):
            return  # a symbol, or a label as in "specimen A"
        self.complaints.reject(
            "TIS502",
            f'column "{column.name}" of {self.complaints.file} has another unit than the '
            "one after in",
            column.span,
            hint="write the unit of the column after in; if that is wrong in the file, name "
            f'the column by its number, "{number + 1}"',
        )

    def first_unit(self, axis: DataAxis) -> float:
        """Return the factor from the unit of the first column, in its name, to SI."""
        wanted = TIME if axis.nodes is None else LENGTH
        name = self.names[self.dialect.clock]
        entry = "time" if axis.nodes is None else "displacement of …"
        if wanted == TIME and self.is_named and is_count(name):
            self._reject_count(name)
        hint = f'write, with its own unit: {entry} using column "NAME" in {si_unit(wanted)}'
        first = f'the first column of {self.complaints.file}, "{name}",'
        try:
            unit = self.dialect.unit(self.dialect.clock)
        except UnitError as error:
            message = f"{first} has an unknown unit: {error}"
            self.complaints.reject("TIS104", message, hint=hint)
        if unit is None:
            return 1.0
        if unit.dimension != wanted:
            message = f"{first} ends with the unit of {describe(unit.dimension)}"
            problem = f"{message}; {describe(wanted)} is needed"
            self.complaints.reject("TIS502", problem, hint=hint)
        return unit.factor

    def _reject_count(self, name: str) -> NoReturn:
        """Reject the first column, which counts rows, as the column of times."""
        what = f', "{name}",' if name else ""
        known = name if name and self.names.count(name) == 1 else f"{self.dialect.clock + 1}"
        self.complaints.reject(
            "TIS304",
            f"the first column of {self.complaints.file}{what} counts rows; the time between "
            "them is missing",
            hint=f'write, with the time from one row to the next: time using column "{known}" '
            f"in 10 ms; or name the column of times  columns: "
            f"{', '.join(first_few([one for one in self.names if one]))}",
        )

    def reject_unnamed(self, fit: Fit) -> NoReturn:
        listed = ", ".join(first_few([one for one in self.names if one]))
        self.complaints.reject(
            "TIS304",
            f"{self.complaints.file} is a table; the column of {fit.text} is not given",
            fit.span,
            hint=f'write after it: using column "NAME" in UNIT  columns: {listed}{self.begin}',
        )


FEWEST_EQUAL = 4  # values; fewer may agree by rounding


def read_table(
    data: bytes, axis: DataAxis, fits: Sequence[Fit], network: Network, complaints: Complaints
) -> list[Series]:
    """Return the series of every fit in a table; errors of single fits go to ``complaints``.

    Args:
        data: Content of the file.

    Raises:
        CompileError: No fit can be read.
    """
    text = decoded(data)
    if text is None:
        message = f"{complaints.file} is neither text nor HDF5"
        hint = "data is a table as text (CSV), a result of tissuec or an H5MD file"
        complaints.reject("TIS604", message, hint=hint)
    table = TextTable.of(complaints.file, text)
    if table is None:
        complaints.reject("TIS313", f"{complaints.file} is empty")
    wanted = find_columns(table.dialect, axis, fits, complaints)
    rows = _rows(table, wanted, complaints, timed=axis.nodes is None)
    is_once = not any(map(is_long, fits))
    if is_once:
        rows = rows.in_order()
    series: list[Series] = []
    for fit in fits:
        with complaints.part():
            columns = np.array([rows.values[:, wanted.places[c]] for c in fit.columns])
            _refuse_marks(fit, columns, rows)
            one = _series(fit, columns * _units(fit), rows, network, is_once=is_once)
            _check_varies(one, rows)
            series.append(_thinned(one) if rows.timed else one)
    return series


def _rows(table: TextTable, wanted: Wanted, complaints: Complaints, *, timed: bool) -> DataRows:
    """Return the rows that say something, with the wanted columns."""
    try:
        numbers = table.numbers(wanted.numbers)
    except BadRow as error:
        column, span, hint = None, None, "comments begin with #"
        if error.remedy:
            hint = f"{error.remedy}; {hint}"
        if error.column is not None:
            column, span = wanted.numbers[error.column], wanted.spans[error.column]
        message = f"{table.place(error.row, column)}: {error.problem}"
        complaints.reject("TIS313", message, span, hint)
    times = numbers[:, 0] * wanted.factor
    return DataRows.of(table, complaints, times, numbers, wanted.spans[0], timed)


def _refuse_marks(fit: Fit, columns: Floats, rows: DataRows) -> None:
    """Reject numbers that mark gaps, such as -9999.

    Args:
        columns: Of the fit as they are written, shape (column, row).

    Raises:
        CompileError: There is one.
    """
    for column, values in list(zip(fit.columns, columns, strict=True))[is_long(fit) :]:
        row = gap_mark(values)
        if row is None:
            continue
        where = f'{rows.table.place(int(rows.number[row]))}, column "{column.name}"'
        message = (
            f"{where}: {values[row]:g} is far from all other numbers, as marks of gaps are"
        )
        hint = f"{GAP}; if it was measured, remove its row"
        rows.complaints.reject("TIS313", message, column.span, hint)


def _units(fit: Fit) -> Floats:
    """Return the factor from the unit of each column to SI, shape (column, 1); 1 for ids."""
    units = np.array([[column.unit] for column in fit.columns])
    units[: is_long(fit)] = 1.0
    return units


def _series(
    fit: Fit, columns: Floats, rows: DataRows, network: Network, *, is_once: bool
) -> Series:
    """Return the series of one fit from its columns in SI units, shape (column, row).

    Args:
        is_once: Whether no time has several rows.
    """
    if is_long(fit):
        return read_long(fit, columns, rows, network)
    times, columns = (rows.places, columns) if is_once else rows.once(fit, columns)
    if fit.measure is None:
        nodes = nodes_of(fit.subjects)
        if len(nodes) != 1:
            rows.complaints.reject(
                "TIS313",
                f"{fit.text} has {len(nodes)} nodes, but x, y and z describe one node",
                fit.columns[0].span.to(fit.columns[-1].span),
                hint=f'write a row for each node and time, and: using columns "{LONG}"',
            )
        return Series(fit, times, nodes, columns.T[:, None, :].copy())
    if len(columns) == 1:
        return Series(fit, times, None, columns[0])
    values = columns.T.copy() if fit.along is None else fit.along @ columns
    return Series(fit, times, None, values)


def _check_varies(one: Series, rows: DataRows) -> None:
    """Check that a fit has values, which are not all the same.

    One component may well be constant, such as a coordinate of what moves in a plane.

    Raises:
        CompileError: There is none, or ``FEWEST_EQUAL`` rows and more have the same value.
    """
    fit, columns = one.fit, one.fit.columns
    known = np.flatnonzero(one.known)
    if len(known):
        values = one.values[known].reshape(len(known), -1)
        # A gap differs from no value.
        same = np.isnan(values) | (values == np.nanmax(values, axis=0, initial=-np.inf))
        if len(known) < FEWEST_EQUAL or not same.all():
            return
    table = rows.table
    first, last = (
        table.line_number(int(row)) for row in (rows.number.min(), rows.number.max())
    )
    lines = f"from line {first} to line {last} of {table.file}"
    called = " ".join(column.name for column in columns)
    plural = len(columns) > 1
    name = f'columns "{called}" are' if plural else f'column "{called}" is'
    span = columns[0].span.to(columns[-1].span)
    if not len(known):
        message = f"{name} empty {lines}: {fit.text} has no value"
        alone = "name another column, or remove the fit"
        hint = alone if rows.complaints.is_alone else TWO_MACHINES
    else:
        message = f"{name} constant {lines}: {fit.text} does not change"
        hint = (
            "a sensor that is off or out of range shows this: name another column, or remove "
            "the fit; if the quantity is at rest, keep its value in one row only"
        )
    rows.complaints.reject("TIS313", message, span, hint)


def _thinned(one: Series) -> Series:
    """Return the rows that are used; gaps are none where only some are."""
    if one.fit.every is None:
        return one
    known = np.flatnonzero(one.known)
    return one.at(known[nearest_rows(one.times[known], one.fit.every)])


#: How the columns of a long table are written.
LONG = "node x y z"


def is_long(fit: Fit) -> bool:
    """Return whether a fit names a column of nodes."""
    return fit.measure is None and len(fit.columns) == len(LONG.split())


def read_long(fit: Fit, columns: Floats, rows: DataRows, network: Network) -> Series:
    """Return positions of nodes from a table with a row for each node and time.

    Rows of other nodes of the same bodies are ignored, and so are rows without a position.

    Args:
        columns: Ids of nodes and positions [m], shape (4, row).
        rows: The rows that count.

    Raises:
        CompileError: A cell is no id, no node has the id, or a node has two rows at a time.
    """
    chosen = np.flatnonzero(~np.isnan(columns[1:]).all(axis=0))
    ids = _ids(fit, columns[0], chosen, rows)
    wanted = nodes_of(fit.subjects)
    number, known = _numbers(fit, ids, wanted, rows, network)
    _check_known(fit, ids[~known], rows, network)
    inside = number >= 0
    chosen, number = chosen[inside], number[inside]
    times, at = np.unique(rows.places[chosen], return_inverse=True)
    nodes, column = np.unique(number, return_inverse=True)
    place = at * len(nodes) + column
    _check_once(chosen, place, columns[0], rows)
    values = np.full((len(times) * len(nodes), 3), np.nan)
    values[place] = columns[1:, chosen].T
    return Series(fit, times, nodes, values.reshape(len(times), len(nodes), 3))


def _ids(fit: Fit, column: Floats, chosen: Indices, rows: DataRows) -> Indices:
    """Return the ids in some rows of a column, shape (chosen,)."""
    written = column[chosen]
    with np.errstate(invalid="ignore"):
        bad = np.flatnonzero(~(written == np.rint(written)) | (np.abs(written) > 2.0**53))
    if len(bad):
        value, row = written[bad[0]], int(rows.number[chosen[bad[0]]])
        problem = "no node" if np.isnan(value) else f"the node {value:g}, which is not an id"
        message = f"{rows.table.place(row)} has {problem}"
        hint = "ids of nodes are whole numbers"
        rows.complaints.reject("TIS313", message, fit.columns[0].span, hint)
    return written.astype(np.int64)


def _numbers(
    fit: Fit, ids: Indices, wanted: Indices, rows: DataRows, network: Network
) -> tuple[Indices, np.ndarray]:
    """Return numbers of the wanted nodes that ids mean, -1 of others, and which are ids at all.

    Both have shape (id,).
    """
    order = np.argsort(network.node_ids[wanted], kind="stable")
    listed = network.node_ids[wanted][order]
    twice = np.flatnonzero(np.diff(listed) == 0)
    if len(twice):
        names = " and ".join(body.name for body in owners(network, wanted))
        rows.complaints.reject(
            "TIS313",
            f"the id {listed[twice[0]]} belongs to several nodes of {fit.text}",
            fit.span,
            hint=f"fit the positions of {names} separately, from separate files",
        )
    place = np.minimum(np.searchsorted(listed, ids), len(listed) - 1)
    hit = listed[place] == ids
    every = [network.node_ids[body.nodes] for body in owners(network, wanted)]
    return np.where(hit, wanted[order][place], -1), np.isin(ids, np.concatenate(every))


def _check_known(fit: Fit, unknown: Indices, rows: DataRows, network: Network) -> None:
    if not len(unknown):
        return
    names = np.unique(unknown).astype(str).tolist()
    bodies = owners(network, nodes_of(fit.subjects))
    has = "; ".join(_range_of(body.name, network.node_ids[body.nodes]) for body in bodies)
    rows.complaints.reject(
        "TIS301",
        f"{rows.table.file} contains {counted(len(names), 'node')} that "
        f"{' and '.join(body.name for body in bodies)} does not have: "
        f"{', '.join(first_few(names))}",
        fit.columns[0].span,
        hint=has,
    )


def _range_of(name: str, ids: Sequence[int] | Indices) -> str:
    return f"ids of {name} run from {min(ids)} to {max(ids)}"


def _check_once(chosen: Indices, place: Indices, ids: Floats, rows: DataRows) -> None:
    """Check that no node has two rows at a time."""
    order = np.argsort(place, kind="stable")
    twice = np.flatnonzero(np.diff(place[order]) == 0)
    if len(twice):
        row, other = chosen[order[twice[0]]], chosen[order[twice[0] + 1]]
        rows.reject_twice(int(row), int(other), f"node {ids[row]:g}")
