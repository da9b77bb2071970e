"""Springs in runs, which the processor takes eight at a time.

A run is a row of springs between the nodes (i, i + k), (i + 1, i + 1 + k), …, of which
lattices, tubes and sheets have many; springs of no strength fill short gaps. They need no lists
of nodes: all that belongs to a run lies in a row in memory.
"""

from dataclasses import dataclass

import numpy as np

from tissuec.kernels.records import Runs
from tissuec.kernels.runs import BLOCK
from tissuec.network import Floats, Indices

GAP = 8  # springs that are missing in a row, at most
# What a run costs, and each of its springs, beside a spring by itself.
RUN_COST, SPRING_COST = 3.5, 0.4
_NODES = 4096  # whose springs are kept together, as they fit into a cache


@dataclass(frozen=True, slots=True, eq=False)
class RunPlaces:
    """Where springs stand in runs.

    Attributes:
        first, length, offset, at: As in ``Runs``, shape (run,).
        place: Of each spring among those in runs, shape (spring,).
        size: How many those are, with what fills gaps.
    """

    first: Indices
    length: Indices
    offset: Indices
    at: Indices
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
    offset, block = high - low, low // _NODES
    if not len(low):
        none = np.zeros(0, dtype=np.int64)
        return RunPlaces(none, none, none, none, none, 0)
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
    return RunPlaces(first, length, offset[start], at, place, int(length.sum()))


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
    apart, each = np.zeros((9, nodes)), np.zeros((5, BLOCK))
    where = places.first, places.length, places.offset, places.at
    return Runs(*where, **filled, apart=apart, each=each)
