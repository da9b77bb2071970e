"""Curves through measured points, as formulas."""

from collections.abc import Sequence

import numpy as np

from tissuec.core.interpolation import monotone_slopes
from tissuec.laws.formula import Formula, Spline


def check_points(
    places: Sequence[float], of_places: str, values: Sequence[float], of_values: str
) -> None:
    """Raise ValueError, which names the entries, where no curve goes through points."""
    if len(places) != len(values):
        raise ValueError(
            f'"{of_values}" has {len(values)} numbers, "{of_places}" {len(places)}: '
            "each point needs both"
        )
    if np.any(np.diff(places) <= 0.0):
        raise ValueError(f'"{of_places}" must ascend')


def through(argument: Formula, places: Sequence[float], values: Sequence[float]) -> Formula:
    """Return cubic pieces that rise and fall only where the points do, and straight ends.

    F. N. Fritsch and J. Butland, SIAM J. Sci. Stat. Comput. 5:300 (1984).
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
