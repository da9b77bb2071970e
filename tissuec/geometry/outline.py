"""Sheets that cannot pass through themselves, because one side of them is fully visible.

How often a sheet covers a point of a picture is the winding number of its outline about that
point, if all of its triangles show the same side. Around a closed line that does not cross
itself it is at most one (P. Volino, N. Magnenat-Thalmann, Computer Graphics Forum 13, 1994,
155).
"""

from typing import Self

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.arrays import cross, norm
from tissuec.geometry.edges import Edges, Floats, Indices
from tissuec.model.topology import pieces

MOST = 1000  # edges of an outline, each of which is compared with all of them
STEEP = 1e-3  # cosine: triangles seen as steep as that may be seen from their other side


class Outline(Struct, frozen=True, eq=False):
    """A sheet whose triangles face alike, with one closed line around it.

    Attributes:
        triangles: Corners, shape (triangle, 3).
        nodes: On the line, shape (node,).
        ends: Places in ``nodes`` of both ends of its edges, shape (edge, 2).
        apart: Which edges have no end in common, shape (edge, edge).
    """

    triangles: Indices
    nodes: Indices
    ends: Indices
    apart: NDArray[np.bool_]

    @classmethod
    def of(cls, edges: Edges) -> Self | None:
        """Return the sheet with these edges; None if they do not belong to such a sheet."""
        around = edges.ends[edges.count == 1]
        if not 0 < len(around) <= MOST or edges.count.max() > 2 or not edges.pairs[2].all():
            return None
        nodes, ends = np.unique(around, return_inverse=True)
        ends = ends.reshape(-1, 2)
        if (np.bincount(ends.ravel()) != 2).any() or pieces(len(nodes), ends).any():
            return None
        joined = (ends[:, None, :, None] == ends[None, :, None]).any(axis=(2, 3))
        return cls(edges.triangles, nodes, ends, ~joined)

    def is_simple(self, position: Floats) -> bool:
        """Return whether the sheet hides no part of itself, seen along its mean normal.

        Args:
            position: Of all nodes [m], shape (node, 3).
        """
        a, b, c = position[self.triangles].swapaxes(0, 1)
        normals = cross(b - a, c - a)
        towards = normals.sum(axis=0)
        if (normals @ towards <= STEEP * norm(normals) * norm(towards)).any():
            return False
        right = cross(towards, np.eye(3)[np.abs(towards).argmin()])
        seen = position[self.nodes] @ np.stack([right, cross(towards, right)], axis=1)
        start, end = seen[self.ends].swapaxes(0, 1)
        low, high = np.minimum(start, end), np.maximum(start, end)
        (x, y), (u, v), (first, last) = seen.T, (end - start).T, self.ends.T
        sides = u[:, None] * (y - start[:, 1, None]) - v[:, None] * (x - start[:, 0, None])
        cut = self.apart & (sides[:, first] * sides[:, last] <= 0.0)
        for axis in range(2):  # those on a straight line cut each other only if they meet
            cut &= low[:, axis, None] <= high[:, axis]
        return not (cut & cut.T).any()
