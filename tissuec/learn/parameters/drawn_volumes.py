"""Volumes that are preserved, as they follow from start positions.

A cell keeps the volume V0 = V(x) that it has as drawn, so V0 changes by ∂V/∂x δx when start
positions change by δx.
"""

from collections.abc import Iterator

import numpy as np
from scipy import sparse

from tissuec.forces.volume import Enclosure
from tissuec.learn.parameters.fields import numbered
from tissuec.learn.parameters.numbers import NumberOrder
from tissuec.model.network import Floats


def put_volumes(order: NumberOrder, vector: Floats) -> Floats:
    """Return the numbers with volumes as they are at start positions, changed in place.

    Args:
        order: Order of the numbers.
        vector: In SI units, shape (number,).
    """
    position = order.array(vector, "position").reshape(-1, 3)
    for part, enclosure in _drawn(order):
        vector[part] = enclosure.volumes(position)
    return vector


def change_of_volumes(
    order: NumberOrder, vector: Floats, change: sparse.csr_matrix
) -> sparse.csr_matrix:
    """Return the derivative of these volumes, in the rows of all numbers.

    Args:
        order: Order of the numbers.
        vector: In SI units, shape (number,).
        change: Of all numbers by each parameter, shape (number, parameter).

    Returns:
        Shape (number, parameter).
    """
    position = order.array(vector, "position").reshape(-1, 3)
    first, size = order.places["position"].start, order.size
    total = sparse.csr_matrix(change.shape)
    for part, enclosure in _drawn(order):
        columns = first + 3 * enclosure.corners[..., None] + np.arange(3)
        rows = np.broadcast_to(part.start + enclosure.owner[:, None, None], columns.shape)
        entries = enclosure.gradient(position).ravel(), (rows.ravel(), columns.ravel())
        ways = sparse.csr_matrix(sparse.coo_matrix(entries, shape=(size, size)))
        total = total + ways @ change
    return sparse.csr_matrix(total)


def _drawn(order: NumberOrder) -> Iterator[tuple[slice, Enclosure]]:
    """Yield the places of the drawn volumes of each enclosure, which follow its modulus."""
    first = order.places["fields"].start
    for _, field, part in numbered(order.fields):
        if isinstance(field, Enclosure):
            yield slice(first + part.start + 1, first + part.stop), field
