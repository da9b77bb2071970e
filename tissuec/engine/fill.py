"""Predicted size of the factor of the matrix of an implicit step.

Nodes that a spring or an item of a field joins are neighbours in a graph, whose matrix of
one number for each pair has the pattern of the 3 × 3 blocks of S. The size of its factor gives
that of S: each of c numbers in a column represents 9, in 3 columns.
"""

from typing import TYPE_CHECKING, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from tissuec.forces import Field
from tissuec.model.network import Indices

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

# Nodes from which on conjugate gradients solve, whatever the net; and multiplications for a
# factor, and numbers in it.
MOST_NODES = 50_000
LARGEST_FACTOR, LARGEST_FILL = 5e10, 1e8
WIDEST = 32  # nodes of an item that are all neighbours; larger ones have columns beside S


class Fill(NamedTuple):
    """The factor of S.

    Attributes:
        numbers: Entries in both triangles; infinite if there are too many nodes to predict
            them.
        multiplications: That the factor takes.
    """

    numbers: float
    multiplications: float

    @property
    def is_small(self) -> bool:
        """Return whether S is factorised."""
        return self.numbers <= LARGEST_FILL and self.multiplications <= LARGEST_FACTOR

    @classmethod
    def of(
        cls, free: NDArray[np.bool_], ends: NDArray[np.integer], fields: tuple[Field, ...]
    ) -> Self:
        """Return the fill of a net.

        Args:
            free: Which nodes are unknowns, shape (node,).
            ends: Nodes of the springs that act, shape (spring, 2).
            fields: The fields that act besides them.
        """
        from scipy.sparse import csc_matrix, diags_array
        from scipy.sparse.linalg import splu

        count = int(np.count_nonzero(free))
        if count > MOST_NODES:
            return cls(np.inf, np.inf)
        if not count:
            return cls(0.0, 0.0)
        joined = _joined(np.where(free, np.cumsum(free) - 1, -1), count, ends, fields)
        joined.data[:] = -1.0
        degrees = np.diff(joined.indptr)
        graph = csc_matrix(joined + diags_array(2.0 + degrees, format="csc"))
        options = {"SymmetricMode": True, "DiagPivotThresh": 0.0}
        factor = splu(graph, permc_spec="MMD_AT_PLUS_A", options=options)
        columns = np.diff(factor.L.indptr).astype(float)
        return cls(18.0 * float(columns.sum()), 27.0 * float((columns**2).sum()))


def _joined(
    number: Indices, count: int, ends: NDArray[np.integer], fields: tuple[Field, ...]
) -> "csc_matrix":
    """Return a matrix that is not zero between free nodes of an item, shape (count, count)."""
    from scipy.sparse import csc_matrix, csr_matrix

    rows, nodes, start = [np.repeat(np.arange(len(ends)), 2)], [ends.ravel()], len(ends)
    for field in fields:
        items = field.items(np.arange(len(number)))
        if items is not None:
            counts = np.diff(items.first)
            rows.append(start + np.repeat(np.arange(len(counts)), counts))
            nodes.append(items.places)
            start += len(counts)
    row, node = np.concatenate(rows), number[np.concatenate(nodes).astype(np.int64)]
    row, node = np.unique(np.stack([row, node])[:, node >= 0], axis=1)
    small = np.bincount(row, minlength=start)[row] <= WIDEST
    shape = start, count
    member = csr_matrix((np.ones(small.sum()), (row[small], node[small])), shape=shape)
    return csc_matrix(member.T @ member)
