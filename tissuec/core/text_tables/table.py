"""A table in a file of text: its head, and its lines and columns, which messages name.

The names of the columns are in the first line, unless that is a row of numbers. If the first
two lines do not fit together, the table begins further down, at the first two rows of equally
many numbers, and the names are in the line above: instruments write remarks about the test,
OpenSim a block that ends with ``endheader``. Between names and numbers there can be a row of
units. Two kinds of heads have rows of their own: TRC files of motion capture (markers and
axes), and tables of DeepLabCut (body parts and coordinates).
"""

from collections.abc import Sequence
from itertools import islice
from typing import Self

from msgspec import Struct

from tissuec.core.text_tables.columns import Floats, read_columns
from tissuec.core.text_tables.dialect import (
    DELIMITERS,
    GAPS,
    Dialect,
    TableLine,
    as_number,
    cells_of,
    is_unit,
    lines_of,
)


class TextTable(Struct, frozen=True, eq=False):
    """A table as it was read.

    Attributes:
        file: What messages call the file.
        text: Its text.
        dialect: Names and separators of its columns, and where its rows begin.
    """

    file: str
    text: str
    dialect: Dialect

    @classmethod
    def of(cls, file: str, text: str, delimiters: Sequence[str] = DELIMITERS) -> "Self | None":
        """Return the table in a text; None if there is no line in it.

        Args:
            file: What messages call the file.
            delimiters: What can separate cells.
        """
        dialect = find_dialect(text, delimiters)
        return None if dialect is None else cls(file, text, dialect)

    @property
    def names(self) -> tuple[str, ...]:
        """Return the names of the columns, or their numbers."""
        return self.dialect.names

    def numbers(self, columns: Sequence[int]) -> Floats:
        """Return the numbers of some columns, as `read_columns` does.

        Args:
            columns: Their places, from 0.

        Returns:
            In the units of the text, NaN for gaps, shape (row, column).

        Raises:
            BadRow: A row or a cell is wrong.
        """
        return read_columns(self.text, self.dialect, columns)

    def cells(self) -> list[list[str]]:
        """Return the cells of all rows as texts."""
        lines = lines_of(self.text, self.dialect.start)
        return [cells_of(line.text, self.dialect.delimiter) for line in lines]

    def line_number(self, row: int) -> int:
        """Return the line, from 1, of a row, from 0.

        Raises:
            IndexError: There is no such row.
        """
        for number, line in enumerate(lines_of(self.text, self.dialect.start)):
            if number == row:
                return self.text.count("\n", 0, line.start) + 1
        raise IndexError(row)

    def place(self, row: int, column: int | None = None) -> str:
        """Return how messages call a row, or a cell of it: ``line 3 of a.csv, column "x"``."""
        line = f"line {self.line_number(row)} of {self.file}"
        return line if column is None else f'{line}, column "{self.names[column]}"'

    def places(self, row: int, other: int) -> str:
        """Return how messages call two rows, the upper one first."""
        first, second = sorted(map(self.line_number, (row, other)))
        return f"lines {first} and {second} of {self.file}"


_HIGHEST = 200  # lines of a head; what is longer is no head
_TRC, _DEEPLABCUT = "PathFileType", "scorer"


def find_dialect(text: str, delimiters: Sequence[str] = DELIMITERS) -> Dialect | None:
    """Return the dialect of a table; None if there is no line in it.

    Args:
        delimiters: What can separate its cells.
    """
    lines = list(islice(lines_of(text), _HIGHEST))
    if not lines:
        return None
    first = lines[0].text
    begin = first.split("\t" if "\t" in first else ",")[0].strip().strip('"')
    if begin == _TRC:
        return _of_markers(lines)
    # Of a row of numbers: "0,5 1,5" are two cells, and "0,5" too: commas come before decimals.
    numeric = [(cells_of(first, d), d) for d in delimiters]
    numeric = [(cells, d) for cells, d in numeric if _are_numbers(cells)]
    if numeric:
        cells, delimiter = max(numeric, key=lambda pair: len(pair[0]))
        names = _remark_above(text, lines[0].start, delimiter, len(cells))
        numbers = tuple(str(i + 1) for i in range(len(cells)))
        return Dialect(delimiter, names or numbers, bool(names), lines[0].start)
    second = lines[1].text if lines[1:] else first
    delimiter = _of_header(first, second, delimiters)
    names, below = cells_of(first, delimiter), cells_of(second, delimiter)
    # "Width,10" above "Length,25" are remarks.
    is_remark = _is_any_number(names) and as_number(below[0]) is None
    if len(names) != len(below) or not _is_any_number(below) or is_remark:
        body = None if _is_bad_row(first, second, delimiter) else _first_body(lines, delimiters)
        if body is not None:
            return _above(text, lines, *body)
    return Dialect(delimiter, tuple(names), True, lines[0].end + 1)


