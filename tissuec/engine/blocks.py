"""Blocks of nodes, so that threads can compute springs or items of fields at a time.

Sums depend neither on the number of threads nor on their pace: what is computed at a time has
no node in common, and the order of what is computed in succession is fixed.
"""

import numpy as np
from numpy.typing import NDArray

from tissuec.forces import Field
from tissuec.kernels.thread_loops import PIECE
from tissuec.model.network import Indices

Places = NDArray[np.integer]
BLOCK_NODES = 1024  # of a block, at least; what belongs to its springs fits into a cache
LEAST_BLOCKS = 4  # that are worth being shared by threads
BITS = 64  # blocks that a number can name


def block_size(low: Places, high: Places) -> int:
    """Return the number of nodes of a block such that no spring is longer than a block.

    Then every other block, with all springs that begin in it, has no node in common with the
    next one.

    Args:
        low, high: Lower and upper nodes of springs, shape (spring,).
    """
    return _rounded(int((high - low).max(initial=0)))


def are_several(high: Places, size: int) -> bool:
    """Return whether there are enough blocks for threads to share.

    Args:
        high: Upper nodes of springs, shape (spring,).
        size: Number of nodes of a block.
    """
    return int(high.max(initial=0)) + 1 >= LEAST_BLOCKS * size


def parts_of(field: Field, place: Indices) -> list[list[Field]]:
    """Return the parts of a field, in groups whose members have no node in common.

    Items are in one part if their nodes are in the same blocks. Greedily, each part joins the
    first group whose parts have nodes in other blocks only.

    Args:
        place: Index of each node in the arrays of the kernel, shape (node,).
    """
    count = len(place) - len(field.hidden)  # none of which has two items
    is_small = count < LEAST_BLOCKS * BLOCK_NODES
    items = None if is_small else field.items(place)
    if items is None or len(items.first) < 2:
        return [[field]]
    low, high = (
        extreme.reduceat(items.places, items.first[:-1]) for extreme in (np.minimum, np.maximum)
    )
    size = _rounded(max(-(-count // BITS), int(np.median(high - low))))
    blocks = np.left_shift(np.uint64(1), (items.places // size).astype(np.uint64))
    touched = np.bitwise_or.reduceat(blocks, items.first[:-1])
    order = np.argsort(touched, kind="stable")
    found, begins = np.unique(touched[order], return_index=True)
    groups: list[list[Field]] = []
    taken: list[int] = []
    for part, which in zip(found.tolist(), np.split(order, begins[1:]), strict=True):
        group = next((k for k, other in enumerate(taken) if not other & part), len(groups))
        if group == len(groups):
            groups.append([])
            taken.append(0)
        groups[group].append(field.only(which))
        taken[group] |= part
    return groups


def _rounded(nodes: int) -> int:
    """Return the number of nodes of a block that has at least some."""
    return -(-max(nodes, BLOCK_NODES) // PIECE) * PIECE
