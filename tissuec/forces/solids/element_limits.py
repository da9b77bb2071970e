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
from functools import cache
from typing import NamedTuple, Protocol, Self

import numpy as np
from msgspec import Struct

from tissuec.laws.derivatives import energy
from tissuec.laws.solid import SolidLaw
from tissuec.model.network import Floats, Indices


class LimitColumns(NamedTuple):
    """Limits as kernels read them, the first columns of their records.

    Attributes:
        strain: Shape (element,).
        stress: [Pa], shape (element,).
        energy: [J], shape (element,).
        energies: Address of the energies of laws; 0 where no energy breaks elements.
    """

    strain: Floats
    stress: Floats
    energy: Floats
    energies: int


class Loaded(Protocol):
    """Elements of one shape, as ``forces.element_fields.MaterialField``."""

    @property
    def laws(self) -> tuple[SolidLaw, ...]:
        """Return their laws."""
        ...

    @property
    def crack_areas(self) -> Floats:
        """Return the areas of cracks through single elements [m²], shape (element,)."""
        ...

    def only(self, items: Indices) -> Self:
        """Return some elements, by indices of shape (n,)."""
        ...

    def energies(self, position: Floats) -> Floats:
        """Return the energy of each element [J], shape (element,).

        Args:
            position: Of all nodes [m], shape (node, 3).
        """
        ...

    @property
    def limit_kernel(self) -> Callable[..., None]:
        """Return the scalar loops that set the loads."""
        ...

    def limit_table(self, place: Indices, limits: LimitColumns) -> NamedTuple:
        """Return the record of these loops.

        Args:
            place: Index of each node in their arrays, shape (node,).
            limits: Of the elements.
        """
        ...


class ElementLimits(NamedTuple):
    """Limits of elements; infinite where there is none.

    Attributes:
        strain: Shape (element,).
        stress: [Pa], shape (element,).
        toughness: Energy per area of a crack that they hold when they break [J/m²], shape
            (element,).
        marks: The spring without force that marks each element: it exists while the
            element is, shape (element,).
    """

    strain: Floats
    stress: Floats
    toughness: Floats
    marks: Indices

    def some(self, items: Indices) -> "ElementLimits":
        """Return those of some elements, by indices of shape (n,)."""
        strain, stress = self.strain[items], self.stress[items]
        return ElementLimits(strain, stress, self.toughness[items], self.marks[items])

    def behind(self, first: int) -> "ElementLimits":
        """Return the same with marks that are counted from a first one."""
        return self._replace(marks=first + self.marks)

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
    """

    elements: Loaded
    limits: ElementLimits

    @property
    def kernel(self) -> Callable[..., None]:
        """Return the scalar loops, which set the loads."""
        return self.elements.limit_kernel

    def some(self, items: Indices) -> "BreakableElements":
        """Return some of them, by indices of shape (n,)."""
        return BreakableElements(self.elements.only(items), self.limits.some(items))

    def table(self, place: Indices) -> NamedTuple:
        """Return the record of the kernel.

        Args:
            place: Index of each node in the arrays of the kernel, shape (node,).
        """
        address = _address_of_energies(self.elements.laws)
        energy = np.full(len(self.limits.marks), np.inf) if address is None else self.energy
        columns = LimitColumns(self.limits.strain, self.limits.stress, energy, address or 0)
        return self.elements.limit_table(place, columns)

    @property
    def energy(self) -> Floats:
        """Return the energies that break them [J], shape (element,)."""
        return np.asarray(self.limits.toughness * self.elements.crack_areas)

    def is_coded(self) -> bool:
        """Return whether the kernel sets all loads, rather than those of stretch and stress."""
        has_none = not np.isfinite(self.limits.toughness).any()
        return has_none or _address_of_energies(self.elements.laws) is not None

    def by_energy(self, position: Floats) -> Floats:
        """Return the loads of energy alone, shape (element,).

        Args:
            position: Of all nodes [m], shape (node, 3).
        """
        return np.asarray(self.elements.energies(position) / self.energy)

    def loads(self, position: Floats) -> Floats:
        """Return the loads divided by the limits of elements, shape (element,).

        Args:
            position: Of all nodes [m], shape (node, 3).
        """
        from tissuec.compiled.calls import kernel_on

        call = kernel_on(self.kernel, self.table(np.arange(len(position))))
        found, still = np.zeros(len(self.limits.marks)), np.zeros(0)
        call(0.0, np.ascontiguousarray(position, dtype=float).ravel(), still, found, still)
        return found if self.is_coded() else np.maximum(found, self.by_energy(position))

    def broken(self, position: Floats) -> Indices:
        """Return the marks of those that break, shape (n,).

        Args:
            position: Of all nodes [m], shape (node, 3).
        """
        return self.limits.marks[self.loads(position) > 1.0]


@cache
def _address_of_energies(laws: tuple[SolidLaw, ...]) -> int | None:
    """Return where the compiled energies of laws are; None if one has no code."""
    from tissuec.compiled.laws import slope_addresses

    try:
        return slope_addresses(tuple((energy(law),) for law in laws))[0]
    except TypeError:  # of sums over principal stretches, only slopes are compiled
        return None
