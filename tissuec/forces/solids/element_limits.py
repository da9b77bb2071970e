"""Limits of elements: a strain, a stress, or the energy of a crack.

With the mean F̄ of the deformation gradient over the volume V of an element, whose largest
principal stretch is λ, and the mean of the Kirchhoff stress τ = P Fᵀ without its viscous part
and what relaxes, whose largest principal value is τ₁, an element is broken by

    a breaking strain ε    λ - 1 > ε
    a strength S           τ₁ / λ > S, the force per drawn section in tension
    a toughness G          E > G a, E being its energy, and a the area of one of its sides.

The last is the crack band (Z. P. Bažant, B. H. Oh, Mater. Struct. 16:155, 1983): elements of
the size V^(1/3) that break side by side set free E / V^(2/3) per area of the crack, on meshes
of any size, so that a = V^(2/3) in solids. In a wall, cracks go through its thickness t: a
triangle of the area A has a = t √A as drawn, and stretch and stress are those in its plane.
"""

from collections.abc import Callable
from typing import Protocol, Self

import numpy as np
from msgspec import Struct
from msgspec.structs import astuple

from tissuec.autodiff import Number, Tensor, largest, maximum, sqrt
from tissuec.autodiff.points import TracedPoint
from tissuec.autodiff.tensors import PLACES
from tissuec.core.structs import replace
from tissuec.forces.moduli import plane_modulus
from tissuec.model.network import Floats, Indices

#: Elements in the zone in which the faces of a tear soften.
SOFTENING = 3.0
#: Length of this zone, over E'G/σ².
ZONE = 9.0 * np.pi / 32.0


def softening_strength(plane: Floats, energy: Floats | float, size: Floats) -> Floats:
    """Return the strength of faces that soften, for a mesh [Pa], shape (n,).

    The zone in which they soften is then n = ``SOFTENING`` elements long: with the modulus E'
    in plane strain, σ² = 9π/32 E' G/(n h) (A. Turon, C. G. Dávila, P. P. Camanho, J. Costa,
    Eng. Fract. Mech. 74:1665, 2007).

    Args:
        plane: E' [Pa], shape (n,).
        energy: G [J/m²].
        size: h as drawn [m], shape (n,).
    """
    return np.sqrt(ZONE * plane * energy / (SOFTENING * size))


class Loaded(Protocol):
    """Elements of one shape, as ``forces.point_fields.PointField``."""

    @property
    def crack_areas(self) -> Floats:
        """Return the areas of cracks through single elements [m²], shape (element,)."""
        ...

    @property
    def weights(self) -> Floats:
        """Return the volumes of points without stress [m³], shape (element, point)."""
        ...

    def only(self, items: Indices) -> Self:
        """Return some elements, by indices of shape (n,)."""
        ...

    def measuring(self, names: tuple[str, ...], place: Indices) -> Callable[[Floats], Floats]:
        """Return the function that finds ``measures_of`` elements, shape (element, name).

        It takes the flat positions of all nodes [m], shape (3 node,).

        Args:
            names: Which.
            place: Index of each node among them, shape (node,).
        """
        ...


class ElementLimits(Struct, frozen=True, eq=False):
    """Limits of elements; infinite where there is none.

    Attributes:
        strain: Shape (element,).
        stress: [Pa], shape (element,).
        toughness: Energy per area of a crack that they hold when they break [J/m²], shape
            (element,).
        parting: Energy per area as drawn that faces of a tear take [J/m²], shape (element,); 0
            where elements tear at once.
    """

    strain: Floats
    stress: Floats
    toughness: Floats
    parting: Floats

    def some(self, items: Indices) -> "ElementLimits":
        """Return those of some elements, by indices of shape (n,)."""
        return ElementLimits(*(each[items] for each in astuple(self)))

    def times(self, factor: Floats) -> "ElementLimits":
        """Return limits multiplied by dimensionless factors, shape (element,)."""
        each = self.strain * factor, self.stress * factor, self.toughness * factor
        return ElementLimits(*each, self.parting)

    def softening(self, shear: Floats, bulk: Floats, size: Floats) -> "ElementLimits":
        """Return the same with strengths that follow from the toughness of faces.

        See ``softening_strength``.

        Args:
            shear, bulk: Initial moduli [Pa], shape (element,).
            size: h of elements as drawn [m], shape (element,).
        """
        found = softening_strength(plane_modulus(shear, bulk), self.parting, size)
        return replace(self, stress=np.where(self.parting > 0.0, found, self.stress))

    @property
    def finite(self) -> Indices:
        """Return the elements that have a limit, shape (n,)."""
        least = np.minimum(np.minimum(self.strain, self.stress), self.toughness)
        return np.flatnonzero(np.isfinite(least))


