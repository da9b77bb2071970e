"""The visible side of solid bodies, whose springs fill a volume."""

import numpy as np
from numpy.typing import NDArray

from tissuec.geometry.edges import Edges
from tissuec.model.network import Floats, Indices, Network
from tissuec.view.plots.projection import Projection

Mask = NDArray[np.bool_]
_ASIDE = 1e-9  # cosine to the viewer below which a triangle is seen from its edge


def solid_nodes(network: Network) -> Mask:
    """Return which nodes belong to bodies with nodes inside a closed skin, shape (node,)."""
    solid = np.zeros(network.node_count, dtype=bool)
    for body in network.bodies:
        skin, count = network.skin_of(body), body.nodes.stop - body.nodes.start
        solid[body.nodes] = len(np.unique(skin)) < count and Edges.among(skin).is_closed
    return solid


def front_nodes(position: Floats, triangles: NDArray[np.integer], view: Projection) -> Mask:
    """Return which nodes are corners of triangles that face the eye, shape (node,).

    Args:
        position: [m], shape (node, 3).
        triangles: The skin, its normals outwards, shape (triangle, 3).
        view: Direction of the eye.
    """
    corners = position[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    in_front = np.zeros(len(position), dtype=bool)
    facing = normal @ view.towards > _ASIDE * np.linalg.norm(normal, axis=1)
    in_front[triangles[facing]] = True
    return in_front


def seen_springs(
    ends: Indices,
    solid: Mask,
    position: Floats,
    triangles: NDArray[np.integer],
    view: Projection,
) -> Mask:
    """Return which springs are drawn, shape (spring,); of solid bodies those on the front side.

    A node on the front side with fewer than two springs in the skin, as in a lattice of caesium
    chloride, is drawn with all its springs.

    Args:
        ends: Nodes of each spring, shape (spring, 2).
        solid: Which nodes belong to solid bodies, shape (node,).
        position: [m], shape (node, 3).
        triangles: The skin, its normals outwards, shape (triangle, 3).
        view: Direction of the eye.
    """
    in_front = front_nodes(position, triangles, view)
    seen = np.asarray((~solid | in_front)[ends].all(axis=1))
    joins = np.bincount(ends[seen].ravel(), minlength=len(position))
    alone = solid & in_front & (joins < 2)
    return seen | alone[ends].any(axis=1)
