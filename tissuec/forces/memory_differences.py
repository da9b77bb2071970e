"""Derivatives of tensors that elements remember, by differences, for implicit steps.

All tensors of a point are the internal variables of one item (``forces.memory``): branches of
a wall change its thickness together, and plastic flow carries branches along. The derivatives
of stress and rates by F and by the tensors are central differences; those are exact to about
1e-10, and Newton's method needs no better ones.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from tissuec.forces.memory import MemoryTangents
from tissuec.forces.stored_tensors import StoredTensors
from tissuec.model.network import Floats, Indices

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
