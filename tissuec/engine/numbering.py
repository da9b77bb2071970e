"""The order in which the engine keeps nodes: neighbours in space are neighbours in memory."""

import numpy as np

from tissuec.network import Floats, Indices

SMALL = 2000  # nodes; below, everything stays in the cache in any order
BITS = 21


def node_order(position: Floats) -> Indices:
    """Return the node to put at each place, shape (node,): Morton order if there are many.

    The bits of the coordinates are interleaved (Morton 1966); equal keys keep their order.
    """
    if len(position) <= SMALL:
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
