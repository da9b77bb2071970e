"""Where nodes, internal variables and springs of a network are in the stepping code.

Nodes are put in an order for springs in long runs, or for near neighbours, and keep their
places for a whole run. Springs are sorted by their lower and then by their upper node.
"""

from math import prod
from typing import NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.compiled.record_tables import aligned_zeros
from tissuec.core.structs import replace
from tissuec.engine.spring_runs import RunPlaces, are_shared, places_of
from tissuec.engine.threads import are_chunks, block_size, useful
from tissuec.model.network import FRICTION, Floats, Indices, Network
from tissuec.model.topology import lower_and_upper

Places = NDArray[np.integer]
SMALL = 2000  # nodes; below, everything stays in the cache in any order
FEW = 5000  # nodes whose tiles do, in any order with springs in runs
GAPS = 0.1  # part of runs from which on other orders are tried
TRIALS = 3
NONE: Indices = np.zeros(0, dtype=np.int64)
BITS = 21


class Layout(Struct, frozen=True, eq=False):
    """The places of the nodes and springs of a network, for a whole run.

    Attributes:
        order: The node or row of internal variables at each place, shape (place,).
        place: The place of each node, followed by those of rows of internal variables, -1 of
            those that are left out, shape (node + row,).
        nodes: How many of these are nodes.
        bodies: How many nodes of bodies have places; they come first.
        parked: Nodes without a place, each of which moves with another one, shape (n,).
        hosts: The node that each of them moves with, shape (n,).
        keeps_order: Whether nodes are where they are in the network.
        springs: Springs by their places; None where they are in this order in the network.
        runs: All springs in runs, by the numbers of the network; None where that is of no use.
        threads: How many share loops over nodes and springs.
    """

    order: Indices
    place: Indices
    nodes: int
    bodies: int
    keeps_order: bool
    springs: Indices | None
    runs: RunPlaces | None
    threads: int
    parked: Indices = NONE
    hosts: Indices = NONE

    def ends_of(self, ends: Places) -> tuple[Places, Places]:
        """Return the lower and the upper place of nodes that springs join, shape (spring,).

        Args:
            ends: Nodes of springs, shape (spring, 2).
        """
        if self.keeps_order:
            return lower_and_upper(ends.astype(np.int32, copy=False))
        return lower_and_upper(self.place.astype(np.int32).take(ends))

    def inwards(self, vector: Floats) -> Floats:
        """Return numbers or vectors of nodes in the order of the stepping code, flat.

        Args:
            vector: In the order of the network and in any unit, shape (node,) or (node, 3), or
                (node + row, 3); 0 for internal variables that it does not have.
        """
        rows = len(self.place) - len(vector)
        if rows:
            vector = np.concatenate([vector, np.zeros((rows, *vector.shape[1:]))])
        shape = (len(self.order), *vector.shape[1:])
        flat = aligned_zeros(prod(shape))
        # Clipped, because where it tests indices, NumPy keeps a second copy.
        np.take(vector, self.order, axis=0, out=flat.reshape(shape), mode="clip")
        return flat

    def outwards(self, flat: Floats) -> Floats:
        """Return flat vectors in the order of the network, shape (…, node + row, 3).

        Args:
            flat: In the order of the stepping code and in any unit, shape (…, 3 place); parked
                nodes have what their hosts have, and rows that are left out 0.
        """
        apart = flat.reshape(*flat.shape[:-1], len(self.order), 3)
        if self.keeps_order:
            return apart.copy()
        # Contiguous, unlike what an index in the middle returns, and twice as fast.
        found = apart.take(self.place, axis=-2)
        if len(self.order) < len(self.place):
            found[..., self.place < 0, :] = 0.0
            found[..., self.parked, :] = found[..., self.hosts, :]
        return found

    def of_nodes(self, flat: Floats) -> Floats:
        """Return those of nodes alone, shape (…, node, 3), in their unit; see ``outwards``."""
        return self.outwards(flat)[..., : self.nodes, :]

    def without(self, rows: Indices, parked: Indices, hosts: Indices) -> "Layout":
        """Return a layout without some rows of internal variables and some nodes.

        Args:
            rows: Shape (n,).
            parked, hosts: As the attributes, shape (m,) each.
        """
        out = np.zeros(len(self.place), dtype=bool)
        out[rows] = out[parked] = True
        order = self.order[~out[self.order]]
        place = np.full_like(self.place, -1)
        place[order] = np.arange(len(order))
        return replace(
            self, order=order, place=place, bodies=self.bodies - len(parked),
            keeps_order=self.keeps_order and not out.any(), parked=parked, hosts=hosts,
        )  # fmt: skip


