"""The order of nodes in the engine: neighbours in space are neighbours in memory."""

import numpy as np
from numpy.typing import NDArray

from tissuec.engine.spring_runs import places_of
from tissuec.model.network import Floats, Indices

SMALL = 2000  # nodes; below, everything stays in the cache in any order
BITS = 21


def node_order(position: Floats, ends: NDArray[np.int32]) -> Indices:
    """Return the node to put at each place, shape (node,).

    They keep their places if they are few, or if their springs lie in runs; otherwise they are
    put in Morton order. The bits of the coordinates are interleaved (Morton 1966); equal keys
    keep their order.

    Args:
        position: Shape (node, 3) [m].
        ends: Nodes of springs, also of such that are not among these, shape (spring, 2).
    """
    if len(position) <= SMALL or places_of(*np.sort(ends, axis=1).T).is_worthwhile:
        return np.arange(len(position))
    low = position.min(axis=0)
    extent = float(np.max(position.max(axis=0) - low))
    if extent == 0.0:
        return np.arange(len(position))
    cell = ((position - low) / extent * (2**BITS - 1)).astype(np.uint64)
    key = sum(_spread(cell[:, axis]) << np.uint64(axis) for axis in range(3))
    return np.argsort(key, kind="stable")


def _spread(value: np.ndarray) -> np.ndarray:
    """Return values of 21 bits with two zeros put between any two bits."""
    for shift, mask in (
        (32, 0x1F00000000FFFF),
        (16, 0x1F0000FF0000FF),
        (8, 0x100F00F00F00F00F),
        (4, 0x10C30C30C30C30C3),
        (2, 0x1249249249249249),
    ):
        value = (value | (value << np.uint64(shift))) & np.uint64(mask)
    return value
