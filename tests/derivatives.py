"""Forces of fields, and forces from energies by differences."""

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def forces(
    field: Any, position: Floats, velocity: Floats | None = None, time: float = 0.0
) -> Floats:
    """Return the forces of a field on all nodes [N], shape (…, node, 3).

    Args:
        field: Such as contact.
        position: Of all nodes [m], shape (…, node, 3).
        velocity: Of all nodes [m/s]; at rest by default.
        time: [s].
    """
    total = np.zeros_like(position)
    still = np.zeros_like(position) if velocity is None else velocity
    field.add_forces(time, position, still, total)
    return total


def stiffness(field: Any, position: Floats, column: int, step: float) -> Floats:
    """Return a column of the stiffness matrix by differences of forces [N/m], (3 node,).

    Args:
        field: Such as contact.
        position: Of all nodes [m], shape (node, 3).
        column: Number of the coordinate.
        step: [m].
    """
    way = np.zeros(position.size)
    way[column] = step
    way = way.reshape(position.shape)
    ahead, behind = (forces(field, position + each).ravel() for each in (way, -way))
    return (behind - ahead) / (2.0 * step)


def slopes(
    energy: Callable[[Floats], object], position: Floats, nodes: Iterable[int], step: float
) -> Floats:
    """Return minus the central differences of an energy by places of nodes [N], (chosen, 3).

    Args:
        energy: Of the places of all nodes [J].
        position: Of all nodes [m], shape (node, 3).
        nodes: The chosen ones.
        step: Of each coordinate [m].
    """
    found = []
    for node in nodes:
        for axis in range(3):
            way = np.zeros_like(position)
            way[node, axis] = step
            ahead, behind = (float(energy(position + each)) for each in (way, -way))
            found.append((behind - ahead) / (2.0 * step))
    return np.array(found).reshape(-1, 3)
