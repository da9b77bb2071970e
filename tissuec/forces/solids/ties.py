"""Ties: what still holds the faces of a cut together, where the blade has not parted them.

A point of a section has the place Σ N_a x_a in the part in front of it and in the part behind
it. With the difference g of both, the area A of a point and the stiffness k per area, it stores

    E = A k |g|²/2,    and loses    A d |dg/dt|²

in a tissue with viscosity. An element in which a blade ends is divided like those behind it,
and what is ahead of the blade is tied: so a cut ends where the blade does, and energy is
released as the blade proceeds.

Where tissue has torn, the traction on both faces falls with their distance g, from σ at
g₀ = σ/k to nothing at g₁ = 2 G/σ, so that the energy G per area has been spent:

    E/A = k g²/2 up to g₀,    G - (g₁ - g)² σ/(2 (g₁ - g₀)) up to g₁,    G beyond.

The energy is a function of g until the faces are free for good. Damping falls with the fourth
power of the traction over g, so that what faces take hardly depends on how fast they part.
"""

from collections.abc import Callable, Sequence
from typing import ClassVar, Self

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.autodiff import (
    Number,
    Numbers,
    Potential,
    Vector,
    maximum,
    minimum,
    sqrt,
    square,
    where,
)
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.forces.fields import Items
from tissuec.forces.potential_fields import PotentialField
from tissuec.model.blocks import FieldBlock
from tissuec.model.network import Floats, Indices

#: Opening at which ties that never tear would: larger than any tissue [m].
FAR = 1e3
#: k h/E of ties between two regions or bodies.
STIFF_INTERFACE = 10.0
#: Energy up to where ties begin to soften, at most, over what they take in all.
LATE = 0.25
#: Largest opening of ties of tissue that tears at once, over that at which they begin to.
SUDDEN = 1.01


def openings(strength: Floats, energy: Floats, stiffness: Floats) -> tuple[Floats, Floats]:
    """Return the openings at which faces begin to soften, and are free [m], shape (n,) each.

    Ties that are soft have less strength, and take the energy all the same.

    Args:
        strength: σ [Pa], infinite where a blade alone parts them, shape (n,).
        energy: G [J/m²], shape (n,).
        stiffness: k [Pa/m], shape (n,).
    """
    least = np.where(energy > 0.0, np.sqrt(2.0 * LATE * energy * stiffness), np.inf)
    strength = np.minimum(strength, least)
    first = strength / stiffness
    with np.errstate(invalid="ignore"):
        last = np.maximum(2.0 * energy / strength, SUDDEN * first)
    return first, np.where(np.isfinite(first), last, np.inf)


def _sums(x: Sequence[Vector], v: Sequence[Vector], p: Numbers) -> tuple[Number, Number]:
    """Return |g|² and |dg/dt|² of a point."""
    gap, speed = p.weights[0] * x[0], p.weights[0] * v[0]
    for k in range(1, len(x)):
        gap, speed = gap + p.weights[k] * x[k], speed + p.weights[k] * v[k]
    return square(gap), square(speed)


def _tie(x: Sequence[Vector], v: Sequence[Vector], p: Numbers) -> Potential:
    """Return the potential of a point."""
    gap, speed = _sums(x, v, p)
    return Potential(0.5 * p.stiffness * gap, 0.5 * p.damping * speed)


