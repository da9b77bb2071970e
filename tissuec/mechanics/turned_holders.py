"""Where nodes come to when what holds a net has turned.

Large turns are not foretold by a tangent. Between holders, rotations change evenly (their
vectors are harmonic on the edges of the net), and each edge turns as its ends do, as far as all
edges together let it: the positions minimise Σ w |x_i - x_j - R_ij (X_i - X_j)|² (O. Sorkine,
M. Alexa, As-rigid-as-possible surface modeling, SGP 2007, with given rotations).
"""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix, diags_array
from scipy.sparse.linalg import cg

from tissuec.core.arrays import dot, largest_side, norm
from tissuec.mechanics.balance import Balance
from tissuec.model.network import Floats
from tissuec.model.topology import pieces

LEAST = 0.2  # turn of a holder from which this is better than a tangent [rad]
RIGID = 1e-3  # of its size: what a holder may be deformed by
PRECISE = 1e-4  # of a start: the search for the equilibrium follows


def after_turns(balance: Balance, before: Floats, now: Floats) -> Floats | None:
    """Return where the free nodes come to.

    Args:
        balance: The free nodes, and the edges that end at them.
        before: Positions before holders moved [m], shape (node, 3).
        now: The same after it, where those of free nodes do not matter [m], shape (node, 3).

    Returns:
        Positions of the free nodes [m], shape (free, 3); None if holders turn little, or
        deform, or if guides hold nodes, too.
    """
    if balance.is_guided:
        return None
    ends, free = balance.links, balance.free
    is_free = np.zeros(len(before), dtype=bool)
    is_free[free] = True
    turns = _turns(ends, balance.every_link, is_free, before, now)
    if turns is None:
        return None
    from scipy.spatial.transform import Rotation  # it takes a while to import

    count = len(ends)
    signs, begin = np.tile((-1.0, 1.0), count), 2 * np.arange(count + 1)
    apart = csr_matrix((signs, ends.ravel(), begin), shape=(count, len(before)))
    edge = apart @ before
    weight = 1.0 / np.maximum(dot(edge, edge), 1e-300)
    outer = csr_matrix(apart.T @ diags_array(weight) @ apart)[free]
    inner = csr_matrix(outer[:, free])
    scaling = diags_array(1.0 / np.maximum(inner.diagonal(), 1e-300))

    def between(values: Floats, right: Floats) -> Floats:
        """Return the values at free nodes, from those of holders and a right-hand side."""
        rest = right - outer @ np.where(is_free[:, None], 0.0, values)
        found = np.empty_like(rest)
        for k in range(3):
            found[:, k] = cg(inner, rest[:, k], values[free, k], rtol=PRECISE, M=scaling)[0]
        return found

    turns[free] = between(turns, np.zeros((len(free), 3)))
    turned = Rotation.from_rotvec(turns[ends].mean(axis=1)).apply(edge)
    pull = apart.T @ (weight[:, None] * turned)
    return between(np.where(is_free[:, None], before, now), pull[free])


def _turns(
    ends: NDArray[np.integer],
    every: NDArray[np.integer],
    is_free: NDArray[np.bool_],
    before: Floats,
    now: Floats,
) -> Floats | None:
    """Return the rotation vectors of holders, 0 at free nodes, shape (node, 3).

    A holder consists of held nodes that edges join.

    Args:
        ends: Of edges at free nodes, shape (edge, 2).
        every: Of all edges, shape (edge, 2).
    """
    across = ends[is_free[ends[:, 0]] != is_free[ends[:, 1]]]
    label = pieces(len(before), every[~is_free[every].any(axis=1)])
    held = np.unique(across[~is_free[across]])
    turns, most = np.zeros_like(before), 0.0
    for one in np.unique(label[held]):
        nodes = held[label[held] == one]
        drawn, moved = (x[nodes] - x[nodes].mean(axis=0) for x in (before, now))
        size = largest_side(drawn)
        if norm(moved - drawn).max() <= RIGID * size:
            continue  # it is where it was, or only shifted
        if np.linalg.matrix_rank(drawn, 1e-6 * size) < 2:
            continue  # a point or a line does not say how it turns
        from scipy.spatial.transform import Rotation

        turn, _ = Rotation.align_vectors(moved, drawn)
        left = norm(turn.apply(drawn) - moved).max()
        if left > RIGID * size:
            return None
        turns[nodes] = turn.as_rotvec()
        most = max(most, turn.magnitude())
    return turns if most > LEAST else None
