"""A smooth surface as a linear map of node positions."""

from typing import TYPE_CHECKING

import numpy as np
from msgspec import Struct

from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:
    from scipy.sparse import csr_array


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