class BreakableElements(Struct, frozen=True, eq=False):
    """Elements of one shape that can break.

    Attributes:
        elements: All of them have a limit.
        limits: Theirs.
        entities: Their numbers among the entities of the network, shape (element,).
    """

    elements: Loaded
    limits: ElementLimits
    entities: Indices

    def some(self, items: Indices) -> "BreakableElements":
        """Return some of them, by indices of shape (n,)."""
        own = self.elements.only(items), self.limits.some(items)
        return BreakableElements(*own, self.entities[items])

    def loading(self, place: Indices) -> Callable[[Floats], Floats]:
        """Return the function that finds loads divided by limits, shape (element,).

        It takes the flat positions of all nodes [m], shape (3 node,).

        Args:
            place: Index of each node among them, shape (node,).
        """
        elements, limits = self.elements, self.limits
        energy = limits.toughness * elements.crack_areas / elements.weights.sum(axis=1)
        every = {"strain": limits.strain, "stress": limits.stress, "energy": energy}
        some = {name: limit for name, limit in every.items() if np.isfinite(limit).any()}
        measure, least = elements.measuring(tuple(some), place), np.stack([*some.values()], 1)
        return lambda x: (measure(x) / least).max(axis=1)

    def loads(self, position: Floats) -> Floats:
        """Return the loads divided by the limits of elements, shape (element,).

        Args:
            position: Of all nodes [m], shape (node, 3).
        """
        x = np.ascontiguousarray(position, dtype=float).ravel()
        return self.loading(np.arange(len(position)))(x)

    def broken(self, position: Floats) -> Indices:
        """Return the entities that break, shape (n,).

        Args:
            position: Of all nodes [m], shape (node, 3).
        """
        return self.entities[self.loads(position) > 1.0]


def measures_of(point: TracedPoint) -> dict[str, Number]:
    """Return what limits are of: a strain, a stress [Pa], and an energy per volume [Pa].

    Args:
        point: Of elements; what it remembers has no part in them.
    """
    f = point.tensor(list(map(point.mean_of, point.state.seen.get("deformation", point.f))))
    stretch = sqrt(largest(f.transposed @ f))
    pull = _largest_stress(point) / stretch
    if point.functions > 1:
        energy = point.mean_of(point.state.energy + point.of_mean)
    else:
        energy = point.mean_of(point.state.energy) + point.of_mean
    if point.cell is not None:
        energy = energy + point.cell.state.energy
    return {"strain": stretch - 1.0, "stress": pull, "energy": energy}


def _largest_stress(point: TracedPoint) -> Number:
    """Return the largest principal value of the mean of P Fᵀ [Pa]."""
    if point.directions == 2:  # in the plane, where Fᵀ P has the same principal values
        f, piola = point.tensor(point.f), point.tensor(point.elastic_stress)
        (a, b), (c, d) = (map(point.mean_of, row) for row in (f.transposed @ piola).rows)
        half = 0.5 * (a - d)
        return 0.5 * (a + d) + sqrt(maximum(half * half + b * c, 0.0))
    mean = dict(zip(PLACES[3], map(point.mean_of, point.state.seen["kirchhoff"]), strict=True))
    every = range(3)
    return largest(Tensor([mean[min(i, j), max(i, j)] for j in every] for i in every))
