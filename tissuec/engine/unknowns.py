"""The unknowns of implicit steps: their order, whether their matrix is banded, its cost."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.kernels.records import Integers, Solver

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
