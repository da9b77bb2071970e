"""Internal variables in the matrix of an implicit step, and their derivatives.

Internal variables z of an item, such as a spring or a point of an element, follow the
velocities of nodes, so that a step treats them like all other motion: z' = r(x, z), and the
item pulls with f(x, z). With q = h γ, Newton's method on accelerations a of nodes and rates b
of variables has, with G = -∂r/∂z, R = ∂r/∂x and P = ∂f/∂z,

    (1 + q G) δb - q² R δa = β,        (M + q D + q² K) δa - q P δb = α

for the residuals α and β. δb = (1 + q G)⁻¹ (β + q² R δa) leaves an equation for nodes alone:

    (M + q D + q² K - q³ P (1 + q G)⁻¹ R) δa = α + q P (1 + q G)⁻¹ β.

(Static condensation: J. C. Simo, T. J. R. Hughes, Computational Inelasticity, 1998, section
1.7.) A branch of a spring that relaxes within a step then adds c / (1 + q/τ) instead of c.

All tensors of a point are the internal variables of one item (``forces.memory``): branches of
a wall change its thickness together, and plastic flow carries branches along.
"""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from tissuec.forces.matrices import assembled
from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix, csr_matrix

# Time of the derivatives of three variables, and of eliminating them in a solution [s].
TANGENT_SECONDS, ELIMINATION_SECONDS = 8e-6, 4e-7


class MemoryTangents(NamedTuple):
    """Derivatives of the rates and forces of internal variables.

    Variables have the unit of velocities, which they follow; see ``Network.internal``.

    Attributes:
        slots: Places of the variables among the components of all velocities, -1 where there is
            none, shape (item, variable).
        nodes: That an item acts on, shape (item, node).
        giving: -∂r/∂z [1/s], shape (item, variable, variable).
        by_position: ∂r/∂x [1/s²], shape (item, variable, node, 3).
        pull: ∂f/∂z [N s/m], shape (item, node, 3, variable).
    """

    slots: Indices
    nodes: Indices
    giving: Floats
    by_position: Floats
    pull: Floats

    def matrices(self, size: int) -> "tuple[csr_matrix, csr_matrix]":
        """Return the derivatives of rates by positions, and of rates and forces by variables.

        Rows of variables count as nodes of 1 kg.

        Args:
            size: Number of all nodes and rows of variables.

        Returns:
            [1/s²] and [1/s] for variables, [N s/m] for nodes, shape (3 size, 3 size).
        """
        nodes = 3 * self.nodes[..., None] + np.arange(3)
        rows = self.slots[:, :, None], nodes.reshape(len(nodes), -1, 1)
        columns = np.swapaxes(rows[0], 1, 2), np.swapaxes(rows[1], 1, 2)
        flat = (len(nodes), self.slots.shape[1], -1)
        return (
            _summed([(self.by_position.reshape(flat), rows[0], columns[1])], size),
            _summed(
                [
                    (-self.giving, rows[0], columns[0]),
                    (self.pull.reshape(len(nodes), -1, flat[1]), rows[1], columns[0]),
                ],
                size,
            ),
        )


def _summed(parts: "list[tuple[Floats, Indices, Indices]]", size: int) -> "csr_matrix":
    """Return a matrix of all nodes from entries, and their rows and columns, -1 for none."""
    from scipy.sparse import csr_matrix

    found = csr_matrix((3 * size, 3 * size))
    for values, *places in parts:
        row, column = (np.broadcast_to(each, values.shape) for each in places)
        has = (row >= 0) & (column >= 0)
        entries = values[has], (row[has], column[has])
        found = found + csr_matrix(entries, shape=found.shape)
    return found


class Condensed:
    """Internal variables of some items, eliminated for a step.

    Args:
        tangents: Of the items.
        q: Step size times the coefficient of the method [s].
    """

    def __init__(self, tangents: MemoryTangents, q: float):
        items, variables = tangents.slots.shape
        self._slots, self._has = tangents.slots, tangents.slots >= 0
        self._nodes, self._q = tangents.nodes, q
        whole = np.eye(variables) + q * tangents.giving
        flat = tangents.by_position.reshape(items, variables, -1)
        self._inverse = np.linalg.inv(whole)
        self._follow = self._inverse @ flat
        self._pull = tangents.pull.reshape(items, -1, variables)

    def matrix(self, number: Indices, size: int) -> "csc_matrix":
        """Return -q³ P (1 + q G)⁻¹ R [kg], shape (3 size, 3 size).

        Args:
            number: Of each node among those that may move, -1 for others, shape (node,).
            size: Number of nodes that may move.
        """
        nodes = self._nodes.shape[1]
        blocks = -(self._q**3) * (self._pull @ self._follow)
        blocks = blocks.reshape(-1, nodes, 3, nodes, 3)
        return assembled(blocks, number[self._nodes], size)

    def enter(self, residual: Floats, force: Floats) -> Floats:
        """Add q P (1 + q G)⁻¹ β to forces, and return (1 + q G)⁻¹ β.

        Args:
            residual: Residuals of all nodes and variables [m/s²], flat, shape (3 node,).
            force: Of all nodes [N], shape (node, 3); changed in place.

        Returns:
            Changes of the rates while no node moves [m/s²], shape (item, variable).
        """
        own = np.where(self._has, residual[np.where(self._has, self._slots, 0)], 0.0)
        found = np.einsum("iuv,iv->iu", self._inverse, own)
        push = self._q * np.einsum("ifv,iv->if", self._pull, found)
        np.add.at(force, self._nodes, push.reshape(*self._nodes.shape, 3))
        return found

    def leave(self, found: Floats, change: Floats) -> None:
        """Set the changes of the rates.

        Args:
            found: What ``enter`` returned.
            change: Changes of accelerations of all nodes [m/s²], flat, shape (3 node,); those
                of the variables are set in it.
        """
        moved = change.reshape(-1, 3)[self._nodes].reshape(len(self._nodes), -1)
        found = found + self._q**2 * np.einsum("ivf,if->iv", self._follow, moved)
        change[self._slots[self._has]] = found[self._has]
