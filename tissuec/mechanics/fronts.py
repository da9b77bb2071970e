"""Cholesky's factors K = L Lᵀ by fronts, which are dense.

The unknowns that a dissection eliminates together, a leaf or what separates two halves, form a
front with the later ones that they are coupled to. A front adds up its entries of K and what
earlier ones leave behind, eliminates its own unknowns by dense operations, and leaves the rest
to the next front. (I. S. Duff, J. K. Reid, ACM Trans. Math. Softw. 9:302, 1983; J. W. H. Liu,
SIAM Rev. 34:82, 1992.) Where K is not positive definite, a root of a negative number ends this
early.
"""

from collections.abc import Iterator
from itertools import pairwise
from typing import Self

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray
from scipy.linalg.blas import dsyrk, dtrsm
from scipy.linalg.lapack import dpotrf
from scipy.sparse import bsr_matrix

from tissuec.core.arrays import unknowns
from tissuec.core.signals import give_way
from tissuec.model.network import Floats, Indices


class Front(Struct, frozen=True, eq=False):
    """Unknowns that are eliminated together, and those that they change.

    Unknowns are counted in the order of elimination.

    Attributes:
        own: The first of those that are eliminated, and the one after the last.
        rest: Later unknowns, in order, shape (rest,).
        blocks: Which blocks of K belong to own columns, shape (block,).
        places: Of their entries in the front, counted by columns, shape (block, 3, 3).
        earlier: Fronts that leave something to this one, and the places of their ``rest``
            among the unknowns of this one, shape (rest,) of each.
    """

    own: tuple[int, int]
    rest: Indices
    blocks: Indices
    places: Indices
    earlier: list[tuple[int, Indices]]


class Fronts(Struct, frozen=True, eq=False):
    """The fronts of all matrices that couple the same nodes.

    Attributes:
        indptr, indices: Of the blocks of these matrices, by rows.
        order: Unknowns in the order of elimination, shape (n,).
        each: In the order of elimination.
    """

    indptr: NDArray[np.integer]
    indices: NDArray[np.integer]
    order: Indices
    each: list[Front]

    @classmethod
    def of(cls, matrix: bsr_matrix, nodes: Indices, starts: Indices) -> Self:
        """Return the fronts of a symmetric matrix.

        Args:
            matrix: With a block for each pair of nodes that it couples, shape (3 node, 3 node).
            nodes: In the order of elimination, shape (node,).
            starts: Where the nodes of each front begin in this order, shape (front,).
        """
        count = len(nodes)
        rank = np.empty(count, dtype=np.int64)
        rank[nodes] = np.arange(count)
        bounds: list[int] = [*starts.tolist(), count]
        front_of = np.repeat(np.arange(len(starts)), np.diff(bounds))
        row = np.repeat(rank, np.diff(matrix.indptr))
        column = rank[matrix.indices]
        lower = np.flatnonzero(row >= column)
        lower = lower[np.argsort(front_of[column[lower]], kind="stable")]
        row, column = row[lower], column[lower]
        begin = np.searchsorted(front_of[column], np.arange(len(starts) + 1))

        each: list[Front] = []
        rests: list[Indices] = []
        earlier: list[list[int]] = [[] for _ in starts]
        axes = np.arange(3)
        for k, (start, stop) in enumerate(pairwise(bounds)):
            part = slice(begin[k], begin[k + 1])
            every = np.unique(np.concatenate([row[part]] + [rests[one] for one in earlier[k]]))
            rest = every[np.searchsorted(every, stop) :]
            rests.append(rest)
            if len(rest):  # what is left goes to the front of the first node that it changes
                earlier[front_of[rest[0]]].append(k)
            within = np.concatenate([np.arange(start, stop), rest])
            down, across = (
                3 * np.searchsorted(within, of[part])[:, None] + axes for of in (row, column)
            )
            places = down[:, :, None] + 3 * len(within) * across[:, None, :]
            before = [
                (one, unknowns(np.searchsorted(within, rests[one]))) for one in earlier[k]
            ]
            own = (3 * start, 3 * stop)
            each.append(Front(own, unknowns(rest), lower[part], places, before))
        return cls(matrix.indptr, matrix.indices, unknowns(nodes), each)

    def fit(self, matrix: bsr_matrix) -> bool:
        """Return whether a matrix has these blocks."""
        return np.array_equal(matrix.indptr, self.indptr) and np.array_equal(
            matrix.indices, self.indices
        )

    def factor(self, matrix: bsr_matrix) -> "CholeskyFactor | None":
        """Return the factor of a matrix with these blocks; None if it is not definite."""
        left: dict[int, Floats] = {}
        columns: list[tuple[Floats, Floats]] = []
        for number, front in enumerate(self.each):
            give_way()
            own = front.own[1] - front.own[0]
            size = own + len(front.rest)
            flat = np.zeros(size * size)
            flat[front.places] = matrix.data[front.blocks]
            dense = flat.reshape(size, size).T
            for one, places in front.earlier:
                dense[np.ix_(places, places)] += left.pop(one)
            top, failed = dpotrf(dense[:own, :own], lower=1, clean=1)
            if failed:
                return None
            below = dense[own:, :own]
            if len(below):
                below = dtrsm(1.0, top, below, side=1, lower=1, trans_a=1)
                left[number] = dsyrk(-1.0, below, 1.0, dense[own:, own:], lower=1)
            columns.append((top, below))
        return CholeskyFactor(self, columns)


class CholeskyFactor:
    """L, by the columns of each front."""

    def __init__(self, fronts: Fronts, columns: list[tuple[Floats, Floats]]):
        self._fronts, self._columns = fronts, columns

    def solve(self, vectors: Floats, _way: str = "N") -> Floats:
        """Return K⁻¹ times vectors in any unit, shape (n,) or (n, vector)."""
        ordered = vectors[self._fronts.order].reshape(len(vectors), -1)
        found = np.array(ordered, dtype=float, order="F")
        for own, rest, top, below in self._each():
            found[own] = dtrsm(1.0, top, found[own], lower=1)
            if len(rest):
                found[rest] -= below @ found[own]
        for own, rest, top, below in reversed(list(self._each())):
            right = found[own] - below.T @ found[rest] if len(rest) else found[own]
            found[own] = dtrsm(1.0, top, right, lower=1, trans_a=1)
        solved = np.empty(vectors.shape)
        solved[self._fronts.order] = found.reshape(vectors.shape)
        return solved

    def _each(self) -> Iterator[tuple[slice, Indices, Floats, Floats]]:
        for front, (top, below) in zip(self._fronts.each, self._columns, strict=True):
            yield slice(*front.own), front.rest, top, below
