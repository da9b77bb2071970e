"""Topology of a net: pieces, springs between nodes, and floppy modes.

A floppy mode is a motion, other than a rigid one, that no spring resists to first order. With
unit directions u and tensions T = c(L - L0), the stiffness of a spring is

    c uuᵀ + max(T, 0)/L (I - uuᵀ),

and the floppy modes are the null space of their sum. Compression only weakens a net, and is
left out, so that the sum is positive semidefinite and its null space says what is not held.
"""

from typing import NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.arrays import counted_up, rigid_motions

LARGEST_CHECK = 1200
"""Unknowns up to which floppy modes are counted: a dense eigenvalue problem below a second."""

SAME_DIRECTION = 1e-5
"""Angle [rad] below which springs count as parallel and a piece as flat or straight."""


class Extents(NamedTuple):
    """Lowest and highest coordinates [m], each of shape (3,)."""

    low: NDArray[np.float64]
    high: NDArray[np.float64]

    @property
    def diagonal(self) -> float:
        """Return the diagonal of the box around the net [m]."""
        return float(np.linalg.norm(self.high - self.low))


class FloppyModes(Struct, frozen=True):
    """Number of independent motions of the free nodes that no spring resists.

    A piece, here, is a set of free nodes joined by springs, with the held nodes next to it.

    Attributes:
        count: Floppy modes within the space, plane or line that each piece lies in.
        across: Floppy modes at right angles to the plane or line of flat and straight pieces,
            which every net drawn flat or straight has unless it is prestressed.
        rigid: Rigid motions of the pieces that the held nodes leave free.
        checked: False where the net was too large to count; all counts are 0 then.
    """

    count: int
    across: int
    rigid: int
    checked: bool


def extents(position: NDArray[np.float64]) -> Extents:
    """Return the box around at least one node.

    Args:
        position: Node positions [m], shape (node, 3).
    """
    return Extents(position.min(axis=0), position.max(axis=0))


def pieces(
    node_count: int, ends: NDArray[np.integer], alive: NDArray[np.bool_] | None = None
) -> NDArray[np.int32]:
    """Return which connected piece each node belongs to.

    Each round joins every piece that touches one with a lower label to the lowest of them. A
    piece that has only higher neighbours gains one of them, or meets that neighbour's new and
    lower label in the next round, so two rounds at least halve the number of open pieces.

    Args:
        node_count: Number of nodes.
        ends: Node pair of each spring, shape (spring, 2).
        alive: Springs that count, shape (spring,); all by default.

    Returns:
        Labels from 0, numbered by the lowest node of each piece, shape (node,).
    """
    label = np.arange(node_count)
    one, other = (ends if alive is None else ends[alive]).astype(np.int64).T
    while len(one):
        one, other = label[one], label[other]
        open_ = one != other
        one, other = one[open_], other[open_]
        np.minimum.at(label, np.maximum(one, other), np.minimum(one, other))
        while not np.array_equal(jumped := label[label], label):
            label = jumped
    is_lowest = label == np.arange(node_count)
    return (np.cumsum(is_lowest, dtype=np.int32) - 1)[label].astype(np.int32)


