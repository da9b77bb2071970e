"""Rims of surfaces, the middles of the caps that close them, and where a surface is open.

The pairs of nodes at which triangles do not cancel form the rims of a surface. The cap of a rim
is the fan of triangles from its middle, the mean of its nodes, to its edges.

Beside planes of symmetry, the part that is drawn of a surface ends at the planes. Edges within
a plane cancel with their mirror images and are no rim. What is left of a rim begins and ends on
planes; its middle is that of the whole rim, with all mirror images:

    z = P Σ s_n x_n + Σ d_k n_k,        s_n = 2^(-k_n) / Σ 2^(-k),        P = 1 - Σ n_k n_kᵀ

for the planes n_k · x = d_k that it reaches, of which the node n is on k_n. As seen from a
point on all planes, the surfaces that close the drawn part along the planes enclose nothing.
"""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.errors import counted
from tissuec.forces.grouped_items import CarriedPoints
from tissuec.model.network import Floats, Indices, MirrorPlane, Network
from tissuec.model.topology import pieces

_NONE = 1e-9  # of a weight: less is due to rounding
_PARALLEL = 1e-6  # sine of an angle


class Crossing(Struct, frozen=True, eq=False):
    """The intersection of planes at right angles; all of space without any.

    Attributes:
        within: P, shape (3, 3).
        fixed: Σ d_k n_k [m], shape (3,).
    """

    within: Floats
    fixed: Floats

    @classmethod
    def of(cls, planes: Iterable[MirrorPlane]) -> "Crossing":
        """Return the intersection of planes, no two of which are parallel."""
        within, fixed = np.eye(3), np.zeros(3)
        for plane in planes:
            within -= np.outer(plane.normal, plane.normal)
            fixed += plane.normal * float(plane.normal @ plane.origin)
        return cls(within, fixed)

    @property
    def is_limited(self) -> bool:
        """Return whether there are planes."""
        return bool((self.within != np.eye(3)).any())

    def at(self, position: Floats) -> Floats:
        """Return the nearest points of the intersection [m], shape (…, 3).

        Args:
            position: [m], shape (…, 3).
        """
        return np.asarray(position @ self.within + self.fixed)


class Rim(NamedTuple):
    """One rim of a surface.

    Attributes:
        edges: Pairs of nodes in the direction of the surface, shape (edge, 2).
        weight: Of each edge, shape (edge,).
        nodes: Ascending, shape (node,).
        shares: s of each node, shape (node,).
        crossing: Of the planes of symmetry that it reaches.
    """

    edges: Indices
    weight: Floats
    nodes: Indices
    shares: Floats
    crossing: Crossing


class Rims(Struct, frozen=True, eq=False):
    """Rims of a surface, one after the other.

    Attributes:
        edges: Pairs of nodes in the direction of the surface, shape (edge, 2).
        weight: Of each edge, shape (edge,).
        first: The edges of a rim are first[rim]:first[rim + 1], shape (rim + 1,).
        nodes: Nodes of each rim, shape (node,).
        shares: s of each of these, shape (node,).
        node_first: Those of a rim are node_first[rim]:node_first[rim + 1], shape (rim + 1,).
        within: P of each rim, shape (rim, 3, 3).
        fixed: Σ d_k n_k of each [m], shape (rim, 3).
    """

    edges: Indices
    weight: Floats
    first: Indices
    nodes: Indices
    shares: Floats
    node_first: Indices
    within: Floats
    fixed: Floats

    @property
    def count(self) -> int:
        """Return the number of rims."""
        return len(self.first) - 1

    @property
    def of_edge(self) -> Indices:
        """Return the rim of each edge, shape (edge,)."""
        return np.repeat(np.arange(self.count), np.diff(self.first))

    @property
    def of_node(self) -> Indices:
        """Return the rim of each node, shape (node,)."""
        return np.repeat(np.arange(self.count), np.diff(self.node_first))

    @property
    def fans(self) -> Indices:
        """Return the triangles of caps: their middle r as -1 - r, and two nodes.

        The shape is (edge, 3).
        """
        return np.column_stack([-1 - self.of_edge, self.edges[:, 1], self.edges[:, 0]])

    @property
    def middles(self) -> CarriedPoints:
        """Return the middles, which nodes carry."""
        parts = self.shares[:, None, None] * self.within[self.of_node]
        return CarriedPoints(self.nodes, self.of_node, parts, self.fixed)

    def nodes_of(self, rim: int) -> Indices:
        """Return the nodes of a rim, ascending, shape (n,)."""
        return self.nodes[self.node_first[rim] : self.node_first[rim + 1]]

    def some(self, rims: Indices) -> "Rims":
        """Return some of the rims, by indices of shape (n,)."""
        return joined([self._rim(rim) for rim in rims.tolist()])

    def _rim(self, rim: int) -> Rim:
        edges = slice(self.first[rim], self.first[rim + 1])
        nodes = slice(self.node_first[rim], self.node_first[rim + 1])
        crossing = Crossing(self.within[rim], self.fixed[rim])
        return Rim(
            self.edges[edges], self.weight[edges], self.nodes[nodes], self.shares[nodes],
            crossing,
        )  # fmt: skip


