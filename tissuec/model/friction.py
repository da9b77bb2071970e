"""Coefficients of friction of nodes and of surfaces."""

from collections.abc import Sequence

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class SurfaceFriction(Struct, frozen=True, eq=False):
    """Coefficients of friction that tissues give.

    Attributes:
        nodes: Of the nodes of bodies, shape (body node,).
        skin: Of the triangles of their surfaces, shape (triangle,).
    """

    nodes: Floats
    skin: Floats

    @classmethod
    def joined(cls, parts: Sequence["SurfaceFriction"]) -> "SurfaceFriction | None":
        """Return the coefficients of several bodies, one after the other; None without any."""
        if not any(one.nodes.any() for one in parts):
            return None
        return cls(
            np.concatenate([one.nodes for one in parts]),
            np.concatenate([one.skin for one in parts]),
        )
