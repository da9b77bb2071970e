"""Which region each element of a body belongs to.

It is the region of most of its nodes. Of several with as many nodes, it is the one that the
centre of the element lies in, or else the first; so a plane between two layers of cells divides
them there, whether or not nodes in the plane belong to a region.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from tissuec.compiler.selections import Mask, PointScope
from tissuec.lang import syntax as s
from tissuec.meshes.generators import Mesh
from tissuec.model.network import Indices
from tissuec.scene.expressions import Scope


def regions_of_elements(
    mesh: Mesh,
    part: NDArray[np.int32],
    conditions: Sequence[s.Expression],
    scope: Scope,
    surface: Mask | None,
    groups: Mapping[str, Mask],
) -> Indices:
    """Return the number of the region of each element from 1, 0 without one, shape (element,).

    Args:
        mesh: With elements, which are numbered shape by shape.
        part: Number of the region of each node, shape (node,).
        conditions: Of the regions.
        scope: Looks up names of expressions.
        surface: Which nodes lie on the surface, shape (node,).
        groups: Nodes of each group of a file, shape (node,).
    """
    found: list[Indices] = []
    for one in mesh.elements:
        own = part[one.nodes]
        votes = np.stack(
            [(own == number).sum(axis=1) for number in range(len(conditions) + 1)], axis=1
        )
        is_tied = votes == votes.max(axis=1, keepdims=True)
        chosen = is_tied.argmax(axis=1)
        if (open_ := np.flatnonzero(is_tied.sum(axis=1) > 1)).size:
            nodes = one.nodes[open_]

            def whole(mask: Mask, nodes: Indices = nodes) -> Mask:
                return np.asarray(mask[nodes].all(axis=1))

            centre = PointScope(
                scope,
                mesh.position[nodes].mean(axis=1),
                surface=None if surface is None else whole(surface),
                groups={name: whole(mask) for name, mask in groups.items()},
            )
            for number, condition in enumerate(conditions, start=1):
                inside = open_[centre.select(condition)]
                chosen[inside[is_tied[inside, number]]] = number
        found.append(chosen.astype(np.int64))
    return np.concatenate(found)
