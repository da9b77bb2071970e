"""From label images to meshes: closed surfaces with labels, and lattices of cubes.

Marching cubes is that of scikit-image in the form of W. Lorensen and H. Cline (Computer
Graphics 21(4):163, 1987), whose triangles close around any set of voxels. Its steps are
smoothed by passes that shrink and grow in turn (G. Taubin, A signal processing approach to fair
surface design, SIGGRAPH 1995, 351), each node staying within half a voxel of its place
(S. Gibson, Constrained elastic surface nets, MICCAI 1998, 888). Then the nodes move along their
normals, within the same bounds, until the surface encloses the volume of the voxels.

Where parts of the surface pass each other diagonally between voxels, the bounds are half as
wide: so no two parts can meet.

A lattice of cubes from a label image: those whose centre has a label.

Where two cubes would touch along an edge only, a third joins them: the surface of the lattice
is then closed, and nothing can turn about that edge.
"""

from collections.abc import Mapping
from importlib import import_module
from itertools import combinations, product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.core.errors import counted
from tissuec.geometry.edges import Edges, volume
from tissuec.meshes.formats import FormatError, Indices, MeshCells, RawMesh
from tissuec.meshes.images import INSTALL, TOO_FAR, Floats, LabelImage, Labels
from tissuec.meshes.repair import RepairedMesh

_PASSES = 20
_SHRINK, _GROW = 0.5, -0.53  # of the way to the mean of the neighbours
#: Voxels, or blocks of them, from where marching cubes puts a node, along each axis.
_FARTHEST, _FARTHEST_BESIDE = 0.49, 0.24
_CORNERS = tuple(product((0, 1), repeat=3))  # of the cube between eight blocks
_VOLUME_PASSES = 4


class _Blocks(NamedTuple):
    """A body in blocks of whole voxels, with an empty margin of one block.

    Attributes:
        label: Of each block, 0 outside, shape (i, j, k).
        step: Voxels of a block along each axis, shape (3,).
        first: Index of the voxel at the lowest corner of the first block, shape (3,).
    """

    label: Labels
    step: Indices
    first: Indices

    def place(self, index: Floats) -> Floats:
        """Return places counted in voxels, of places counted in blocks."""
        return self.first + (index + 0.5) * self.step - 0.5


def surface(image: LabelImage, values: tuple[int, ...], resolution: float | None) -> RawMesh:
    """Return the surface of a body as triangles facing outwards, in metres.

    Args:
        values: Labels of the body. A group of nodes for each has those beside its voxels.
        resolution: About the distance of neighbouring nodes [m], if it is above the size of a
            voxel; None for the latter.

    Raises:
        FormatError: The library is missing, or nothing of the body is as large as that.
    """
    try:
        march: Any = import_module("skimage.measure").marching_cubes
    except ImportError:
        message = "surfaces of images need the optional package scikit-image"
        raise FormatError(message, INSTALL) from None
    blocks = _blocks(image, values, resolution)
    inside = blocks.label != 0
    if not inside.any():
        raise FormatError(
            "nothing is left of the body: it is thinner than the resolution",
            "write a smaller resolution",
        )
    index, triangles, *_ = march(inside.view(np.uint8), 0.5, method="lorensen")
    index, triangles = index.astype(float), triangles.astype(np.int64)
    owner = _owners(blocks.label, index)
    position = image.placed(blocks.place(index))
    if volume(position, triangles) < 0.0:  # as the axes of the image turn
        triangles = triangles[:, ::-1]
    axes = image.axes * blocks.step
    far = np.where(_is_tight(inside, index), _FARTHEST_BESIDE, _FARTHEST)
    bounds = _Bounds(position, axes, far[:, None])
    smooth = _smoothed(bounds, triangles)
    position = _with_volume(smooth, triangles, image.volume(values), bounds)
    groups = {image.names[value]: np.flatnonzero(owner == value) for value in values}
    cells = MeshCells("triangle", triangles, np.arange(len(triangles)))
    remarks = (*image.remarks, *_missed(position, triangles, image.volume(values)))
    return RawMesh(position, (cells,), groups=groups, remarks=remarks)


def _missed(position: Floats, triangles: Indices, wanted: float) -> tuple[str, ...]:
    """Return a remark on a surface that encloses another volume than the voxels, if any."""
    part = volume(position, triangles) / wanted
    if abs(part - 1.0) <= TOO_FAR:
        return ()
    return (
        f"the surface encloses {100 * part:.0f} % of the volume of the voxels: the resolution "
        "is too coarse for the shape",
    )


