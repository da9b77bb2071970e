"""Arrays of equal or different values, of runs of numbers, and of evenly spread numbers."""

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


def distinct(values: NDArray[Any]) -> NDArray[Any]:
    """Return different values in ascending order, as ``numpy.unique`` does.

    That imports masked arrays, which takes longer than many a scene needs in all.

    Args:
        values: In any unit, any shape, no NaN.

    Returns:
        Shape (n,).
    """
    ascending = np.sort(values, axis=None)
    is_new = np.ones(len(ascending), dtype=bool)
    np.not_equal(ascending[1:], ascending[:-1], out=is_new[1:])
    return ascending[is_new]


def typical(values: NDArray[Any]) -> float:
    """Return the median, the higher of the two in the middle, in the unit of the values.

    ``numpy.median`` imports masked arrays as well.

    Args:
        values: At least one, any shape.
    """
    middle = values.size // 2
    return float(np.partition(values, middle, axis=None)[middle])


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
