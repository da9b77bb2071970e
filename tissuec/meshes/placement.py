"""Meshes that are shifted, turned, scaled or mirrored as a whole.

Nodes and springs keep their numbers. Under a reflection, the corners of triangles, elements and
faces change their order, so that surfaces still face outwards and volumes remain positive.
"""

import numpy as np
from numpy.typing import NDArray

from tissuec.core.structs import replace
from tissuec.geometry.affine import Affine
from tissuec.geometry.edges import Indices
from tissuec.geometry.elements import MIDDLES
from tissuec.meshes.elements import MIRRORED, TRIANGLE
from tissuec.meshes.generators import ElementMesh, Mesh
from tissuec.meshes.stiffness_sharing import area_shares, volume_shares


def placed(mesh: Mesh, affine: Affine) -> Mesh:
    """Return the image of a mesh under an affine map."""
    position, is_mirrored = affine.points(mesh.position), affine.is_mirrored
    skin, elements = mesh.skin, mesh.elements
    if is_mirrored:
        skin, elements = skin[:, [0, 2, 1]], tuple(map(_inside_out, elements))
    shares = mesh.shares
    if shares is not None and affine.scale is None:  # they depend on the shape of cells
        if mesh.shared_by_area:
            shares = area_shares(position, skin, mesh.ends)
        else:
            assert mesh.tetrahedra is not None
            shares = volume_shares(position, mesh.tetrahedra, mesh.ends)
    return replace(
        mesh,
        position=position,
        on_shape=None if mesh.on_shape is None else affine.points(mesh.on_shape),
        skin=skin,
        shares=shares,
        volume=None if mesh.volume is None else affine.volume * mesh.volume,
        elements=elements,
    )


def reversed_faces(faces: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return faces that face the other way.

    Args:
        faces: Four corners each; a triangle names its last one twice. Shape (…, 4).

    Returns:
        Nodes, shape (…, 4).
    """
    is_triangle = faces[..., 2:3] == faces[..., 3:4]
    return np.where(is_triangle, faces[..., [1, 0, 2, 3]], faces[..., [0, 3, 2, 1]])


def _inside_out(elements: ElementMesh) -> ElementMesh:
    """Return elements with their nodes in the order that has the opposite volume."""
    nodes = elements.nodes
    if elements.shape == TRIANGLE:
        return replace(elements, nodes=nodes[:, [0, 2, 1]])
    order = MIRRORED[elements.shape]
    if nodes.shape[1] > len(order):
        order = [*order, *_middles(order)]
    return replace(elements, nodes=nodes[:, order])


def _middles(corners: list[int]) -> list[int]:
    """Return the nodes in the middle of the edges of tetrahedra with reordered corners."""
    number = {tuple(pair): 4 + k for k, pair in enumerate(np.sort(MIDDLES).tolist())}
    ends: Indices = np.sort(np.array(corners)[MIDDLES])
    return [number[tuple(pair)] for pair in ends.tolist()]
