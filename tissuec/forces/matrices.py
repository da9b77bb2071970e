"""Matrices of fields from blocks of nodes and items, and exact derivatives of their forces.

A field whose forces have exact derivatives, for learning, names the ``columns`` of numbers that
its forces depend on, and two loops beside its kernel, which get the same table:

    ``pull_back`` adds the derivatives of Σ weight · f by positions, velocities and numbers;
    ``push_forward`` adds the changes of f for many changes of these.

They are transposes of each other. Numbers are those of one column after the other, each flat in
its own order.

Arguments of both are ``time, x, v`` as of the kernel, and

    weight: Any weights of the forces of all nodes, shape (3 node,).
    by_x, by_v: Derivatives by positions and velocities, added to, shape (3 node,).
    by: Derivatives by numbers, added to, shape (number,).
    dx, dv: Changes of positions and velocities, shape (3 node change,): all of one component
        together.
    dn: Changes of numbers, shape (number change,).
    df: Changes of the forces, added to, shape (3 node change,).
    room: Scratch, shape (change,).
"""

from collections.abc import Callable, Iterable
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.forces.effects import Resisting
from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix


def assembled(blocks: Floats, number: Indices, size: int) -> "csc_matrix":
    """Return the matrix in which the blocks of items add up, shape (3 size, 3 size).

    Args:
        blocks: In any unit, shape (item, node, 3, node, 3).
        number, size: As for ``BlockPattern.of``.
    """
    pattern = BlockPattern.of(number, size)
    room = pattern.room
    pattern.add(blocks, np.arange(len(number)), room)
    return pattern.matrix(room)


class BlockPattern(NamedTuple):
    """Where the blocks of items are added up, 3 x 3 for each pair of their nodes.

    Attributes:
        places: Where the block of each pair of nodes of an item begins among the entries, the
            node of its columns first, and then how far its columns are apart; blocks of nodes
            that do not move are behind all entries; shape (item, node, node + 1).
        indices, indptr: Rows of the entries, and where columns begin, as in
            ``scipy.sparse.csc_matrix``.
        left_out: Length of the room behind all entries.
    """

    places: Indices
    indices: NDArray[np.integer]
    indptr: NDArray[np.integer]
    left_out: int

    @classmethod
    def of(cls, number: Indices, size: int) -> "BlockPattern":
        """Return the pattern of items.

        Args:
            number: Of their nodes among those that may move, -1 for others, shape (item, node).
            size: Number of nodes that may move.
        """
        return _pattern(number.shape, np.ascontiguousarray(number, np.int64).tobytes(), size)

    @property
    def room(self) -> Floats:
        """Return room for entries in any unit, and what is left out, shape (n,)."""
        return np.zeros(len(self.indices) + self.left_out)

    def add(self, blocks: Floats, items: Indices, room: Floats) -> None:
        """Add the blocks of some items to those of the matrix.

        Args:
            blocks: In the unit of the room, shape (item, node, 3, node, 3).
            items: Numbers of these items, shape (item,).
        """
        first, apart = np.split(self.places[items], [-1], axis=-1)
        every = _entries(first, apart)
        np.add.at(room, every.ravel(), blocks.transpose(0, 3, 1, 4, 2).ravel())

    def blocks(self, room: Floats) -> Floats:
        """Return the blocks of items that share no node, shape (item, node, 3, node, 3)."""
        first, apart = np.split(self.places, [-1], axis=-1)
        return np.asarray(room[_entries(first, apart)].transpose(0, 2, 4, 1, 3))

    def matrix(self, room: Floats) -> "csc_matrix":
        """Return the matrix of blocks that are added up, shape (3 size, 3 size)."""
        from scipy.sparse import csc_matrix

        count, side = len(self.indices), len(self.indptr) - 1
        found = csc_matrix((room[:count], self.indices, self.indptr), shape=(side, side))
        found.has_canonical_format = True
        return found


def _entries(first: Indices, apart: Indices) -> Indices:
    """Return the places of the entries of blocks, shape (…, 3 columns, 3 rows).

    Args:
        first: Of the blocks, shape (…).
        apart: How far their columns are apart, shape (…).
    """
    three = np.arange(3)
    return np.asarray(
        (first + 0 * apart)[..., None, None] + apart[..., None, None] * three[:, None] + three
    )


@lru_cache(maxsize=4)
def _pattern(shape: tuple[int, int], numbers: bytes, size: int) -> BlockPattern:
    number = np.frombuffer(numbers, np.int64).reshape(shape)
    columns, rows = number[:, :, None], number[:, None, :]
    moves = (rows >= 0) & (columns >= 0)
    keys, found = np.unique((columns * size + rows)[moves], return_inverse=True)
    column, row = np.divmod(keys, max(size, 1))
    begin = np.searchsorted(keys, size * np.arange(size + 1))  # the columns of a node
    apart = 3 * np.diff(begin)
    first = 6 * begin[column] + 3 * np.arange(len(keys))
    count = 9 * len(keys)
    kind = np.int32 if count <= np.iinfo(np.int32).max else np.int64
    indices = np.empty(count, kind)
    indices[_entries(first, apart[column])] = (3 * row[:, None] + np.arange(3))[:, None]
    indptr = np.append(0, np.cumsum(np.repeat(apart, 3))).astype(kind)
    for each in (indices, indptr):
        each.setflags(write=False)  # matrices share them
    places = np.full((*shape, shape[1] + 1), count)
    places[..., :-1][moves] = first[found.reshape(-1)]
    places[..., -1] = np.append(apart, 3)[number]
    return BlockPattern(places, indices, indptr, 2 * int(apart.max(initial=3)) + 3)


