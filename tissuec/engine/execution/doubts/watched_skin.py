"""The watched surface of a body, and its intact part."""

import numpy as np
from numpy.typing import NDArray

from tissuec.core.vectors import norm
from tissuec.geometry.edge_supports import SupportedTriangles
from tissuec.geometry.sweeps import SweptSurface
from tissuec.model.network import BodyPart, Indices, Network


class WatchedSkin:
    """The surface of a body, of which parts may be cut or torn.

    Args:
        network: With the body.
        body: One with a surface.

    Attributes:
        surface: Its triangles and edges.
        edge: Median length of its edges as drawn [m].
    """

    def __init__(self, network: Network, body: BodyPart):
        skin = network.skin_of(body)
        self.body, self.surface = body, SweptSurface.of(skin)
        self.edge = float(
            np.median(norm(np.diff(network.position[self.surface.edges.ends], axis=1)))
        )
        self._supported = SupportedTriangles(
            network.springs.ends, skin, network.skin_marks_of(body)
        )
        self._alive: NDArray[np.bool_] | None = None
        self._whole = np.ones(len(skin), dtype=bool)

    @property
    def triangles(self) -> Indices:
        """Return the corners of all triangles, shape (triangle, 3)."""
        return self.surface.triangles

    def whole(self, alive: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return which triangles are neither cut nor torn, shape (triangle,)."""
        if self._alive is None or not np.array_equal(alive, self._alive):
            self._alive, self._whole = alive.copy(), self._supported.whole(alive)
        return self._whole
