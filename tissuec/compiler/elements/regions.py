"""Which region each element of a body belongs to.

It is the region that the centre of the element lies in, the first if there are several; so a
plane between two layers of cells divides them there, whether or not nodes in it belong to a
region. Of groups and of the surface, an element is a part if all of its nodes are.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from tissuec.compiler.selections import Mask, PointScope, largest_side
from tissuec.lang import syntax as s
from tissuec.meshes.generators import Mesh
from tissuec.model.network import Indices
from tissuec.scene.reading.expressions import Scope


def regions_of_elements(
    mesh: Mesh,
    conditions: Sequence[s.Expression],
    scope: Scope,
    surface: Mask | None,
    groups: Mapping[str, Mask],
) -> Indices:
    """Return the number of the region of each element from 1, 0 without one, shape (element,).

    Args:
        mesh: With elements, which are numbered shape by shape.
        conditions: Of the regions.
        scope: Looks up names of expressions.
        surface: Which nodes lie on the surface, shape (node,).
        groups: Nodes of each group of a file, shape (node,).
    """
    found: list[Indices] = []
    for one in mesh.elements:

        def whole(mask: Mask, nodes: Indices = one.nodes) -> Mask:
            return np.asarray(mask[nodes].all(axis=1))

        centre = PointScope(
            scope,
            mesh.position[one.nodes].mean(axis=1),
            size=largest_side(mesh.position),
            surface=None if surface is None else whole(surface),
            groups={name: whole(mask) for name, mask in groups.items()},
        )
        chosen = np.zeros(len(one.nodes), dtype=np.int64)
        for number, condition in reversed([*enumerate(conditions, start=1)]):
            chosen[centre.select(condition)] = number
        found.append(chosen)
    return np.concatenate(found)
