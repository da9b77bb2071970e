"""Selection of rows at a given interval."""

import numpy as np

from tissuec.model.network import Floats, Indices

#: Longer runs of multiples than whole numbers can count are those of a wrong unit.
_MOST = 2.0**62
#: By which part of a multiple a row in the middle between two may be off.
_ROUNDING = 1e-9


def nearest_rows(times: Floats, every: float | None) -> Indices:
    """Return the rows whose times are nearest to the multiples of a time, ascending.

    Each row belongs to the multiple that it is nearest to, the lower one of two; of those of
    one multiple the nearest is taken, so none twice, and a multiple with no row near has none.
    Nothing is interpolated and nothing averaged: the values are those that were measured, with
    their noise.

    Args:
        times: Ascending [s], shape (row,).
        every: [s]; None: all rows.
    """
    if every is None or not len(times):
        return np.arange(len(times))
    multiple = np.clip(np.ceil(times / every - 0.5 - _ROUNDING), -_MOST, _MOST)
    off = np.abs(times - multiple * every)
    order = np.lexsort((off, multiple))
    _, first = np.unique(multiple[order], return_index=True)
    return np.sort(order[first])
