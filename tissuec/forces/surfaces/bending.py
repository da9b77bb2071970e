"""Folds of hinges: the angles between the faces at the edges of walls.

A hinge has four nodes: the ends i and j of its edge e = x_j - x_i, and the tips k and l of the
triangles on either side. With a = e × (x_k - x_i) and b = (x_l - x_i) × e, which are normal to
them, its fold is

    θ = atan2((b × a)·e/|e|, a·b),    ∂θ/∂x_k = |e| a/a²,    ∂θ/∂x_l = |e| b/b²,

and both ends of the edge share the opposite of these by the lever rule (R. Bridson, S. Marino,
R. Fedkiw, *Simulation of clothing with folds and wrinkles*, 2003). The weight w of a hinge lets
go of triangles that collapse into a line, about which nothing can turn:

    w = g(a²/a0²) g(b²/b0²),    g(u) = (1 + ε) u / (u + ε),    ε = 1/100,

a0 and b0 being the drawn ones; so w is 1 as drawn, and hardly changes while triangles stretch.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from tissuec import autodiff
from tissuec.autodiff import Angle, Number, Vector
from tissuec.core.arrays import cross, dot
from tissuec.model.network import Floats

COLLAPSE = 1e-2  # ε: part of the drawn a² of a triangle that counts as none


class Fold(NamedTuple):
    """The fold of a hinge.

    Attributes:
        angle: θ.
        slopes: ∂θ/∂x of i, j, k and l [1/m].
        squares: a² and b² [m⁴].
    """

    angle: Angle
    slopes: tuple[Vector, ...]
    squares: tuple[Number, Number]

    @classmethod
    def of(cls, corners: Sequence[Vector]) -> "Fold":
        """Return the fold of a hinge with the nodes i, j, k and l."""
        i, j, k, l = corners  # noqa: E741
        e, q, r = j - i, k - i, l - i
        a, b = autodiff.cross(e, q), autodiff.cross(r, e)
        aa, bb, ee = (autodiff.square(each) + autodiff.TINY for each in (a, b, e))
        length = autodiff.sqrt(ee)
        by_k, by_l = length / aa * a, length / bb * b
        by_j = -(autodiff.dot(q, e) / ee * by_k) - autodiff.dot(r, e) / ee * by_l
        slopes = -(by_j + by_k + by_l), by_j, by_k, by_l
        both = autodiff.sqrt(aa * bb)
        sine = autodiff.dot(autodiff.cross(b, a), e) / length / both
        cosine = autodiff.dot(a, b) / both
        arguments, by = (
            [each for vector in part for each in vector] for part in (corners, slopes)
        )
        return cls(Angle.of(arguments, by, cosine, sine), slopes, (aa, bb))

    def weight(self, drawn: Sequence[Number]) -> Number:
        """Return w, given a0² and b0² [m⁴]."""
        u, v = (square / first for square, first in zip(self.squares, drawn, strict=True))
        return _grip(u) * _grip(v)

    def speed(self, rates: Sequence[Vector]) -> Number:
        """Return dθ/dt [1/s], given the velocities of the nodes."""
        parts = [
            autodiff.dot(slope, rate) for slope, rate in zip(self.slopes, rates, strict=True)
        ]
        return parts[0] + parts[1] + parts[2] + parts[3]


def _grip(u: Number) -> Number:
    return (1.0 + COLLAPSE) * u / (u + COLLAPSE)


def as_drawn(corners: Floats) -> tuple[Floats, Floats]:
    """Return θ0 [rad], shape (hinge,), and a0² and b0² [m⁴], shape (hinge, 2), of hinges.

    Args:
        corners: Where their nodes are drawn [m], shape (hinge, 4, 3).
    """
    _, a, b = _normals(corners)
    return folds(corners), np.stack([dot(a, a), dot(b, b)], axis=1)


def folds(corners: Floats) -> Floats:
    """Return θ of hinges [rad], from -π to π, shape (…, hinge).

    Args:
        corners: Where their nodes are [m], shape (…, hinge, 4, 3).
    """
    e, a, b = _normals(corners)
    along = dot(cross(b, a), e) / np.sqrt(dot(e, e))
    return np.arctan2(along, dot(a, b))


def _normals(corners: Floats) -> tuple[Floats, Floats, Floats]:
    """Return e, a and b, shape (…, hinge, 3) each."""
    i, j, k, x = (corners[..., corner, :] for corner in range(4))
    e = j - i
    return e, cross(e, k - i), cross(x - i, e)
