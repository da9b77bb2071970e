"""Springs that support an edge of a skin, and when the edge tears.

Springs side by side are one *strand*. An edge with a strand tears when the last of its springs
is gone. Some skins have edges without springs, such as the diagonals of a face, or all edges of
a lattice whose springs run inside: such an edge tears when all pairs of strands are broken that
led from its one end to its other by way of a third node. Where no pair led either, it tears
when its ends come to be in different pieces of the net.
"""

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.arrays import counted_up
from tissuec.model.network import Indices
from tissuec.model.topology import pieces


class EdgeSupports(Struct, frozen=True, eq=False):
    """The strands at some nodes of a network, numbered by the node pairs that they join.

    Attributes:
        ends: Nodes of each spring of the network, shape (spring, 2).
        keys: One number for each pair of nodes that springs join, ascending, shape (strand,).
        springs: The springs in them, shape (member,).
        of_spring: The strand of each of these, shape (member,).
    """

    ends: NDArray[np.integer]
    keys: Indices
    springs: NDArray[np.integer]
    of_spring: NDArray[np.integer]

    @classmethod
    def at_nodes(cls, ends: NDArray[np.integer], nodes: NDArray[np.integer]) -> "EdgeSupports":
        """Return the strands with an end at some of ``nodes``.

        Args:
            ends: Nodes of each spring of the network, shape (spring, 2).
            nodes: Shape (…).
        """
        chosen = np.zeros(max(int(a.max(initial=-1)) for a in (ends, nodes)) + 1, dtype=bool)
        chosen[nodes] = True
        springs = np.flatnonzero(chosen[ends].any(axis=1))
        keys, of_spring = np.unique(_edge_keys(ends[springs]), return_inverse=True)
        small = np.int32 if len(ends) <= np.iinfo(np.int32).max else np.int64
        return cls(ends, keys, springs.astype(small), of_spring.reshape(-1).astype(small))

    def along(self, edges: NDArray[np.integer]) -> Indices:
        """Return the strand along each edge or -1, shape (…); edges are pairs (…, 2)."""
        wanted = _edge_keys(edges)
        if not len(self.keys):
            return np.full(wanted.shape, -1, dtype=np.int64)
        found = np.minimum(np.searchsorted(self.keys, wanted), len(self.keys) - 1)
        return np.where(self.keys[found] == wanted, found, -1)

    def at(self, nodes: Indices) -> tuple[Indices, Indices, Indices]:
        """Return the strands at nodes.

        Args:
            nodes: Indices, shape (n,).

        Returns:
            Rows of ``nodes``, strands, and their other ends, each of shape (found,).
        """
        low, high = self.keys >> 32, self.keys & 0xFFFFFFFF
        here, there = np.concatenate([low, high]), np.concatenate([high, low])
        order = np.argsort(here, kind="stable")
        first = np.searchsorted(here, nodes, sorter=order)
        count = np.searchsorted(here, nodes, side="right", sorter=order) - first
        row = np.repeat(np.arange(len(nodes)), count)
        found = order[first[row] + counted_up(count)]
        return row, found % max(len(low), 1), there[found]

    def holding(self, alive: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return which strands hold while entities, shape (entity,), are ``alive``."""
        held = self.of_spring[alive[self.springs]]
        return np.bincount(held, minlength=len(self.keys)) > 0


class SupportedEdges(Struct, frozen=True, eq=False):
    """Edges and the strands that support them.

    Attributes:
        strands: At the nodes of the edges.
        own: The strand along each edge or -1, shape (…).
        by_way: Edges without a strand as flat numbers, one row for each way, shape (way,).
        ways: The two strands of each way, shape (way, 2).
        loose: Edges that nothing leads along but are within one piece, shape (edge,).
        loose_ends: Their nodes, shape (edge, 2).
        elements: As for ``of``.
    """

    strands: EdgeSupports
    own: Indices
    by_way: Indices
    ways: Indices
    loose: Indices
    loose_ends: Indices
    elements: Indices | None = None

    @classmethod
    def of(
        cls,
        springs: NDArray[np.integer],
        edges: NDArray[np.integer],
        elements: Indices | None = None,
    ) -> "SupportedEdges":
        """Return the supports of edges.

        Args:
            springs: Nodes of each spring of the network, shape (spring, 2).
            edges: Pairs of nodes, shape (…, 2), such as (triangle, 3, 2).
            elements: The element of each triangle, without which none of its edges holds, as an
                entity, or -1, shape (triangle,); None where no element may break.
        """
        strands = EdgeSupports.at_nodes(springs, edges)
        own = strands.along(edges)
        bare = np.flatnonzero(own.reshape(-1) < 0)
        ends = np.asarray(edges, dtype=np.int64).reshape(-1, 2)[bare]
        edge, first, third = strands.at(ends[:, 0])
        second = strands.along(np.stack([third, ends[edge, 1]], axis=1))
        there = second >= 0
        ways = np.stack([first[there], second[there]], axis=1)
        by_way = bare[edge[there]]
        lonely = ~np.isin(bare, by_way)
        loose, ends = bare[lonely], ends[lonely]
        piece = _pieces(strands.ends, ends)
        joined = piece[ends[:, 0]] == piece[ends[:, 1]]
        return cls(strands, own, by_way, ways, loose[joined], ends[joined], elements)

    def holding(self, alive: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return which edges hold while the entities ``alive``, shape (entity,), are there."""
        strands = self.strands.holding(alive)
        whole = self.own.reshape(-1) < 0
        whole[self.by_way] = False
        whole[self.by_way[strands[self.ways].all(axis=1)]] = True
        piece = _pieces(self.strands.ends[alive[: len(self.strands.ends)]], self.loose_ends)
        whole[self.loose] = piece[self.loose_ends[:, 0]] == piece[self.loose_ends[:, 1]]
        whole = whole.reshape(self.own.shape)
        has_strand = self.own >= 0
        whole[has_strand] = strands[self.own[has_strand]]
        if self.elements is not None:
            whole[~alive[self.elements] & (self.elements >= 0)] = False
        return whole


class SupportedTriangles:
    """Triangles of a skin, of which those are whole whose edges hold.

    Args:
        springs: Nodes of each spring of the network, shape (spring, 2).
        triangles: Corners, shape (triangle, 3).
        elements: As for ``SupportedEdges.of``.
    """

    def __init__(
        self, springs: NDArray[np.integer], triangles: Indices, elements: Indices | None = None
    ):
        self._springs, self.triangles, self._elements = springs, triangles, elements
        self._edges: SupportedEdges | None = None

    def whole(self, alive: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return which triangles are neither cut nor torn, shape (triangle,).

        Args:
            alive: Entities that are there, shape (entity,).
        """
        if alive.all():
            return np.ones(len(self.triangles), dtype=bool)
        if self._edges is None:
            following = np.roll(self.triangles, -1, axis=1)
            sides = np.stack([self.triangles, following], axis=-1)
            self._edges = SupportedEdges.of(self._springs, sides, self._elements)
        return np.asarray(self._edges.holding(alive).all(axis=1))


def _pieces(ends: NDArray[np.integer], edges: Indices) -> Indices:
    """Return the piece that each node belongs to, if there are any edges to examine."""
    if not len(edges):
        return np.zeros(0, dtype=np.int64)
    count = max(int(ends.max(initial=0)), int(edges.max())) + 1
    return pieces(count, ends).astype(np.int64)


def _edge_keys(ends: NDArray[np.integer]) -> Indices:
    """Return one number per unordered node pair of the last axis."""
    pairs = np.sort(np.asarray(ends, dtype=np.int64), axis=-1)
    return (pairs[..., 0] << 32) | pairs[..., 1]
