"""Columns of numbers from the text of a table: fast for plain rows, exact about odd cells."""

import re
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.core.text_tables.dialect import (
    BLANK,
    Dialect,
    as_number,
    cells_of,
    is_row,
    lines_of,
)
from tissuec.core.units import UnitError, parse_unit

Floats = NDArray[np.float64]

#: Characters that are converted at a time, so that memory holds numbers rather than cells.
_BLOCK = 1 << 23
#: How gaps are mostly written; others take the longer way.
_WORDS = ("NA", "-")
#: Characters of rows of numbers and gaps, shape (256,).
_PLAIN = np.isin(np.arange(256), list(b"0123456789+-.eEnaNA, \n"))


class BadRow(Exception):
    """A row is wrong.

    Attributes:
        row: From 0, counted without header, remarks and empty lines.
        column: Among the wanted ones; None if it is the row as a whole.
        problem: What is wrong, after the name of the line.
        remedy: What to do about it, if that is known.
    """

    def __init__(self, row: int, column: int | None, problem: str, remedy: str = ""):
        self.row, self.column, self.problem, self.remedy = row, column, problem, remedy
        super().__init__(problem)


class ColumnCells(NamedTuple):
    """Cells of a block of rows: numbers, shape (row, wanted), and decimal signs."""

    numbers: Floats
    signs: frozenset[str]


def read_columns(text: str, dialect: Dialect, wanted: Sequence[int]) -> Floats:
    """Return some columns of a table in the units of the text, shape (row, wanted).

    Empty cells are NaN.

    Args:
        wanted: Numbers of the columns.

    Raises:
        BadRow: It has another number of cells than there are columns, one of the wanted cells
            is no finite number, or some decimals are written with points and others with
            commas.
    """
    parts: list[Floats] = []
    signs: frozenset[str] = frozenset()
    row = 0
    for block in _blocks(text, dialect.start):
        cells = _plain(block, dialect, wanted) or _by_cell(block, dialect, wanted, row)
        if len(signs | cells.signs) > 1:
            raise BadRow(
                *_mixed(text, dialect, wanted),
                "decimals have points in some rows and commas in others",
                "write them all with points",
            )
        signs |= cells.signs
        parts.append(cells.numbers)
        row += len(cells.numbers)
    return np.concatenate(parts) if parts else np.zeros((0, len(wanted)))


def _blocks(text: str, start: int) -> Iterator[str]:
    """Yield whole lines, about as many as a block holds."""
    while start < len(text):
        end = text.find("\n", start + _BLOCK)
        end = len(text) if end < 0 else end
        yield text[start:end]
        start = end + 1


# --- rows of nothing but numbers --------------------------------------------------------------


def _plain(block: str, dialect: Dialect, wanted: Sequence[int]) -> ColumnCells | None:
    """Return the cells by one conversion of the whole block, or None if it is not so plain."""
    width = len(dialect.names)
    if width < 2 or '"' in block or "#" in block or not block.isascii():
        return None
    point, comma = "." in block, "," in block and dialect.delimiter != ","
    if point and comma:
        return None
    signs = frozenset("." if point else ("," if comma else ""))
    rows = _canonical(block.replace(",", ".") if comma else block, dialect.delimiter)
    marks = np.frombuffer(f"{rows}\n".encode(), dtype=np.uint8)
    if not _PLAIN[marks].all():
        return None
    ends = marks[(marks == ord(",")) | (marks == ord("\n"))] == ord("\n")
    if ends.size % width:
        return None
    ends = ends.reshape(-1, width)
    if not ends[:, -1].all() or ends[:, :-1].any():
        return None
    numbers = _converted(rows, ends.size)
    return (
        None if numbers is None else ColumnCells(numbers.reshape(-1, width)[:, wanted], signs)
    )


def _canonical(block: str, delimiter: str) -> str:
    """Return rows with one comma between cells; only whole-text replacements are fast."""
    if delimiter != BLANK:
        return block.replace(delimiter, ",").rstrip("\n")
    block = block.replace("\t", " ")
    # Runs of blanks halve in each round.
    while "  " in block:
        block = block.replace("  ", " ")
    return block.replace(" \n", "\n").replace("\n ", "\n").strip(" \n").replace(" ", ",")


def _converted(rows: str, count: int) -> Floats | None:
    """Return all numbers of canonical rows, or None if one of the cells is none."""
    cells = f",{rows},".replace("\n", ",")
    for blank in (" ,", ", "):
        while blank in cells:
            cells = cells.replace(blank, ",")
    if " " in cells:  # which NumPy would pass over
        return None
    for gap in ("", *_WORDS):
        for _ in range(2):  # the second time for every other gap of several side by side
            cells = cells.replace(f",{gap},", ",nan,")
    try:
        # NumPy stops at what is no number; a last one shows whether it came so far.
        numbers = np.fromstring(cells[1:-1] + ",0", sep=",")
    except (ValueError, DeprecationWarning):
        return None
    return None if numbers.size != count + 1 or np.isinf(numbers).any() else numbers[:-1]


# --- rows of anything -------------------------------------------------------------------------


