"""Units at the ends of names of columns: ``t_ms``, ``time [us]``, ``t/s``, ``u (mm)``."""

import re

from tissuec.core.names import key_of
from tissuec.core.units import TIME, Unit, UnitError, parse_unit

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