def floppy_modes(
    position: NDArray[np.float64],
    ends: NDArray[np.int32],
    stiffness: NDArray[np.float64],
    rest: NDArray[np.float64],
    fixed_mask: NDArray[np.bool_],
) -> FloppyModes:
    """Count the motions that nothing resists; springs of zero length are passed over.

    A null space depends on which terms there are and not on their sizes, so all weights are
    set to 1: stiffness ratios of any size then leave the eigenvalues well apart from rounding.

    Args:
        position: Node positions [m], shape (node, 3).
        ends: Node pair of each spring, shape (spring, 2).
        stiffness: Spring constants [N/m], shape (spring,); a spring with 0 resists nothing.
        rest: Rest lengths [m], shape (spring,).
        fixed_mask: True for nodes that cannot move, shape (node,).
    """
    unknowns = 3 * int(np.count_nonzero(~fixed_mask))
    if unknowns > LARGEST_CHECK:
        return FloppyModes(0, 0, 0, checked=False)
    reach = position[ends[:, 1]] - position[ends[:, 0]]
    length = np.linalg.norm(reach, axis=1)
    works = (stiffness > 0.0) & (length > 0.0) & ~fixed_mask[ends].all(axis=1)
    ends, reach, length, rest = ends[works], reach[works], length[works], rest[works]
    # A billionth is above the rounding of lengths and below any prestress that is meant.
    is_taut = length - rest > 1e-9 * length
    number = np.where(fixed_mask, -1, np.cumsum(~fixed_mask) - 1)
    frame, within, motions = _pieces_apart(position, ends, number)
    direction = np.einsum(
        "si,sij->sj", reach / length[:, None], frame[number[ends].max(axis=1)]
    )
    matrix = _unit_stiffness(number[ends], direction, is_taut, unknowns // 3)
    # A rigid motion of a prestressed net may cost energy to second order, where the drawn shape
    # is not its equilibrium; it is no deformation all the same. Raised by the largest entry,
    # rigid motions are out of the null space whether they were in it or not.
    top = max(float(np.abs(matrix).max(initial=0.0)), 1.0)
    matrix += top * (motions @ motions.T)
    count, across = (_null(matrix[np.ix_(part, part)], top) for part in (within, ~within))
    return FloppyModes(count, across, motions.shape[1], checked=True)


def _null(matrix: NDArray[np.float64], top: float) -> int:
    """Return how many eigenvalues are zero beside ``top``.

    Two springs an angle a apart leave an eigenvalue near a², hence the square. Rounding leaves
    1e-15 and coordinates kept in single precision up to 1e-11; the softest bending of a truss a
    thousand times as long as wide is near 1e-9.
    """
    limit = SAME_DIRECTION**2 * top
    try:
        # Most nets have none: all eigenvalues are above the limit where this factor exists,
        # which is found out many times faster than the eigenvalues.
        np.linalg.cholesky(matrix - limit * np.eye(len(matrix)))
    except np.linalg.LinAlgError:
        return int(np.count_nonzero(np.linalg.eigvalsh(matrix) < limit))
    return 0


def _unit_stiffness(
    ends: NDArray[np.int64],
    direction: NDArray[np.float64],
    is_taut: NDArray[np.bool_],
    count: int,
) -> NDArray[np.float64]:
    """Return the stiffness matrix of the free nodes with unit weights, shape (3n, 3n).

    Args:
        ends: Free node at either end of each spring, -1 for a held one, shape (spring, 2).
        direction: Unit direction of each spring, shape (spring, 3).
        is_taut: Springs whose tension resists turning, shape (spring,).
        count: Number of free nodes.
    """
    block = direction[:, :, None] * direction[:, None, :]
    block[is_taut] = np.eye(3)  # uuᵀ + (I - uuᵀ)
    matrix = np.zeros((count, count, 3, 3))
    for row, column, sign in ((0, 0, 1), (1, 1, 1), (0, 1, -1), (1, 0, -1)):
        is_free = (ends[:, row] >= 0) & (ends[:, column] >= 0)
        index = (ends[is_free, row], ends[is_free, column])
        np.add.at(matrix, index, sign * block[is_free])
    return matrix.transpose(0, 2, 1, 3).reshape(3 * count, 3 * count)


def _pieces_apart(
    position: NDArray[np.float64], ends: NDArray[np.int32], number: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.bool_], NDArray[np.float64]]:
    """Return each piece's own axes, which unknowns lie within it, and its rigid motions.

    Args:
        position: Node positions [m], shape (node, 3).
        ends: Node pair of each spring with a free end, shape (spring, 2).
        number: Number of each node among the n free ones, -1 for held nodes, shape (node,).

    Returns:
        Axes of each free node's piece as columns, shape (n, 3, 3); whether an unknown is along
        the space, plane or line of its piece, shape (3n,); orthonormal rigid motions of the
        free nodes in those axes, shape (3n, motion).
    """
    numbered = number[ends]
    to_held = (numbered < 0).any(axis=1)
    free, held_side = np.flatnonzero(number >= 0), ends[to_held][numbered[to_held] < 0]
    count = len(free)
    labels = pieces(count, numbered[~to_held])
    labels_beside = labels[numbered[to_held].max(axis=1)]
    frame = np.zeros((count, 3, 3))
    within = np.zeros((count, 3), dtype=bool)
    found = [np.zeros((3 * count, 0))]
    for label in range(int(labels.max(initial=-1)) + 1):
        members = np.flatnonzero(labels == label)
        beside = np.unique(held_side[labels_beside == label])
        axes, rank, motions = _rigid_motions(position[free[members]], position[beside])
        frame[members] = axes
        within[members, :rank] = True
        spread_out = np.zeros((count, 3, motions.shape[1]))
        spread_out[members] = motions.reshape(len(members), 3, -1)
        found.append(spread_out.reshape(3 * count, -1))
    return frame, within.ravel(), np.concatenate(found, axis=1)