def _by_cell(block: str, dialect: Dialect, wanted: Sequence[int], first: int) -> ColumnCells:
    """Return the cells one by one; ``first`` is the number of the first row of the block."""
    width = len(dialect.names)
    rows = [cells_of(line, dialect.delimiter) for line in block.split("\n") if is_row(line)]
    for number, row in enumerate(rows, first):
        if len(row) != width:
            cells = f"{len(row)} cell{'' if len(row) == 1 else 's'}"
            problem = f"{cells} where there are {width} columns"
            raise BadRow(number, None, problem, TOO_MANY if len(row) > width else "")
    numbers = np.empty((len(rows), len(wanted)))
    signs: set[str] = set()
    for place, column in enumerate(wanted):
        cells = [row[column] for row in rows]
        values = [as_number(cell) for cell in cells]
        if None in values:
            bad = values.index(None)
            problem = f'"{cells[bad]}" is not a finite number'
            raise BadRow(first + bad, place, problem, remedy(cells[bad]))
        if dialect.delimiter == "," and any(map(is_ambiguous, cells)):
            bad = next(n for n, cell in enumerate(cells) if is_ambiguous(cell))
            text = cells[bad]
            problem = f'"{text}" can be {text.replace(",", "")} or {text.replace(",", ".")}'
            raise BadRow(first + bad, place, problem, "write decimals with points")
        numbers[:, place] = values
        signs |= set("".join(cells)) & {".", ","}
    return ColumnCells(numbers, frozenset(signs))


def _mixed(text: str, dialect: Dialect, wanted: Sequence[int]) -> tuple[int, int | None]:
    """Return row and wanted column of the first decimal with another sign than one before."""
    seen: set[str] = set()
    for row, line in enumerate(lines_of(text, dialect.start)):
        for column, cell in enumerate(cells_of(line.text, dialect.delimiter)):
            if as_number(cell) is not None:
                seen |= set(cell) & {".", ","}
            if len(seen) > 1:
                return row, wanted.index(column) if column in wanted else None
    return 0, None


# Patterns of cells that are no numbers; most tables have none, so they are compiled when used.
_NUMBER = r"[+-]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][+-]?\d+)?"
_CLOCK = r"(?:(\d+):)?(\d{1,2}):(\d{2}(?:[.,]\d+)?)"
_DATE = r"\d{1,4}[-./]\d{1,2}[-./]\d{1,4}(?:[T ].*)?"
_GROUPED = r"[+-]?\d{1,3}(?:([,.' _\u00a0\u2009\u202f])\d{3})(?:\1\d{3})*(?:[.,]\d+)?"
_FORTRAN = r"([+-]?\d*\.?\d*)[dDqQ]([+-]?\d+)"
_FOLLOWED = rf"({_NUMBER})\s*([^\d\s].*)"
_LIMIT = rf"[<>≤≥~≈]=?\s*{_NUMBER}"

GAP = "leave a gap empty, or write nan, NA or -"

#: What programs write where nothing was measured.
MARKS = (
    -999.0, -999.25, -999.9, -9999.0, -9999.25, -9999.9, -99999.0, -999999.0,
    9999.0, 99999.0, 999999.0, -32768.0, 32767.0, 1e20, -1e20, 1e30, -1e30,
)  # fmt: skip
_FEWEST = 3  # values beside a mark, so that it can be far from them


#: What to do about a row with too many cells.
TOO_MANY = "write digits without separators, and units after the names of columns"


def remedy(cell: str) -> str:
    """Return the remedy for a cell that is not a number."""
    text = cell.strip()
    if clock := re.fullmatch(_CLOCK, text):
        hours, minutes, seconds = clock[1] or "0", clock[2], clock[3].replace(",", ".")
        total = 3600 * int(hours) + 60 * int(minutes) + float(seconds)
        return f"write times as numbers, from the start of the test: {total:.12g} for {text}"
    if re.fullmatch(_DATE, text):
        return "write times as numbers, from the start of the test, instead of dates"
    if grouped := re.fullmatch(_GROUPED, text):
        plain = text.replace(grouped[1], "").replace(",", ".")
        return f"write digits without separators: {plain}"
    if "_" in text and re.fullmatch(_NUMBER, plain := text.replace("_", "")):
        return f"write digits without separators: {plain}"
    if re.fullmatch(_NUMBER, text):
        return f"such large numbers are not measurements: {GAP}"
    if fortran := re.fullmatch(_FORTRAN, text):
        return f"write exponents with E: {fortran[1]}E{fortran[2]}"
    if re.fullmatch(_LIMIT, text):
        return f"a limit is not a measured number: {GAP}"
    if followed := re.fullmatch(_FOLLOWED, text):
        number, rest = followed[1], followed[2].strip()
        where = "put it after the name of the column" if _is_unit(rest) else "remove it"
        what = "the unit" if _is_unit(rest) else "the text"
        return f'{what} "{rest}" after {number} is not part of the number: {where}'
    return GAP


def is_ambiguous(cell: str) -> bool:
    """Return whether a cell with a comma can be a decimal or a number of thousands: "1,234".

    No thousands begin with a zero: "0,234" is a decimal.
    """
    grouped = re.fullmatch(_GROUPED, cell)
    return grouped is not None and grouped[1] == "," and not cell.lstrip("+-").startswith("0")


def gap_mark(values: Floats) -> int | None:
    """Return the first row whose number marks a gap, such as -9999; None without one.

    A number of ``MARKS`` counts if it is further from all others than any two of these are
    apart.

    Args:
        values: In the unit of the table [-], NaN for gaps, shape (row,).
    """
    is_mark = np.isin(values, MARKS)
    others = values[~is_mark & ~np.isnan(values)]
    if not is_mark.any() or len(others) < _FEWEST:
        return None
    low, high = float(others.min()), float(others.max())
    beyond = np.maximum(low - values, values - high)
    rows: Sequence[int] = np.flatnonzero(is_mark & (beyond > high - low)).tolist()
    return rows[0] if rows else None


def _is_unit(text: str) -> bool:
    try:
        parse_unit(text)
    except UnitError:
        return text == "%"
    return True
