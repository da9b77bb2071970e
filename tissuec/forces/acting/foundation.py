"""An elastic foundation: tissue around a body that keeps it in place.

Each node is held to where it is drawn by a spring and a dashpot that have no direction of their
own, by the area A of skin that it represents:

    F = -A (c (x - x0) + d v),    E = A c |x - x0|²/2.

(E. Winkler, *Die Lehre von der Elasticitaet und Festigkeit*, 1867.)
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated

import numpy as np
from numpy.typing import NDArray

from tissuec.core import units
from tissuec.core.fields import Real
from tissuec.forces.acting import FORCES, Acted, Force
from tissuec.forces.acting.foundation_kernel import BedTable, hold
from tissuec.forces.effects import Resisting
from tissuec.forces.fields import Field
from tissuec.forces.matrices import ForceDerivatives, diagonal
from tissuec.kernels.records import BoundaryConditions, Floats
from tissuec.model.network import Indices

if TYPE_CHECKING:
    from scipy.sparse import coo_matrix


@FORCES.member("foundation")
class Foundation(Force, frozen=True, eq=False):
    """Holds a surface at its drawn place, as the tissue around a body does.

    Attributes:
        stiffness: pressure per displacement, in all directions
        damping: pressure per velocity
    """

    stiffness: Annotated[float, Real(units.AREAL_STIFFNESS, above=0.0, example="20 kPa/m")]
    damping: Annotated[
        float, Real(units.AREAL_VISCOSITY, at_least=0.0, example="20 Pa*s/m")
    ] = 0.0

    def on(self, acted: Acted) -> Field:
        """Return the bed of some nodes.

        Raises:
            ValueError: None of the nodes is on a surface.
        """
        if not acted.area.any():
            raise ValueError("it acts on surfaces, but none of these nodes is on one")
        kept = acted.area > 0.0
        area = acted.area[kept]
        return Bed(
            acted.nodes[kept], acted.position[kept], self.stiffness * area, self.damping * area
        )


class Bed(Field, frozen=True):
    """Springs and dashpots between nodes and where they are drawn.

    Attributes:
        nodes: Shape (n,).
        home: Where they are drawn [m], shape (n, 3).
        stiffness: A c of each [N/m], shape (n,).
        damping: A d of each [N s/m], shape (n,).
    """

    nodes: Indices
    home: Floats
    stiffness: Floats
    damping: Floats

    @property
    def kernel(self) -> Callable[..., None]:
        """Return the scalar loops."""
        return hold

    def table(self, place: Indices, acts: BoundaryConditions, position: Floats) -> BedTable:
        """Return the constraint, which is the same at any position."""
        return BedTable(place[self.nodes], self.home, self.stiffness, self.damping)

    @property
    def derivatives(self) -> ForceDerivatives:
        """Return the derivatives, also by stiffness, damping and home."""
        from tissuec.forces.acting.foundation_derivatives_kernel import pull_bed, push_bed

        return ForceDerivatives(("stiffness", "damping", "home"), pull_bed, push_bed)

    def energy(self, time: Floats | float, position: Floats) -> Floats:
        """Return the stored energy [J], shape (…)."""
        squares = (self._moved(position) ** 2).sum(axis=-1)
        # No product of matrices, whose last bits depend on how many states there are.
        return np.asarray((0.5 * self.stiffness * squares).sum(axis=-1))

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "coo_matrix":
        """Return a diagonal [N/m]."""
        blocks = self.stiffness[:, None, None] * np.eye(3)
        return diagonal(blocks, number[self.nodes], size)

    def damping_matrices(
        self, position: Floats, velocity: Floats, number: Indices, size: int
    ) -> "tuple[coo_matrix, coo_matrix] | None":
        """Return nothing [N/m] and a diagonal [N s/m]; see ``Field``."""
        blocks = self.damping[:, None, None] * np.eye(3)
        slow = diagonal(blocks, number[self.nodes], size)
        return 0.0 * slow, slow

    def touched(self, position: Floats) -> NDArray[np.bool_]:
        """Return the nodes that are held, shape (node,)."""
        found = np.zeros(len(position), dtype=bool)
        found[self.nodes] = True
        return found

    def braking(self, position: Floats) -> Resisting | None:
        """Return the dashpots [N s/m], None without any."""
        if not self.damping.any():
            return None

        def resist(moved: Floats, to: Floats) -> None:
            to[self.nodes] += self.damping[:, None] * moved[self.nodes]

        return resist

    def _moved(self, position: Floats) -> Floats:
        """Return how far nodes are from home [m], shape (…, n, 3)."""
        return position[..., self.nodes, :] - self.home
