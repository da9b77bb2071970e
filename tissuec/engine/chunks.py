"""Chunks of nodes whose springs a thread processes together, in any net.

A spring belongs to the chunk of its lower node. What it does to an upper node of another chunk
is summed in a slot that its chunk has for that node; afterwards, each node adds up its slots in
the order of the chunks. So sums depend neither on the number of threads nor on their pace.
"""

import numpy as np

from tissuec.compiled.record_tables import aligned_zeros
from tissuec.engine.blocks import Places
from tissuec.kernels.records import Chunks
from tissuec.kernels.thread_loops import PIECE

NODES = 4096  # of a chunk, at least
MOST = 64  # chunks
LEAST = 4  # chunks that are worth being shared by threads


def are_chunks(nodes: int) -> bool:
    """Return whether a net has several chunks, so that threads can share them."""
    return nodes >= LEAST * NODES


def chunks_of(low: Places, high: Places, nodes: int, whole: int | None = None) -> Chunks:
    """Return chunks of a net.

    Args:
        low, high: Ends of springs as places of nodes, by ascending lower ones, shape (spring,).
        nodes: How many there are.
        whole: How many there are with hidden nodes that are left out for a time, on which the
            chunks of all others must not depend; by default none are.
    """
    lower, upper = (4 * low).astype(np.uint32), (4 * high).astype(np.uint32)
    whole = nodes if whole is None else whole
    size = max(whole, 1)
    if are_chunks(whole):
        size = -(-max(NODES, -(-whole // MOST)) // PIECE) * PIECE
    begins = np.append(np.arange(0, nodes, size), nodes)
    chunk = low // size
    away = np.flatnonzero(high // size != chunk)
    keys, inverse = np.unique(
        chunk[away].astype(np.int64) * nodes + high[away], return_inverse=True
    )
    to = upper.copy() if len(away) else upper
    to[away] = 4 * (nodes + inverse)
    node = keys % nodes
    of = np.argsort(node, kind="stable")
    return Chunks(
        node=begins,
        low=lower,
        high=upper,
        to=to,
        states=aligned_zeros(8 * nodes),
        sums=aligned_zeros(4 * (nodes + len(keys))),
        slot=np.searchsorted(keys, np.arange(len(begins)) * nodes),
        first=np.searchsorted(node[of], np.arange(nodes + 1)).astype(np.uint32),
        of=(4 * of).astype(np.uint32),
    )
