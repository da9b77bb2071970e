"""An elastic foundation: tissue around a body that keeps it in place.

Each node is held to where it is drawn by a spring and a dashpot that have no direction of their
own, by the area A of skin that it stands for:

    F = -A (c (x - x0) + d v),    E = A c |x - x0|²/2.

(E. Winkler, *Die Lehre von der Elasticitaet und Festigkeit*, 1867.)
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core import units
from tissuec.core.fields import Real
from tissuec.forces import FORCES, Acted, Field, Resisting, diagonal
from tissuec.kernels.records import BoundaryConditions, Floats, Rows
from tissuec.model.network import Indices

if TYPE_CHECKING:
    from scipy.sparse import coo_matrix


@FORCES.member("foundation")
class Foundation(Struct, frozen=True, eq=False):
    """Holds a surface at its drawn place, as the tissue around a body does.

    Attributes:
        stiffness: pressure per displacement, in all directions
        damping: pressure per velocity
    """

    stiffness: Annotated[float, Real(units.AREAL_STIFFNESS, above=0.0)]
    damping: Annotated[float, Real(units.AREAL_VISCOSITY, at_least=0.0)] = 0.0

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

    def table(self, place: Indices, acts: BoundaryConditions, position: Floats) -> "BedTable":
        """Return what holds anywhere."""
        return BedTable(place[self.nodes], self.home, self.stiffness, self.damping)

    def energy(self, time: Floats | float, position: Floats) -> Floats:
        """Return the stored energy [J], shape (…)."""
        return 0.5 * (self._moved(position) ** 2).sum(axis=-1) @ self.stiffness

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int, *, exact: bool = True
    ) -> "coo_matrix":
        """Return a diagonal [N/m]."""
        blocks = self.stiffness[:, None, None] * np.eye(3)
        return diagonal(blocks, number[self.nodes], size)

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


class BedTable(NamedTuple):
    """A bed as the kernel reads it; see ``Bed``."""

    nodes: Indices
    home: Rows
    stiffness: Floats
    damping: Floats


def hold(time: float, x: Floats, v: Floats, f: Floats, power: Floats, bed: BedTable) -> None:
    """Add the forces of a bed to those on nodes, and the power that its dashpots dissipate.

    Args:
        bed: The bed.
    """
    for k in range(bed.nodes.size):
        stiffness, damping = bed.stiffness[k], bed.damping[k]
        for axis in range(3):
            i = 3 * bed.nodes[k] + axis
            f[i] -= stiffness * (x[i] - bed.home[k, axis]) + damping * v[i]
            power[1] += damping * v[i] * v[i]
