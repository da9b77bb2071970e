"""What nodes can be glued to, and where they are in it."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.core.arrays import norm
from tissuec.geometry.elements import CUBE_27, MIDDLES, SHAPES, trilinear
from tissuec.geometry.natural_coordinates import places_in
from tissuec.geometry.nearest import TRIANGLE, places
from tissuec.model.network import Floats, Indices, Network

#: Of the length of edges: what counts as no distance.
ON = 1e-9


def _corner_functions() -> dict[str, Floats]:
    """Return the linear functions of corners at all nodes, of shapes that have more."""
    tetrahedron = np.zeros((10, 10))
    tetrahedron[range(4), range(4)] = 1.0
    tetrahedron[np.arange(4, 10)[:, None], MIDDLES] = 0.5
    cube = np.pad(trilinear(CUBE_27).values, ((0, 0), (0, 19)))
    return {"tetrahedron": tetrahedron, "quadratic hexahedron": cube}


#: Functions of higher order are negative near some nodes, as masses must not be.
CORNERS = _corner_functions()


class Hosts(NamedTuple):
    """What nodes can be glued to: elements of one shape, triangles or springs.

    Attributes:
        shape: Name of the shape of elements; "triangle" or "spring".
        nodes: Shape (element, node).
    """

    shape: str
    nodes: Indices

    @property
    def is_solid(self) -> bool:
        """Return whether weights can be continued beside the element."""
        return self.shape not in ("triangle", "spring")


def hosts_at(network: Network, nodes: Indices) -> list[Hosts]:
    """Return the elements at some nodes, or else pieces of threads, as hosts.

    Args:
        nodes: Of a set or body, shape (n,).
    """
    inside = np.zeros(network.node_count, dtype=bool)
    inside[nodes] = True
    found: list[Hosts] = []
    for each in network.elements:
        at = inside[each.nodes].any(axis=1)
        if at.any():
            shape = getattr(each, "shape", None)
            name = "triangle" if shape is None else shape.name
            found.append(Hosts(name, each.nodes[at].astype(np.int64)))
    solid = [each for each in found if each.is_solid]
    if found:
        return solid or found
    for thread in network.threads.values():
        pieces = network.springs.ends[thread.pieces].astype(np.int64)
        at = inside[pieces].all(axis=1)
        if at.any():
            found.append(Hosts("spring", pieces[at]))
    return found


def sizes(corners: Floats) -> Floats:
    """Return a length of edges of each element [m], shape (element,).

    Args:
        corners: Of elements [m], shape (element, node, 3).
    """
    return norm(corners - corners[:, :1])[:, 1:].min(axis=1)


def candidates(points: Floats, corners: Floats, reach: float) -> tuple[Indices, Indices]:
    """Return pairs of points and elements in whose boxes, widened by the reach, they are.

    Args:
        points: [m], shape (point, 3).
        corners: Of elements [m], shape (element, node, 3).
    """
    from scipy.spatial import KDTree

    low, high = corners.min(axis=1), corners.max(axis=1)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    radius = norm(half) + reach
    near = KDTree(points).query_ball_point(middle, radius * (1.0 + ON), return_sorted=True)
    point = np.concatenate([np.zeros(0, dtype=np.int64), *map(_as_indices, near)])
    element = np.repeat(np.arange(len(corners)), [len(each) for each in near])
    inside = np.abs(points[point] - middle[element]) <= (half[element] + reach) * (1.0 + ON)
    inside = inside.all(axis=1)
    return point[inside], element[inside]


def _as_indices(values: list[int]) -> NDArray[np.int64]:
    return np.asarray(values, dtype=np.int64)


def placed(shape: str, points: Floats, corners: Floats) -> tuple[Floats, Floats]:
    """Return weights of points, shape (pair, node), and how far they are beside [m]."""
    if shape in SHAPES:
        return places_in(shape, points, corners)
    if shape == "spring":
        corners = np.concatenate([corners, corners[:, 1:]], axis=1)
        ends = _nearest(points, corners)
        weights = np.stack([ends[:, 0], ends[:, 1] + ends[:, 2]], axis=1)
    else:
        ends = weights = _nearest(points, corners)
    return weights, norm(points - np.einsum("pa,pak->pk", ends, corners))


def _nearest(points: Floats, corners: Floats) -> Floats:
    """Return the weights of corners of triangles in the points nearest to others."""
    kind = np.full(len(points), TRIANGLE)
    return places(points, kind, corners, np.zeros(len(points))).weights
