"""Internal variables in the matrix of an implicit step, and their derivatives.

Internal variables z of an item, such as a spring or a point of an element, are kept as
velocities of hidden nodes, so that a step treats them like all other motion: z' = r(x, z), and
the item pulls with f(x, z). With q = h γ, Newton's method on accelerations a of nodes and rates
b of variables has, with G = -∂r/∂z, R = ∂r/∂x and P = ∂f/∂z,

    (1 + q G) δb - q² R δa = β,        (M + q D + q² K) δa - q P δb = α

for the residuals α and β. δb = (1 + q G)⁻¹ (β + q² R δa) leaves an equation for nodes alone:

    (M + q D + q² K - q³ P (1 + q G)⁻¹ R) δa = α + q P (1 + q G)⁻¹ β.

(Static condensation: J. C. Simo, T. J. R. Hughes, Computational Inelasticity, 1998, section
1.7.) A branch of a spring that relaxes within a step then adds c / (1 + q/τ) instead of c.

All tensors of a point are the internal variables of one item (``forces.memory``): branches of
a wall change its thickness together, and plastic flow carries branches along. The derivatives
of stress and rates by F and by the tensors are central differences; those are exact to about
1e-10, and Newton's method needs no better ones.
"""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from tissuec.forces.element_memory import StoredTensors
from tissuec.forces.matrices import assembled
from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:
    from scipy.sparse import coo_matrix

# Time of the derivatives of what a hidden node keeps, and of eliminating it in a solution [s].
TANGENT_SECONDS, ELIMINATION_SECONDS = 2.5e-5, 4e-7


class MemoryTangents(NamedTuple):
    """Derivatives of the rates and forces of internal variables.

    Variables have the unit of velocities, as hidden nodes keep them.

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

    def matrix(self, number: Indices, size: int) -> "coo_matrix":
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


STEP = 6e-6  # of F and of tensors, dimensionless: about the cube root of rounding errors

#: Given F and tensors T, returns P [Pa] and dT/dt [1/s].
Response = Callable[[Floats, Floats], tuple[Floats, Floats]]


def tangents_by_differences(
    stored: Sequence[StoredTensors],
    response: Response,
    deformation: Floats,
    velocity: Floats,
    nodes: Indices,
    gradients: Floats,
    weight: Floats,
) -> MemoryTangents:
    """Return the derivatives, one item for each point.

    Args:
        stored: Tensors of the elements, of one size.
        response: Given F, shape (element, point, 3, k), and all tensors in their order, shape
            (tensor, element, point, n, n), returns P and rates of the same shapes; P need not
            contain what is independent of the tensors.
        deformation: F, dimensionless, shape (element, point, 3, k).
        velocity: Of all nodes [m/s], shape (node, 3).
        nodes: Of the elements, shape (element, node).
        gradients: Of the shape functions [1/m], shape (element, point, node, k).
        weight: Volumes of the points [m³], shape (element, point).
    """
    points = deformation.shape[1]
    tensors = np.concatenate([each.tensors(velocity, points) for each in stored])
    places = np.concatenate([each.places(points) for each in stored])
    has = np.concatenate([each.slot for each in stored]) >= 0
    rate = np.where(has, np.concatenate([each.rate for each in stored]), 1.0)
    rows, columns = stored[0].at
    differences = _Differences(response, deformation, tensors, rows, columns)
    pull, giving = differences.by_tensors()
    by_strain = differences.by_strain()
    # Variables have the unit of velocities; those that do not exist take no part.
    exists, scale = (np.repeat(each.T, len(rows), axis=1)[:, None] for each in (has, rate))
    to_own, from_own = np.where(exists, scale, 0.0), np.where(exists, 1.0 / scale, 0.0)
    giving *= to_own[..., :, None] * from_own[..., None, :]
    by_position = np.einsum("epv,eqvxk,eqak->eqvax", to_own, by_strain, gradients)
    push = -np.einsum("eqv,eqvxk,eqak->eqaxv", weight[..., None] * from_own, pull, gradients)
    slots = np.moveaxis(np.where(has[..., None, None], places, -1), 0, 2)
    count = differences.size
    return MemoryTangents(
        slots=slots.reshape(-1, count),
        nodes=np.repeat(nodes, points, axis=0),
        giving=giving.reshape(-1, count, count),
        by_position=by_position.reshape(-1, *by_position.shape[2:]),
        pull=push.reshape(-1, *push.shape[2:]),
    )


class _Differences(NamedTuple):
    """Central differences of a response; attributes are as for ``tangents_by_differences``.

    Attributes:
        rows, columns: Those of the independent components of a tensor, shape (number,).
    """

    response: Response
    deformation: Floats
    tensors: Floats
    rows: Indices
    columns: Indices

    @property
    def size(self) -> int:
        """Return the number of variables of a point: the numbers of all of its tensors."""
        return len(self.rows) * len(self.tensors)

    def by_tensors(self) -> tuple[Floats, Floats]:
        """Return ∂P/∂T and -∂(dT/dt)/∂T, shape (element, point, variable, …)."""
        f, tensors, numbers = self.deformation, self.tensors, len(self.rows)
        pull = np.empty((*f.shape[:2], self.size, *f.shape[2:]))
        giving = np.empty((*f.shape[:2], self.size, self.size))
        for variable in range(self.size):
            tensor, number = divmod(variable, numbers)
            row, column = self.rows[number], self.columns[number]
            way = np.zeros((len(tensors), 1, 1, *tensors.shape[3:]))
            way[tensor, ..., row, column] = way[tensor, ..., column, row] = STEP
            above, below = self.response(f, tensors + way), self.response(f, tensors - way)
            pull[:, :, variable] = (above[0] - below[0]) / (2.0 * STEP)
            giving[..., variable] = self._told(below[1] - above[1]) / (2.0 * STEP)
        return pull, giving

    def by_strain(self) -> Floats:
        """Return ∂(dT/dt)/∂F [1/s], shape (element, point, variable, 3, k)."""
        f, shape = self.deformation, self.deformation.shape
        found = np.empty((*shape[:2], self.size, *shape[2:]))
        for x, k in np.ndindex(*shape[2:]):
            way = np.zeros(shape[2:])
            way[x, k] = STEP
            above, below = (self.response(f + by, self.tensors)[1] for by in (way, -way))
            found[..., x, k] = self._told(above - below) / (2.0 * STEP)
        return found

    def _told(self, of: Floats) -> Floats:
        """Return the numbers of all tensors, shape (element, point, variable)."""
        found = np.moveaxis(of[..., self.rows, self.columns], 0, 2)
        return found.reshape(*found.shape[:2], self.size)
