"""The rows of tables to columns: fast for good rows, exact about the place of bad ones.

A cell ``-`` means "not given" in a column where that is allowed.
"""

import re
from collections.abc import Iterator, Sequence
from itertools import islice
from typing import Any, Literal

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.errors import CompileError, Diagnostic, counted
from tissuec.core.hints import Edit, Hint
from tissuec.core.source import Span
from tissuec.lang.rows import CELL, blank_comments, quoted_rows
from tissuec.lang.syntax import Table
from tissuec.lang.token_names import shown
from tissuec.lang.tree_builder import MOST_PROBLEMS

#: Marks a whole number that is not given.
NOT_GIVEN = np.iinfo(np.int64).min

#: Up to here every whole number has a floating-point number of its own.
_EXACT = 2.0**53

_MISSING = "-"
_KINDS = {"number": "a number", "whole": "a whole number", "word": "a word"}


class ColumnSpec(Struct, frozen=True):
    """Contents of a column.

    Attributes:
        name: What messages call it.
        kind: Numbers become float64, whole numbers int64, words an array of objects.
        optional: Whether a cell may be ``-``: NaN, ``NOT_GIVEN`` or an empty word.
    """

    name: str
    kind: Literal["number", "whole", "word"] = "number"
    optional: bool = False


def read_rows(table: Table, columns: Sequence[ColumnSpec]) -> list[NDArray[Any]]:
    """Return one array in the unit of the text for each column, shape (row,) each.

    Without rows the arrays are empty.

    Raises:
        CompileError: Rows have another number of cells (TIS120), cells are no numbers or names
            (TIS121), or numbers are not finite (TIS122); up to ten are reported.
    """
    values = _numbers_only(table.rows, columns)
    if values is None:
        values = _by_column(table.rows, columns)
    if values is None:
        raise CompileError(_problems(table, columns))
    return values


def _numbers_only(text: str, columns: Sequence[ColumnSpec]) -> list[NDArray[Any]] | None:
    """Return the columns by one conversion of the whole text, or None if it is not so plain."""
    if any(column.kind == "word" for column in columns) or not text.isascii():
        return None
    # In canonical rows, cells end with a blank, and rows with a line end.
    signs = np.frombuffer(f"{text}\n".encode() if text else b"", dtype=np.uint8)
    is_end = signs[signs <= ord(" ")] == ord("\n")
    if is_end.size % len(columns):
        return None
    is_end = is_end.reshape(-1, len(columns))
    if not is_end[:, -1].all() or is_end[:, :-1].any():
        return None
    try:
        values = np.fromstring(text, sep=" ")
    except (ValueError, DeprecationWarning):
        return None
    if values.size != is_end.size or not np.isfinite(values).all():
        return None
    rows = values.reshape(is_end.shape)
    result = [_converted(rows[:, i], column) for i, column in enumerate(columns)]
    return None if any(part is None for part in result) else result  # type: ignore[return-value]


def _by_column(text: str, columns: Sequence[ColumnSpec]) -> list[NDArray[Any]] | None:
    """Return the columns from cells that were split one by one, or None if any is bad."""
    width = len(columns)
    if '"' in text:
        rows = quoted_rows(text)
        fits = all(len(row) == width for row in rows)
        cells = [cell for row in rows for cell in row]
    else:
        fits = not text or all(line.count(" ") == width - 1 for line in text.split("\n"))
        cells = text.replace("\n", " ").split(" ") if text else []
    result: list[NDArray[Any]] = []
    for i, column in enumerate(columns):
        values = _column(cells[i::width], column) if fits else None
        if values is None:
            return None
        result.append(values)
    return result


def _column(cells: list[str], column: ColumnSpec) -> NDArray[Any] | None:
    """Return the values of one column, or None if a cell is bad."""
    if not column.optional and _MISSING in cells:
        return None
    if column.kind == "word":
        words = ["" if cell == _MISSING else cell.strip('"') for cell in cells]
        return np.array(words, dtype=object)
    given = [cell for cell in cells if cell != _MISSING]
    written = "".join(given)
    # Python also reads 1_000, digits of other scripts, and blanks around a number.
    if "_" in written or not (written.isascii() and written.isprintable()):
        return None
    try:
        numbers = np.array([float(cell) for cell in given], dtype=np.float64)
    except ValueError:
        return None
    if not np.isfinite(numbers).all():
        return None
    values = np.full(len(cells), np.nan)
    values[[cell != _MISSING for cell in cells]] = numbers
    return _converted(values, column)


def _converted(values: NDArray[np.float64], column: ColumnSpec) -> NDArray[Any] | None:
    """Return numbers as the type of the column; NaN is not given, None a broken promise."""
    if column.kind == "number":
        return np.ascontiguousarray(values)
    given = np.isfinite(values)
    whole = np.full(values.shape, NOT_GIVEN)
    if np.any(values[given] != np.rint(values[given])) or np.any(abs(values[given]) > _EXACT):
        return None
    whole[given] = values[given].astype(np.int64)
    return whole