def _softening(x: Sequence[Vector], v: Sequence[Vector], p: Numbers) -> Potential:
    """Return the potential of a point of a tear."""
    gap, speed = _sums(x, v, p)
    least = p.first * p.first
    size = sqrt(maximum(gap, least))
    left = p.last - minimum(size, p.last)
    whole = 0.5 * p.stiffness * p.first
    beyond = whole * (p.last - left * left / (p.last - p.first))
    stored = where(gap > least, beyond, 0.5 * p.stiffness * gap)
    secant = p.first * left / (size * (p.last - p.first))
    damping = p.damping * secant * secant * secant * secant
    return Potential(stored, 0.5 * damping * speed)


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

    def touched(self, position: Floats) -> NDArray[np.bool_]:
        """Return no node, shape (node,): weights of both sides add up to nothing.

        Args:
            position: Of all nodes [m], shape (node, 3).
        """
        return np.zeros(len(position), dtype=bool)

    @property
    def joined_pairs(self) -> Indices:
        """Return a node of the part in front and one of the part behind, shape (point, 2)."""
        return self.nodes[:, [0, self.nodes.shape[1] // 2]]

    def items(self, place: Indices) -> Items:
        """Return the nodes of the points, each once: both parts may share some."""
        places = np.sort(place[self.nodes], axis=1)
        is_new = np.diff(places, axis=1, prepend=-1) > 0
        return Items(places[is_new], np.concatenate([[0], np.cumsum(is_new.sum(axis=1))]))


class SofteningTies(Ties, frozen=True):
    """Points of sections that tear.

    Attributes:
        first, last: g₀ and g₁ [m], shape (point,).
        sections: The entity that names its section, see ``TiedSections.names``, shape (point,).
        softens: Whether its section has begun to, shape (point,).
    """

    item_potential = staticmethod(_softening)
    columns = (*Ties.columns, "first", "last")

    first: Floats
    last: Floats
    sections: Indices
    softens: NDArray[np.bool_]

    def only(self, items: Indices) -> Self:
        """Return some points, by indices of shape (n,)."""
        own = {name: getattr(self, name)[items] for name in ("sections", "softens")}
        return replace(super().only(items), **own)

    @property
    def breakable(self) -> "TearingSections | None":
        """Return the sections that can tear; None without any."""
        able = np.flatnonzero(self.first < FAR)
        return TearingSections(self.only(able)) if len(able) else None


class GlueTies(SofteningTies, frozen=True):
    """Points of faces of two bodies that are glued, and can come apart.

    Sections are not booked as softening before they are free: nothing depends on it. They are
    numbered behind the entities of the network, so that elements in front can break as well.

    Attributes:
        name: Of the joint.
        sections: The number of the section, shape (point,).
        elements: The element in front, an entity, shape (point,).
        areas: As drawn [m²], shape (point,).
    """

    elements: Indices
    areas: Floats

    def only(self, items: Indices) -> Self:
        """Return some points, by indices of shape (n,)."""
        own = {name: getattr(self, name)[items] for name in ("elements", "areas")}
        return replace(super().only(items), **own)

    @property
    def block(self) -> FieldBlock:
        """Return this as a block of a net."""
        return FieldBlock(f"the glue of {self.name}", "glue", self, self.span)


class TearingSections(Struct, frozen=True, eq=False):
    """The sections of a body that can tear, each by its name.

    A section begins to soften when the first of its points does, and is free when all are.

    Attributes:
        points: All of them can tear.
    """

    points: SofteningTies

    @property
    def entities(self) -> Indices:
        """Return the name of each, an entity, ascending, shape (section,)."""
        return np.unique(self.points.sections)

    def some(self, items: Indices) -> Self:
        """Return some sections, by indices of shape (n,)."""
        own = np.isin(self.points.sections, self.entities[items])
        return type(self)(self.points.only(np.flatnonzero(own)))

    def loading(self, place: Indices) -> Callable[[Floats], Floats]:
        """Return the function that finds openings divided by limits, shape (section,).

        It takes the flat positions of all nodes [m], shape (3 node,).

        Args:
            place: Index of each node among them, shape (node,).
        """
        points = self.points
        order = np.argsort(points.sections, kind="stable")
        own = points.only(order)
        starts = np.flatnonzero(np.diff(own.sections, prepend=-1))
        nodes, weights, begun = place[own.nodes], own.weights, own.softens[starts]

        def loads(x: Floats) -> Floats:
            gap = np.einsum("pa,pax->px", weights, x.reshape(-1, 3)[nodes])
            size = np.sqrt((gap * gap).sum(axis=1))
            first = np.maximum.reduceat(size / own.first, starts)
            return np.where(begun, np.minimum.reduceat(size / own.last, starts), first)

        return loads

    def loads(self, position: Floats) -> Floats:
        """Return the openings divided by the limits of sections, shape (section,).

        Args:
            position: Of all nodes [m], shape (node, 3).
        """
        x = np.ascontiguousarray(position, dtype=float).ravel()
        return self.loading(np.arange(len(position)))(x)

    def broken(self, position: Floats) -> Indices:
        """Return the names of sections above their limits, entities, shape (n,).

        Args:
            position: Of all nodes [m], shape (node, 3).
        """
        return self.entities[self.loads(position) > 1.0]
