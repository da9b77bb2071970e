"""Fields of elements, whose matrices are sums of those of single elements."""

from abc import abstractmethod
from collections.abc import Callable, Sequence
from functools import cache
from typing import TYPE_CHECKING, Self

import numpy as np

from tissuec.forces.effects import Resisting
from tissuec.forces.fields import Items, WalledField
from tissuec.forces.matrices import BlockPattern, ForceDerivatives, as_operator
from tissuec.laws.solid import SolidLaw
from tissuec.laws.solid.invariants import NeoHookean
from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:
    from scipy.sparse import csc_array, csc_matrix


MANY = 64  # elements of each kind: fewer are faster in one matrix


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

    def items(self, place: Indices) -> Items:
        """Return the nodes of the elements."""
        return Items.of(place[self.nodes])

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
    ) -> "csc_matrix":
        """Return ∂²E/∂x∂x [N/m], shape (3 size, 3 size); see ``Effect``."""
        return self._sum(lambda own: own.element_matrices(position, exact=exact), number, size)

    def damping_matrices(
        self, position: Floats, velocity: Floats, number: Indices, size: int
    ) -> "tuple[csc_matrix, csc_matrix] | None":
        """Return minus the derivatives of viscous forces; see ``Field``.

        By positions, the change of their direction is left out, which leaves both positive.
        """
        if not self.is_damped:
            return None
        from scipy.sparse import csc_matrix

        slow = self._slow(position, number, size)
        return csc_matrix(slow.shape), slow

    def _slow(self, position: Floats, number: Indices, size: int) -> "csc_matrix":
        """Return the viscous matrix [N s/m], shape (3 size, 3 size)."""
        return self._sum(lambda own: own.damping_of_elements(position), number, size)

    def _sum(
        self, blocks: Callable[[Self], Floats], number: Indices, size: int
    ) -> "csc_matrix":
        """Return the matrix of all elements from those of single ones."""
        moves = (number[self.nodes] >= 0).any(axis=1)
        own = self if moves.all() else self.only(np.flatnonzero(moves))
        pattern = BlockPattern.of(number[own.nodes], size)
        room = pattern.room
        for part, some in own.in_blocks():
            pattern.add(blocks(some), part, room)
        return pattern.matrix(room)

    def stiffening(self, time: float, position: Floats) -> Resisting:
        """Return the matrix of positive parts as an operator [N/m]; see ``Effect``.

        Of elements that are alike, as in a lattice, it is made once.
        """
        every, count = np.arange(len(position)), len(position)
        first, like = self.alike(position)
        if MANY * len(first) > self.item_count:
            return as_operator(lambda: self.matrix(time, position, every, count, exact=False))
        some = self.only(first)
        blocks = cache(lambda: some.element_matrices(position, exact=False))
        return as_blocks(self.nodes, like, blocks)

    def alike(self, position: Floats) -> tuple[Indices, Indices]:
        """Return elements with the same matrices: one of each kind, and the kind of each.

        Args:
            position: Of all nodes [m], shape (node, 3).
        """
        every = np.arange(self.item_count)
        return every, every

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


def as_blocks(nodes: Indices, like: Indices, blocks: Callable[[], Floats]) -> Resisting:
    """Return the matrices of elements as an operator on vectors of all nodes.

    Args:
        nodes: Shape (element, node).
        like: Number of the matrix of each element, shape (element,).
        blocks: Returns the matrices in any unit, shape (n, node, 3, node, 3).
    """
    count, width = nodes.shape
    groups = [np.flatnonzero(like == each) for each in range(int(like.max(initial=-1)) + 1)]
    force = np.zeros((count, width, 3))

    @cache
    def at_nodes(size: int) -> "csc_array":
        """Return the sum over elements as a matrix, shape (size, element · node)."""
        from scipy.sparse import csc_array

        ends = np.ones(nodes.size), nodes.ravel(), np.arange(nodes.size + 1)
        return csc_array(ends, shape=(size, nodes.size))

    def resist(moved: Floats, to: Floats) -> None:
        for group, block in zip(groups, blocks(), strict=True):
            own = moved[nodes[group]].reshape(len(group), 3 * width)
            force[group] = (own @ block.reshape(3 * width, -1)).reshape(-1, width, 3)
        to += at_nodes(len(to)) @ force.reshape(-1, 3)

    return resist


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
