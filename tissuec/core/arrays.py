"""Arrays of equal values, of runs of numbers, and of numbers that are evenly spread."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray


def uniform(values: NDArray[Any]) -> NDArray[Any]:
    """Return values as they are or, if all are equal, as a read-only view of one value.

    Args:
        values: In any unit, shape (…).
    """
    if values.size < 2 or (values != values.flat[0]).any():
        return values
    return np.broadcast_to(values.flat[0].copy(), values.shape)


def behind_one_another(
    parts: Sequence[NDArray[Any]], kind: type[np.generic] | type, shape: tuple[int, ...] = ()
) -> NDArray[Any]:
    """Concatenate parts in any unit; a single part is returned as it is.

    Args:
        parts: Each of shape (n, *shape).
        kind: Type of the numbers.
        shape: Of each row.
    """
    if len(parts) == 1:
        return np.asarray(parts[0], dtype=kind)
    none = np.asarray(np.zeros((0, *shape)), dtype=kind)
    return np.concatenate([none, *parts]).astype(kind, copy=False)


def counted_up(counts: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return 0, 1, … for each of some runs, one after the other.

    Args:
        counts: Lengths of the runs, shape (run,).
    """
    return np.arange(int(counts.sum())) - np.repeat(np.cumsum(counts) - counts, counts)


def evenly(count: int, most: int) -> NDArray[np.int64]:
    """Return 0, …, count - 1, or at most so many of these, evenly spread from first to last.

    Args:
        count: How many numbers there are.
        most: How many are wanted, 2 or more.

    Returns:
        Ascending numbers, shape (n,).
    """
    return np.linspace(0, count - 1, min(most, count)).round().astype(np.int64)
