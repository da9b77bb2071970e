"""Sums of spring forces in chunks of nodes, as scalar loops; see ``engine.threads``."""

import numpy as np

from tissuec.kernels.records import Chunks, Floats
from tissuec.kernels.thread_loops import part_of

# Unsigned, so that no index has to be tested for being negative.
ONE, TWO, THREE, FOUR = np.uint64(1), np.uint64(2), np.uint64(3), np.uint64(4)


def clear_sums(chunk: int, chunks: Chunks) -> None:
    """Set the sums of a chunk to zero: of its nodes, and in its slots."""
    nodes = chunks.node[chunks.node.size - 1]
    own = chunks.sums[4 * chunks.node[chunk] : 4 * chunks.node[chunk + 1]]
    for i in range(own.size):
        own[i] = 0.0
    first, last = nodes + chunks.slot[chunk], nodes + chunks.slot[chunk + 1]
    others = chunks.sums[4 * first : 4 * last]
    for i in range(others.size):
        others[i] = 0.0


def total_sums(part: int, parts: int, out: Floats, chunks: Chunks) -> None:
    """Set a part of a vector of all nodes to the sums of all chunks.

    Args:
        out: Vector of all nodes in the unit of the sums, shape (3 node,).
        chunks: The chunks with their sums.
    """
    nodes = chunks.node[chunks.node.size - 1]
    first, last = part_of(part, parts, nodes)
    sums, others, of = chunks.sums[4 * first : 4 * last], chunks.sums[4 * nodes :], chunks.of
    begin, own = chunks.first[first : last + 1], out[3 * first : 3 * last]
    for node in range(last - first):
        i, k = THREE * np.uint64(node), FOUR * np.uint64(node)
        s0, s1, s2 = sums[k], sums[k + ONE], sums[k + TWO]
        for entry in range(begin[node], begin[node + 1]):
            k = np.uint64(of[entry])
            s0 += others[k]
            s1 += others[k + ONE]
            s2 += others[k + TWO]
        own[i], own[i + ONE], own[i + TWO] = s0, s1, s2
