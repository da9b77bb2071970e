"""Guided nodes: nodes that are held in some directions and free in others.

A plane of symmetry guides the nodes on it: its mirror image pulls them with the mirrored force,
so that of the sum F + (1 - 2 n nᵀ) F, shared by both halves, (1 - n nᵀ) F is left to each. A
script guides nodes that it fixes, holds or moves along single directions. Of the acceleration
of a guided node, the projection P into the directions in which it is free is left, whatever
acts; what is held follows a path or rests.
"""

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.source import Span

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class Guides(Struct, frozen=True, eq=False):
    """Guided nodes, from now to the next event.

    Attributes:
        nodes: Ascending, shape (n,).
        projections: P of each, symmetric, dimensionless, shape (n, 3, 3).
        share: The part of each node on the drawn side of planes of symmetry, dimensionless,
            shape (n,).
        span: The first sentence that guides nodes.
    """

    nodes: Indices
    projections: Floats
    share: Floats
    span: Span

    def some(self, nodes: Indices, like: Indices) -> "Guides":
        """Return nodes that are guided as others are.

        Args:
            nodes: Ascending, shape (m,).
            like: The guided node that each is like, shape (m,).
        """
        row = np.searchsorted(self.nodes, like)
        return Guides(nodes, self.projections[row], self.share[row], self.span)

    def keep(self, vectors: Floats) -> None:
        """Leave the part of vectors in the free directions.

        Args:
            vectors: Of all nodes in any unit, shape (…, node, 3); changed in place.
        """
        own = vectors[..., self.nodes, :]
        vectors[..., self.nodes, :] = np.einsum("nij,...nj->...ni", self.projections, own)

    def held_part(self, vectors: Floats) -> Floats:
        """Return the part of vectors of the guided nodes in held directions, in their unit.

        Args:
            vectors: Of all nodes, shape (…, node, 3).

        Returns:
            Of guided nodes, shape (…, n, 3).
        """
        own = vectors[..., self.nodes, :]
        return own - np.einsum("nij,...nj->...ni", self.projections, own)


def free_directions(held: Floats, least: float) -> Floats:
    """Return the projection, dimensionless, off some directions, shape (3, 3).

    Args:
        held: Dimensionless, shape (n, 3).
        least: Sine of the angle from which one of them is new beside others.
    """
    _, sizes, ways = np.linalg.svd(held)
    across = ways[: int((sizes > least).sum())]
    return np.asarray(np.eye(3) - across.T @ across)
