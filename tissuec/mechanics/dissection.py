"""The order in which unknowns are eliminated, so that factors have few entries.

By nested dissection of places: the net is halved across its longest side, and the nodes of one
half that something joins to the other come last; both halves likewise. For meshes of the plane
the factor has O(n log n) entries, and for solids O(n^(4/3)). (A. George, SIAM J. Numer. Anal.
10:345, 1973; G. L. Miller et al., J. ACM 44:1, 1997.)
"""

from typing import NamedTuple

import numpy as np
from scipy.sparse import bsr_matrix, csc_matrix, csr_matrix

from tissuec.core.arrays import unknowns
from tissuec.mechanics.fronts import CholeskyFactor, Fronts
from tissuec.model.network import Floats, Indices

# Multiplications for a factor over the sum of the cubes of the sizes of separators, and numbers
# of the factor over the sum of their squares; measured for cubes and bars of hexahedra, within
# 30 %.
MULTIPLICATIONS, NUMBERS = 60.0, 62.0
LEAF = 32  # nodes that are not divided further


class EliminationOrder:
    """The order for all matrices that couple the same nodes, found with the first of them.

    Args:
        position: Of the nodes [m], shape (node, 3).
    """

    def __init__(self, position: Floats):
        self._position = position
        self._found: Dissection | None = None
        self._fronts: Fronts | None = None

    def of(self, matrix: csc_matrix) -> Indices:
        """Return the unknowns in the order of elimination, shape (3 node,).

        Args:
            matrix: Symmetric, with three rows for each node, shape (3 node, 3 node).
        """
        return unknowns(self._dissected(matrix).nodes)

    def cholesky(self, matrix: csc_matrix) -> CholeskyFactor | None:
        """Return the factor of a symmetric matrix; None if it is not positive definite."""
        found, blocks = self._dissected(matrix), blocks_of(matrix)
        if self._fronts is None or not self._fronts.fit(blocks):
            self._fronts = Fronts.of(blocks, found.nodes, found.starts)
        return self._fronts.factor(blocks)

    def work(self, matrix: csc_matrix) -> float:
        """Return about how many multiplications a factor takes."""
        return self._dissected(matrix).work

    def numbers(self, matrix: csc_matrix) -> float:
        """Return about how many numbers a factor has."""
        return self._dissected(matrix).numbers

    def _dissected(self, matrix: csc_matrix) -> "Dissection":
        if self._found is None:
            self._found = dissected(self._position, joined_nodes(matrix))
        return self._found


class Dissection(NamedTuple):
    """Nodes in the order of elimination.

    Attributes:
        nodes: In this order, shape (node,).
        starts: Where those begin that are eliminated together, shape (front,).
        separators: Number of nodes that separate the halves of each division, shape
            (division,).
    """

    nodes: Indices
    starts: Indices
    separators: Indices

    @property
    def work(self) -> float:
        """Return about how many multiplications a factor takes."""
        return MULTIPLICATIONS * float((self.separators**3.0).sum())

    @property
    def numbers(self) -> float:
        """Return about how many numbers a factor has."""
        return NUMBERS * float((self.separators**2.0).sum())


def by_rows(matrix: csc_matrix) -> csr_matrix:
    """Return a symmetric matrix by rows, with the same arrays."""
    return csr_matrix((matrix.data, matrix.indices, matrix.indptr), shape=matrix.shape)


def blocks_of(matrix: csc_matrix) -> bsr_matrix:
    """Return a symmetric matrix with a block for each pair of nodes that it couples."""
    return bsr_matrix(by_rows(matrix).tobsr((3, 3)))


def joined_nodes(matrix: csc_matrix) -> csr_matrix:
    """Return which nodes a symmetric matrix of three rows for each couples, with itself."""
    blocks, size = blocks_of(matrix), matrix.shape[0] // 3
    joined = np.ones(len(blocks.indices), np.int8), blocks.indices, blocks.indptr
    return csr_matrix(joined, shape=(size, size))


def dissected(position: Floats, joined: csr_matrix) -> Dissection:
    """Return the order of elimination by nested dissection.

    Args:
        position: Of the nodes [m], shape (node, 3).
        joined: Which nodes act on one another, symmetric, shape (node, node).
    """
    order, separators = np.empty(len(position), dtype=np.int64), list[int]()
    starts: list[int] = []
    is_there = np.zeros(len(position), dtype=bool)
    waiting = [(0, np.arange(len(position)))]
    while waiting:
        first, nodes = waiting.pop()
        if len(nodes) <= LEAF:
            order[first : first + len(nodes)] = nodes
            starts.append(first)
            continue
        low, high = _halves(position, nodes)
        is_there[high] = True
        rows = joined[low]
        touches = np.bincount(
            np.repeat(np.arange(len(low)), np.diff(rows.indptr)),
            is_there[rows.indices], len(low),
        ) > 0.0  # fmt: skip
        is_there[high] = False
        separators.append(int(np.count_nonzero(touches)))
        last = first + len(nodes) - separators[-1]
        order[last : first + len(nodes)] = low[touches]
        starts.append(last)
        inner = low[~touches]
        waiting += [(first, inner), (first + len(inner), high)]
    # Halves that nothing joins have no separator, and may be empty.
    fronts = np.unique([start for start in starts if start < len(order)])
    return Dissection(order, fronts, np.array(separators, dtype=np.int64))


def _halves(position: Floats, nodes: Indices) -> tuple[Indices, Indices]:
    """Return the nodes on either side of the middle of the longest side."""
    places = position[nodes]
    along = places[:, np.argmax(np.ptp(places, axis=0))]
    ranked = nodes[np.argsort(along, kind="stable")]
    return ranked[: len(ranked) // 2], ranked[len(ranked) // 2 :]
