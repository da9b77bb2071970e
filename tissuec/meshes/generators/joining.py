"""Common code of generators: canonical spring lists, and rows and columns of nodes.

A grid numbers its nodes row by row: node ``row * columns + column``.
"""

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from tissuec.model.topology import lower_and_upper

Pairs: TypeAlias = NDArray[np.int64]


def springs(node_count: int, *pairs: Pairs) -> NDArray[np.int32]:
    """Return every pair once, lower node first, sorted by first and then second node.

    Sorted, so that the springs of a node lie together in memory and sums are reproducible.

    Args:
        node_count: Number of nodes.
        *pairs: Node pairs in any order and direction, each of shape (pair, 2).

    Returns:
        Node pair of each spring, shape (spring, 2).
    """
    low, high = lower_and_upper(np.concatenate(pairs))
    keys = np.sort(low * node_count + high)
    keys = keys[np.diff(keys, prepend=-1) > 0]
    return np.stack(np.divmod(keys, node_count), axis=1).astype(np.int32)


def grid_pairs(shape: tuple[int, int], step: tuple[int, int], *, wrap: bool = False) -> Pairs:
    """Return the pairs of grid nodes that lie ``step`` apart.

    Args:
        shape: Numbers of rows and columns.
        step: Rows (not negative) and columns from the first node of a pair to the second.
        wrap: Whether the last column is followed by the first.

    Returns:
        Node pairs, shape (pair, 2).
    """
    (rows, columns), (down, right) = shape, step
    column = np.arange(columns)
    if not wrap:
        column = column[max(0, -right) : max(0, columns - max(0, right))]
    row = np.arange(rows - down)[:, None]
    first = row * columns + column
    second = (row + down) * columns + (column + right) % columns
    return np.stack((first.ravel(), second.ravel()), axis=1)


def grid_triangles(shape: tuple[int, int], *, wrap: bool = False) -> NDArray[np.int32]:
    """Return two triangles per grid cell, cut along the step (1, 1).

    Their normals point along (direction of a row) x (direction of a column).

    Args:
        shape: Numbers of rows and columns.
        wrap: Whether the last column is followed by the first.

    Returns:
        Node numbers, shape (triangle, 3).
    """
    start, ahead = grid_pairs(shape, (1, 1), wrap=wrap).T
    columns = shape[1]
    beside, below = ahead - columns, start + columns
    halves = ((start, beside, ahead), (start, ahead, below))
    return (
        np.stack([np.stack(half, axis=1) for half in halves], axis=1)
        .reshape(-1, 3)
        .astype(np.int32)
    )