def joined(rims: Sequence[Rim]) -> Rims:
    """Return rims one after the other."""
    none = np.zeros((0, 2), dtype=np.int64)
    counts = np.array([[len(rim.edges), len(rim.nodes)] for rim in rims] or none)
    first, node_first = np.vstack([[0, 0], counts.cumsum(axis=0)]).astype(np.int64).T
    return Rims(
        np.concatenate([none, *(rim.edges for rim in rims)]),
        np.concatenate([np.zeros(0), *(rim.weight for rim in rims)]),
        np.ascontiguousarray(first),
        np.concatenate([none[:, 0], *(rim.nodes for rim in rims)]),
        np.concatenate([np.zeros(0), *(rim.shares for rim in rims)]),
        np.ascontiguousarray(node_first),
        np.array([rim.crossing.within for rim in rims]).reshape(-1, 3, 3),
        np.array([rim.crossing.fixed for rim in rims]).reshape(-1, 3),
    )


def rims_of(corners: Indices, weight: Floats, planes: Sequence[MirrorPlane] = ()) -> Rims:
    """Return the rims of weighted triangles, in the order of their first node.

    Args:
        corners: Nodes of the triangles, shape (triangle, 3).
        weight: Of each, shape (triangle,).
        planes: Of symmetry, no two of which are parallel.
    """
    pairs = corners[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    weight, size = np.repeat(weight, 3), int(corners.max(initial=0)) + 1
    low, high = pairs.min(axis=1), pairs.max(axis=1)
    keys, place = np.unique(low * size + high, return_inverse=True)
    net = np.bincount(place, np.where(pairs[:, 0] == low, weight, -weight), len(keys))
    stays = np.abs(net) > _NONE
    edges, net = np.stack(np.divmod(keys[stays], size), axis=1), net[stays]
    stays = ~within_planes(edges, planes)
    edges, net = edges[stays], net[stays]
    edges[net < 0.0] = edges[net < 0.0][:, ::-1]
    nodes, ends = np.unique(edges, return_inverse=True)
    piece = pieces(len(nodes), ends.reshape(-1, 2).astype(np.int32))
    of_edge = piece[ends.reshape(-1, 2)[:, 0]] if len(edges) else piece[:0]
    found: list[Rim] = []
    for number in range(int(piece.max(initial=-1)) + 1):
        own = nodes[piece == number]
        reached = [plane for plane in planes if np.isin(own, plane.nodes).any()]
        shares = 0.5 ** planes_at(own, reached)
        found.append(
            Rim(
                edges[of_edge == number],
                np.abs(net[of_edge == number]),
                own,
                shares / shares.sum(),
                Crossing.of(reached),
            )
        )
    return joined(found)


def within_planes(edges: Indices, planes: Sequence[MirrorPlane]) -> NDArray[np.bool_]:
    """Return which edges lie within a plane, shape (edge,).

    Args:
        edges: Pairs of nodes, shape (edge, 2).
        planes: Of symmetry.
    """
    found = np.zeros(len(edges), dtype=bool)
    for plane in planes:
        found |= np.isin(edges, plane.nodes).all(axis=1)
    return found


def planes_at(nodes: Indices, planes: Sequence[MirrorPlane]) -> Indices:
    """Return on how many planes each node is, shape (node,)."""
    found = np.zeros(len(nodes), dtype=np.int64)
    for plane in planes:
        found += np.isin(nodes, plane.nodes)
    return found


def are_parallel(planes: Sequence[MirrorPlane]) -> bool:
    """Return whether two of the planes are parallel."""
    return any(
        bool(np.linalg.norm(np.cross(one.normal, other.normal)) < _PARALLEL)
        for k, one in enumerate(planes)
        for other in planes[:k]
    )


_MOST_NODES = 4  # that are named of one ring
_MOST_RINGS = 3


def where_open(network: Network, edges: Indices) -> str:
    """Return where the free edges of a surface are, by the nodes of the rings that they form.

    Args:
        edges: Node pairs, each in the direction of its triangle, shape (edge, 2).
    """
    rings = _rings(edges)
    named = [
        ", ".join(str(network.node_ids[node]) for node in ring[:_MOST_NODES])
        + (", …" if len(ring) > _MOST_NODES else "")
        for ring in rings[:_MOST_RINGS]
    ]
    more = " and others" if len(rings) > _MOST_RINGS else ""
    where = "along" if len(rings) == 1 else f"in {counted(len(rings), 'ring')} along"
    return f"{len(edges)} edges are free, {where} the nodes {' and '.join(named)}{more}"


def _rings(edges: Indices) -> list[list[int]]:
    """Return the nodes along free edges, ring by ring, each as far as it leads."""
    after: dict[int, list[int]] = {}
    for first, second in edges.tolist():
        after.setdefault(first, []).append(second)
    rings: list[list[int]] = []
    while after:
        node = next(iter(after))
        ring: list[int] = []
        while after.get(node):
            ring.append(node)
            following = after[node].pop()
            if not after[node]:
                del after[node]
            node = following
        rings.append(ring)
    return rings
