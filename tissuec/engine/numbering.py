"""The order of nodes in the engine, for springs in long runs or for near neighbours."""

import numpy as np
from numpy.typing import NDArray

from tissuec.engine.spring_runs import RunPlaces, places_of
from tissuec.model.network import Floats, Indices

SMALL = 2000  # nodes; below, everything stays in the cache in any order
TRIALS = 3  # of other orders, where gaps in runs are more than this part of what they hold
GAPS = 0.1
BITS = 21


def node_order(position: Floats, ends: NDArray[np.int32]) -> Indices:
    """Return the node to put at each place, shape (node,).

    Few nodes are put in an order with long runs of springs. Many keep their places if their
    springs lie in runs, and are put in Morton order otherwise: the bits of the coordinates are
    interleaved (Morton 1966); equal keys keep their order.

    Args:
        position: Shape (node, 3) [m].
        ends: Nodes of springs, also of such that are not among these, shape (spring, 2).
    """
    if len(position) <= SMALL:
        return _order_for_runs(len(position), ends)
    if _places(ends).is_worthwhile:
        return np.arange(len(position))
    low = position.min(axis=0)
    extent = float(np.max(position.max(axis=0) - low))
    if extent == 0.0:
        return np.arange(len(position))
    cell = ((position - low) / extent * (2**BITS - 1)).astype(np.uint64)
    key = sum(_spread(cell[:, axis]) << np.uint64(axis) for axis in range(3))
    return np.argsort(key, kind="stable")


def _order_for_runs(nodes: int, ends: NDArray[np.int32]) -> Indices:
    """Return the best order of few nodes for runs of springs.

    Nodes of a tube are drawn ring by ring. Ring by ring, the springs from one ring to the next
    lie in runs with gaps, as the last node of a ring has none to the one that follows it; side
    by side, there are gaps at the ends only. So nodes are read by rows and by columns, in
    tables as wide as the differences of numbers that most springs have.

    Args:
        nodes: How many.
        ends: Shape (spring, 2).
    """
    order = np.arange(nodes)
    found = _places(ends)
    if (1.0 - GAPS) * found.size < len(ends):
        return order
    best, least = order, found.cost
    widths, counts = np.unique(np.abs(ends[:, 1] - ends[:, 0]), return_counts=True)
    for width in widths[np.argsort(-counts, kind="stable")][:TRIALS]:
        by_columns = np.lexsort((order // width, order % width))
        place = np.empty_like(order)
        place[by_columns] = order
        cost = _places(place[ends]).cost
        if cost < least:
            best, least = by_columns, cost
    return best


def _places(ends: NDArray[np.integer]) -> RunPlaces:
    """Return places in runs of springs between nodes."""
    return places_of(*np.sort(ends, axis=1).T)


def _spread(value: np.ndarray) -> np.ndarray:
    """Return values of 21 bits with two zeros put between any two bits."""
    for shift, mask in (
        (32, 0x1F00000000FFFF),
        (16, 0x1F0000FF0000FF),
        (8, 0x100F00F00F00F00F),
        (4, 0x10C30C30C30C30C3),
        (2, 0x1249249249249249),
    ):
        value = (value | (value << np.uint64(shift))) & np.uint64(mask)
    return value
