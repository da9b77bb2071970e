"""Small operations on arrays: equal, different and even numbers, vectors, monotone slopes."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Of the size of a drawing: places that are nearer to each other are the same but for rounding.
SAME_PLACE = 1e-9


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


def divided(values: NDArray[Any], others: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return the different values that are among others, and those that are not, ascending.

    ``numpy.intersect1d`` and ``numpy.setdiff1d`` import masked arrays; see ``distinct``.

    Args:
        values, others: In the same unit, any shape, no NaN.

    Returns:
        Shapes (n,) and (m,).
    """
    own, known = distinct(values), distinct(others)
    place = np.searchsorted(known, own)
    is_known = place < len(known)
    is_known[is_known] = known[place[is_known]] == own[is_known]
    return own[is_known], own[~is_known]


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


Floats = NDArray[np.float64]


def irregular(count: int) -> Floats:
    """Return irregular but fixed numbers, dimensionless, shape (count,).

    As a vector, they have a part along every motion of a net, and runs repeat exactly.
    """
    return np.sin(1.0 + np.arange(count, dtype=float) ** 2)


def unknowns(nodes: NDArray[np.integer]) -> NDArray[np.int64]:
    """Return the numbers of the coordinates x, y, z of nodes, shape (3 node,)."""
    return (3 * nodes[:, None] + np.arange(3)).ravel()


def rigid_motions(position: Floats) -> Floats:
    """Return the velocities of points by unit twists about the origin, shape (point, 3, 6).

    Translations come before rotations.

    Args:
        position: Of the points, shape (point, 3).
    """
    found = np.zeros((len(position), 3, 6))
    found[:, :, :3] = np.eye(3)
    found[:, :, 3:] = np.cross(np.eye(3), position[:, None, :]).transpose(0, 2, 1)
    return found


ALIKE = 1e-12  # of the largest coordinate: differences of elements that are rounding


def are_alike(corners: Floats) -> bool:
    """Return whether all elements are the same but for their place, up to rounding.

    Args:
        corners: Positions of their nodes in any unit, shape (element, node, 3).
    """
    own = corners - corners[:, :1]
    apart = float(np.abs(own - own[:1]).max(initial=0.0))
    return apart <= ALIKE * float(np.abs(corners).max(initial=0.0))


def cross(one: Floats, other: Floats) -> Floats:
    """Return the products one × other, in any units, shape (…, 3), twice as fast as NumPy."""
    shape = np.broadcast_shapes(one.shape, other.shape)
    found = np.empty(shape, dtype=np.result_type(one, other))
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        found[..., k] = one[..., i] * other[..., j] - one[..., j] * other[..., i]
    return found


def cross_matrices(vectors: Floats) -> Floats:
    """Return the matrices M of M y = vector × y, in the unit of the vectors, shape (…, 3, 3).

    Args:
        vectors: In any unit, shape (…, 3).
    """
    return cross(vectors[..., None, :], np.eye(3)).swapaxes(-1, -2)


def dot(one: Floats, other: Floats) -> Floats:
    """Return the products one · other, in any units, shape (…), twice as fast as ``np.einsum``.

    Both factors have the shape (…, 3).
    """
    return (
        one[..., 0] * other[..., 0] + one[..., 1] * other[..., 1] + one[..., 2] * other[..., 2]
    )


def largest_side(places: Floats) -> float:
    """Return the largest side of the box around places [m]; 0 without any.

    Args:
        places: In any number of dimensions [m], shape (place, axis).
    """
    return float(np.ptp(places, axis=0).max()) if len(places) else 0.0


def norm(vectors: Floats) -> Floats:
    """Return the lengths of vectors of shape (…, 3), in their unit, shape (…).

    This is five times as fast as NumPy.
    """
    return np.sqrt(dot(vectors, vectors))


def directions(count: int) -> Floats:
    """Return unit vectors, evenly spread over all directions, shape (count, 3)."""
    turn = np.arange(count) * np.pi * (3.0 - np.sqrt(5.0))
    height = 1.0 - 2.0 * (np.arange(count) + 0.5) / count
    flat = np.sqrt(1.0 - height**2)
    return np.stack([flat * np.cos(turn), flat * np.sin(turn), height], axis=1)


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
