"""Tools in the file: where the nodes of their shapes are, and who holds what."""

from collections.abc import Iterator, Mapping, Sequence
from math import inf
from typing import Any

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.model.network import Floats, Indices, Network
from tissuec.results.access import Contents, ResultGroup
from tissuec.results.finite import check_finite
from tissuec.results.schema import HOLDS, TOOL_FRAMES
from tissuec.results.store import ColumnTable, Store

FIX = "fix"  # the holder of fixed nodes


class HoldInterval(Struct, frozen=True, eq=False):
    """Nodes that a holder holds from a time on, until the next interval of the same holder.

    Attributes:
        time: When [s].
        holder: "fix", or the name of a tool or set.
        nodes: Network numbers, shape (node,); none when everything is released.
    """

    time: float
    holder: str
    nodes: Indices


def with_ends(holds: Sequence[HoldInterval]) -> Iterator[tuple[HoldInterval, float]]:
    """Yield the intervals in which nodes are held, and the end of each [s]; infinite without.

    Args:
        holds: In order of time.
    """
    for number, hold in enumerate(holds):
        if len(hold.nodes):
            later = (one.time for one in holds[number + 1 :] if one.holder == hold.holder)
            yield hold, next(later, inf)


class ToolTable:
    """Positions of the nodes of tools in each frame; nothing is written without such nodes."""

    def __init__(self, store: Store, network: Network, kind: str):
        self._store, self._network, self._kind = store, network, kind
        self._nodes = np.arange(network.body_nodes, network.node_count)
        self._position = None
        if len(self._nodes):
            self._position = store.column(TOOL_FRAMES["position"].of(kind=kind))

    def checked(self, position: NDArray[Any], time: Floats) -> NDArray[Any]:
        """Return the positions of the nodes of tools as they are recorded [m].

        Args:
            position: Of all nodes [m], shape (frame, node, 3).
            time: Times of the frames [s], shape (frame,).

        Returns:
            Positions [m], shape (frame, tool node, 3).

        Raises:
            ValueError: One is not finite.
        """
        with np.errstate(over="ignore"):  # such a number is reported as not finite
            found = position[:, self._nodes].astype(self._kind)
        check_finite(found, "position", time, self._network, self._nodes, "node")
        return found

    def append(self, position: NDArray[Any]) -> None:
        """Add checked frames of positions [m], shape (frame, node, 3)."""
        if self._position is not None:
            self._store.append({self._position: position.reshape(-1, 3)})


class HoldTable:
    """One row for each time that a holder takes nodes or lets go of some."""

    def __init__(self, store: Store, network: Network):
        self._table, self._bodies = ColumnTable(store, HOLDS), network.body_nodes
        self._held = {hold.holder: hold.nodes for hold in read_holds(store.content)}

    def set(self, time: float, holders: Mapping[str, Indices]) -> None:
        """Set which nodes are held from now on; only changes are written.

        Args:
            time: The time [s].
            holders: Indices of nodes by holder, shape (n,) each.
        """
        none = np.zeros(0, dtype=np.int64)
        for holder in [*holders, *(name for name in self._held if name not in holders)]:
            nodes = np.asarray(holders.get(holder, none), dtype=np.int64)
            nodes = nodes[nodes < self._bodies]  # tools carry themselves
            if not np.array_equal(nodes, self._held.get(holder, none)):
                self._held[holder] = nodes
                self._append(HoldInterval(time, holder, nodes))

    def _append(self, hold: HoldInterval) -> None:
        rows = {"time": [hold.time], "holder": [hold.holder], "nodes": hold.nodes}
        first, count = [self._table["nodes"].rows], [len(hold.nodes)]
        self._table.append(rows | {"first_node": first, "node_count": count})


def read_holds(file: ResultGroup) -> tuple[HoldInterval, ...]:
    """Return who held what since when, in order."""
    found = Contents(file, HOLDS)
    return tuple(
        HoldInterval(time, holder, found["nodes"][first : first + count])
        for time, holder, first, count in found.rows(
            "time", "holder", "first_node", "node_count"
        )
    )
