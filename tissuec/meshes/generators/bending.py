"""Bending springs: between nodes that are two steps apart on a surface.

A spring of constant c over a hinge whose sides, of length l, meet at the angle π - θ is
L = 2 l cos(θ/2) long and turns the hinge with

    M = dE/dθ = -c (L - L0) l sin(θ/2),

which near a drawn angle θ0 is c l² sin²(θ0/2) (θ - θ0). A surface that is drawn flat therefore
resists bending with the third power of the angle at first, and a curved one in proportion.
"""

from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from tissuec.meshes.generators import Mesh
from tissuec.meshes.generators.joining import Pairs, springs


@runtime_checkable
class Bendable(Protocol):
    """A generator that knows its second neighbours, or says why it has none."""

    def second_neighbours_of_surface(self) -> Pairs:
        """Return the pairs that bending springs join, shape (spring, 2).

        Raises:
            ValueError: Bending springs make no sense here, and why.
        """
        ...


def bending_springs(mesh: Mesh, generator: object) -> NDArray[np.int32]:
    """Return the pairs of second neighbours that no spring joins, shape (pair, 2).

    Without a word from the generator these are the nodes on either side of an edge of the skin.

    Raises:
        ValueError: There are none.
    """
    if isinstance(generator, Bendable):
        pairs = generator.second_neighbours_of_surface()
    elif len(mesh.skin):
        pairs = across_edges(mesh.skin)
    else:
        raise ValueError("it has no surface that can bend; join second neighbours by springs")
    count = len(mesh.position)
    found = springs(count, pairs)
    low, high = mesh.ends.min(axis=1), mesh.ends.max(axis=1)
    joined = low.astype(np.int64) * count + high
    asked = found[:, 0].astype(np.int64) * count + found[:, 1]
    new = found[np.isin(asked, joined, assume_unique=True, invert=True)]
    if not len(new):
        raise ValueError("springs already join all its second neighbours")
    return new


def across_edges(skin: NDArray[np.int32]) -> Pairs:
    """Return the two nodes beside each edge that two triangles share, shape (edge, 2)."""
    return around_edges(skin)[:, 2:]


def around_edges(skin: NDArray[np.int32]) -> Pairs:
    """Return the ends of each edge that two triangles share, and the two nodes beside it.

    Args:
        skin: Triangles, shape (triangle, 3).

    Returns:
        Nodes, shape (edge, 4); triangles with all three nodes in common have no such edge.
    """
    triangles = skin.astype(np.int64)
    size = int(triangles.max()) + 1
    first, second = triangles, np.roll(triangles, -1, axis=1)
    beside = np.roll(triangles, -2, axis=1).ravel()
    keys = (np.minimum(first, second) * size + np.maximum(first, second)).ravel()
    order = np.argsort(keys, kind="stable")
    keys, beside = keys[order], beside[order]
    begins = np.flatnonzero(np.diff(keys, prepend=-1))
    shared = begins[np.diff(begins, append=len(keys)) == 2]
    low, high = np.divmod(keys[shared], size)
    found = np.stack((low, high, beside[shared], beside[shared + 1]), axis=1)
    return found[found[:, 2] != found[:, 3]]
