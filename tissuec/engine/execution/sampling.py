"""Lists of times in which times that differ by rounding only count as one."""

import numpy as np
from numpy.typing import NDArray

from tissuec.model.network import Floats

SAME = 1e-12
"""Times closer than this part of the duration are one time."""


def join_times(times: Floats, anchors: Floats, near: float) -> Floats:
    """Return distinct times in ascending order.

    Of times that are nearly the same the first counts, or the last anchor that is among them.

    Args:
        times: [s], shape (time,), in any order.
        anchors: Times that are taken as they are, such as those of events [s].
        near: Largest difference between times that are one [s].
    """
    times = np.sort(times)
    if not len(times):
        return times
    times = times[np.concatenate([[True], np.diff(times) > near])]
    places = np.minimum(np.searchsorted(times, anchors - near), len(times) - 1)
    is_there = np.abs(times[places] - anchors) <= near
    times[places[is_there]] = anchors[is_there]
    return times


def rows_at(times: Floats, wanted: Floats, near: float) -> NDArray[np.bool_]:
    """Return which times are among the wanted ones, shape (time,).

    Args:
        times: Distinct and ascending [s]; holds every wanted time, up to ``near``.
        wanted: [s], shape (wanted,).
        near: Largest difference between times that are one [s].
    """
    chosen = np.zeros(len(times), dtype=bool)
    places = np.searchsorted(times, wanted - 2.0 * near)
    chosen[places[places < len(times)]] = True
    return chosen


def rows_within(times: Floats, start: float, stop: float, near: float) -> NDArray[np.bool_]:
    """Return which times lie in a closed interval, shape (time,).

    Args:
        times: Times [s], shape (time,).
        start: Start of the interval [s].
        stop: End of the interval [s].
        near: Largest difference between times that are considered equal [s].
    """
    return (times >= start - 2.0 * near) & (times <= stop + 2.0 * near)
