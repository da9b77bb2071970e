"""What the nodes of a solid stand for: their parts of its volume and of its boundary."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from tissuec.network import Floats
from tissuec.shapes.parallelograms import parallelograms


@dataclass(frozen=True, slots=True, eq=False)
class Solid:
    """How a solid is shared out among its nodes.

    A uniform stress σ acts on its boundary with the force σ N on each node.

    Attributes:
        volume: [m³], shape (node,).
        outward: N, the area of the boundary times its outward normal [m²], shape (node, 3).
    """

    volume: Floats
    outward: Floats

    @classmethod
    def of(cls, position: Floats, volume: Floats, skin: NDArray[np.int32]) -> Self:
        """Return the solid within a closed skin.

        Args:
            position: [m], shape (node, 3).
            volume: What each node stands for [m³], shape (node,).
            skin: Triangles that face outwards, shape (triangle, 3).
        """
        a, b, c = position[skin].swapaxes(0, 1)
        third = np.cross(b - a, c - a) / 6.0
        outward = np.zeros_like(position)
        for corner in skin.T:
            np.add.at(outward, corner, third)
        found, number = parallelograms(position, skin.astype(np.int64))
        share = third[number].sum(axis=1) / 4.0
        for corner, sign in enumerate((1.0, -1.0, 1.0, -1.0)):
            np.add.at(outward, found[:, corner], sign * share)
        return cls(volume, outward)