def _rigid_motions(
    free: NDArray[np.float64], held: NDArray[np.float64]
) -> tuple[NDArray[np.float64], int, NDArray[np.float64]]:
    """Return a piece's axes, its dimension, and its rigid motions that leave ``held`` in place.

    Args:
        free: Positions of the free nodes [m], shape (free, 3).
        held: Positions of the held nodes that they are joined to [m], shape (held, 3).

    Returns:
        Principal axes as columns, shape (3, 3); 0 to 3; orthonormal motions of the free nodes
        along those axes, shape (3 * free, motion).
    """
    every = np.concatenate((free, held))
    every = every - every.mean(axis=0)
    _, spread, axes = np.linalg.svd(np.vstack((every, np.zeros((3, 3)))), full_matrices=False)
    rank = int(np.count_nonzero(spread > SAME_DIRECTION * spread[0]))
    # In units of the piece's own size, so that turns and shifts weigh alike.
    local = every @ axes.T / max(spread[0] / np.sqrt(len(every)), np.finfo(float).tiny)
    motions = rigid_motions(local)
    at_held = np.vstack((motions[len(free) :].reshape(-1, 6), np.zeros((6, 6))))
    _, sizes, modes = np.linalg.svd(at_held, full_matrices=False)
    stays = sizes <= SAME_DIRECTION * sizes[0]
    moving = motions[: len(free)].reshape(-1, 6) @ modes[stays].T
    basis, sizes, _ = np.linalg.svd(moving, full_matrices=False)
    return axes.T, rank, basis[:, sizes > SAME_DIRECTION * np.sqrt(len(free))]


def lower_and_upper(
    pairs: NDArray[np.integer],
) -> tuple[NDArray[np.integer], NDArray[np.integer]]:
    """Return the lower and the upper node of each pair, shape (pair,).

    Args:
        pairs: Of nodes, shape (pair, 2).
    """
    one, other = pairs.T
    return np.minimum(one, other), np.maximum(one, other)


def join_nodes_of(ends: NDArray[np.int32], chosen: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which springs have both ends among some nodes, shape (spring,).

    Args:
        ends: Node pair of each spring, shape (spring, 2).
        chosen: Which nodes, shape (node,).
    """
    one, other = chosen[ends.T]
    return np.asarray(one & other)


def _keys(pairs: NDArray[np.integer], size: int) -> NDArray[np.int64]:
    """Return one number for each pair, whichever of its nodes is named first."""
    low, high = lower_and_upper(pairs)
    return low.astype(np.int64) * size + high


class PairIndex:
    """Finds springs, or others, by the pairs of nodes that they join.

    Args:
        ends: Their node pairs, shape (spring, 2).
    """

    def __init__(self, ends: NDArray[np.integer]):
        self._size = 1 + int(ends.max(initial=0))
        keys = _keys(ends, self._size)
        self._order = np.argsort(keys, kind="stable")
        self._keys = keys[self._order]

    def between(
        self, pairs: NDArray[np.integer]
    ) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return the springs that join pairs of nodes, and the number of the pair of each.

        Args:
            pairs: Of nodes, shape (pair, 2).
        """
        # No spring ends at a larger number, and the key of such a pair may be that of another.
        wanted = np.where((pairs < self._size).all(axis=1), _keys(pairs, self._size), -1)
        low = np.searchsorted(self._keys, wanted, side="left")
        high = np.searchsorted(self._keys, wanted, side="right")
        count = high - low  # more than one where springs are parallel
        which = np.repeat(np.arange(len(pairs)), count)
        return self._order[low[which] + counted_up(count)], which