def summed(parts: "Iterable[csc_matrix]", size: int) -> "csc_matrix":
    """Return the sum of matrices, shape (3 size, 3 size), which may be one of them.

    Args:
        parts: In any unit, each of this shape.
    """
    from scipy.sparse import csc_matrix

    found = csc_matrix((3 * size, 3 * size))
    for each in parts:
        if (each := csc_matrix(each)).nnz:  # forces of other packages may have another format
            found = csc_matrix(found + each) if found.nnz else each
    return found


def diagonal(blocks: Floats, number: Indices, size: int) -> "csc_matrix":
    """Return a block-diagonal matrix with one block for each node that may move.

    Args:
        blocks: Blocks in any unit, shape (n, 3, 3).
        number: Of the nodes among those that may move, -1 for others, shape (n,).
        size: Number of nodes that may move; the matrix has the shape (3 size, 3 size).
    """
    return assembled(blocks[:, None, :, None], number[:, None], size)


def as_operator(matrix: "Callable[[], csc_matrix]") -> Resisting:
    """Return a symmetric matrix over all nodes as an operator on vectors.

    Args:
        matrix: Returns it, in any unit, shape (3 node, 3 node), when the operator is first
            applied: often only its existence matters.
    """
    rows = cache(lambda: matrix().T)  # by rows, without a copy

    def resist(moved: Floats, to: Floats) -> None:
        to += (rows() @ moved.ravel()).reshape(-1, 3)

    return resist


def whole(halves: Floats) -> Floats:
    """Return symmetric matrices, in any unit, shape (…, n, n).

    Args:
        halves: Their lower halves, row by row, shape (…, n (n + 1)/2).
    """
    size = int((2 * halves.shape[-1]) ** 0.5)
    rows, columns = np.tril_indices(size)
    found = np.empty((*halves.shape[:-1], size, size))
    found[..., rows, columns] = found[..., columns, rows] = halves
    return found


POSITIVE = 1e-11  # of the largest entry: rounding that counts as positive semidefinite


def without_negative(matrices: Floats) -> Floats:
    """Return symmetric matrices with zero in place of negative eigenvalues.

    Those that have none stay as they are, which costs much less, and so do those that are not
    finite, which whoever solves with them refuses.

    Args:
        matrices: In any unit, shape (…, n, n).
    """
    size = matrices.shape[-1]
    found = matrices.reshape(-1, size, size).copy()
    top = POSITIVE * np.abs(found).max(axis=(1, 2), initial=0.0)
    is_known = np.isfinite(top)
    rest = np.flatnonzero(is_known & ~_are_positive(found + top[:, None, None] * np.eye(size)))
    if len(rest):
        value, way = np.linalg.eigh(found[rest])
        found[rest] = (way * np.maximum(value, 0.0)[:, None, :]) @ way.swapaxes(1, 2)
    return found.reshape(matrices.shape)


def _are_positive(matrices: Floats) -> NDArray[np.bool_]:
    """Return which symmetric matrices are positive definite: all pivots are positive, (n,)."""
    left = np.ascontiguousarray(matrices.transpose(1, 2, 0))
    found = np.ones(len(matrices), dtype=bool)
    with np.errstate(all="ignore"):  # of those that are not
        for _ in range(len(left)):
            pivot, row = left[0, 0], left[0, 1:]
            found &= pivot > 0.0
            left = left[1:, 1:] - row[:, None] * (row / pivot)
    return found


class ForceDerivatives(NamedTuple):
    """How the forces of a field depend on positions, velocities and its own numbers."""

    columns: tuple[str, ...]  # each a number, or an array with a row for each item
    pull_back: Callable[..., None]
    push_forward: Callable[..., None]


def numbers_of(field: Any, columns: tuple[str, ...]) -> Floats:
    """Return the numbers of a field, in SI units, shape (number,)."""
    parts = [np.ravel(field.column(name)) for name in columns]
    return np.concatenate([np.zeros(0), *parts])


def with_numbers(field: Any, columns: tuple[str, ...], numbers: Floats) -> Any:
    """Return a field with other numbers.

    Args:
        columns: Names of its columns.
        numbers: In SI units, shape (number,).
    """
    found: dict[str, Any] = {}
    start = 0
    for name in columns:
        old: Floats | float = field.column(name)
        size = np.size(old)
        part = numbers[start : start + size]
        if isinstance(old, np.ndarray):
            found[name] = part.reshape(old.shape).copy()
        else:
            found[name] = float(part[0])
        start += size
    return field.with_columns(found)


def places_of(
    field: Any, columns: tuple[str, ...], lost: Indices, kept: tuple[str, ...]
) -> Indices:
    """Return which numbers of a field are left when it loses some of its items, shape (n,).

    Args:
        columns: Names of its columns.
        lost: Indices of the items, shape (item,).
        kept: The columns that are left.
    """
    parts = [np.zeros(0, dtype=np.int64)]
    start = 0
    for name in columns:
        value = np.asarray(field.column(name))
        numbers = start + np.arange(value.size).reshape(value.shape)
        if name in kept:
            left = np.delete(numbers, lost, axis=0) if value.ndim else numbers
            parts.append(left.ravel())
        start += value.size
    return np.concatenate(parts)
