"""A lattice of cubes from a label image: those whose centre has a label.

Where two cubes would touch along an edge only, a third joins them: the surface of the lattice
is then closed, and nothing can turn about that edge.
"""

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from tissuec.core.errors import counted
from tissuec.meshes.formats import FormatError, Indices, MeshCells, RawMesh
from tissuec.meshes.images import TOO_FAR, Floats, LabelImage, Labels

#: Corners of a cube in the order of VTK, in cells.
_CORNERS = np.array(
    [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
)
_TIE = 1e-6  # of a cell: a smaller part of one at the end of a box is rounding
_NEAR = 1e-3  # voxels from the face of one: rounding may decide
_MOST_LOOKED_AT = 1000  # cells along an axis
_LARGEST_BOX = 1 << 32  # cells that are examined
_PER_CELL = 13  # springs of a cell inside: 3 edges, 6 diagonals of faces, rounded up


def size(image: LabelImage, values: tuple[int, ...], cell: float) -> tuple[int, int]:
    """Return about how many nodes and springs there are, rather too many.

    Args:
        image: The image.
        values: Labels of the body.
        cell: Edge of a cube [m].
    """
    cells = 1.2 * image.volume(values) / cell**3 + 8.0
    return int(min(cells, 1e18)), int(min(_PER_CELL * cells, 1e18))


def cubes(image: LabelImage, values: tuple[int, ...], cell: float) -> RawMesh:
    """Return cubes along x, y and z, with the nodes of each label as a group, in metres.

    A node belongs to the label of most cubes around it, and of equally many to the label that
    has fewer voxels, so that groups share no node. A label that would have none gets those of
    its cubes.

    Args:
        image: The image.
        values: Labels of the body.
        cell: Edge of a cube [m].

    Raises:
        FormatError: No cube has its centre in the body, or there are too many to examine.
    """
    low, shape = _box(image, values, cell)
    place, label = _sampled(image, values, cell, low, shape)
    place, label, added = _joined(place, label, shape)
    if not len(place):
        raise FormatError(
            "no cell has its centre in the body: it is thinner than a cell",
            "write a smaller cell",
        )
    corners = place[:, None] + _CORNERS
    strides = np.array([(shape[1] + 1) * (shape[2] + 1), shape[2] + 1, 1])
    keys, nodes = np.unique(corners @ strides, return_inverse=True)
    nodes = nodes.reshape(-1, 8)
    position = np.stack(np.unravel_index(keys, tuple(shape + 1)), axis=1) * cell + low
    groups, remarks = _groups(image, values, nodes, label)
    cells = MeshCells("hexahedron", nodes.astype(np.int64), np.arange(len(nodes)))
    if added:
        remarks.append(f"{counted(added, 'cell')} added where two touched along an edge only")
    part = len(place) * cell**3 / image.volume(values)
    if abs(part - 1.0) > TOO_FAR:
        remarks.append(
            f"cubes take {100 * part:.0f} % of the volume of the voxels: the cell is too large "
            "for the shape"
        )
    return RawMesh(position, (cells,), groups=groups, remarks=(*image.remarks, *remarks))


def _box(image: LabelImage, values: tuple[int, ...], cell: float) -> tuple[Floats, Indices]:
    """Return the lowest corner [m] and the size in cells of a box around a body.

    The middle of one cell is at that of a voxel, or half a cell beside it along axes where more
    cells would have their middle exactly between two voxels.
    """
    block = image.extent(values)
    ends = np.array([(part.start - 0.5, part.stop - 0.5) for part in block]).T
    corners = image.placed(np.stack(np.meshgrid(*ends.T), axis=-1).reshape(-1, 3))
    middle = image.placed(np.floor(ends.mean(axis=0))[None])[0]
    middle += 0.5 * cell * _between(image, corners, cell)
    below, above = middle - corners.min(axis=0), corners.max(axis=0) - middle
    before, after = (np.maximum(np.ceil(w / cell - 0.5 - _TIE), 0.0) for w in (below, above))
    shape = before + 1.0 + after
    if shape.prod() > _LARGEST_BOX:
        raise FormatError("the cell is too small: it gives too many nodes")
    return middle - (before + 0.5) * cell, shape.astype(np.int64)


def _between(image: LabelImage, corners: Floats, cell: float) -> NDArray[np.bool_]:
    """Return along which axes half a cell more puts fewer cells between two voxels, shape (3,).

    Args:
        corners: Of the body [m], shape (corner, 3).
    """
    voxel = np.abs(image.axes)
    if (np.sort(voxel, axis=1)[:, 1] > _TIE * voxel.max()).any():
        return np.zeros(3, dtype=bool)  # the axes are oblique
    count = min(int(np.ptp(corners, axis=0).max() / cell) + 1, _MOST_LOOKED_AT)
    place = np.arange(count)[:, None] * cell / voxel.max(axis=1)

    def ties(shift: Floats | float) -> Indices:
        return (np.abs((place + shift) % 1.0 - 0.5) < _NEAR).sum(axis=0)

    return ties(0.5 * cell / voxel.max(axis=1)) < ties(0.0)


def _sampled(
    image: LabelImage, values: tuple[int, ...], cell: float, low: Floats, shape: Indices
) -> tuple[Indices, Labels]:
    """Return the cells of a box whose centre has a label, shape (cell, 3), and the labels.

    Args:
        low: Lowest corner of the box [m], shape (3,).
        shape: Cells along x, y and z, shape (3,).
    """
    places: list[Indices] = []
    labels: list[Labels] = []
    across = np.indices((int(shape[1]), int(shape[2]))).reshape(2, -1).T
    for row in range(int(shape[0])):  # one layer after another, for the sake of memory
        layer = np.column_stack([np.full(len(across), row), across])
        found = image.labels_at((layer + 0.5) * cell + low)
        inside = np.isin(found, values)
        places.append(layer[inside])
        labels.append(found[inside])
    return np.concatenate(places), np.concatenate(labels)


def _joined(place: Indices, label: Labels, shape: Indices) -> tuple[Indices, Labels, int]:
    """Return cells and labels with those that are added, and the number of the latter.

    Args:
        place: Of the cells, shape (cell, 3).
        label: Of the cells.
        shape: Of the box in cells, shape (3,).
    """
    first = len(place)
    strides = np.array([(shape[1] + 2) * (shape[2] + 2), shape[2] + 2, 1])  # with a margin
    while len(place):
        keys = place @ strides
        new: list[Indices] = []
        of: list[Labels] = []
        for one, other in combinations(np.eye(3, dtype=np.int64), 2):
            for diagonal in (one + other, one - other):
                touching = np.isin(keys + diagonal @ strides, keys)
                for beside in (one, diagonal - one):
                    touching &= ~np.isin(keys + beside @ strides, keys)
                new.append(place[touching] + one)
                of.append(label[touching])
        found = np.concatenate(new)
        if not len(found):
            break
        _, once = np.unique(found, axis=0, return_index=True)
        place = np.concatenate([place, found[once]])
        label = np.concatenate([label, np.concatenate(of)[once]])
    return place, label, len(place) - first


def _groups(
    image: LabelImage, values: tuple[int, ...], nodes: Indices, label: Labels
) -> tuple[dict[str, Indices], list[str]]:
    """Return the nodes of each label by its name, and remarks on labels without any."""
    pairs = np.stack([nodes.ravel(), np.repeat(label, 8).astype(np.int64)], axis=1)
    pairs, many = np.unique(pairs, axis=0, return_counts=True)
    voxels = np.array([image.count[value] for value in values])[
        np.searchsorted(values, pairs[:, 1])
    ]
    order = np.lexsort((voxels, -many, pairs[:, 0]))
    _, first = np.unique(pairs[order, 0], return_index=True)
    node, owner = pairs[order[first]].T
    for value in values:
        if not (owner == value).any():
            owner[np.isin(node, nodes[label == value])] = value
    groups = {image.names[value]: node[owner == value] for value in values}
    lost = [f'"{name}"' for name, found in groups.items() if not len(found)]
    if not lost:
        return groups, []
    return groups, [f"{counted(len(lost), 'part')} too small for the cell: {', '.join(lost)}"]
