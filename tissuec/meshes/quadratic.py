"""Hexahedra with 27 nodes in the place of those with eight.

Nodes in the middle of edges, faces and cells follow all others. They are where the trilinear
cell has them, so that bodies keep their shape.
"""

import numpy as np
from numpy.typing import NDArray

from tissuec.core.structs import replace
from tissuec.geometry.edges import Floats, Indices
from tissuec.geometry.elements import CUBE, CUBE_27, trilinear
from tissuec.meshes.elements import mesh_of_elements
from tissuec.meshes.formats import FormatError
from tissuec.meshes.generators import ElementMesh, Mesh

QUADRATIC = "quadratic hexahedron"
_HINT = "write made of elements"


def with_middles(mesh: Mesh) -> Mesh:
    """Return a mesh whose hexahedra have 27 nodes.

    A new node joins the groups of all nodes that it is between.

    Raises:
        FormatError: There are other elements than hexahedra.
    """
    others = {one.shape for one in mesh.elements} - {"hexahedron"}
    if "tetrahedron" in others:
        raise FormatError("its tetrahedra are quadratic anyway, with ten nodes each", _HINT)
    if others:
        raise FormatError("only hexahedra can be quadratic, and it has wedges", _HINT)
    (one,) = mesh.elements
    count = len(mesh.position)
    between = [np.flatnonzero(each) for each in _between()]
    keys = np.full((len(one.nodes), len(between), 8), -1)
    for k, corners in enumerate(between):
        keys[:, k, : len(corners)] = np.sort(one.nodes[:, corners], axis=1)
    found, number = np.unique(keys.reshape(-1, 8), axis=0, return_inverse=True)
    used = found >= 0
    middle = np.where(used[..., None], mesh.position[found], 0.0).sum(axis=1)
    middle /= used.sum(axis=1)[:, None]
    groups: dict[str, Indices] = {}
    for name, nodes in mesh.groups.items():
        inside = np.zeros(count, dtype=bool)
        inside[nodes] = True
        more = np.flatnonzero((inside[found] | ~used).all(axis=1))
        groups[name] = np.concatenate([nodes, count + more])
    nodes = np.concatenate([one.nodes, count + number.reshape(len(one.nodes), -1)], axis=1)
    new = mesh_of_elements(
        np.concatenate([mesh.position, middle]), [ElementMesh(QUADRATIC, nodes)], groups
    )
    return replace(
        mesh, position=new.position, ends=new.ends, skin=new.skin, groups=groups,
        volume=new.volume, elements=new.elements,
    )  # fmt: skip


def with_middles_between(mesh: Mesh, position: Floats) -> Floats:
    """Return places where corners are as given, and other nodes follow them.

    Args:
        mesh: As drawn before.
        position: Of all nodes [m], shape (node, 3).
    """
    position, values = position.copy(), trilinear(CUBE_27[8:]).values
    for one in mesh.elements:
        if one.shape == QUADRATIC:
            corners = position[one.nodes[:, :8]]
            position[one.nodes[:, 8:]] = np.einsum("qa,eak->eqk", values, corners)
    return position


def _between() -> NDArray[np.bool_]:
    """Return which corners the nodes 8 to 26 are between, shape (19, 8)."""
    return np.asarray((CUBE_27[8:, None] * CUBE >= 0.0).all(axis=2))
