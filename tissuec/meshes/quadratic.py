"""Hexahedra with 27 nodes in the place of those with eight.

Nodes in the middle of edges, faces and cells follow all others. They are where the trilinear
cell has them, so that bodies keep their shape.
"""

import numpy as np

from tissuec.core.structs import replace
from tissuec.geometry.edges import Floats, Indices
from tissuec.geometry.elements import CUBE_27, trilinear
from tissuec.meshes.between import keys_of
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
    keys = keys_of(one.nodes)
    found, number = np.unique(keys.reshape(-1, 8), axis=0, return_inverse=True)
    used = found >= 0
    middle = np.where(used[..., None], mesh.position[found], 0.0).sum(axis=1)
    middle /= used.sum(axis=1)[:, None]
    middle = mesh.between.places(found, middle)
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