def cell_span(table: Table, row: int, column: int) -> Span:
    """Return the place of a cell of rows that were read without error.

    Args:
        row: Index of the row, from 0.
        column: Index of the column, from 0.
    """
    return _places(table.rows_span, {row})[row][column]


# --- what is wrong ----------------------------------------------------------------------------


def _problems(table: Table, columns: Sequence[ColumnSpec]) -> list[Diagnostic]:
    """Return the mistakes in rows and cells, in order."""
    rows = quoted_rows(table.rows)
    # A row that is wrong as a whole is known by column -1.
    fits = [len(row) == len(columns) and not _has_commas(row) for row in rows]
    bad = [(i, -1) for i, fit in enumerate(fits) if not fit]
    fitting = [i for i, fit in enumerate(fits) if fit]
    for number, column in enumerate(columns):
        cells = [rows[i][number] for i in fitting]
        found = islice(_bad_cells(cells, column), MOST_PROBLEMS)
        bad += ((fitting[i], number) for i in found)
    bad = sorted(bad)[:MOST_PROBLEMS]
    places = _places(table.rows_span, {row for row, _ in bad})
    return [
        _bad_row(places[row], columns)
        if number < 0
        else _bad_cell(places[row][number], columns[number])
        for row, number in bad
    ]


def _bad_cells(cells: list[str], column: ColumnSpec, start: int = 0) -> Iterator[int]:
    """Yield the indices of bad cells, by halves, with the test used for whole columns."""
    if _column(cells, column) is not None:
        return
    if len(cells) == 1:
        yield start
        return
    middle = len(cells) // 2
    yield from _bad_cells(cells[:middle], column, start)
    yield from _bad_cells(cells[middle:], column, start + middle)


def _places(rows_span: Span, wanted: set[int]) -> dict[int, list[Span]]:
    """Return the places of the cells of some rows, counted from 0."""
    places: dict[int, list[Span]] = {row: [] for row in wanted}
    number = -1
    between = True
    for cell in CELL.finditer(blank_comments(rows_span.text)):
        if cell[0] in ("\n", ";"):
            between = True
            continue
        number += between
        between = False
        if number in wanted:
            start, end = cell.span()
            place = Span(rows_span.source, rows_span.start + start, rows_span.start + end)
            places[number].append(place)
    return places


def _has_commas(row: Sequence[str]) -> bool:
    """Return whether commas part the cells of a row, and not the digits of a number."""
    return any(cell.endswith(",") for cell in row)


def _bad_row(row: list[Span], columns: Sequence[ColumnSpec]) -> Diagnostic:
    whole = row[0].to(row[-1])
    parted = whole.text.replace(",", " ").split()
    if "," in whole.text and len(parted) == len(columns):
        mended = " ".join(parted)
        hint = Hint(f"write {shown(mended)}", Edit(mended))
        return Diagnostic("TIS120", "cells are separated by blanks, not by commas", whole, hint)
    message = f"this row has {counted(len(row), 'cell')} instead of {len(columns)}"
    hint = f"the columns are {', '.join(column.name for column in columns)}"
    return Diagnostic("TIS120", message, whole, hint)


def _bad_cell(place: Span, column: ColumnSpec) -> Diagnostic:
    cell = place.text
    if cell == _MISSING:
        message = f'"{column.name}" must not be empty here'
        return Diagnostic("TIS121", message, place, f"write {_KINDS[column.kind]}")
    if re.fullmatch(r"[+-]?(nan|inf|infinity|[0-9.]+e\+?[0-9]+)", cell, re.IGNORECASE):
        hint = 'write "-" for an unknown number' if column.optional else ""
        wanted = "a finite number" if column.kind == "number" else "a whole number that fits"
        return Diagnostic("TIS122", f"{shown(cell)} is not {wanted}", place, hint)
    hint: str = f'the column "{column.name}" contains {_KINDS[column.kind]} in each row'
    if "," in cell:
        pointed = cell.replace(",", ".")
        is_number = column.kind == "number" and re.fullmatch(r"-?[0-9]+\.[0-9]+", pointed)
        hint = Hint(
            "write decimals with a point, and separate cells by blanks",
            *([Edit(pointed)] if is_number else []),
        )
    elif re.match(r"[+-]?[0-9.]+ *[^\W\d_]", cell):
        hint = (
            'cells contain numbers only; write their unit after the name of the table: "in mm"'
        )
    return Diagnostic("TIS121", f"{shown(cell)} is not {_KINDS[column.kind]}", place, hint)
