"""Ties: what still holds the faces of a cut together, where the blade has not parted them.

A point of a section has the place Σ N_a x_a in the part in front of it and in the part behind
it. With the difference g of both, the area A of a point and the stiffness k per area, it stores

    E = A k |g|²/2,    and loses    A d |dg/dt|²

in a tissue with viscosity. An element in which a blade ends is divided like those behind it,
and what is ahead of the blade is tied: so a cut ends where the blade does, and energy is
released as the blade proceeds.
"""

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from tissuec.autodiff import Numbers, Potential, Vector, square
from tissuec.core.source import Span
from tissuec.forces.fields import Items
from tissuec.forces.potential_fields import PotentialField
from tissuec.model.blocks import FieldBlock
from tissuec.model.network import Floats, Indices


def _tie(x: Sequence[Vector], v: Sequence[Vector], p: Numbers) -> Potential:
    """Return the potential of a point."""
    gap, speed = p.weights[0] * x[0], p.weights[0] * v[0]
    for k in range(1, len(x)):
        gap, speed = gap + p.weights[k] * x[k], speed + p.weights[k] * v[k]
    return Potential(0.5 * p.stiffness * square(gap), 0.5 * p.damping * square(speed))


class Ties(PotentialField, frozen=True):
    """Points of tied sections of a body.

    Attributes:
        nodes: Of the part in front, then of the part behind, shape (point, 2 node).
        name: Of the body.
        weights: N_a of those in front, -N_a of those behind, shape (point, 2 node).
        stiffness: A k [N/m], shape (point,).
        damping: A d [N s/m], shape (point,).
        span: The entry that asks for the elements.
    """

    at_once: ClassVar[int] = 512
    item_potential = staticmethod(_tie)
    columns = ("weights", "stiffness", "damping")

    name: str
    weights: Floats
    stiffness: Floats
    damping: Floats
    span: Span

    @property
    def block(self) -> FieldBlock:
        """Return this as a block of a net."""
        return FieldBlock(f"the ties of {self.name}", "ties", self, self.span)

    @property
    def is_damped(self) -> bool:
        """Return whether any point is damped."""
        return bool(self.damping.any())

    @property
    def joined_pairs(self) -> Indices:
        """Return a node of the part in front and one of the part behind, shape (point, 2)."""
        return self.nodes[:, [0, self.nodes.shape[1] // 2]]

    def items(self, place: Indices) -> Items:
        """Return the nodes of the points, each once: both parts may share some."""
        places = np.sort(place[self.nodes], axis=1)
        is_new = np.diff(places, axis=1, prepend=-1) > 0
        return Items(places[is_new], np.concatenate([[0], np.cumsum(is_new.sum(axis=1))]))
