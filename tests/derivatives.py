"""Forces from energies, by differences."""

from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


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
