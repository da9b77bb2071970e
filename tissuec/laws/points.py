"""Curves through measured points, as formulas."""

from collections.abc import Sequence

import numpy as np

from tissuec.core.interpolation import monotone_slopes
from tissuec.laws.formula import Formula, Spline


def check_points(
    places: Sequence[float], of_places: str, values: Sequence[float], of_values: str
) -> None:
    """Refuse points that no curve passes through; the message names the entries.

    Args:
        places: Arguments of the points.
        of_places: Name of their entry.
        values: Values of the points.
        of_values: Name of their entry.

    Raises:
        ValueError: Numbers of places and values differ, or places do not ascend.
    """
    if len(places) != len(values):
        raise ValueError(
            f'"{of_values}" has {len(values)} numbers, "{of_places}" {len(places)}: '
            "each point needs one of both"
        )
    if np.any(np.diff(places) <= 0.0):
        raise ValueError(f'"{of_places}" must ascend')


def through(argument: Formula, places: Sequence[float], values: Sequence[float]) -> Formula:
    """Return a piecewise cubic that is monotone where the points are, with straight ends.

    F. N. Fritsch and J. Butland, SIAM J. Sci. Stat. Comput. 5:300 (1984).

    Args:
        argument: Argument of the curve.
        places: Arguments of the points, ascending.
        values: Values of the points.
    """
    x, y = np.array(places), np.array(values)
    slope = monotone_slopes(x, y)
    width = np.diff(x)
    secant = np.diff(y) / width
    bend = (3.0 * secant - 2.0 * slope[:-1] - slope[1:]) / width
    twist = (slope[:-1] + slope[1:] - 2.0 * secant) / width**2
    pieces = np.column_stack([y[:-1], slope[:-1], bend, twist])
    last = (y[-1], slope[-1], 0.0, 0.0)
    rows = tuple((float(a), float(b), float(c), float(d)) for a, b, c, d in (*pieces, last))
    return Spline(argument, tuple(map(float, x)), rows, float(slope[0]))
