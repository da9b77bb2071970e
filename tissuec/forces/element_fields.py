"""Fields of elements, whose matrices are sums of those of single elements."""

from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Self

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from tissuec.forces.effects import Resisting
from tissuec.forces.fields import WalledField
from tissuec.forces.matrices import BlockPattern, ForceDerivatives, as_operator
from tissuec.forces.solids.element_limits import ElementLimits
from tissuec.laws.solid import SolidLaw
from tissuec.laws.solid.invariants import NeoHookean
from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:
    from scipy.sparse import coo_matrix

    from tissuec.forces.solids.element_memory import StoredTensors


class ElementField(WalledField, frozen=True):
    """A field whose items are elements.

    Attributes:
        nodes: Shape (element, node).
    """

    nodes: Indices

    @property
    def item_count(self) -> int:
        """Return the number of elements."""
        return len(self.nodes)

    @property
    @abstractmethod
    def is_damped(self) -> bool:
        """Return whether any element is viscous."""

    @abstractmethod
    def element_matrices(self, position: Floats, *, exact: bool) -> Floats:
        """Return ∂²E/∂x∂x of each element [N/m], shape (element, node, 3, node, 3).

        Args:
            position: Of all nodes [m], shape (node, 3).
            exact: As for ``matrix``.
        """

    @abstractmethod
    def damping_of_elements(self, position: Floats) -> Floats:
        """Return minus the derivative of viscous forces by velocities, element by element.

        Args:
            position: Of all nodes [m], shape (node, 3).

        Returns:
            [N s/m], shape (element, node, 3, node, 3).
        """

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "coo_matrix":
        """Return ∂²E/∂x∂x [N/m], shape (3 size, 3 size); see ``Effect``."""
        return self._sum(lambda own: own.element_matrices(position, exact=exact), number, size)

    def damping_matrices(
        self, position: Floats, velocity: Floats, number: Indices, size: int
    ) -> "tuple[coo_matrix, coo_matrix] | None":
        """Return minus the derivatives of viscous forces; see ``Field``.

        By positions, the change of their direction is left out, which leaves both positive.
        """
        if not self.is_damped:
            return None
        from scipy.sparse import coo_matrix

        slow = self._slow(position, number, size)
        return coo_matrix(slow.shape), slow

    def _slow(self, position: Floats, number: Indices, size: int) -> "coo_matrix":
        """Return the viscous matrix [N s/m], shape (3 size, 3 size)."""
        return self._sum(lambda own: own.damping_of_elements(position), number, size)

    def _sum(
        self, blocks: Callable[[Self], Floats], number: Indices, size: int
    ) -> "coo_matrix":
        """Return the matrix of all elements from those of single ones."""
        moves = (number[self.nodes] >= 0).any(axis=1)
        own = self if moves.all() else self.only(np.flatnonzero(moves))
        pattern = BlockPattern.of(number[own.nodes], size)
        room = pattern.room
        for part, some in own.in_blocks():
            pattern.add(blocks(some), part, room)
        return pattern.matrix(room)

    def stiffening(self, time: float, position: Floats) -> Resisting:
        """Return the matrix of positive parts as an operator [N/m]; see ``Effect``."""
        every, count = np.arange(len(position)), len(position)
        return as_operator(lambda: self.matrix(time, position, every, count, exact=False))

    def braking(self, position: Floats) -> Resisting | None:
        """Return the viscous matrix as an operator [N s/m]; see ``Effect``."""
        if not self.is_damped:
            return None
        every, count = np.arange(len(position)), len(position)
        return as_operator(lambda: self._slow(position, every, count))

    @property
    def derivatives(self) -> ForceDerivatives | str:
        """Return why there are no exact derivatives for learning."""
        return "have no exact derivatives"


def young_of(shear: Floats, bulk: Floats) -> Floats:
    """Return Young's modulus 9 K μ/(3 K + μ) [Pa], of the shape of the arguments.

    Args:
        shear, bulk: μ and K [Pa].
    """
    return 9.0 * bulk * shear / (3.0 * bulk + shear)