def _is_bad_row(header: str, row: str, delimiter: str) -> bool:
    """Return whether a row below names is one of numbers, too few or too many of them."""
    return len(cells_of(header, delimiter)) > 1 and _are_numbers(cells_of(row, delimiter))


def _first_body(
    lines: Sequence[TableLine], delimiters: Sequence[str]
) -> tuple[int, str] | None:
    """Return the first of two lines of equally many numbers, and what separates these."""
    for place, (line, behind) in enumerate(zip(lines[1:], [*lines[2:], None], strict=False), 1):
        found: list[tuple[int, str]] = []
        for delimiter in delimiters:
            cells = cells_of(line.text, delimiter)
            below = cells if behind is None else cells_of(behind.text, delimiter)
            # A single row of numbers is a table only below as many names.
            above = len(cells_of(lines[place - 1].text, delimiter))
            fits = len(cells) > 1 and len(cells) == (above if behind is None else len(below))
            if fits and _are_numbers(cells) and _is_any_number(below):
                found.append((len(cells), delimiter))
        if found:  # of several that divide it alike the first, for names can hold blanks
            return place, max(found, key=lambda pair: pair[0])[1]
    return None


def _above(text: str, lines: Sequence[TableLine], place: int, delimiter: str) -> Dialect:
    """Return the dialect of a table whose numbers begin further down."""
    width, start = len(cells_of(lines[place].text, delimiter)), lines[place].start
    head = [cells_of(line.text, delimiter) for line in lines[:place]]
    if head[0][0] == _DEEPLABCUT and len(head) > 2:
        rows = [row for row in head[1:] if len(row) == width]
        names = ["_".join(cells) for cells in zip(*rows, strict=True)]
        return Dialect(delimiter, ("frame", *names[1:]), True, start)
    units: tuple[str, ...] = ()
    if (
        len(head) > 1
        and len(head[-1]) == width == len(head[-2])
        and all(map(is_unit, head[-1]))
    ):
        units = tuple(cell.strip("()[] ") for cell in head.pop())
    names, named = tuple(head[-1]), len(head[-1]) == width
    if not named:
        names = tuple(str(i + 1) for i in range(width))
    begin = lines[len(head) - 1].start if named else start
    return Dialect(delimiter, names, named, start, units, above=text.count("\n", 0, begin))


def _of_markers(lines: Sequence[TableLine]) -> Dialect | None:
    """Return the dialect of a TRC file, with a column for each axis of a marker: "knee_x"."""
    rows = [cells_of(line.text, "\t") for line in lines]
    body = next((n for n, cells in enumerate(rows) if n > 3 and _are_numbers(cells)), None)
    if body is None:
        return None
    width = len(rows[body])
    facts = dict(zip(rows[1], rows[2], strict=False))
    markers = [cell for cell in rows[3][2:] if cell]
    names = ["frame", "time", *(f"{m}_{axis}" for m in markers for axis in "xyz")][:width]
    # Rows may end with a separator.
    names += [""] * (width - len(names))
    units = ("", "s", *([facts.get("Units", "")] * (3 * len(markers))))
    units = (*units, *([""] * width))[:width]
    return Dialect("\t", tuple(names), True, lines[body].start, units, clock=1)


def _are_numbers(cells: list[str]) -> bool:
    """Return whether cells are numbers and gaps, and not gaps alone."""
    return all(as_number(cell) is not None for cell in cells) and _is_any_number(cells)


def _is_any_number(cells: list[str]) -> bool:
    return any(cell.lower() not in GAPS and as_number(cell) is not None for cell in cells)


def _of_header(header: str, row: str, delimiters: Sequence[str]) -> str:
    """Return the separator that divides a header and the row below it into equally many cells.

    Of several, it is the one with most numbers in the row. Names may hold commas and blanks,
    and so may numbers with decimal commas.
    """
    widths = {d: len(cells_of(header, d)) for d in delimiters}
    found = [(cells_of(row, d), d) for d in delimiters if widths[d] > 1]
    agree = [(cells, d) for cells, d in found if len(cells) == widths[d]]
    if agree:
        counted = ((sum(as_number(c) is not None for c in cells), d) for cells, d in agree)
        return max(counted, key=lambda pair: pair[0])[1]
    return found[0][1] if found else delimiters[-1]


def _remark_above(text: str, end: int, delimiter: str, width: int) -> tuple[str, ...]:
    """Return the names in the remark that ends before an offset, if there are so many."""
    above = text[:end].rstrip("\n").rpartition("\n")[2].strip()
    names = cells_of(above.lstrip("#").strip(), delimiter) if above[:1] == "#" else []
    return tuple(names) if len(names) == width and not _are_numbers(names) else ()
