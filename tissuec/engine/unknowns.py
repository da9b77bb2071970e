"""The unknowns of implicit steps: their order, their matrix, and the size of its factor.

For the size of the factor, nodes that a spring or an item of a field joins are neighbours in a
graph, whose matrix of one number for each pair has the pattern of the 3 × 3 blocks of S. The
size of its factor gives that of S: each of c numbers in a column represents 9, in 3 columns.
"""

from typing import TYPE_CHECKING, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from tissuec.forces.acting.embedding import EmbeddedNodes
from tissuec.forces.fields import Field
from tissuec.kernels.records import Integers, Solver

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

# Multiplications for the factor of a band, and numbers in it, up to which it is used. Above,
# conjugate gradients of some fifty rounds are faster.
LARGEST_FACTOR = 4e8
LARGEST_BAND = 2e7
# Time of a factor per multiplication, of a solution per number of the band, of one by conjugate
# gradients per spring, and of making the matrix per spring [s].
FACTOR, BAND, GRADIENTS, SPRING = 8e-11, 6e-10, 30 * 8e-9, 1.6e-8


class SolvingCost(NamedTuple):
    """The predicted time of one factor of the matrix, and of one solution [s]."""

    factor: float
    solution: float


def cost_of_springs(solver: Solver, springs: int) -> SolvingCost:
    """Return the cost of the matrix of springs alone.

    Args:
        solver: Its arrays.
        springs: Number of springs that act.
    """
    numbers = solver.band.size
    return SolvingCost(
        FACTOR * numbers * solver.band.shape[1] + SPRING * springs,
        BAND * numbers if numbers else GRADIENTS * springs,
    )


def no_solver() -> Solver:
    """Return an empty solver, as explicit methods have."""
    return Solver(
        slot=np.zeros(0, dtype=np.int64),
        band=np.zeros((0, 0)),
        bar=np.zeros((0, 5)),
        block=np.zeros((0, 6)),
        unknown=np.zeros(0),
        scratch=np.zeros((0, 0)),
        at=np.zeros(0),
        speed=np.zeros(0),
        made=np.zeros(5),
    )


def new_solver(
    low: NDArray[np.integer], high: NDArray[np.integer], free: NDArray[np.bool_]
) -> Solver:
    """Return empty arrays for the matrix of a net.

    Args:
        low, high: Ends of the springs that act, as places of nodes, shape (spring,).
        free: Which nodes are unknowns, shape (node,).
    """
    slot = _narrow(low, high, free)
    both = free[low] & free[high]
    width = int(np.abs(slot[low] - slot[high])[both].max(initial=0))
    band = 3 * width + 2
    size = 3 * int(np.count_nonzero(free))
    none = no_solver()._replace(
        slot=slot, at=np.zeros(3 * len(free)), speed=np.zeros(3 * len(free))
    )
    if size * float(band) ** 2 <= LARGEST_FACTOR and size * (band + 1) <= LARGEST_BAND:
        return none._replace(band=np.zeros((size, band + 1)), unknown=np.zeros(size))
    return none._replace(
        bar=np.zeros((len(low), 5)),
        block=np.zeros((len(free), 6)),
        scratch=np.zeros((4, 3 * len(free))),
    )


def unknown_solver(free: NDArray[np.bool_]) -> Solver:
    """Return the arrays of a solver whose matrix is that of ``StageMatrix``.

    Args:
        free: Which nodes are unknowns, shape (node,).
    """
    size = 3 * len(free)
    return no_solver()._replace(
        slot=np.where(free, np.cumsum(free) - 1, -1), at=np.zeros(size), speed=np.zeros(size)
    )


def _narrow(
    low: NDArray[np.integer], high: NDArray[np.integer], free: NDArray[np.bool_]
) -> Integers:
    """Return places of free nodes in an order of narrow band, -1 for held ones, shape (node,).

    The reverse order of Cuthill and McKee (1969; A. George 1971), from SciPy.
    """
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import reverse_cuthill_mckee

    slot = np.full(len(free), -1, dtype=np.int64)
    if not free.any():
        return slot  # of which SciPy finds no order
    number = np.where(free, np.cumsum(free) - 1, -1)
    both = free[low] & free[high]
    rows, columns = number[low[both]], number[high[both]]
    count = int(np.count_nonzero(free))
    graph = csr_matrix(
        (
            np.ones(2 * len(rows), dtype=np.int8),
            (np.append(rows, columns), np.append(columns, rows)),
        ),
        shape=(count, count),
    )
    order = reverse_cuthill_mckee(graph, symmetric_mode=True)
    place = np.empty(count, dtype=np.int64)
    place[order] = np.arange(count)
    slot[free] = place
    return slot


# Nodes from which on conjugate gradients solve, whatever the net; and multiplications for a
# factor, and numbers in it.
MOST_NODES = 50_000
LARGEST_WORK, LARGEST_FILL = 5e10, 1e8
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
        return self.numbers <= LARGEST_FILL and self.multiplications <= LARGEST_WORK

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
        joined = joined_nodes(free, ends, fields)
        joined.data[:] = -1.0
        degrees = np.diff(joined.indptr)
        graph = csc_matrix(joined + diags_array(2.0 + degrees, format="csc"))
        options = {"SymmetricMode": True, "DiagPivotThresh": 0.0}
        factor = splu(graph, permc_spec="MMD_AT_PLUS_A", options=options)
        columns = np.diff(factor.L.indptr).astype(float)
        return cls(18.0 * float(columns.sum()), 27.0 * float((columns**2).sum()))


def joined_nodes(
    free: NDArray[np.bool_], ends: NDArray[np.integer], fields: tuple[Field, ...]
) -> "csc_matrix":
    """Return a matrix that is not zero between free nodes of an item, shape (count, count).

    Hosts of embedded nodes are nodes of the items of these.

    Args:
        free: Which nodes are unknowns, shape (node,).
        ends: Nodes of the springs that act, shape (spring, 2).
        fields: The fields that act besides them.
    """
    from scipy.sparse import csc_matrix, csr_matrix

    every = np.arange(len(free))
    rows, nodes, start = [np.repeat(np.arange(len(ends)), 2)], [ends.ravel()], len(ends)
    for field in fields:
        items = field.items(every)
        if items is not None:
            counts = np.diff(items.first)
            rows.append(start + np.repeat(np.arange(len(counts)), counts))
            nodes.append(items.places)
            start += len(counts)
    moves, source, target = free.copy(), [every], [every]
    for field in fields:
        if isinstance(field, EmbeddedNodes):
            moves[field.nodes] = field.any_of(free)
            source.append(field.nodes[field.owners])
            target.append(field.hosts)
    row, node = np.concatenate(rows), np.concatenate(nodes).astype(np.int64)
    row, node = np.unique(np.stack([row, node])[:, moves[node]], axis=1)
    small = np.bincount(row, minlength=start)[row] <= WIDEST
    shape = start, len(free)
    member = csr_matrix((np.ones(small.sum()), (row[small], node[small])), shape=shape)
    if len(source) > 1:
        pairs = np.concatenate(source), np.concatenate(target)
        member = member @ csr_matrix((np.ones(len(pairs[0])), pairs), shape=(len(free),) * 2)
    member = member[:, free]
    return csc_matrix(member.T @ member)
