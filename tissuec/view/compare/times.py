"""Times of two runs that are equal but for rounding."""

import numpy as np
from numpy.typing import NDArray

from tissuec.model.network import Floats, Indices

SAME = 1e-9  # of the longer time: below, times differ by rounding alone


def nearness(*times: Floats) -> float:
    """Return the largest difference of times that are considered equal [s].

    Args:
        *times: Times [s], shape (time,) each.
    """
    return SAME * max((float(np.abs(one).max(initial=0.0)) for one in times), default=0.0)


def are_same(a: Floats, b: Floats) -> bool:
    """Return whether two lists of times [s], shape (time,), are equal but for rounding."""
    return len(a) == len(b) and bool((np.abs(a - b) <= nearness(a, b)).all())


def common(a: Floats, b: Floats) -> Floats:
    """Return the times of either within the span of both, each once [s], shape (time,)."""
    near = nearness(a, b)
    times = np.union1d(a, b)
    times = times[(times >= max(a[0], b[0]) - near) & (times <= min(a[-1], b[-1]) + near)]
    return times[np.diff(times, prepend=-np.inf) > near]


def nearest(times: Floats, wanted: Floats, near: float) -> tuple[Indices, NDArray[np.bool_]]:
    """Return the index of the nearest of some times, and whether both are equal.

    Args:
        times: Times [s], ascending, shape (time,).
        wanted: Times to look for [s], shape (n,).
        near: Largest difference of times that are considered equal [s].

    Returns:
        Indices and Booleans, shape (n,) each.
    """
    after = np.clip(np.searchsorted(times, wanted), 0, len(times) - 1)
    before = np.maximum(after - 1, 0)
    place = np.where(wanted - times[before] < times[after] - wanted, before, after)
    return place, np.abs(times[place] - wanted) <= near
