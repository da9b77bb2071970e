"""Checks of the limits in a generator's field types, for generators made in Python."""

from typing import Any, cast, get_type_hints

import numpy as np

from tissuec.core import units
from tissuec.core.fields import FromTo, OneOf, Point, Real, Whole


def require_limits(generator: object) -> None:
    """Check every field of ``generator`` against the metadata of its annotation.

    Raises:
        ValueError: A value is outside its declared limits; the message names the entry.
    """
    for field, hint in get_type_hints(type(generator), include_extras=True).items():
        for declared in getattr(hint, "__metadata__", ()):
            value = getattr(generator, field)
            problem = "" if value is None else _problem(value, declared)
            if problem:
                raise ValueError(f'"{field.replace("_", " ")}" {problem}')


def _problem(value: Any, declared: object) -> str:
    """Return a description of the error of ``value``, or an empty string."""
    match declared:
        case OneOf(words):
            return "" if value in words else f'must be one of {", ".join(words)}, not "{value}"'
        case Whole(at_least, at_most):
            if isinstance(value, bool) or not isinstance(value, int | np.integer):
                return f'must be a whole number, not "{value}"'
            whole = cast("int | np.integer[Any]", value)
            return _outside(int(whole), at_least, at_most, units.NUMBER)
        case Real(dimension, above, at_least, at_most):
            if not np.isfinite(value):
                return f'must be finite, not "{value}"'
            if above is not None and value <= above:
                limit, shown = (units.show(number, dimension) for number in (above, value))
                return f"must be above {limit}, not {shown}"
            return _outside(value, at_least, at_most, dimension)
        case Point():
            return _not_points(value, (3,))
        case FromTo(may_bend=may_bend):
            count = max(len(value), 2) if may_bend else 2
            return _not_points(value, (count, 3))
        case _:
            return ""


def _outside(
    value: float, low: float | None, high: float | None, dimension: units.Dimension
) -> str:
    shown = units.show(value, dimension, digits=9)
    if low is not None and value < low:
        return f"must be at least {units.show(low, dimension, digits=9)}, not {shown}"
    if high is not None and value > high:
        return f"must be at most {units.show(high, dimension, digits=9)}, not {shown}"
    return ""


def _not_points(value: Any, shape: tuple[int, ...]) -> str:
    array = np.asarray(value, dtype=np.float64)
    if array.shape != shape:
        return f"must have the shape {shape}, not {array.shape}"
    return "" if np.isfinite(array).all() else "must have finite components"


def require_fine_part(fine_cell: float | None, fine_box: object, cell: float | None) -> None:
    """Check the entries of a part with finer cells.

    Args:
        fine_cell: Size of cells in the part [m].
        fine_box: Corners of the part.
        cell: Size of all other cells [m].

    Raises:
        ValueError: One of them is missing, or cells are not finer.
    """
    if (fine_cell is None) != (fine_box is None):
        raise ValueError('"fine cell" and "fine box" are needed together')
    if fine_cell is not None and cell is not None and fine_cell >= cell:
        raise ValueError('"fine cell" must be smaller than "cell"')