def layout_of(network: Network, threads: int) -> Layout:
    """Return the layout of a network.

    Args:
        threads: That may share loops over nodes and springs; few nodes take fewer.
    """
    bodies, nodes, count = network.body_nodes, network.node_count, network.row_count
    order, runs = order_nodes(network.position[:bodies], network.line_ends)
    # Of bodies, nodes in reserve come last, so that others keep their places when these have
    # none.
    for part in network.phantoms:
        order = np.append(order[~np.isin(order, part.reserved)], part.reserved)
    # Nodes of tools come last, where measures of motion leave them out, after bristles, some
    # of which may be left out.
    bristles = network.remembering(FRICTION)
    others = np.setdiff1d(np.arange(nodes, count), bristles, assume_unique=True)
    order = np.concatenate([order, others, bristles, np.arange(bodies, nodes)])
    place = np.empty_like(order)
    place[order] = np.arange(count)
    if len(network.edges):
        places = _places(place[network.springs.ends])
        runs = places if places.is_worthwhile else None
    # Runs are counted by the numbers of the network, which only tools may change then.
    keeps_tools = np.array_equal(order[bodies:], np.arange(bodies, count))
    found = Layout(
        order=order,
        place=place,
        nodes=nodes,
        bodies=bodies,
        keeps_order=np.array_equal(place, np.arange(count)),
        springs=None,
        runs=runs if keeps_tools else None,
        threads=1,
    )
    low, high = found.ends_of(network.springs.ends)
    springs = None if _are_sorted(low, high) else np.lexsort((high, low))
    return replace(found, springs=springs, threads=_threads(network, threads, low, high, runs))


def _threads(
    network: Network, permitted: int, low: Places, high: Places, runs: RunPlaces | None
) -> int:
    """Return how many threads are of use."""
    count = useful(permitted, network.line_count)
    if count > 1:
        several = are_chunks(network.row_count)
        if runs is not None:
            several = are_shared(high, block_size(low, high))
        count = count if several else 1
    return count


def _are_sorted(low: Places, high: Places) -> bool:
    """Return whether springs are sorted by their lower and then by their upper ends."""
    upwards, same = low[1:] > low[:-1], low[1:] == low[:-1]
    return bool((upwards | (same & (high[1:] >= high[:-1]))).all())


class NodeOrder(NamedTuple):
    """An order of nodes.

    Attributes:
        order: The node to put at each place, shape (node,).
        runs: The springs in runs, if that is worthwhile.
    """

    order: Indices
    runs: RunPlaces | None


def order_nodes(position: Floats, ends: NDArray[np.int32]) -> NodeOrder:
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
        return NodeOrder(order, places)
    if count <= SMALL or not (extent := np.ptp(position, axis=0).max()):
        return NodeOrder(np.arange(count), None)
    cell = ((position - position.min(axis=0)) / extent * (2**BITS - 1)).astype(np.uint64)
    key = sum(_spread(cell[:, axis]) << np.uint64(axis) for axis in range(3))
    return NodeOrder(np.argsort(key, kind="stable"), None)


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
    apart = np.abs(ends[:, 1] - ends[:, 0])
    widths, counts = np.unique(apart[apart > 0], return_counts=True)
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
