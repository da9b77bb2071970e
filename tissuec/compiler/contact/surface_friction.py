"""Coefficients of friction that tissues give to the nodes and surfaces of bodies.

A triangle of a surface has the coefficient of the element behind it, and a node the mean of the
elements around it. In bodies of springs, nodes have that of their tissue, and triangles the
mean of their corners.
"""

import numpy as np

from tissuec.compiler.bodies.drawn import Drawing
from tissuec.geometry.edges import TriangleIndex
from tissuec.meshes.generators import Mesh
from tissuec.model.network import Indices
from tissuec.model.resistance import SurfaceFriction
from tissuec.scene.tissues.quantities import FRICTION


def friction_of(drawing: Drawing) -> SurfaceFriction:
    """Return the coefficients of friction of a body; tissues that give none have 0."""
    body, mesh = drawing.body, drawing.mesh
    tissues = [body.tissue, *(region.tissue or body.tissue for region in body.regions)]
    given = [None if tissue is None else tissue.given.get(FRICTION) for tissue in tissues]
    each = np.array([0.0 if one is None else one.value for one in given])
    nodes = each[drawing.part]
    skin = nodes[mesh.skin].mean(axis=1)
    if drawing.element_part is None or (each == each[0]).all():
        return SurfaceFriction(nodes, skin)
    behind = _elements_behind(mesh)
    skin[behind >= 0] = each[drawing.element_part[behind[behind >= 0]]]
    pairs = np.stack([mesh.skin.ravel(), np.repeat(behind, 3)], axis=1)
    pairs, first = np.unique(pairs, axis=0, return_index=True)
    count = np.bincount(pairs[:, 0], minlength=len(nodes))
    total = np.bincount(pairs[:, 0], np.repeat(skin, 3)[first], len(nodes))
    return SurfaceFriction(np.where(count > 0, total / np.maximum(count, 1), nodes), skin)


def _elements_behind(mesh: Mesh) -> Indices:
    """Return the element behind each triangle of the skin, or -1, shape (triangle,)."""
    from tissuec.geometry.elements import SHAPES  # where there are elements
    from tissuec.meshes.elements import TRIANGLE

    found, first = np.full(len(mesh.skin), -1), 0
    index = TriangleIndex(mesh.skin)
    for one in mesh.elements:
        faces = one.nodes[:, None]
        if one.shape != TRIANGLE:
            faces = one.nodes[:, SHAPES[one.shape].triangles]
        place = index.find(faces.reshape(-1, 3))
        element = first + np.repeat(np.arange(len(one.nodes)), faces.shape[1])
        found[place[place >= 0]] = element[place >= 0]
        first += len(one.nodes)
    return found
