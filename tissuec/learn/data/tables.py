"""Tables as text: selection of columns, and evaluation of their rows."""

from collections.abc import Sequence

import numpy as np

from tissuec.core.files import read_bytes
from tissuec.core.text_tables.columns import BadRow, line_number, read_columns
from tissuec.core.text_tables.dialect import decoded
from tissuec.core.text_tables.heads import find_dialect
from tissuec.core.text_tables.odd_cells import GAP, gap_mark
from tissuec.learn.data.complaints import TWO_MACHINES, Complaints
from tissuec.learn.data.experiment import Series
from tissuec.learn.data.header import Wanted, find_columns
from tissuec.learn.data.long import LONG, is_long, read_long
from tissuec.learn.data.nodes import nodes_of
from tissuec.learn.data.rows import DataRows, Text
from tissuec.learn.data.thinning import nearest_rows
from tissuec.model.network import Floats, Network
from tissuec.script.fit_problem import DataAxis, Fit

LARGEST_TABLE = 1 << 30  # bytes
FEWEST_EQUAL = 4  # values; fewer may agree by rounding


def read_table(
    axis: DataAxis, fits: Sequence[Fit], network: Network, complaints: Complaints
) -> list[Series]:
    """Return the series of every fit in a table; errors of single fits go to ``complaints``.

    Raises:
        CompileError: No fit can be read.
    """
    text = _text(complaints)
    dialect = find_dialect(text)
    if dialect is None:
        complaints.reject("TIS313", f"{complaints.file} is empty")
    wanted = find_columns(dialect, axis, fits, complaints)
    rows = _rows(Text(text, dialect, complaints), wanted, timed=axis.nodes is None)
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


def _text(complaints: Complaints) -> str:
    """Return the text of a file; its lines end with one sign."""
    try:
        raw = read_bytes(complaints.data.path, LARGEST_TABLE)
    except OSError as error:
        complaints.reject("TIS604", f"cannot read {complaints.file}: {error.strerror}")
    text = decoded(raw)
    if text is None:
        message = f"{complaints.file} is neither text nor HDF5"
        hint = "data is a table as text (CSV), a result of tissuec or an H5MD file"
        complaints.reject("TIS604", message, hint=hint)
    return text


def _rows(table: Text, wanted: Wanted, *, timed: bool) -> DataRows:
    """Return the rows that say something, with the wanted columns."""
    try:
        numbers = read_columns(table.text, table.dialect, wanted.numbers)
    except BadRow as error:
        where, span, hint = table.line(error.row), None, "comments begin with #"
        if error.remedy:
            hint = f"{error.remedy}; {hint}"
        if error.column is not None:
            name = table.dialect.names[wanted.numbers[error.column]]
            where += f', column "{name}"'
            span = wanted.spans[error.column]
        table.complaints.reject("TIS313", f"{where}: {error.problem}", span, hint)
    return DataRows.of(table, numbers[:, 0] * wanted.factor, numbers, wanted.spans[0], timed)


def _refuse_marks(fit: Fit, columns: Floats, rows: DataRows) -> None:
    """Reject numbers that stand for gaps, such as -9999.

    Args:
        columns: Of the fit as they are written, shape (column, row).

    Raises:
        CompileError: There is one.
    """
    for column, values in list(zip(fit.columns, columns, strict=True))[is_long(fit) :]:
        row = gap_mark(values)
        if row is None:
            continue
        where = f'{rows.table.line(int(rows.number[row]))}, column "{column.name}"'
        message = (
            f"{where}: {values[row]:g} is far from all other numbers, as marks of gaps are"
        )
        hint = f"{GAP}; if it was measured, remove its row"
        rows.table.complaints.reject("TIS313", message, column.span, hint)


def _units(fit: Fit) -> Floats:
    """Return what one of the unit of each column is in SI, shape (column, 1); ids have none."""
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
            rows.table.complaints.reject(
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
        line_number(table.text, table.dialect, int(row))
        for row in (rows.number.min(), rows.number.max())
    )
    lines = f"from line {first} to line {last} of {table.file}"
    called = " ".join(column.name for column in columns)
    plural = len(columns) > 1
    name = f'columns "{called}" are' if plural else f'column "{called}" is'
    span = columns[0].span.to(columns[-1].span)
    if not len(known):
        message = f"{name} empty {lines}: {fit.text} has no value"
        alone = "name another column, or remove the fit"
        hint = alone if table.complaints.is_alone else TWO_MACHINES
    else:
        message = f"{name} constant {lines}: {fit.text} does not change"
        hint = (
            "a sensor that is off or out of range shows this: name another column, or remove "
            "the fit; if the quantity is at rest, keep its value in one row only"
        )
    table.complaints.reject("TIS313", message, span, hint)


def _thinned(one: Series) -> Series:
    """Return the rows that are used; gaps are none where only some are."""
    if one.fit.every is None:
        return one
    known = np.flatnonzero(one.known)
    return one.at(known[nearest_rows(one.times[known], one.fit.every)])