class MaterialField(ElementField, frozen=True):
    """Elements that follow laws of solids; one that loses an edge or breaks is removed.

    ``walls`` are the springs along edges, followed by the marks of ``limits``.

    Attributes:
        name: Of the body.
        limits: At which they break; None where nothing may break.
        laws: That they follow.
    """

    name: str
    limits: ElementLimits | None
    laws: tuple[SolidLaw, ...]

    @property
    def joining_springs(self) -> Indices:
        """Return the springs along the edges of elements, shape (n,)."""
        if self.limits is None:
            return self.walls
        return self.walls[~np.isin(self.walls, self.limits.marks)]

    @property
    @abstractmethod
    def faces(self) -> Indices:
        """Return the triangles of the surface of each element, shape (element, triangle, 3)."""

    # --- memory -------------------------------------------------------------------------------

    @property
    @abstractmethod
    def stored_tensors(self) -> "tuple[StoredTensors, ...]":
        """Return the tensors that hidden nodes store, in the order of these nodes."""

    @property
    @abstractmethod
    def points(self) -> int:
        """Return the number of points of an element at which it is stored."""

    @property
    def remembers(self) -> bool:
        """Return whether any element relaxes or yields."""
        return bool(self.stored_tensors)

    @property
    def hidden(self) -> Indices:
        """Return the hidden nodes of branches and of plastic strain; see ``Field``."""
        none = np.zeros(0, dtype=np.int64)
        return np.concatenate(
            [none, *(each.nodes(self.points) for each in self.stored_tensors)]
        )

    def add_forces(
        self, time: Floats | float, position: Floats, velocity: Floats, to: Floats
    ) -> None:
        """Add the forces on all nodes [N]; those on hidden ones, which are rates, are not."""
        if not self.remembers:
            super().add_forces(time, position, velocity, to)
            return
        hidden = self.hidden
        before = to[..., hidden, :]
        super().add_forces(time, position, velocity, to)
        to[..., hidden, :] = before

    # --- bounds -------------------------------------------------------------------------------

    @property
    @abstractmethod
    def rigidity(self) -> Floats:
        """Return moduli times volumes [J], shape (element,)."""

    @property
    @abstractmethod
    def steepest(self) -> Floats:
        """Return the largest gradient of a shape function [1/m], shape (element,)."""

    @property
    def yields(self) -> NDArray[np.bool_]:
        """Return which elements yield, shape (element,)."""
        return np.zeros(self.item_count, dtype=bool)

    @abstractmethod
    def energies(self, position: Floats) -> Floats:
        """Return the energy of each element [J], shape (…, element).

        Args:
            position: Of all nodes [m], shape (…, node, 3).
        """

    @abstractmethod
    def invariants(self, position: Floats) -> tuple[Floats, Floats]:
        """Return both isochoric invariants at the points of elements, shape (element, …).

        Args:
            position: Of all nodes [m], shape (node, 3).
        """

    @abstractmethod
    def stress_shares(self, position: Floats) -> tuple[Floats, Floats]:
        """Return the stress of each element times the volumes of its nodes, and these volumes.

        Args:
            position: Of all nodes [m], shape (node, 3).

        Returns:
            Σ w σ [J], shape (element, node, 3, 3), and Σ w [m³], shape (element, node).
        """

    @property
    @abstractmethod
    def node_volumes(self) -> Floats:
        """Return the drawn volume of each node of each element [m³], shape (element, node)."""

    @property
    @abstractmethod
    def fibre_lines(self) -> tuple[Floats, Floats]:
        """Return ∂N/∂X · a of families of fibres at points, and the volumes of these.

        They refer to the shape without stress; shapes (element, line, node) [1/m] and (element,
        line) [m³], a line being a family at a point.
        """

    @property
    @abstractmethod
    def young(self) -> Floats:
        """Return Young's modulus at rest, without fibres [Pa], shape (element,)."""

    @abstractmethod
    def plastic_shares(self, velocity: Floats) -> tuple[Floats, Floats]:
        """Return equivalent plastic strains times the volumes of nodes, and these volumes.

        Args:
            velocity: Of all nodes [m/s], shape (node, 3); those of hidden ones are read.

        Returns:
            [m³], shape (element, node) both.
        """

    def energy(self, time: Floats | float, position: Floats) -> Floats:
        """Return the stored energy [J], shape (…)."""
        return self.energies(position).sum(axis=-1)

    def around(self, nodes: Indices) -> tuple[Self, Indices]:
        """Return the elements at some nodes, and all nodes of these.

        Args:
            nodes: Indices, shape (n,).

        Returns:
            The elements, with the places of their nodes among the second, which are ascending.
        """
        own = self.only(np.flatnonzero(np.isin(self.nodes, nodes).any(axis=1)))
        used, place = np.unique(own.nodes, return_inverse=True)
        return replace(own, nodes=place.reshape(own.nodes.shape)), used

    def node_stress(self, position: Floats) -> tuple[Floats, Floats]:
        """Return sums of stress over the shares of nodes, and these shares.

        The mean stress of a node is the first divided by the second, without viscous stress.

        Args:
            position: Of all nodes [m], shape (node, 3).

        Returns:
            Σ w σ [J], shape (node, 3, 3), and Σ w [m³], shape (node,).
        """
        total, volume = np.zeros((len(position), 3, 3)), np.zeros(len(position))
        for _, own in self.in_blocks():
            stress, share = own.stress_shares(position)
            np.add.at(volume, own.nodes, share)
            np.add.at(total, own.nodes, stress)
        return total, volume

    def spread(self, time: float, position: Floats) -> float:
        """Return the scale of the rounding errors of the energy [J]; see ``Effect``."""
        return float(self.rigidity.sum())

    def noise(self, time: float, position: Floats) -> float:
        """Return the scale of the rounding errors of forces [N]; see ``Effect``."""
        # Places are rounded to a part of their size, and not to one of the size of elements.
        size = float(np.abs(position[self.nodes]).max(initial=0.0))
        each = self.rigidity * self.steepest * (1.0 + size * self.steepest)
        return float(each.max(initial=0.0))

    @property
    def stiffest(self) -> float:
        """Return about the largest stiffness of an element [N/m]."""
        return float((self.rigidity * self.steepest**2).max(initial=0.0))


def numbered_laws(
    law: Indices, laws: Sequence[SolidLaw]
) -> tuple[Indices, tuple[SolidLaw, ...]]:
    """Return the numbers of laws among those that a kernel knows, and these laws.

    Args:
        law: Number of the law of each element, shape (element,).
        laws: The laws that are numbered.

    Returns:
        Shape (element,), and the laws, of which the first is neo-Hookean; equal laws have the
        first of their numbers.
    """
    every = (NeoHookean(), *laws)
    numbers = {each: k for k, each in reversed(list(enumerate(every)))}
    return np.array([numbers[each] for each in laws], dtype=np.int64)[law], every
