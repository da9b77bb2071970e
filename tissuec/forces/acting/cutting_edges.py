"""Edges of scalpels in tissue: what it takes to part it.

Each piece of an edge pushes a point of the tissue, its *anchor*, in the direction n in which it
cuts. Where the edge is g = n · (x_edge - x_anchor) ahead of it, the piece stores

    E = F g²/2ℓ up to the lag ℓ,    F (g - ℓ/2) beyond,    none for g < 0,

so that it never pushes with more than F, the cutting resistance of the tissue [J/m²] times the
width of the piece. Tissue is dented until the lag is reached. Then the anchor advances through
it (``script.edge_cut``): at g = ℓ, the force stays F, and the cut spends F times the way. The
lag keeps the force smooth, and does not change the energy of a cut.
"""

from collections.abc import Sequence
from functools import cached_property
from typing import Self

import numpy as np

from tissuec.autodiff import Number, Numbers, Vector, dot, maximum, where
from tissuec.core.arrays import counted_up
from tissuec.core.structs import replace
from tissuec.forces.grouped_items import NO_POINTS, GroupedItems
from tissuec.forces.pooled_fields import PooledField
from tissuec.model.network import Floats, Indices

KIND = "cutting edge"


def _ahead(x: Sequence[Vector], p: Numbers) -> Sequence[Number]:
    """Return the contribution of a node to how far the edge is ahead."""
    return [dot(p.shares, x[0])]


def _pushed(sums: Vector, seen: Vector, p: Numbers) -> Number:
    """Return the energy of a piece."""
    ahead = maximum(sums[0], 0.0)
    shared = 0.5 / p.lag * ahead**2
    return p.force * where(p.lag > ahead, shared, ahead - 0.5 * p.lag)


class CuttingEdge(PooledField, frozen=True):
    """Pieces of the edge of a tool, in tissue.

    Attributes:
        nodes: Those that carry anchors and edge, piece by piece, shape (host,).
        first: Where each piece begins among them and, last, where all end, shape (piece + 1,).
        weights: Of the nodes in how far the edge is ahead: those of the edge add up to 1, those
            of the anchor to -1, shape (host,).
        direction: n of each piece, shape (piece, 3).
        force: F [N], shape (piece,).
        lag: ℓ [m], shape (piece,).
    """

    item_shares = staticmethod(_ahead)
    group_energy = staticmethod(_pushed)

    nodes: Indices
    first: Indices
    weights: Floats
    direction: Floats
    force: Floats
    lag: Floats

    @classmethod
    def of(
        cls, piece: Indices, nodes: Indices, weights: Floats, direction: Floats,
        force: Floats, lag: float,
    ) -> Self:  # fmt: skip
        """Return pieces with the same direction and lag.

        Args:
            piece: Number of the piece that each node carries, of any numbers, shape (host,).
            nodes, weights: As of the class; of a piece, those of the edge come last.
            direction: Unit vector, shape (3,).
            force: Of the pieces, in the order of their numbers [N], shape (piece,).
            lag: [m].
        """
        order = np.argsort(piece, kind="stable")
        _, counts = np.unique(piece, return_counts=True)
        none = np.zeros(0, dtype=np.int64)
        return cls(
            walls=none, walled=none, nodes=nodes[order], first=np.append(0, np.cumsum(counts)),
            weights=weights[order], direction=np.tile(direction, (len(force), 1)), force=force,
            lag=np.full(len(force), lag),
        )  # fmt: skip

    @property
    def item_count(self) -> int:
        """Return the number of pieces."""
        return len(self.force)

    @cached_property
    def grouped(self) -> GroupedItems:
        """Return the nodes, piece by piece."""
        counts = np.diff(self.first)
        shares = self.weights * np.repeat(self.direction, counts, axis=0).T
        own = {"force": self.force, "lag": self.lag}
        seen = self.nodes[self.first[:-1]]
        return GroupedItems(
            self.nodes[:, None], self.first, seen, NO_POINTS, {"shares": shares}, own
        )

    def ahead(self, position: Floats) -> Floats:
        """Return how far the edge is ahead of the anchors [m], shape (…, piece).

        Args:
            position: Of all nodes [m], shape (…, node, 3).
        """
        return self.sums(position)[0]

    def only(self, items: Indices) -> "CuttingEdge":
        """Return some pieces."""
        counts = np.diff(self.first)[items]
        own = np.repeat(self.first[items], counts) + counted_up(counts)
        return replace(
            self, nodes=self.nodes[own], first=np.append(0, np.cumsum(counts)),
            weights=self.weights[own], direction=self.direction[items],
            force=self.force[items], lag=self.lag[items],
        )  # fmt: skip
