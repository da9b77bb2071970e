"""The order of nodes in the engine, for springs in long runs or for near neighbours."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.engine.spring_runs import RunPlaces, places_of
from tissuec.model.network import Floats, Indices
from tissuec.model.topology import lower_and_upper

SMALL = 2000  # nodes; below, everything stays in the cache in any order
FEW = 5000  # nodes whose tiles do, in any order with springs in runs
GAPS = 0.1  # part of runs from which on other orders are tried
TRIALS = 3
BITS = 21


class Numbering(NamedTuple):
    """The order of nodes in the engine.

    Attributes:
        order: The node to put at each place, shape (node,).
        runs: The springs in runs, if that is worthwhile.
    """

    order: Indices
    runs: RunPlaces | None


def number_nodes(position: Floats, ends: NDArray[np.int32]) -> Numbering:
    """Return the order of nodes.

    If their springs lie in runs, nodes keep their places, or are put in an order with longer
    runs if they are few. Otherwise, unless they are even fewer, they are put in Morton order:
    the bits of the coordinates are interleaved (Morton 1966); equal keys keep their order.

    Args:
        position: Shape (node, 3) [m].
        ends: Nodes of springs, also of such that are not among these, shape (spring, 2).
    """
    count = len(position)
    order, places = np.arange(count), _places(ends)
    if count <= FEW and places.size - len(ends) > GAPS * places.size:
        order, places = _by_columns(count, ends, places)
    if places.is_worthwhile:
        return Numbering(order, places)
    if count <= SMALL or not (extent := np.ptp(position, axis=0).max()):
        return Numbering(np.arange(count), None)
    cell = ((position - position.min(axis=0)) / extent * (2**BITS - 1)).astype(np.uint64)
    key = sum(_spread(cell[:, axis]) << np.uint64(axis) for axis in range(3))
    return Numbering(np.argsort(key, kind="stable"), None)


def _by_columns(
    nodes: int, ends: NDArray[np.int32], drawn: RunPlaces
) -> tuple[Indices, RunPlaces]:
    """Return the best of some orders for runs of springs, and the places of springs in it.

    Nodes of a tube are drawn ring by ring. Ring by ring, the springs from one ring to the next
    lie in runs with gaps, as the last node of a ring has none to the one that follows it; side
    by side, there are gaps at the ends only. So nodes are read by rows and by columns, in
    tables as wide as the differences of numbers that most springs have.

    Args:
        nodes: How many.
        ends: Shape (spring, 2).
        drawn: Places in the order in which nodes are drawn.
    """
    as_drawn = np.arange(nodes)
    best, least = as_drawn, drawn
    place = np.arange(max(nodes, int(ends.max(initial=0)) + 1))
    widths, counts = np.unique(np.abs(ends[:, 1] - ends[:, 0]), return_counts=True)
    for width in widths[np.argsort(-counts, kind="stable")][:TRIALS]:
        order = np.lexsort((as_drawn // width, as_drawn % width))
        place[order] = as_drawn
        places = _places(place[ends])
        if places.cost < least.cost:
            best, least = order, places
    return best, least


def _places(ends: NDArray[np.integer]) -> RunPlaces:
    """Return places in runs of springs between nodes."""
    return places_of(*lower_and_upper(ends))


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
