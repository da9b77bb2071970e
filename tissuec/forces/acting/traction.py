"""Shares of a force that is spread evenly over the area of faces.

The force on node i of a face whose traction is F/A is F ∫ N_i dA / A. By the weighted triangles
of the face (see ``enclosed.pressed_faces``), with its mean normal n,

    ∫ N_i dA = Σ ⅓ w_T n · ((x_j - x_i) × (x_k - x_i)) / 2

over the triangles of i: exact on a plane face with straight sides, and of second order in its
warp on others. Corners of a rectangle get ¼ each, those of a triangle ⅓. On a side of a
tetrahedron with ten nodes, corners get 0 and middles ⅓; on a rectangle of nine nodes, corners
get 1/36, middles of edges 4/36, and the middle 16/36.
"""

import numpy as np

from tissuec.core.arrays import cross
from tissuec.forces.enclosed.pressed_faces import WeightedTriangles, faces_of
from tissuec.model.network import Floats, Indices, Network


def area_shares(network: Network, nodes: Indices) -> Floats | None:
    """Return the share of each node of a set in a force that is even over the set's faces.

    These are the faces, as drawn, of elements and walls whose corners are all in the set.

    Args:
        nodes: Of the set, ascending, shape (n,).

    Returns:
        Shares, dimensionless, whose sum is 1, shape (n,); None if the set is not part of a
        surface: it has no face, has a node inside a body, or contains whole solid elements.
    """
    if not network.elements:
        return None
    made = np.zeros(network.node_count, dtype=bool)
    for each in network.elements:
        made[each.nodes] = True
    skin = network.skin[made[network.skin].all(axis=1)]
    chosen, outside = np.zeros((2, network.node_count), dtype=bool)
    chosen[nodes], outside[skin] = True, True
    if not outside[nodes].all() or _is_filled(network, chosen):
        return None
    rows = np.flatnonzero((chosen & made)[network.skin].all(axis=1))
    if not len(rows):
        return None
    shares = _areas(network.position, faces_of(network, rows).triples)[nodes]
    return shares / shares.sum() if shares.sum() > 0.0 else None


def _is_filled(network: Network, chosen: Floats) -> bool:
    """Return whether every chosen node belongs to a solid element of chosen nodes alone."""
    inside = np.zeros(network.node_count, dtype=bool)
    for each in network.of_kind("elements"):
        inside[each.nodes[chosen[each.nodes].all(axis=1)]] = True
    return bool((inside == chosen).all())


def _areas(position: Floats, triples: WeightedTriangles) -> Floats:
    """Return the area that belongs to each node [m²], shape (node,)."""
    a, b, c = position[triples.corners].swapaxes(0, 1)
    areas = 0.5 * triples.weight[:, None] * cross(b - a, c - a)
    normal = np.add.reduceat(areas, triples.first[:-1], axis=0)
    size = np.sqrt((normal**2).sum(axis=1, keepdims=True))
    normal /= np.where(size > 0.0, size, 1.0)
    part = (areas * normal[triples.face]).sum(axis=1) / 3.0
    count = len(position)
    return np.bincount(triples.corners.ravel(), np.repeat(part, 3), count).astype(float)
