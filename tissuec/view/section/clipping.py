"""Triangles without the parts in front of a plane, and their sections with it."""

import numpy as np

from tissuec.model.network import Floats, Indices


def clipped(values: Floats, height: Floats) -> tuple[Floats, Indices]:
    """Return the parts of triangles that are not in front of a plane.

    Args:
        values: At their corners, places and whatever changes evenly between these, in any
            units, shape (triangle, 3, value).
        height: Of the corners in front of the plane [m], shape (triangle, 3).

    Returns:
        Values of shape (part, 3, value), and the triangle of each part, shape (part,).
    """
    front = height > 0.0
    count = front.sum(axis=1)
    whole = np.flatnonzero(count == 0)
    parts, of = [values[whole]], [whole]
    for many in (1, 2):
        chosen = np.flatnonzero(count == many)
        # The corner that is alone on its side first.
        alone = front[chosen] if many == 1 else ~front[chosen]
        turn = (alone.argmax(axis=1)[:, None] + np.arange(3)) % 3
        rows = chosen[:, None]
        (a, b, c), (p, q, r) = values[rows, turn].swapaxes(0, 1), height[rows, turn].T
        ab = a + (p / (p - q))[:, None] * (b - a)
        ac = a + (p / (p - r))[:, None] * (c - a)
        pieces = [(ab, b, c), (ab, c, ac)] if many == 1 else [(a, ab, ac)]
        for piece in pieces:
            parts.append(np.stack(piece, axis=1))
            of.append(chosen)
    return np.concatenate(parts), np.concatenate(of)


def met(values: Floats, height: Floats) -> Floats:
    """Return where a plane meets triangles, shape (segment, 2, value).

    Args:
        values: At their corners, in any units, shape (triangle, 3, value).
        height: Of the corners in front of the plane [m], shape (triangle, 3).
    """
    front = height > 0.0
    rows = np.flatnonzero(front.any(axis=1) & ~front.all(axis=1))
    alone = np.where(front[rows].sum(axis=1)[:, None] == 1, front[rows], ~front[rows])
    turn = (alone.argmax(axis=1)[:, None] + np.arange(3)) % 3
    rows = rows[:, None]
    (a, b, c), (p, q, r) = values[rows, turn].swapaxes(0, 1), height[rows, turn].T
    first, second = (a + (p / (p - h))[:, None] * (to - a) for to, h in ((b, q), (c, r)))
    return np.stack([first, second], axis=1)
