"""Affine maps of space: shifts, turns, scalings and reflections, one after the other.

A turn by the angle φ about the unit vector u is the matrix (O. Rodrigues, J. Math. Pures Appl.
5:380, 1840)

    R = cos φ I + sin φ [u]× + (1 - cos φ) u uᵀ,

a reflection in the plane with the unit normal n is I - 2 n nᵀ. With x → A x + b, directions of
lines become A d, and normals of planes A⁻ᵀ n.
"""

import numpy as np
from msgspec import Struct

from tissuec.core.arrays import cross_matrices
from tissuec.model.network import Floats

_ROUNDING = 1e-15  # a cosine or sine of less is that of a quarter turn
_SIMILAR = 1e-12  # relative deviation of scales that is rounding


class Affine(Struct, frozen=True, eq=False):
    """The map x → A x + b.

    Attributes:
        matrix: A, dimensionless and invertible, shape (3, 3).
        shift: b [m], shape (3,).
    """

    matrix: Floats
    shift: Floats

    @classmethod
    def moving(cls, by: Floats) -> "Affine":
        """Return a shift.

        Args:
            by: The shift [m], shape (3,).
        """
        return cls(np.eye(3), by)

    @classmethod
    def turning(cls, angle: float, axis: Floats, through: Floats) -> "Affine":
        """Return a right-handed turn; whole quarter turns are exact.

        Args:
            angle: In radians.
            axis: Unit vector, shape (3,).
            through: A point of the axis [m], shape (3,).
        """
        cosine, sine = (_cleaned(float(f(angle))) for f in (np.cos, np.sin))
        matrix = cosine * np.eye(3) + (1.0 - cosine) * np.outer(axis, axis)
        return cls._around(through, matrix + sine * cross_matrices(axis))

    @classmethod
    def scaling(cls, factors: Floats, around: Floats) -> "Affine":
        """Return a scaling along x, y and z.

        Args:
            factors: Dimensionless and positive, shape (3,).
            around: The point that stays where it is [m], shape (3,).
        """
        return cls._around(around, np.diag(factors))

    @classmethod
    def mirroring(cls, through: Floats, normal: Floats) -> "Affine":
        """Return the reflection in a plane.

        Args:
            through: A point of the plane [m], shape (3,).
            normal: Unit vector, shape (3,).
        """
        return cls._around(through, np.eye(3) - 2.0 * np.outer(normal, normal))

    @classmethod
    def _around(cls, fixed: Floats, matrix: Floats) -> "Affine":
        """Return the map with a matrix that leaves a point where it is."""
        return cls(matrix, fixed - matrix @ fixed)

    def then(self, other: "Affine") -> "Affine":
        """Return this map followed by another one."""
        return Affine(other.matrix @ self.matrix, other.matrix @ self.shift + other.shift)

    def inverse(self) -> "Affine":
        """Return the inverse map."""
        matrix = np.asarray(np.linalg.inv(self.matrix), dtype=float)
        return Affine(matrix, -(matrix @ self.shift))

    def points(self, position: Floats) -> Floats:
        """Return the images of points [m], shape (…, 3)."""
        return np.asarray(position @ self.matrix.T + self.shift)

    def direction(self, along: Floats) -> Floats:
        """Return the unit vector along the image of a line.

        Args:
            along: Direction of the line, shape (3,).
        """
        image = self.matrix @ along
        return image / np.linalg.norm(image)

    def normal(self, across: Floats) -> Floats:
        """Return the unit normal of the image of a plane.

        Args:
            across: Normal of the plane, shape (3,).
        """
        image = np.linalg.solve(self.matrix.T, across)
        return image / np.linalg.norm(image)

    @property
    def volume(self) -> float:
        """Return the factor of volumes."""
        return abs(float(np.linalg.det(self.matrix)))

    @property
    def is_mirrored(self) -> bool:
        """Return whether left and right are exchanged."""
        return float(np.linalg.det(self.matrix)) < 0.0

    @property
    def scale(self) -> float | None:
        """Return the factor of all lengths; None if it depends on the direction."""
        scale = float(np.cbrt(self.volume))
        scale = 1.0 if abs(scale - 1.0) <= _SIMILAR else scale  # of turns, without rounding
        square = self.matrix.T @ self.matrix / scale**2
        return scale if np.abs(square - np.eye(3)).max() <= _SIMILAR else None


def _cleaned(value: float) -> float:
    """Return a cosine or sine without the rounding of quarter turns."""
    nearest = round(value)
    return float(nearest) if abs(value - nearest) < _ROUNDING else value
