"""The dialect of a table: separators of its cells, and names of its columns.

Cells are parted by tabs, semicolons, commas or blanks; where commas part none of them, decimals
may have commas. Lines that begin with ``#`` are remarks; the last one above rows without a
header is the header if it has as many names.
"""

import csv
import math
import re
from collections.abc import Iterator
from typing import NamedTuple

BLANK = " "
_DELIMITERS = ("\t", ";", ",", BLANK)
#: What stands where nothing was measured.
GAPS = frozenset(("", "nan", "-nan", "+nan", "na", "n/a", "-", "null"))
# A unit in brackets, which is short, belongs to the name before it.
_CELL = re.compile(r'"[^"]*"?|[^\s"]+(?:\s+[\[(][^\])]{0,99}[\])])?')


class Dialect(NamedTuple):
    """The format of a table.

    Attributes:
        delimiter: What parts cells; ``BLANK`` means any number of blanks or tabs.
        names: Of the columns; their numbers from 1 if there is no header.
        named: Whether there is a header.
        start: Offset in the text behind the header.
    """

    delimiter: str
    names: tuple[str, ...]
    named: bool
    start: int


class TableLine(NamedTuple):
    """One line of a text that is no remark and not empty."""

    start: int
    end: int
    text: str


def is_row(line: str) -> bool:
    """Return whether a line is neither empty nor a remark."""
    stripped = line.lstrip()
    return bool(stripped) and stripped[0] != "#"


def lines_of(text: str, start: int = 0) -> Iterator[TableLine]:
    """Yield the rows of a text from an offset on, one by one."""
    while start < len(text):
        end = text.find("\n", start)
        end = len(text) if end < 0 else end
        if is_row(text[start:end]):
            yield TableLine(start, end, text[start:end])
        start = end + 1


def cells_of(line: str, delimiter: str) -> list[str]:
    """Return the cells of a row, without quotes and without blanks around them."""
    if delimiter == BLANK:
        return [cell.strip('"') for cell in _CELL.findall(line)]
    if '"' not in line:
        return [cell.strip() for cell in line.split(delimiter)]
    try:
        row = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))
    except csv.Error:  # a cell of 100 000 characters
        return [line]
    return [cell.strip() for cell in row]


def as_number(cell: str) -> float | None:
    """Return a cell as a finite number, NaN for a gap, or None if it is neither."""
    if cell.lower() in GAPS:
        return math.nan
    # Python also reads 1_000 and digits of other scripts.
    if "_" in cell or not cell.isascii():
        return None
    try:
        value = float(cell.replace(",", "."))
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def find_dialect(text: str) -> Dialect | None:
    """Return how a table is written; None if there is no line in it."""
    rows = lines_of(text)
    first = next(rows, None)
    if first is None:
        return None
    # Of a row of numbers: "0,5 1,5" are two cells, and "0,5" too: commas come before decimals.
    numeric = [(cells_of(first.text, d), d) for d in _DELIMITERS]
    numeric = [(cells, d) for cells, d in numeric if _are_numbers(cells)]
    if numeric:
        cells, delimiter = max(numeric, key=lambda pair: len(pair[0]))
        names = _remark_above(text, first.start, delimiter, len(cells))
        numbers = tuple(str(i + 1) for i in range(len(cells)))
        return Dialect(delimiter, names or numbers, bool(names), first.start)
    second = next(rows, None)
    delimiter = _of_header(first.text, first.text if second is None else second.text)
    return Dialect(delimiter, tuple(cells_of(first.text, delimiter)), True, first.end + 1)


def _are_numbers(cells: list[str]) -> bool:
    """Return whether cells are numbers and gaps, and not gaps alone."""
    return all(map(_is_number, cells)) and any(cell.lower() not in GAPS for cell in cells)


def _of_header(header: str, row: str) -> str:
    """Return what parts a header and the row below it into as many cells, most of them numbers.

    Names may hold commas and blanks, and so may numbers with decimal commas.
    """
    widths = {d: len(cells_of(header, d)) for d in _DELIMITERS}
    found = [(cells_of(row, d), d) for d in _DELIMITERS if widths[d] > 1]
    agree = [(cells, d) for cells, d in found if len(cells) == widths[d]]
    if agree:
        return max(agree, key=lambda pair: sum(map(_is_number, pair[0])))[1]
    return found[0][1] if found else BLANK


def _is_number(cell: str) -> bool:
    return as_number(cell) is not None


def _remark_above(text: str, end: int, delimiter: str, width: int) -> tuple[str, ...]:
    """Return the names in the remark that ends before an offset, if there are so many."""
    above = text[:end].rstrip("\n").rpartition("\n")[2].strip()
    names = cells_of(above.lstrip("#").strip(), delimiter) if above[:1] == "#" else []
    return tuple(names) if len(names) == width and not _are_numbers(names) else ()
