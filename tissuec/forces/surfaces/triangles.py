"""Triangles of the skin on which forces act, and how their areas depend on positions.

Of a triangle with corners x0, x1, x2, let e_i be the edge opposite of x_i, from the corner
behind it in the triangle to the one in front of it, and n the unit normal. Its area is
A = |e1 × e2| / 2, and

    ∂A/∂x_i = n × e_i / 2,
    ∂²A/∂x_i∂x_j = (e_i · e_j) n nᵀ / 4A + s_ij [n] / 2,

where [n] d = n × d, and s_ij is -1 if j follows i, 1 if i follows j, and 0 if i is j. The first
part belongs to motions out of the plane, and is never negative; the second one to motions
within the plane, where the area is a quadratic function. A triangle without area has no normal
and exerts no forces.
"""

from typing import TYPE_CHECKING

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.arrays import cross
from tissuec.forces.matrices import assembled
from tissuec.geometry.edge_supports import SupportedTriangles
from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

#: s_ij of the second derivatives.
_TURNS = np.array([[0.0, -1.0, 1.0], [1.0, 0.0, -1.0], [-1.0, 1.0, 0.0]])
#: [n] of n = (1, 0, 0), (0, 1, 0) and (0, 0, 1), by the component, the row and the column.
_CROSS = -np.array(
    [[[0, 0, 0], [0, 0, 1], [0, -1, 0]], [[0, 0, -1], [0, 0, 0], [1, 0, 0]],
     [[0, 1, 0], [-1, 0, 0], [0, 0, 0]]], dtype=float,
)  # fmt: skip


class SkinTriangles:
    """Triangles of the skin of a network.

    Args:
        corners: Nodes, shape (triangle, 3).
        rows: Their numbers among all triangles of the skin, shape (triangle,).
        drawn: Their areas as drawn [m²], shape (triangle,).
        ends: Nodes of each spring of the network, shape (spring, 2).
        elements: The element of each, an entity, or -1, shape (triangle,); None where
            no element may break.

    Attributes:
        corners, rows, drawn: As given.
    """

    def __init__(
        self,
        corners: Indices,
        rows: Indices,
        drawn: Floats,
        ends: NDArray[np.integer],
        elements: Indices | None = None,
    ):
        self.corners, self.rows, self.drawn = corners, rows, drawn
        self._ends, self._elements = ends, elements
        self._supported = SupportedTriangles(ends, corners, elements)

    def __len__(self) -> int:
        return len(self.corners)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, SkinTriangles) and all(
            np.array_equal(getattr(self, name), getattr(other, name))
            for name in ("corners", "rows", "drawn")
        )

    def __hash__(self) -> int:
        return hash(self.corners.tobytes())

    def some(self, items: Indices) -> "SkinTriangles":
        """Return some of the triangles, by indices of shape (n,)."""
        parts = self.corners[items], self.rows[items], self.drawn[items]
        elements = None if self._elements is None else self._elements[items]
        return SkinTriangles(*parts, self._ends, elements)

    def torn(self, alive: NDArray[np.bool_]) -> Indices:
        """Return the triangles that are cut or torn, ascending.

        Args:
            alive: False for springs that were cut or broke, shape (spring,).
        """
        return np.flatnonzero(~self._supported.whole(alive))


class Areas(Struct, frozen=True, eq=False):
    """Areas of triangles at some positions.

    Attributes:
        corners: Nodes, shape (triangle, 3).
        edges: Opposite of each corner [m], shape (…, triangle, 3, 3).
        area: [m²], shape (…, triangle).
        normal: Unit vectors, 0 without an area, shape (…, triangle, 3).
    """

    corners: Indices
    edges: Floats
    area: Floats
    normal: Floats

    @classmethod
    def at(cls, corners: Indices, position: Floats) -> "Areas":
        """Return the areas of triangles.

        Args:
            corners: Nodes, shape (triangle, 3).
            position: Of all nodes [m], shape (…, node, 3).
        """
        x = position[..., corners, :]
        edges = np.roll(x, -2, axis=-2) - np.roll(x, -1, axis=-2)
        twice = cross(edges[..., 1, :], edges[..., 2, :])
        size = np.sqrt((twice * twice).sum(axis=-1))
        normal = twice / np.where(size > 0.0, size, 1.0)[..., None]
        return cls(corners, edges, 0.5 * size, normal)

    @property
    def gradient(self) -> Floats:
        """Return ∂A/∂x of each corner [m], shape (…, triangle, 3, 3)."""
        return 0.5 * cross(self.normal[..., None, :], self.edges)

    def add(self, numbers: Floats, to: Floats) -> None:
        """Add Σ T ∂A/∂x, of areas at a single time.

        Args:
            numbers: T of each triangle, in any unit, shape (triangle,).
            to: Of all nodes, shape (node, 3), changed in place.
        """
        np.add.at(to, self.corners, numbers[:, None, None] * self.gradient)

    def along(self, way: Floats) -> Floats:
        """Return Σ w · ∂A/∂x of each triangle at a single time, shape (triangle,).

        Args:
            way: w of all nodes, in any unit, shape (node, 3).
        """
        return np.einsum("tkc,tkc->t", self.gradient, way[self.corners])

    def matrix(
        self,
        tension: Floats,
        stiffness: Floats,
        number: Indices,
        size: int,
        *,
        exact: bool = True,
    ) -> "csc_matrix":
        """Return Σ T ∂²A/∂x∂x + c ∂A/∂x ∂A/∂xᵀ at a single time [N/m], shape (3 size, 3 size).

        It is the second derivative of an energy of areas with dE/dA = T and d²E/dA² = c.

        Args:
            tension: T of each triangle [N/m], shape (triangle,).
            stiffness: c of each triangle [N/m³], shape (triangle,).
            number: Of each node among those that may move, -1 for others, shape (node,).
            size: Number of nodes that may move.
            exact: Whether parts are included that may make the matrix indefinite.
        """

        sides, n = self.gradient, self.normal
        if not exact:
            tension, stiffness = np.maximum(tension, 0.0), np.maximum(stiffness, 0.0)
        out = np.divide(tension, 4.0 * self.area, where=self.area > 0.0, out=0.0 * tension)
        heights = np.einsum("t,tic,tjc->tij", out, self.edges, self.edges)
        values = np.einsum("tij,tx,ty->tixjy", heights, n, n)
        values += np.einsum("t,tix,tjy->tixjy", stiffness, sides, sides)
        if exact:
            values += np.einsum("t,ij,tk,kxy->tixjy", 0.5 * tension, _TURNS, n, _CROSS)
        return assembled(values, number[self.corners], size)
