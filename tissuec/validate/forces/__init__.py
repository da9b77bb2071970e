"""Forces on the nodes, by formulas of the reference's own.

Nothing here, and nothing that these modules import, computes a force for the engine: numbers
come from a ``State`` as plain attributes, and docs/numerics.md is what both implement.

Shared arguments:
    corners: Corners of triangles [m], shape (triangle, 3, 3).
    along: Unit vector, dimensionless, shape (3,).
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from tissuec.core.registry import Family

if TYPE_CHECKING:
    from scipy.sparse import coo_matrix

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class ForceFormula(Protocol):
    """A field of forces; a member of ``FORMULAS`` is made from the field of a block.

    Shared arguments:
        time: Time [s].
        position: Of all nodes [m], shape (node, 3).
        velocity: Of all nodes [m/s], shape (node, 3).
        to: Forces on all nodes that are added to [N], shape (node, 3).
        number: Of each node among those that may move, -1 for others.
        size: Number of nodes that may move.
    """

    def add_forces(self, time: float, position: Floats, velocity: Floats, to: Floats) -> None:
        """Add the forces on all nodes [N], shape (node, 3)."""
        ...

    def energy(self, time: float, position: Floats) -> float:
        """Return the stored energy [J]; none by default."""
        return 0.0

    def potential(self, time: float, position: Floats) -> float:
        """Return the energy whose negative gradient is the force at rest [J], at one state."""
        return self.energy(time, position)

    def wayward(self, time: float, position: Floats) -> Floats:
        """Return the forces at rest without a potential [N], shape (node, 3); often none."""
        return np.zeros_like(position)

    def pumping(self, time: float, position: Floats, velocity: Floats) -> float:
        """Return the power supplied from outside [W]; none by default."""
        return 0.0

    def dissipated(self, time: float, position: Floats, velocity: Floats) -> float:
        """Return the power dissipated [W]; none by default."""
        return 0.0

    def matrix(self, time: float, position: Floats, number: Indices, size: int) -> "coo_matrix":
        """Return minus the derivative of the forces [N/m], shape (3 size, 3 size)."""
        ...


def assembled(blocks: Floats, number: Indices, size: int) -> "coo_matrix":
    """Return the sum of blocks of items as a matrix, shape (3 size, 3 size).

    Args:
        blocks: In any unit, shape (item, node, 3, node, 3).
        number: Of the nodes of items among those that may move, -1 for others, shape (item,
            node).
        size: Number of nodes that may move.
    """
    from scipy.sparse import coo_matrix

    place = 3 * number[..., None] + np.arange(3)
    rows = np.broadcast_to(place[:, :, :, None, None], blocks.shape)
    columns = np.broadcast_to(place[:, None, None, :, :], blocks.shape)
    moves = (rows >= 0) & (columns >= 0)
    entries = blocks[moves], (rows[moves], columns[moves])
    return coo_matrix(entries, shape=(3 * size, 3 * size))


#: Under the names of the members of ``tissuec.forces.FORCES``.
FORMULAS: Family[Callable[[Any], ForceFormula]] = Family(
    "tissuec.validate.forces", "force formula"
)