def _blocks(image: LabelImage, values: tuple[int, ...], resolution: float | None) -> _Blocks:
    """Return the body in blocks; at least half of the voxels of each block are of the body."""
    extent = image.extent(values)
    start = np.array([part.start for part in extent])
    found = image.labels[extent]
    step = np.ones(3, dtype=np.int64)
    if resolution is not None:
        sides = np.linalg.norm(image.axes, axis=0)
        with np.errstate(over="ignore"):
            step = np.clip(np.rint(resolution / sides), 1, found.shape).astype(np.int64)
    if (step == 1).all():
        label = np.where(np.isin(found, values), found, 0)
        return _Blocks(np.pad(label, 1), step, start - 1)
    shape = -(-np.array(found.shape) // step)
    most, total = np.zeros(shape, np.int64), np.zeros(shape, np.int64)
    label = np.zeros(shape, found.dtype)
    for value in values:
        many = _summed(found == value, step)
        label[many > most] = value
        most, total = np.maximum(most, many), total + many
    label[2 * total < step.prod()] = 0
    return _Blocks(np.pad(label, 1), step, start - step)


def _summed(inside: NDArray[np.bool_], step: Indices) -> Indices:
    """Return how many voxels of each block are inside."""
    found: NDArray[Any] = inside
    for axis in range(3):
        starts = list(range(0, inside.shape[axis], int(step[axis])))
        found = np.add.reduceat(found, starts, axis=axis, dtype=np.int64)
    return found


def _is_tight(inside: NDArray[np.bool_], index: Floats) -> NDArray[np.bool_]:
    """Return which nodes are where two parts of the surface pass each other, shape (node,).

    Args:
        inside: Of each block, shape (i, j, k).
        index: Of the nodes [blocks], shape (node, 3).
    """
    size = np.array(inside.shape) - 1
    code = np.zeros(size, np.uint8)
    for bit, corner in enumerate(_CORNERS):
        i, j, k = (slice(low, low + many) for low, many in zip(corner, size, strict=True))
        code |= inside[i, j, k].view(np.uint8) << np.uint8(bit)
    tight = np.array([_passes_itself(one) for one in range(256)])[code]
    base = np.floor(index).astype(np.int64)
    found = np.zeros(len(index), dtype=bool)
    for corner in _CORNERS:  # of the cubes around a node; more than it belongs to, to be safe
        cube = np.clip(base - corner, 0, size - 1)
        found |= tight[tuple(cube.T)]
    return found


def _passes_itself(code: int) -> bool:
    """Return whether blocks around a cube touch only along an edge or at a corner.

    Args:
        code: A bit for each of the corners in order, set where the block is inside.
    """
    held = np.array([code >> bit & 1 for bit in range(8)], dtype=bool).reshape(2, 2, 2)
    faces = (face for axis in range(3) for face in np.moveaxis(held, axis, 0))
    if any(face[0, 0] == face[1, 1] != face[0, 1] == face[1, 0] for face in faces):
        return True
    opposite = [held[i, j, k] == held[1 - i, 1 - j, 1 - k] for i, j, k in _CORNERS]
    return held.sum() in (2, 6) and all(opposite)


def _owners(label: Labels, index: Floats) -> Labels:
    """Return the label on the inner side of each node, which lies between two blocks."""
    low, high = (label[tuple(end(index).astype(int).T)] for end in (np.floor, np.ceil))
    return np.where(low != 0, low, high)


class _Bounds(NamedTuple):
    """How far nodes may move.

    Attributes:
        position: Where marching cubes puts them [m], shape (node, 3).
        axes: From block to block [m], one in each column.
        far: How far along each axis of the image [blocks], shape (node, 1).
    """

    position: Floats
    axes: Floats
    far: Floats

    def nearest(self, moved: Floats) -> Floats:
        """Return the allowed places nearest to moved nodes [m], shape (node, 3)."""
        way = (moved - self.position) @ np.linalg.inv(self.axes).T
        return self.position + np.clip(way, -self.far, self.far) @ self.axes.T


def _smoothed(bounds: _Bounds, triangles: Indices) -> Floats:
    """Return nodes moved towards their neighbours and back [m], shape (node, 3)."""
    from scipy.sparse import coo_array

    ends = Edges.among(triangles).ends
    count = len(bounds.position)
    rows, columns = np.concatenate([ends, ends[:, ::-1]]).T
    weight = 1.0 / np.bincount(rows, minlength=count)[rows]
    mean: Any = coo_array((weight, (rows, columns)), shape=(count, count)).tocsr()
    moved = bounds.position
    for _ in range(_PASSES):
        for part in (_SHRINK, _GROW):
            neighbours: Floats = mean @ moved
            moved = moved + part * (neighbours - moved)
    return bounds.nearest(moved)


def _with_volume(
    position: Floats, triangles: Indices, wanted: float, bounds: _Bounds
) -> Floats:
    """Return nodes moved along their normals, so that they enclose a volume.

    Args:
        position: [m], shape (node, 3).
        triangles: Facing outwards, shape (triangle, 3).
        wanted: The volume [m³].
        bounds: How far nodes may be from their first places.
    """
    moved = position
    for _ in range(_VOLUME_PASSES):
        a, b, c = moved[triangles].swapaxes(0, 1)
        third = np.cross(b - a, c - a) / 6.0
        normal = np.zeros_like(position)
        for corner in triangles.T:
            np.add.at(normal, corner, third)
        size = np.linalg.norm(normal, axis=1, keepdims=True)
        unit = np.divide(normal, size, out=np.zeros_like(normal), where=size > 0.0)
        missing = wanted - volume(moved, triangles)
        moved = bounds.nearest(moved + unit * (missing / float(size.sum())))
    return moved


def with_inner_nodes(
    image: LabelImage, shape: RepairedMesh, inner: Floats
) -> Mapping[str, Indices]:
    """Return the groups of a surface with the nodes inside, by their labels.

    A node inside whose voxel has no label of the body belongs to the group of the nearest node
    of the surface: a smooth surface passes through voxels outside.

    Args:
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


#: Corners of a cube in the order of VTK, in cells.
_CUBE_CORNERS = np.array(
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
    corners = place[:, None] + _CUBE_CORNERS
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
