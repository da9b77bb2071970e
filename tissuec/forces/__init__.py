"""Forces on nodes by where these are: volumes, walls that bend, contact, jets.

Springs have their own way; everything else that acts on nodes is a ``Field``. Each file has
the numbers of one effect, what it does to nodes, and all that the rest of the program wants to
know of it; a file whose name ends in ``kernel`` has the same forces as scalar loops, for the
engine. Beside ``situation``, which holds fields, and the reference, which has formulas of its
own, nothing knows them by more than ``Field``.
"""

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, Protocol

from tissuec.courses import Course
from tissuec.kernels.records import Acts
from tissuec.network import Floats, Indices

if TYPE_CHECKING:
    from scipy.sparse import coo_matrix

#: Adds an operator applied to a vector to another one, both of shape (node, 3).
Resisting = Callable[[Floats, Floats], None]


class Field(Protocol):
    """What acts on nodes beside springs; arrays stand in the order of the scene.

    Arguments have the same meaning in all functions: ``time`` [s] of shape (…); ``position``
    [m] and ``velocity`` [m/s] of all nodes, shape (…, node, 3), or (node, 3) where the result
    is one number or matrix; ``number`` of each node among those that may move, -1 for others,
    and the ``size`` of these, so that matrices are of shape (3 size, 3 size).
    """

    @property
    def kernel(self) -> Callable[..., None]:
        """Return the scalar loops: of time, positions, velocities, forces, powers and a table.

        They add forces [N] and the powers that are put in from outside and lost [W].
        """
        ...

    def table(self, place: Indices, acts: Acts, position: Floats) -> Any:
        """Return what the kernel is given, a record of arrays.

        Args:
            place: Where the engine keeps each node, shape (node,).
            acts: The sum of ``changes``, as the first component of its only act.
            position: Around which it holds.
        """
        ...

    @property
    def changes(self) -> Iterable[tuple[float, Course]]:
        """Return what changes in time by itself: amounts, and the courses they follow."""
        ...

    def add_forces(
        self, time: Floats | float, position: Floats, velocity: Floats, to: Floats
    ) -> None:
        """Add the forces on all nodes [N], shape (…, node, 3)."""
        ...

    def energy(self, time: Floats | float, position: Floats) -> Any:
        """Return the stored energy [J], shape (…)."""
        ...

    def dissipated(self, time: Any, position: Floats, velocity: Floats) -> Any:
        """Return the power that is lost [W]."""
        ...

    def pumping(self, time: float, position: Floats, velocity: Floats) -> float:
        """Return the power that is put in from outside, beside that of moving nodes [W]."""
        ...

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "coo_matrix":
        """Return minus the derivative of the forces [N/m]; none that weakens unless exact."""
        ...

    def weakening(self, time: float, position: Floats, number: Indices, size: int) -> float:
        """Return how far below zero an eigenvalue of the matrix may be [N/m]."""
        ...

    def stiffening(self, position: Floats) -> Resisting | None:
        """Return what resists displacements at most [N/m], None if nothing does."""
        ...

    def braking(self, position: Floats) -> Resisting | None:
        """Return what resists velocities at most [N s/m], None if nothing does."""
        ...

    def spread(self, time: float, position: Floats) -> float:
        """Return the sum of what energies are made of, whose digits rounding spoils [J]."""
        ...

    def noise(self, position: Floats) -> float:
        """Return a force whose digits rounding spoils [N]."""
        ...
