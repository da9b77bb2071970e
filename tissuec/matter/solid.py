"""The shares of the nodes of a solid in its volume and boundary, and its fibres.

Moments of what a skin encloses are integrals over the skin (B. Mirtich, J. Graphics Tools
1(2):31, 1996).

Fibres: what they add to the stiffness of a body.

Fibres along the unit vector f that bear β for each strain along them add β f f f f to the
tensor of stiffness. A body of Young's modulus E, stretched along f and free across, then has
the modulus E + β, whatever its Poisson's ratio.
"""

from typing import Self

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.geometry.edges import parallelograms
from tissuec.matter.elasticity import IN_PLANE, VOIGT
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


class Fibres(Struct, frozen=True, eq=False):
    """Fibres of one direction.

    Attributes:
        direction: f, of as many components as the body has dimensions.
        added: β per Young's modulus of the body without them.
    """

    direction: Floats
    added: float

    @property
    def strain(self) -> Floats:
        """Return the factors of strains in the strain of fibres f · ε f, shape (3,) or (6,).

        They are dimensionless and in Voigt's order; shear strains are changes of angles.
        """
        f = self.direction
        pairs = IN_PLANE if len(f) == 2 else VOIGT
        return np.array([f[i] * f[j] for i, j in pairs])

    @property
    def stiffness(self) -> Floats:
        """Return the stiffness added per Young's modulus, shape (3, 3) or (6, 6).

        It is dimensionless and in Voigt's order.
        """
        return self.added * np.outer(self.strain, self.strain)
