"""Interpolation that does not overshoot."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def monotone_slopes(times: Floats, values: Floats) -> Floats:
    """Return slopes that keep a cubic interpolant monotone between its knots.

    Args:
        times: Knots in any unit, shape (knot,), strictly ascending, at least 2.
        values: Values at the knots in any unit, shape (knot,).

    Returns:
        Derivatives, shape (knot,), by the weighted harmonic mean of Fritsch & Butland (1984).
    """
    h, d = np.diff(times), np.diff(values) / np.diff(times)
    if len(d) == 1:
        return np.array([d[0], d[0]])
    w1, w2 = 2.0 * h[1:] + h[:-1], h[1:] + 2.0 * h[:-1]
    same = d[1:] * d[:-1] > 0.0
    safe = np.where(same, d[:-1], 1.0), np.where(same, d[1:], 1.0)
    with np.errstate(over="ignore"):  # a slope near 0 makes its share infinite, and the mean 0
        inner = np.where(same, (w1 + w2) / (w1 / safe[0] + w2 / safe[1]), 0.0)
    return np.concatenate(
        [[_end_slope(h[0], h[1], d[0], d[1])], inner, [_end_slope(h[-1], h[-2], d[-1], d[-2])]]
    )


def _end_slope(h0: float, h1: float, d0: float, d1: float) -> float:
    """Return the one-sided three-point slope at an end, limited so as to stay monotone."""
    slope = ((2.0 * h0 + h1) * d0 - h0 * d1) / (h0 + h1)
    if slope * d0 <= 0.0:
        return 0.0
    return 3.0 * d0 if d0 * d1 <= 0.0 and abs(slope) > 3.0 * abs(d0) else float(slope)
