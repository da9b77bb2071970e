"""The closed surface of a label image, and the labels of nodes that fill it.

Marching cubes is that of scikit-image in the form of W. Lorensen and H. Cline (Computer
Graphics 21(4):163, 1987), whose triangles close around any set of voxels. Its steps are
smoothed by passes that shrink and grow in turn (G. Taubin, A signal processing approach to fair
surface design, SIGGRAPH 1995, 351), each node staying within half a voxel of its place
(S. Gibson, Constrained elastic surface nets, MICCAI 1998, 888). Then the nodes move along their
normals, within the same bounds, until the surface encloses the volume of the voxels.

Where parts of the surface pass each other diagonally between voxels, the bounds are half as
wide: so no two parts can meet.
"""

from collections.abc import Mapping
from importlib import import_module
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

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
        image: The image.
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
