"""Hinges: walls that resist bending, by the angles between the faces at their edges.

A hinge has four nodes: the ends i and j of its edge e = x_j - x_i, and the tips k and l of the
triangles on either side. With a = e × (x_k - x_i) and b = (x_l - x_i) × e, which are normal to
them, its fold is

    θ = atan2((b × a)·e/|e|, a·b),    ∂θ/∂x_k = |e| a/a²,    ∂θ/∂x_l = |e| b/b²,

and both ends of the edge share the opposite of these by the lever rule (R. Bridson, S. Marino,
R. Fedkiw, *Simulation of clothing with folds and wrinkles*, 2003). A hinge that is drawn with
the fold θ0 stores and dissipates by

    E = w k (1 - cos(θ - θ0)),    D = w d (dθ/dt)²/2,

so that its moment is k (θ - θ0) for small folds, and has no jump where faces are folded onto
each other. The weight w lets go of triangles that collapse into a line, about which nothing can
turn:

    w = g(a²/a0²) g(b²/b0²),    g(u) = (1 + ε) u / (u + ε),    ε = 1/100,

a0 and b0 being the drawn ones; so w is 1 as drawn, and hardly changes while triangles stretch.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from tissuec import autodiff
from tissuec.autodiff import Angle, Number, Numbers, Potential, Vector
from tissuec.core.arrays import cross, dot
from tissuec.core.structs import replace
from tissuec.forces.potential_fields import PotentialField
from tissuec.model.blocks import FieldBlock
from tissuec.model.network import Floats, Indices

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


def _hinge(x: Sequence[Vector], v: Sequence[Vector], p: Numbers) -> Potential:
    """Return the potential of a hinge."""
    fold = Fold.of(x)
    weight, more = fold.weight(p.squares), fold.angle.less(Angle.written(p.drawn))
    stored = weight * p.stiffness * more.versine
    return Potential(stored, 0.5 * weight * p.damping * fold.speed(v) ** 2)


class Hinges(PotentialField, frozen=True):
    """Hinges of walls that resist bending; a hinge that loses a spring gives way.

    Attributes:
        nodes: i, j, k and l of each, shape (hinge, 4).
        stiffness: k [N m], shape (hinge,).
        damping: d [N m s], shape (hinge,).
        drawn: θ0 [rad], shape (hinge,).
        squares: a0² and b0² [m⁴], shape (hinge, 2).
    """

    item_potential = staticmethod(_hinge)
    columns = ("stiffness", "damping", "drawn", "squares")
    learnt = ("stiffness", "damping", "drawn")

    stiffness: Floats
    damping: Floats
    drawn: Floats
    squares: Floats

    @classmethod
    def joined(cls, parts: Sequence["Hinges"]) -> "Hinges":
        """Return the hinges of several bodies in one numbering."""
        first = np.cumsum([0, *(part.item_count for part in parts)])
        walled = [part.walled + start for part, start in zip(parts, first, strict=False)]
        arrays = {
            name: np.concatenate([getattr(part, name) for part in parts])
            for name in ("nodes", *cls.columns, "walls")
        }
        return cls(**arrays, walled=np.concatenate(walled))

    def behind(self, nodes: int, springs: int) -> "Hinges":
        """Return these with the numbers that they have after other nodes and springs."""
        return replace(self, nodes=self.nodes + nodes, walls=self.walls + springs)

    @property
    def block(self) -> FieldBlock:
        """Return these as a block of a net."""
        return FieldBlock("bending", "bending", self, None)

    @property
    def is_damped(self) -> bool:
        """Return whether any hinge is damped."""
        return bool(self.damping.any())


def hinges_at(
    position: Floats,
    nodes: Indices,
    stiffness: Floats,
    damping: Floats,
    walls: Indices,
    walled: Indices,
) -> Hinges:
    """Return hinges whose angles at rest are those of given positions.

    Args:
        position: Of all nodes at rest [m], shape (node, 3).
        nodes: i, j, k and l of each hinge, shape (hinge, 4).
        stiffness: k [N m], shape (hinge,).
        damping: d [N m s], shape (hinge,).
        walls: Springs between nodes of one hinge, shape (wall,).
        walled: The hinge of each of them, shape (wall,).
    """
    corners = position[nodes]
    _, a, b = _normals(corners)
    squares = np.stack([dot(a, a), dot(b, b)], axis=1)
    return Hinges(walls, walled, nodes, stiffness, damping, folds(corners), squares)


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
