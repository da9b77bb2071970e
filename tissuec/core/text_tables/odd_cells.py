"""Cells that are no numbers but could be, and numbers that mark gaps."""

import re
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tissuec.core.units import UnitError, parse_unit

Floats = NDArray[np.float64]

_NUMBER = r"[+-]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][+-]?\d+)?"
_WHOLE = re.compile(_NUMBER)
_CLOCK = re.compile(r"(?:(\d+):)?(\d{1,2}):(\d{2}(?:[.,]\d+)?)")
_DATE = re.compile(r"\d{1,4}[-./]\d{1,2}[-./]\d{1,4}(?:[T ].*)?")
_GROUPED = re.compile(
    r"[+-]?\d{1,3}(?:([,.' _\u00a0\u2009\u202f])\d{3})(?:\1\d{3})*(?:[.,]\d+)?"
)
_FORTRAN = re.compile(r"([+-]?\d*\.?\d*)[dDqQ]([+-]?\d+)")
_FOLLOWED = re.compile(rf"({_NUMBER})\s*([^\d\s].*)")
_LIMIT = re.compile(rf"[<>≤≥~≈]=?\s*{_NUMBER}")

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
    if clock := _CLOCK.fullmatch(text):
        hours, minutes, seconds = clock[1] or "0", clock[2], clock[3].replace(",", ".")
        total = 3600 * int(hours) + 60 * int(minutes) + float(seconds)
        return f"write times as numbers, from the start of the test: {total:.12g} for {text}"
    if _DATE.fullmatch(text):
        return "write times as numbers, from the start of the test, instead of dates"
    if grouped := _GROUPED.fullmatch(text):
        plain = text.replace(grouped[1], "").replace(",", ".")
        return f"write digits without separators: {plain}"
    if "_" in text and _WHOLE.fullmatch(plain := text.replace("_", "")):
        return f"write digits without separators: {plain}"
    if _WHOLE.fullmatch(text):
        return f"such large numbers are not measurements: {GAP}"
    if fortran := _FORTRAN.fullmatch(text):
        return f"write exponents with E: {fortran[1]}E{fortran[2]}"
    if _LIMIT.fullmatch(text):
        return f"a limit is not a measured number: {GAP}"
    if followed := _FOLLOWED.fullmatch(text):
        number, rest = followed[1], followed[2].strip()
        where = "put it after the name of the column" if _is_unit(rest) else "remove it"
        what = "the unit" if _is_unit(rest) else "the text"
        return f'{what} "{rest}" after {number} is not part of the number: {where}'
    return GAP


def is_ambiguous(cell: str) -> bool:
    """Return whether a cell with a comma can be a decimal or a number of thousands: "1,234".

    No thousands begin with a zero: "0,234" is a decimal.
    """
    grouped = _GROUPED.fullmatch(cell)
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
