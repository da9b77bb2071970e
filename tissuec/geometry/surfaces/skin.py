"""The skin of a body, where it is torn, and a smooth surface as a linear map of its nodes."""

from typing import TYPE_CHECKING

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.geometry.edge_supports import SupportedEdges
from tissuec.model.network import BodyPart, Floats, Grid, Indices, Network

if TYPE_CHECKING:
    from scipy.sparse import csr_array


class Skin(Struct, frozen=True, eq=False):
    """The skin of a body in one topology.

    Attributes:
        nodes: How many nodes the body has.
        triangles: The whole skin, nodes counted from 0 within the body, shape (triangle, 3).
        is_whole: Which triangles are left, shape (triangle,).
        grid: Arrangement of the nodes in rows and columns, if any.
        along: Of a grid, whether each node is joined to the next one of its row, shape
            (row, column); false behind the last one of a row that is not closed.
        down: Whether it is joined to the one below; false in the last row.
    """

    nodes: int
    triangles: Indices
    is_whole: NDArray[np.bool_]
    grid: Grid | None
    along: NDArray[np.bool_]
    down: NDArray[np.bool_]

    def same_as(self, other: "Skin") -> bool:
        """Return whether the same skin is torn in the same places."""
        return all(
            np.array_equal(getattr(self, name), getattr(other, name))
            for name in ("is_whole", "along", "down")
        )


class BodySkin(Struct, frozen=True, eq=False):
    """The skin of a body as it was drawn, and the springs that hold it.

    A triangle goes with the first of its edges that tears, as in the frames of a result.

    Attributes:
        nodes: Place of the body among the nodes of the network.
        triangles: Nodes counted from 0 within the body, shape (triangle, 3).
        edges: What holds the edges of each triangle, shape (triangle, 3).
        along, down: What holds each node of a grid to its neighbours, shape (row, column).
    """

    nodes: slice
    triangles: Indices
    grid: Grid | None
    edges: SupportedEdges
    along: SupportedEdges
    down: SupportedEdges

    @classmethod
    def of(cls, network: Network, body: BodyPart) -> "BodySkin":
        """Return the skin of a body, which may be empty."""
        first = body.nodes.start
        triangles = network.skin_of(body)
        numbers = _numbers(body) + first
        elements = network.skin_elements_of(body)
        edges, along, down = (
            SupportedEdges.of(
                network.line_ends,
                np.stack([here, np.roll(here, -1, axis=axis)], axis=-1),
                elements if here is triangles else None,
            )
            for here, axis in ((triangles, 1), (numbers, 1), (numbers, 0))
        )
        return cls(body.nodes, triangles - first, body.grid, edges, along, down)

    def size(self, subdivisions: int) -> int:
        """Return about how many points a surface over the whole skin has."""
        return max(4, len(self.triangles) * 4**subdivisions // 2)

    def at(self, alive: NDArray[np.bool_]) -> Skin:
        """Return the skin while the springs ``alive``, shape (spring,), are there."""
        along, down = self.along.holding(alive), self.down.holding(alive)
        down[-1:] = False
        if self.grid is not None and not self.grid.closed:
            along[:, -1] = False
        whole = np.asarray(self.edges.holding(alive).all(axis=1))
        count = self.nodes.stop - self.nodes.start
        return Skin(count, self.triangles, whole, self.grid, along, down)


def _numbers(body: BodyPart) -> Indices:
    """Return the nodes of a grid in rows and columns, counted from 0."""
    if body.grid is None:
        return np.zeros((0, 0), dtype=np.int64)
    rows, columns, _ = body.grid
    return np.arange(rows * columns).reshape(rows, columns)


class Refinement(Struct, frozen=True, eq=False):
    """Linear map from the nodes of one body, in one topology, to the points of its surface.

    Attributes:
        factors: Sparse matrices, applied to the positions one after the other. The weights of a
            point add up to 1. They stay factors where their product would fill up: each point
            of an interpolating spline hangs, however little, on every node.
        triangles: Of the surface, as its points, shape (triangle, 3).
    """

    factors: "tuple[csr_array, ...]"
    triangles: Indices

    @property
    def points(self) -> int:
        """Return how many points the surface has."""
        return int(self.triangles.max(initial=-1)) + 1

    def at(self, position: Floats) -> Floats:
        """Return the points of the surface [m], shape (…, point, 3).

        Args:
            position: Of the nodes of the body [m], shape (…, node, 3).
        """
        leading = position.shape[:-2]
        moved = np.moveaxis(position, -2, 0).reshape(position.shape[-2], -1)
        for factor in self.factors:
            moved = factor @ moved
        return np.moveaxis(moved.reshape(self.points, *leading, 3), 0, -2)

    def matrix(self) -> "csr_array":
        """Return the whole map as one matrix, shape (point, node)."""
        product = self.factors[0]
        for factor in self.factors[1:]:
            product = factor @ product
        return product
