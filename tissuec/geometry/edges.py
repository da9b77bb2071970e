"""Triangles: edges that they share, parallelograms that they form, and how they are found.

Triangles that share an edge face the same way where they run along it in opposite directions.

Thirds of triangles depend on which diagonal divides a parallelogram; quarters of it do not.
"""

from functools import cached_property
from typing import TypeAlias

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.model.topology import pieces

Floats: TypeAlias = NDArray[np.float64]
Indices: TypeAlias = NDArray[np.int64]


class Edges(Struct, frozen=True, eq=False, dict=True):
    """The edges of a set of triangles.

    Attributes:
        triangles: Corners, shape (triangle, 3).
        ends: Both nodes of each edge, lower one first, shape (edge, 2), in ascending order.
        count: How many triangles have each edge, shape (edge,).
        of: Edges of each triangle: of its corners 0-1, 1-2 and 2-0, shape (triangle, 3).
    """

    triangles: Indices
    ends: Indices
    count: Indices
    of: Indices

    @classmethod
    def among(cls, triangles: Indices) -> "Edges":
        """Return the edges of triangles, given by corners of shape (triangle, 3)."""
        first, second = triangles, np.roll(triangles, -1, axis=1)
        size = int(triangles.max(initial=0)) + 1
        keys = (np.minimum(first, second) * size + np.maximum(first, second)).ravel()
        found, number, count = np.unique(keys, return_inverse=True, return_counts=True)
        ends = np.stack(np.divmod(found, size), axis=1)
        return cls(triangles, ends, count, number.reshape(-1, 3))

    @property
    def is_closed(self) -> bool:
        """Return whether each edge belongs to exactly two triangles, and there are some."""
        return bool(len(self.count)) and bool(np.all(self.count == 2))

    def holes(self) -> list[Indices]:
        """Return the nodes around each hole: those of connected edges of one triangle.

        The largest number of nodes comes first.
        """
        ends = self.ends[self.count == 1]
        if not len(ends):
            return []
        nodes, number = np.unique(ends, return_inverse=True)
        label = pieces(len(nodes), number.reshape(-1, 2))
        found = [nodes[label == one] for one in np.unique(label)]
        return sorted(found, key=len, reverse=True)

    @cached_property
    def pairs(self) -> tuple[Indices, Indices, NDArray[np.bool_]]:
        """Return the two triangles at each edge with exactly two, and whether they face alike.

        Each of the three arrays has the shape (pair,).
        """
        order = np.argsort(self.of.ravel(), kind="stable")
        upward = (self.triangles < np.roll(self.triangles, -1, axis=1)).ravel()[order]
        start = (np.cumsum(self.count) - self.count)[self.count == 2]
        triangle = order // 3
        return triangle[start], triangle[start + 1], upward[start] != upward[start + 1]

    def facing_alike(self) -> tuple[NDArray[np.bool_], Indices, int]:
        """Return how to make the triangles agree with their neighbours.

        Each triangle has two nodes in a graph, one for each orientation; they are joined to
        the nodes of neighbours that agree with them. Consistent orientations are connected
        parts.

        Returns:
            Which triangles are to be turned, shape (triangle,), so that the lowest of each
            patch stays; the number of the patch that each belongs to; and how many patches
            cannot agree at all, as a Moebius strip.
        """
        one, other, agrees = self.pairs
        size, turn = len(self.triangles), np.where(agrees, 0, len(self.triangles))
        joined = np.concatenate(
            [np.stack([one, other + turn], 1), np.stack([one + size, other + size - turn], 1)]
        )
        label = pieces(2 * size, joined).astype(np.int64)
        kept, turned = label[:size], label[size:]
        patch = np.minimum(kept, turned)
        return turned < kept, patch, len(np.unique(patch[kept == turned]))


def volume(position: Floats, triangles: Indices) -> float:
    """Return the volume that closed triangles enclose [m³], negative if they face inwards.

    Args:
        position: Of the nodes [m], shape (node, 3).
        triangles: Corners, shape (triangle, 3).
    """
    if not len(triangles):
        return 0.0
    a, b, c = (position[triangles] - position[triangles[0, 0]]).swapaxes(0, 1)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


_Indices = NDArray[np.int64]


class TriangleIndex:
    """Finds triangles by their corners in any order.

    Args:
        triangles: Nodes, fewer than two million, shape (triangle, 3).
    """

    def __init__(self, triangles: NDArray[np.integer]):
        self._keys = _keys(triangles)
        self._order = np.argsort(self._keys)

    def find(self, triangles: NDArray[np.integer]) -> _Indices:
        """Return the index of each triangle, -1 for one that is absent.

        Args:
            triangles: Nodes, shape (n, 3).

        Returns:
            Indices, shape (n,).
        """
        if not len(self._keys):
            return np.full(len(triangles), -1)
        wanted = _keys(triangles)
        place = np.searchsorted(self._keys, wanted, sorter=self._order)
        place = self._order[np.minimum(place, len(self._keys) - 1)]
        return np.where(self._keys[place] == wanted, place, -1)


def _keys(triangles: NDArray[np.integer]) -> _Indices:
    low, middle, high = np.sort(triangles.astype(np.int64), axis=1).T
    return (low << 42) | (middle << 21) | high


NEAR = 1e-6  # of a length: what is shorter than this is rounding


def parallelograms(position: Floats, triangles: Indices) -> tuple[Indices, Indices]:
    """Return the parallelograms that lie across the longest edge of both their triangles.

    Args:
        position: [m], shape (node, 3).
        triangles: Of a surface, all facing the same side, shape (triangle, 3).

    Returns:
        Corners in turn as their triangles have them, divided between the second and the last,
        and the numbers of these triangles; shapes (parallelogram, 4) and (parallelogram, 2).
    """
    corners = position[triangles]
    opposite = np.linalg.norm(
        np.roll(corners, -1, axis=1) - np.roll(corners, 1, axis=1), axis=2
    )
    apex = np.argmax(opposite, axis=1)
    length = np.sort(opposite, axis=1)
    number = np.flatnonzero(length[:, 1] < (1.0 - NEAR) * length[:, 2])
    turned = (apex[number, None] + np.arange(3)) % 3
    rows = np.take_along_axis(triangles[number], turned, axis=1)  # the apex first
    diagonal = np.sort(rows[:, 1:], axis=1).T
    order = np.lexsort(diagonal)
    first, second = order[:-1], order[1:]
    is_pair = (diagonal[:, first] == diagonal[:, second]).all(axis=0)
    first, second = first[is_pair], second[is_pair]
    found = np.stack([rows[first, 0], rows[first, 1], rows[second, 0], rows[first, 2]], axis=1)
    a, b, c, d = position[found].swapaxes(0, 1)
    flat = np.linalg.norm(a + c - b - d, axis=1) < NEAR * length[number[first], 2]
    return found[flat], np.stack([number[first], number[second]], axis=1)[flat]
