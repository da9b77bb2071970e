"""An order of nodes in which a stiffness matrix has few entries when it is factorised.

Nested dissection by places: the net is halved across its longest side, and the nodes of one
half that springs join to the other come last; both halves likewise. For meshes of the plane the
factor has O(n log n) entries, and for solids O(n^(4/3)).
(A. George, SIAM J. Numer. Anal. 10:345, 1973; G. L. Miller et al., J. ACM 44:1, 1997.)
"""

import numpy as np
from scipy.sparse import csr_matrix

from tissuec.model.network import Floats, Indices

LEAF = 32  # nodes that are not halved any more


def dissected(position: Floats, joined: csr_matrix) -> Indices:
    """Return the numbers of nodes in the order of elimination, shape (node,).

    Args:
        position: Of the nodes [m], shape (node, 3).
        joined: Which nodes act on one another, symmetric, shape (node, node).
    """
    order = np.empty(len(position), dtype=np.int64)
    is_there = np.zeros(len(position), dtype=bool)
    waiting = [(0, np.arange(len(position)))]
    while waiting:
        first, nodes = waiting.pop()
        if len(nodes) <= LEAF:
            order[first : first + len(nodes)] = nodes
            continue
        low, high = _halves(position, nodes)
        is_there[high] = True
        rows = joined[low]
        touches = np.bincount(
            np.repeat(np.arange(len(low)), np.diff(rows.indptr)),
            is_there[rows.indices], len(low),
        ) > 0.0  # fmt: skip
        is_there[high] = False
        last = first + len(nodes) - np.count_nonzero(touches)
        order[last : first + len(nodes)] = low[touches]
        inner = low[~touches]
        waiting += [(first, inner), (first + len(inner), high)]
    return order


def _halves(position: Floats, nodes: Indices) -> tuple[Indices, Indices]:
    """Return the nodes on either side of the middle of the longest side."""
    places = position[nodes]
    along = places[:, np.argmax(np.ptp(places, axis=0))]
    ranked = nodes[np.argsort(along, kind="stable")]
    return ranked[: len(ranked) // 2], ranked[len(ranked) // 2 :]
