"""Places along a line with fine steps in a part of it and coarse ones far away.

Steps grow by one factor from the fine part on until they are coarse. Products of such lines
have no hanging nodes: a plane of a fine part goes through the whole block.
"""

from math import ceil

import numpy as np
from numpy.typing import NDArray

GROWTH = 1.5  # largest ratio of neighbouring steps; up to 1.6 where few coarse ones fit
_LEAST = 1.0 / GROWTH
_ROUNDING = 1e-9  # of a step


def graded_line(
    ends: tuple[float, float], fine_part: tuple[float, float], coarse: float, fine: float
) -> NDArray[np.float64]:
    """Return ascending places from one end to the other [m], shape (n,).

    Args:
        ends: Of the line [m], ascending.
        fine_part: Ends of the part with fine steps [m], ascending; what is outside of the line
            has no effect.
        coarse: Largest step [m].
        fine: Largest step of the fine part [m], at most ``coarse``.

    Raises:
        ValueError: The fine part is not on the line.
    """
    low, high = ends
    if fine_part[1] < low or fine_part[0] > high:
        raise ValueError("the fine part is not on the line")
    start, stop = max(fine_part[0], low), min(fine_part[1], high)
    if stop - start < fine:  # at least one step
        middle, half = 0.5 * (start + stop), 0.5 * min(fine, high - low)
        middle = min(max(middle, low + half), high - half)
        start, stop = middle - half, middle + half
    # What is left on a side has room for a step that is not much smaller.
    start = low if start - low < _LEAST * fine else start
    stop = high if high - stop < _LEAST * fine else stop
    count = max(1, ceil((stop - start) / fine - _ROUNDING))
    step = (stop - start) / count
    inside = np.linspace(start, stop, count + 1)
    before = start - np.cumsum(_growing(start - low, step, coarse))[::-1]
    after = stop + np.cumsum(_growing(high - stop, step, coarse))
    places = np.concatenate([before, inside, after])
    places[0], places[-1] = low, high  # whatever rounding did
    return places


def _growing(length: float, first: float, most: float) -> NDArray[np.float64]:
    """Return steps that grow from a first one, which is not among them [m], shape (n,).

    Args:
        length: Their sum [m].
        first: The step before them [m].
        most: Largest step [m].
    """
    if length <= 0.0:
        return np.zeros(0)

    def steps(factor: float, count: int) -> NDArray[np.float64]:
        with np.errstate(over="ignore"):
            return np.minimum(first * factor ** np.arange(1.0, count + 1.0), most)

    count = 1
    while steps(GROWTH, count).sum() < length * (1.0 - _ROUNDING):
        more = (length - steps(GROWTH, count).sum()) / most
        count += max(1, int(more))
    low, high = 0.0, GROWTH
    for _ in range(100):
        middle = 0.5 * (low + high)
        is_long = steps(middle, count).sum() > length
        low, high = (low, middle) if is_long else (middle, high)
    found = steps(high, count)
    return found * (length / found.sum())
