"""Sparse matrices of fields, from the blocks of their nodes and items."""

from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from tissuec.forces import Resisting
from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:
    from scipy.sparse import coo_matrix


def assembled(blocks: Floats, number: Indices, size: int) -> "coo_matrix":
    """Return the matrix in which the blocks of items add up, shape (3 size, 3 size).

    Args:
        blocks: In any unit, shape (item, node, 3, node, 3).
        number: Of the nodes of items among those that may move, -1 for others, shape (item,
            node).
        size: Number of nodes that may move.
    """
    from scipy.sparse import coo_matrix

    place = 3 * number[..., None] + np.arange(3)
    rows = np.broadcast_to(place[:, :, :, None, None], blocks.shape)
    columns = np.broadcast_to(place[:, None, None, :, :], blocks.shape)
    moves = (rows >= 0) & (columns >= 0)
    entries = blocks[moves], (rows[moves], columns[moves])
    return coo_matrix(entries, shape=(3 * size, 3 * size))


def diagonal(blocks: Floats, number: Indices, size: int) -> "coo_matrix":
    """Return a block-diagonal matrix with one block for each node that may move.

    Args:
        blocks: Blocks in any unit, shape (n, 3, 3).
        number: Of the nodes among those that may move, -1 for others, shape (n,).
        size: Number of nodes that may move; the matrix has the shape (3 size, 3 size).
    """
    from scipy.sparse import coo_matrix

    moves = number >= 0
    row = np.broadcast_to(
        3 * number[moves, None, None] + np.arange(3)[:, None], (moves.sum(), 3, 3)
    )
    where = row.ravel(), row.swapaxes(1, 2).ravel()
    return coo_matrix((blocks[moves].ravel(), where), shape=(3 * size, 3 * size))


def as_operator(matrix: "Callable[[], coo_matrix]") -> Resisting:
    """Return a matrix over all nodes as an operator on vectors.

    Args:
        matrix: Returns it, in any unit, shape (3 node, 3 node), when the operator is first
            applied: often only its existence matters.
    """
    rows = cache(lambda: matrix().tocsr())

    def resist(moved: Floats, to: Floats) -> None:
        to += (rows() @ moved.ravel()).reshape(-1, 3)

    return resist


def without_negative(matrices: Floats) -> Floats:
    """Return symmetric matrices with zero in place of negative eigenvalues.

    Args:
        matrices: In any unit, shape (…, n, n).
    """
    value, way = np.linalg.eigh(matrices)
    return (way * np.maximum(value, 0.0)[..., None, :]) @ way.swapaxes(-1, -2)
