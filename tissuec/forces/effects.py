"""Effects on nodes: forces with their energies, powers, matrices and bounds."""

from abc import ABCMeta, abstractmethod
from collections.abc import Callable
from typing import TYPE_CHECKING, Self

import numpy as np
from msgspec import Struct, StructMeta
from numpy.typing import NDArray

from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

    from tissuec.forces.solids.element_limits import BreakableElements

#: Adds an operator applied to a vector to another one, both of shape (node, 3).
Resisting = Callable[[Floats, Floats], None]


class AbstractStruct(StructMeta, ABCMeta):
    """The class of a ``Struct`` that leaves functions to its members."""


class Effect(Struct, metaclass=AbstractStruct, frozen=True, eq=False):
    """An effect on nodes; arrays are in the order of nodes of the scene.

    Shared arguments:
        time: Time [s], shape (…) or a number.
        to: Forces on all nodes that are added to [N], shape (…, node, 3).
        exact: Whether the matrix includes the parts that may make it indefinite.
    """

    @abstractmethod
    def add_forces(
        self, time: Floats | float, position: Floats, velocity: Floats, to: Floats
    ) -> None:
        """Add the forces on all nodes [N], shape (…, node, 3)."""

    @abstractmethod
    def powers(self, time: Floats | float, position: Floats, velocity: Floats) -> Floats:
        """Return the powers supplied from outside and dissipated [W], shape (…, 2).

        The work of nodes on prescribed paths is not included.
        """

    @abstractmethod
    def energy(self, time: Floats | float, position: Floats) -> Floats:
        """Return the stored energy [J], shape (…)."""

    def potential(self, time: Floats | float, position: Floats) -> Floats:
        """Return the energy whose negative gradient is the force at rest [J], shape (…).

        It includes the potential of external loads. ``wayward`` returns the other forces.
        """
        return self.energy(time, position)

    def wayward(self, time: float, position: Floats) -> Floats | None:
        """Return the part of forces at rest that has no potential [N], shape (node, 3).

        None, the default, where there is never any.
        """
        return None

    @abstractmethod
    def matrix(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "csc_matrix":
        """Return minus the derivative of the forces by positions [N/m], shape (3 size, 3 size).

        Without ``exact``, parts that may make the matrix indefinite are left out.
        """

    @property
    def loss(self) -> str:
        """Return why energy is not conserved, as the beginning of a sentence.

        Empty if it is, or is lost only through ``braking``.
        """
        return ""

    def split(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "tuple[csc_matrix, Floats]":
        """Return the matrix as S and W of S + W Wᵀ; S in [N/m], W in [(N/m)^½].

        W, of shape (3 size, column), contains the parts that couple many nodes at once and
        would fill S.
        """
        whole = self.matrix(time, position, number, size, exact=exact)
        return whole, np.zeros((3 * size, 0))

    @property
    def breakable(self) -> "BreakableElements | None":
        """Return the elements that break at a limit; None without any."""
        return None

    def touched(self, position: Floats) -> NDArray[np.bool_]:
        """Return which nodes this ties to anything outside their piece, shape (node,)."""
        return np.zeros(len(position), dtype=bool)

    @property
    def relaxed(self) -> Self:
        """Return the effect after all relaxation, without its branches."""
        return self

    def recalling(self, velocity: Floats) -> Self:
        """Return the same with an energy and a matrix that include what relaxes.

        They are those of a change that leaves no time to relax.

        Args:
            velocity: Of all nodes [m/s], followed by internal variables, shape (…, row, 3).
        """
        return self

    # --- bounds, which members override where they know better ones -----------------------

    def weakening(self, time: float, position: Floats, number: Indices, size: int) -> float:
        """Return a bound on how negative an eigenvalue of the matrix may be [N/m].

        This is Gershgorin's bound of the parts that only the exact matrix has.
        """
        whole, positive = (
            self.matrix(time, position, number, size, exact=exact) for exact in (True, False)
        )
        return float(np.asarray(abs(whole - positive).sum(axis=1)).max(initial=0.0))

    def stiffening(self, time: float, position: Floats) -> Resisting | None:
        """Return a bound of the stiffness, an operator on displacements [N/m], or None.

        It is diagonal: the sums of absolute values in the rows of the matrix.
        """
        rows = self._rows(time, position)

        def resist(moved: Floats, to: Floats) -> None:
            to += rows * moved

        return resist

    def braking(self, position: Floats) -> Resisting | None:
        """Return a bound of the damping, an operator on velocities [N s/m], or None."""
        return None

    def spread(self, time: float, position: Floats) -> float:
        """Return the sum of the absolute terms of the energy, to scale rounding errors [J]."""
        forces = np.zeros_like(position)
        self.add_forces(time, position, np.zeros_like(position), forces)
        return float(abs(self.energy(time, position)) + np.abs(forces * position).sum())

    def noise(self, time: float, position: Floats) -> float:
        """Return the largest absolute term of the forces, a scale of rounding errors [N]."""
        return float((self._rows(time, position) * np.abs(position)).max(initial=0.0))

    def _rows(self, time: float, position: Floats) -> Floats:
        """Return the sums of the sizes in the rows of the matrix [N/m], shape (node, 3)."""
        count = len(position)
        matrix = abs(self.matrix(time, position, np.arange(count), count).tocsr())
        return np.asarray(matrix.sum(axis=1), dtype=float).reshape(-1, 3)
