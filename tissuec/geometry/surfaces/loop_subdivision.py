"""Loop's subdivision of triangles: smooth surfaces over skins of any shape.

C. Loop, "Smooth subdivision surfaces based on triangles", University of Utah (1987). Every edge
gets a point, 3/8 of its ends and 1/8 of the corners opposite; every node of n neighbours moves
to (1 - n β) of itself and β of each neighbour,

    β = (5/8 - (3/8 + cos(2π/n)/4)²) / n.

Free and torn edges are cubic splines of their own nodes alone: 1/2 and 1/2, and 1/8, 3/4, 1/8
(H. Hoppe et al., "Piecewise smooth surface reconstruction", SIGGRAPH 1994). In the end all
points move to where further divisions would take them: to (1 - n ω) of themselves and
ω = 1/(3/(8β) + n) of each neighbour, or to 1/6, 2/3, 1/6 along free edges.
"""

from typing import TYPE_CHECKING, Annotated, ClassVar, NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.fields import Whole
from tissuec.geometry.surfaces import SURFACES
from tissuec.geometry.surfaces.skin import Refinement, Skin
from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:
    from scipy.sparse import csr_array


@SURFACES.member("loop subdivision")
class LoopSubdivision(Struct, frozen=True):
    """Loop's subdivision surface, with the nodes of any skin of triangles as control points.

    It stays within the hull of the nodes: a ball becomes slightly smaller, and a block loses
    its edges. Points lie on the limit surface of infinite subdivision. Free and torn edges
    become smooth curves of their own nodes; a node in which several of them meet stays in
    place.

    Attributes:
        subdivisions: How often every edge is halved.
    """

    needs_grid: ClassVar[bool] = False
    subdivisions: Annotated[int, Whole(at_least=1, at_most=6)] = 2

    def refine(self, skin: Skin) -> Refinement:
        """Return the map from nodes to the limit surface."""
        from scipy.sparse import csr_array

        used, corners = np.unique(skin.triangles[skin.is_whole], return_inverse=True)
        entries = np.ones(len(used)), used, np.arange(len(used) + 1)
        chosen = csr_array(entries, shape=(len(used), skin.nodes))
        net = TriangleNet.of(corners.reshape(-1, 3), len(used))
        for _ in range(self.subdivisions):
            chosen = net.divide() @ chosen
            net = net.divided()
        return Refinement((net.to_limit() @ chosen,), net.triangles)


class TriangleNet(NamedTuple):
    """A net of triangles and its edges.

    Attributes:
        triangles: Points, shape (triangle, 3).
        size: How many points there are.
        edges: Their ends, the lower first, shape (edge, 2).
        sides: The edge from each corner of a triangle to its next, shape (triangle, 3).
        is_inner: Which edges have a triangle on either hand, shape (edge,).
    """

    triangles: Indices
    size: int
    edges: Indices
    sides: Indices
    is_inner: NDArray[np.bool_]

    @classmethod
    def of(cls, triangles: Indices, size: int) -> "TriangleNet":
        """Return the net of triangles, given by corners of shape (triangle, 3).

        Args:
            triangles: Corners, shape (triangle, 3).
            size: Number of points.
        """
        pairs = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=-1), axis=-1)
        keys, sides, shared = np.unique(
            pairs[..., 0] * size + pairs[..., 1], return_inverse=True, return_counts=True
        )
        edges = np.stack(np.divmod(keys, max(size, 1)), axis=1)
        return cls(triangles, size, edges, sides.reshape(-1, 3), shared == 2)

    def divided(self) -> "TriangleNet":
        """Return the net in which every edge has a point in its middle."""
        a, b, c = self.triangles.T
        ab, bc, ca = self.size + self.sides.T
        quarters = ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
        triangles = np.stack([np.stack(quarter, axis=1) for quarter in quarters], axis=1)
        return TriangleNet.of(triangles.reshape(-1, 3), self.size + len(self.edges))

    def divide(self) -> "csr_array":
        """Return the weights of one subdivision, shape (point + edge, point)."""
        from scipy.sparse import csr_array, vstack

        return csr_array(vstack([self._smoothed(self._beta(), 0.125), self._middles()]))

    def to_limit(self) -> "csr_array":
        """Return the weights that take points to the limit surface, shape (point, point)."""
        inner = 1.0 / (0.375 / self._beta() + self._neighbours())
        return self._smoothed(inner, 1.0 / 6.0)

    def _neighbours(self) -> Indices:
        return np.bincount(self.edges.ravel(), minlength=self.size)

    def _beta(self) -> Floats:
        n = self._neighbours()
        return (0.625 - (0.375 + 0.25 * np.cos(2.0 * np.pi / n)) ** 2) / n

    def _smoothed(self, inner: Floats, border: float) -> "csr_array":
        """Return the weights of points among their neighbours.

        Args:
            inner: Weight of each neighbour of a point within the net, shape (point,).
            border: Weight of the two neighbours along a free edge.
        """
        from scipy.sparse import csr_array

        free = np.bincount(self.edges[~self.is_inner].ravel(), minlength=self.size)
        there = np.concatenate([self.edges, self.edges[:, ::-1]])
        is_inner = np.tile(self.is_inner, 2)
        at = free[there[:, 0]]
        weight = np.where(at == 0, inner[there[:, 0]], 0.0)
        weight = np.where((at == 2) & ~is_inner, border, weight)
        kept = 1.0 - np.bincount(there[:, 0], weight, minlength=self.size)
        same = np.arange(self.size)
        row, column = np.concatenate([there, np.stack([same, same], axis=1)]).T
        entries = np.concatenate([weight, kept]), (row, column)
        matrix = csr_array(entries, shape=(self.size, self.size))
        matrix.eliminate_zeros()
        return matrix

    def _middles(self) -> "csr_array":
        """Return the weights of the new points on edges, shape (edge, point)."""
        from scipy.sparse import csr_array

        opposite, inner = np.roll(self.triangles, 1, axis=1).ravel(), self.is_inner
        beside = np.flatnonzero(inner[self.sides.ravel()])
        number = np.arange(len(self.edges))
        ends = np.where(inner, 0.375, 0.5)
        row = np.concatenate([number, number, self.sides.ravel()[beside]])
        column = np.concatenate([*self.edges.T, opposite[beside]])
        weight = np.concatenate([ends, ends, np.full(len(beside), 0.125)])
        return csr_array((weight, (row, column)), shape=(len(self.edges), self.size))
