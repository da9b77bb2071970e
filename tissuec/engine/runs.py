"""Springs in runs, which the processor takes eight at a time.

A run is a row of springs between the nodes (i, i + k), (i + 1, i + 1 + k), …, of which
lattices, tubes and sheets have many; springs of no strength fill short gaps. They need no lists
of nodes: all that belongs to a run lies in a row in memory.

Runs are kept in blocks by their lower nodes. Where no spring is longer than a block, every
other block has no node in common with the next one, so that threads can do these at a time.
"""

import numpy as np
from msgspec import Struct

from tissuec.kernels.records import Runs
from tissuec.kernels.teams import PIECE
from tissuec.network import Floats, Indices

GAP = 8  # springs that are missing in a row, at most
# What a run costs, and each of its springs, beside a spring by itself.
RUN_COST, SPRING_COST = 3.5, 0.4
BLOCK_NODES = 1024  # of a block, at least; what belongs to its springs fits into a cache
LEAST_BLOCKS = 4  # that are worth being shared by threads


class RunPlaces(Struct, frozen=True, eq=False):
    """Where springs stand in runs.

    Attributes:
        first, length, offset, at: As in ``Runs``, shape (run,).
        block: As in ``Runs``; a single one if some springs are too long for several.
        place: Of each spring among those in runs, shape (spring,).
        size: How many those are, with what fills gaps.
    """

    first: Indices
    length: Indices
    offset: Indices
    at: Indices
    block: Indices
    place: Indices
    size: int

    @property
    def is_worthwhile(self) -> bool:
        """Return whether forces are computed faster in runs."""
        return RUN_COST * len(self.first) + SPRING_COST * self.size < len(self.place)


def places_of(low: Indices, high: Indices) -> RunPlaces:
    """Return springs in runs.

    Args:
        low, high: Their ends as places of nodes, low < high, shape (spring,).
    """
    low, high = np.asarray(low, dtype=np.int64), np.asarray(high, dtype=np.int64)
    offset = high - low
    if not len(low):
        none = np.zeros(0, dtype=np.int64)
        return RunPlaces(none, none, none, none, np.zeros(1, dtype=np.int64), none, 0)
    size = block_size(low, high)
    apart = are_several(high, size)
    block = low // (size if apart else 4 * BLOCK_NODES)
    order = np.lexsort((low, offset, block))
    offset, block, ordered = offset[order], block[order], low[order]
    step = np.diff(ordered)
    goes_on = (np.diff(offset) == 0) & (np.diff(block) == 0) & (step > 0) & (step <= GAP + 1)
    start = np.flatnonzero(np.concatenate([[True], ~goes_on]))
    stop = np.append(start[1:], len(low))
    first = ordered[start]
    length = ordered[stop - 1] - first + 1
    at = np.concatenate([[0], np.cumsum(length)[:-1]])
    place = np.empty(len(low), dtype=np.int64)
    place[order] = np.repeat(at - first, stop - start) + ordered
    # Where the runs of each block begin; one that has none begins where the next one does.
    bounds = np.arange(block[-1] + 2) if apart else [0, block[-1] + 1]
    blocks = np.searchsorted(block[start], bounds)
    return RunPlaces(first, length, offset[start], at, blocks, place, int(length.sum()))


def block_size(low: Indices, high: Indices) -> int:
    """Return how many nodes a block has, so that no spring is longer."""
    longest = int((high - low).max(initial=0))
    return -(-max(longest, BLOCK_NODES) // PIECE) * PIECE


def are_several(high: Indices, size: int) -> bool:
    """Return whether there are several blocks of a size, so that threads can share them."""
    return int(high.max(initial=0)) + 1 >= LEAST_BLOCKS * size


def packed(places: RunPlaces, nodes: int, **values: Floats | None) -> Runs:
    """Return springs in runs for the stepping code.

    Args:
        nodes: How many there are.
        **values: ``stiffness``, ``damping``, ``rest``, ``near`` and ``near_crush`` of springs,
            shape (spring,); None for what no spring has.
    """
    fills = {"near": np.inf, "near_crush": np.inf}
    filled: dict[str, Floats] = {}
    for name, value in values.items():
        filled[name] = np.full(0 if value is None else places.size, fills.get(name, 0.0))
        if value is not None:
            filled[name][places.place] = value
    where = places.first, places.length, places.offset, places.at, places.block
    return Runs(*where, **filled, apart=np.zeros((9, nodes)))
