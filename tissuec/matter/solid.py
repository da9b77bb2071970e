"""The shares of the nodes of a solid in its volume and boundary.

Moments of what a skin encloses are integrals over the skin (B. Mirtich, J. Graphics Tools
1(2):31, 1996).
"""

from typing import Self

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.geometry.edges import parallelograms
from tissuec.model.network import Floats


class Solid(Struct, frozen=True, eq=False):
    """Distribution of a solid to its nodes.

    A uniform stress σ acts on its boundary with the force σ N on each node.

    Attributes:
        volume: [m³], shape (node,).
        outward: N, the area of the boundary times its outward normal [m²], shape (node, 3).
        middle: The centre of its volume [m], shape (3,).
        second: ∫ (x - middle)² dV along each axis [m⁵], shape (3,).
    """

    volume: Floats
    outward: Floats
    middle: Floats
    second: Floats

    @classmethod
    def of(cls, position: Floats, volume: Floats, skin: NDArray[np.int32]) -> Self:
        """Return the solid within a closed skin.

        Args:
            position: [m], shape (node, 3).
            volume: Volume that each node represents [m³], shape (node,).
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
        middle, second = _moments(position[skin])
        return cls(volume, outward, middle, second)


def _moments(corners: Floats) -> tuple[Floats, Floats]:
    """Return the centre of what a skin encloses [m], and ∫ (x - centre)² dV [m⁵], shape (3,).

    By Gauss's theorem, of x, x²/2 and x³/3 over triangles, on which means of products of
    coordinates are those over corners.

    Args:
        corners: Of the skin [m], shape (triangle, 3, 3).
    """
    origin = corners.mean(axis=(0, 1))
    a, b, c = np.moveaxis(corners - origin, 1, 0)
    area = 0.5 * np.cross(b - a, c - a)
    total = a + b + c
    squares = a * a + b * b + c * c
    volume = (area * total / 3.0).sum(axis=0).mean()
    first = (area * (squares + total * total) / 24.0).sum(axis=0) / volume
    cubes = a**3 + b**3 + c**3
    # Of all products of three coordinates, each counted once: (t³ + 3 t q + 2 k) / 6.
    second = (area * (total**3 + 3.0 * total * squares + 2.0 * cubes) / 180.0).sum(axis=0)
    return origin + first, second - volume * first * first
