"""The dialect of a table: separators of its cells, names and units of its columns.

Cells are parted by tabs, semicolons, commas or blanks; where commas part none of them, decimals
may have commas. Lines that begin with ``#`` are remarks; the last one above rows without a
header is the header if it has as many names.
"""

import codecs
import csv
import math
import re
from collections.abc import Iterator
from typing import NamedTuple

from tissuec.core.names import key_of
from tissuec.core.units import TIME, Unit, UnitError, parse_unit

BLANK = " "
DELIMITERS = ("\t", ";", ",", BLANK)
#: Marks of missing values, as instruments, spreadsheets and programs write them.
GAPS = frozenset((
    "", "nan", "-nan", "+nan", "na", "n/a", "#n/a", "n.a.", "-", "--", "null", "none",
    "1.#qnan", "-1.#ind",
))  # fmt: skip
# A unit in brackets, which is short, belongs to the name before it.
_CELL = re.compile(r'"[^"]*"?|[^\s"]+(?:\s+[\[(][^\])]{0,99}[\])])?')


class Dialect(NamedTuple):
    """The format of a table.

    Attributes:
        delimiter: What parts cells; ``BLANK`` means any number of blanks or tabs.
        names: Of the columns; their numbers from 1 if there is no header.
        named: Whether there is a header.
        start: Offset in the text after the header.
        units: Of the columns, where a row of them is below the names; "" for none.
        clock: Number of the column of times, unless another is named.
        above: How many lines of text are above the names of the columns.
    """

    delimiter: str
    names: tuple[str, ...]
    named: bool
    start: int
    units: tuple[str, ...] = ()
    clock: int = 0
    above: int = 0

    def unit(self, column: int) -> Unit | None:
        """Return the unit of a column, from the row of units or the end of its name.

        Raises:
            UnitError: It is unknown.
        """
        return unit_of(f"[{self.units[column]}]" if any(self.units) else self.names[column])


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


def decoded(data: bytes) -> str | None:
    """Return the text of a file, whose lines end with one sign; None if it is no text."""
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        text = data.decode("utf-16", errors="replace")
    else:
        data = data.removeprefix(codecs.BOM_UTF8)
        try:
            text = data.decode()
        except UnicodeDecodeError:  # names of columns with letters of older instruments
            text = data.decode("latin-1")
    if "\0" in text:
        return None
    return text.replace("\r\n", "\n").replace("\r", "\n") if "\r" in text else text


_BRACKETS = re.compile(r"[\[(]([^\])]*)[\])]$")
_BEHIND = re.compile(r"(?:^|[\s_/])([^\W\d_]+)$")
_LONGEST = 100  # characters of the end of a name that can be its unit
#: Names of times beside the symbols.
_SPELLED = {
    "sec": 1.0, "secs": 1.0, "second": 1.0, "seconds": 1.0,
    "msec": 1e-3, "millisecond": 1e-3, "milliseconds": 1e-3,
    "usec": 1e-6, "microsecond": 1e-6, "microseconds": 1e-6,
    "minute": 60.0, "minutes": 60.0,
    "h": 3600.0, "hr": 3600.0, "hour": 3600.0, "hours": 3600.0,
}  # fmt: skip
#: Names of columns that count rows; spreadsheets and pandas leave the name out.
_COUNTS = frozenset((
    "", "frame", "frames", "frame number", "image", "picture", "sample", "index", "unnamed",
    "row", "no", "nr", "number", "count",
))  # fmt: skip


def unit_of(name: str) -> Unit | None:
    """Return the unit that the name of a column ends with; None if it ends with none.

    Raises:
        UnitError: The text in brackets is none.
    """
    name = name.strip()[-_LONGEST:]
    if name in ("[]", "[-]"):
        return None
    if bracketed := _BRACKETS.search(name):
        return _unit(bracketed[1].strip())
    behind = _BEHIND.search(name)
    try:
        return _unit(behind[1]) if behind else None
    except UnitError:
        return None


def is_count(name: str) -> bool:
    """Return whether a column with this name counts rows or pictures and has no times."""
    return key_of(name.strip(" #.:0123456789")) in _COUNTS


def is_unit(cell: str) -> bool:
    """Return whether a cell of a row of units is one: "(s)", "[mN]", "mm", "%", or empty."""
    text = cell.strip("()[] ")
    if not text or text in ("%", "-"):
        return True
    try:
        _unit(text)
    except UnitError:
        return False
    return True


def _unit(text: str) -> Unit:
    if text.lower() in _SPELLED:
        return Unit(_SPELLED[text.lower()], TIME)
    return parse_unit(text)
