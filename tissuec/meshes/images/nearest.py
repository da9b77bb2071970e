"""Labels of the nodes that fill a surface."""

from collections.abc import Mapping

import numpy as np

from tissuec.meshes.formats import Indices
from tissuec.meshes.images import Floats, LabelImage
from tissuec.meshes.repair import RepairedMesh


def with_inner_nodes(
    image: LabelImage, shape: RepairedMesh, inner: Floats
) -> Mapping[str, Indices]:
    """Return the groups of a surface with the nodes inside, by their labels.

    A node inside whose voxel has no label of the body belongs to the group of the nearest node
    of the surface: a smooth surface passes through voxels outside.

    Args:
        image: The image.
        shape: Its surface.
        inner: Nodes inside [m], numbered after those of the surface, shape (node, 3).
    """
    from scipy.spatial import KDTree

    count = len(shape.position)
    owner = np.full(count, -1)
    value_of = {name: value for value, name in image.names.items()}
    for name, nodes in shape.groups.items():
        owner[nodes] = value_of[name]
    label = image.labels_at(inner).astype(np.int64)
    outside = ~np.isin(label, [value_of[name] for name in shape.groups])
    if outside.any():
        _, near = KDTree(shape.position).query(inner[outside])
        label[outside] = owner[near]
    return {
        name: np.concatenate([nodes, count + np.flatnonzero(label == value_of[name])])
        for name, nodes in shape.groups.items()
    }
