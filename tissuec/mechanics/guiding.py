"""Holds of nodes in some directions, which leave them free in others.

A node that planes of symmetry and holds keep in the directions n1, n2, … moves at right angles
to all of them. What a motion prescribes is N x, with its own directions as rows of N. With Q,
an orthonormal basis of the directions that the others leave, positions change by A N times what
is missing, A = Q (N Q)⁺: this sets N x, and changes nothing in the directions of the others.
"""

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from msgspec import Struct

from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.model.guides import Floats, Guides, Indices, free_directions

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

PARALLEL = 1e-9  # sine of the angle between directions that are one


class DirectedHold(Struct, frozen=True, eq=False):
    """Nodes that are held in some directions.

    Attributes:
        holder: Who holds them: "fix", or the name of a set.
        nodes: Ascending, shape (n,).
        directions: Orthonormal, shape (direction, 3).
        span: The sentence.
    """

    holder: str
    nodes: Indices
    directions: Floats
    span: Span

    def joined(self, other: "DirectedHold | None") -> "DirectedHold":
        """Return the hold with the nodes of another one of the same key."""
        if other is None:
            return self
        return replace(self, nodes=np.union1d(self.nodes, other.nodes))

    @property
    def key(self) -> str:
        """Return the name under which a state keeps it, and its motion."""
        rows = (", ".join(f"{x:.12g}" for x in row + 0.0) for row in self.directions)
        return f"{self.holder} along {' and '.join(f'({row})' for row in rows)}"


def overlap(one: Floats | None, other: Floats | None) -> bool:
    """Return whether two holds have a direction in common.

    Args:
        one, other: Orthonormal, dimensionless, shape (direction, 3); None for all directions.
    """
    if one is None or other is None:
        return True
    both = np.concatenate([one, other])
    return int(np.linalg.matrix_rank(both, tol=PARALLEL)) < len(both)


def without(directions: Floats, others: Floats) -> Floats:
    """Return the directions of a hold at right angles to those of others.

    Args:
        directions, others: Orthonormal each, dimensionless, shape (direction, 3).

    Returns:
        Orthonormal, shape (m, 3); there may be none.
    """
    _, sizes, ways = np.linalg.svd(others @ directions.T)
    return np.asarray(ways[int((sizes > PARALLEL).sum()) :] @ directions)


def across(direction: Floats) -> Floats:
    """Return two orthonormal directions at right angles to a unit vector, shape (2, 3)."""
    return np.asarray(np.linalg.svd(direction[None]).Vh[1:])


def guides_of(drawn: Guides | None, holds: Iterable[DirectedHold], count: int) -> Guides | None:
    """Return the nodes that planes of symmetry and holds guide; None without any.

    Args:
        drawn: Those on planes.
        holds: In any order.
        count: Of all nodes.
    """
    holds = tuple(holds)
    if not holds:
        return drawn
    is_member = np.zeros((count, len(holds)), dtype=bool)
    for number, one in enumerate(holds):
        is_member[one.nodes, number] = True
    off, share = np.zeros((count, 9)), np.ones(count)
    if drawn is not None:
        off[drawn.nodes] = (np.eye(3) - drawn.projections).reshape(-1, 9)
        share[drawn.nodes] = drawn.share
    nodes = np.flatnonzero(is_member.any(axis=1) | off.any(axis=1))
    kinds, kind = np.unique(
        np.hstack([is_member[nodes], off[nodes]]), axis=0, return_inverse=True
    )
    within = np.empty((len(kinds), 3, 3))
    for number, row in enumerate(kinds):
        own = [one.directions for one, has in zip(holds, row, strict=False) if has]
        within[number] = free_directions(
            np.concatenate([*own, row[len(holds) :].reshape(3, 3)]), PARALLEL
        )
    span = holds[0].span if drawn is None else drawn.span
    return Guides(nodes, within[kind.ravel()], share[nodes], span)


def free_projection(guides: Guides, number: Indices, size: int) -> "csr_matrix":
    """Return the projection into the free directions of nodes, shape (3 size, 3 size).

    Args:
        guides: Of all nodes.
        number: Of each node among those that may move, -1 for others, shape (node,).
        size: How many may move.
    """
    from scipy.sparse import csr_matrix, identity

    from tissuec.forces.matrices import diagonal  # where there are matrices

    across = diagonal(np.eye(3) - guides.projections, number[guides.nodes], size)
    return csr_matrix(identity(3 * size, format="csr") - across)


def prescribing(others: Guides | None, nodes: Indices, directions: Floats) -> Floats:
    """Return by what missing vectors change positions: A N of the module, shape (n, 3, 3).

    Args:
        others: All other guides.
        nodes: Ascending, shape (n,).
        directions: Those of the motion, orthonormal, dimensionless, shape (direction, 3).
    """
    found = np.broadcast_to(directions.T @ directions, (len(nodes), 3, 3)).copy()
    if others is None:
        return found
    _, own, row = np.intersect1d(nodes, others.nodes, return_indices=True)
    kinds, kind = np.unique(others.projections[row].reshape(-1, 9), axis=0, return_inverse=True)
    changes = [_change(within.reshape(3, 3), directions) for within in kinds]
    found[own] = np.array(changes).reshape(-1, 3, 3)[kind.ravel()]
    return found


def _change(within: Floats, directions: Floats) -> Floats:
    """Return A N for the projection into the directions that others leave, shape (3, 3)."""
    return np.asarray(np.linalg.pinv(directions @ within, rcond=PARALLEL) @ directions)
