"""Matrices of implicit steps: derivatives of accelerations by positions and velocities."""

import numpy as np
from scipy import sparse

from tissuec.kernels.sensitivity import Forces, Links, NodeState
from tissuec.learn.derivatives.kernels import blocks
from tissuec.model.network import Floats, Indices


def solver(forces: Forces, at: NodeState, own: float) -> sparse.csc_matrix:
    """Return 1 - own² ∂a/∂x - own ∂a/∂v, shape (3 node, 3 node).

    Args:
        own: Step size times the diagonal coefficient of the method [s].
    """
    by_x, by_v = derivatives(forces, at)
    one = sparse.identity(len(at.x), format="csc")
    return sparse.csc_matrix(one - own * own * by_x - own * by_v)


def derivatives(forces: Forces, at: NodeState) -> tuple[sparse.csr_matrix, sparse.csr_matrix]:
    """Return ∂a/∂x [1/s²] and ∂a/∂v [1/s], shape (3 node, 3 node)."""
    links = forces.links
    of_x, of_v = np.empty((2, len(links.low), 3, 3))
    blocks(forces, at, of_x, of_v)
    drag = sparse.diags(np.repeat(links.drag * links.inverse, 3))
    return _between(links, of_x), _between(links, of_v) - drag


def _between(links: Links, blocks: Floats) -> sparse.csr_matrix:
    """Return the matrix of what blocks between two nodes do to accelerations."""
    low, high, inverse = links.low, links.high, links.inverse
    axes = np.arange(3)
    rows: list[Indices] = []
    columns: list[Indices] = []
    entries: list[Floats] = []
    for at, by, sign in (
        (low, low, -1.0),
        (low, high, 1.0),
        (high, low, 1.0),
        (high, high, -1.0),
    ):
        shape = blocks.shape
        rows.append(np.broadcast_to(3 * at[:, None, None] + axes[:, None], shape).ravel())
        columns.append(np.broadcast_to(3 * by[:, None, None] + axes, shape).ravel())
        entries.append((sign * inverse[at][:, None, None] * blocks).ravel())
    size = 3 * len(inverse)
    parts = np.concatenate(entries), (np.concatenate(rows), np.concatenate(columns))
    return sparse.csr_matrix(sparse.coo_matrix(parts, shape=(size, size)))
