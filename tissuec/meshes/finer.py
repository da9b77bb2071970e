"""Finer fillings in a part of a body: sizes of cells, triangles and sites that follow them.

The size of cells is that of the fine part within a box and grows with the distance d from it:

    h = min(cell, fine + 0.4 d).

Edges of the surface that are longer than 1.5 h are divided at their middles: it keeps its
shape. Sites inside are those of body-centred cubes, which are halved as long as they are larger
than h (as for F. Labelle, J. R. Shewchuk, ACM Trans. Graph. 26(3):57, 2007).
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.geometry.divisions import regular_triangulation
from tissuec.geometry.edges import Edges, Floats, Indices
from tissuec.meshes.formats import FormatError
from tissuec.meshes.slivers import quality

_GROWTH = 0.4  # of sizes with the distance from the fine part
_LONG = 1.5  # sizes: longer edges of the surface are divided
_ROUNDS = 40  # of divisions, each of which halves edges
_ATTEMPTS = 30
_ALL, _SOME = (-0.05, 0.05), (-0.2, 0.2)  # of a size: how far sites are moved
_FLAT = 0.1  # quality of tetrahedra whose sites are moved again
_MOST = 20_000_000  # cubes; more do not fit into memory


class FinePart(Struct, frozen=True, eq=False):
    """A part of a body that is divided more finely.

    Attributes:
        low, high: Corners of the box with fine cells [m], shape (3,).
        fine, cell: Sizes of cells there and far away [m].
    """

    low: Floats
    high: Floats
    fine: float
    cell: float

    def size_at(self, points: Floats) -> Floats:
        """Return the size of cells at points [m], shape (…).

        Args:
            points: [m], shape (…, 3).
        """
        beside = np.maximum(np.maximum(self.low - points, points - self.high), 0.0)
        away = np.sqrt((beside * beside).sum(axis=-1))
        return np.minimum(self.cell, self.fine + _GROWTH * away)


class GroupedSurface(NamedTuple):
    """A surface of triangles, and the nodes of its groups."""

    position: Floats
    triangles: Indices
    groups: Mapping[str, Indices]


def divided(surface: GroupedSurface, part: FinePart) -> GroupedSurface:
    """Return a surface with shorter edges where cells are smaller; new nodes come last.

    A node in the middle of an edge joins the groups that have both of its ends.
    """
    position, triangles, groups = surface
    for _ in range(_ROUNDS):
        edges = Edges.among(triangles)
        ends = position[edges.ends]
        size = part.size_at(ends.mean(axis=1))
        length = np.sqrt(((ends[:, 1] - ends[:, 0]) ** 2).sum(axis=1))
        halved = (length > _LONG * size) & (size < part.cell)
        if not halved.any():
            break
        middle = np.full(len(edges.ends), -1)
        middle[halved] = len(position) + np.arange(int(halved.sum()))
        groups = {
            name: np.concatenate([nodes, middle[halved & _has_both(edges.ends, nodes)]])
            for name, nodes in groups.items()
        }
        position = np.concatenate([position, ends[halved].mean(axis=1)])
        triangles = _cut(triangles, middle[edges.of])
    return GroupedSurface(position, triangles, groups)


def _has_both(ends: Indices, nodes: Indices) -> NDArray[np.bool_]:
    return np.asarray(np.isin(ends, nodes).all(axis=1))


def _cut(triangles: Indices, middle: Indices) -> Indices:
    """Return triangles divided at the middles of some of their edges.

    Args:
        middle: Node in the middle of the edges 0-1, 1-2 and 2-0 of each, -1 for those that are
            not divided, shape (triangle, 3).
    """
    count = (middle >= 0).sum(axis=1)
    found = [triangles[count == 0]]
    for many, first in ((1, 0), (2, 2), (3, 0)):
        own, at = triangles[count == many], middle[count == many]
        # Turned so that the edge 0-1 is the only divided one, or 2-0 the only whole one.
        marks = at >= 0 if many == 1 else at < 0
        turn = (marks.argmax(axis=1) - first if many < 3 else np.zeros(len(own), int))[:, None]
        order = (np.arange(3) + turn) % 3
        a, b, c = np.take_along_axis(own, order, axis=1).T
        ab, bc, ca = np.take_along_axis(at, order, axis=1).T
        parts = {
            1: [(a, ab, c), (ab, b, c)],
            2: [(ab, b, bc), (a, ab, bc), (a, bc, c)],
            3: [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)],
        }[many]
        found += [np.stack(corners, axis=1) for corners in parts]
    return np.concatenate(found)


def sites(low: Floats, cells: Indices, part: FinePart) -> tuple[Floats, Floats]:
    """Return corners and centres of body-centred cubes [m], and the size of cubes there [m].

    Args:
        low: Lowest corner of the box that they fill [m], shape (3,).
        cells: How many undivided cubes are along x, y and z, shape (3,).
        part: Where they are smaller.

    Returns:
        Shapes (site, 3) and (site,).

    Raises:
        FormatError: There are too many.
    """
    corner = np.stack(np.meshgrid(*map(np.arange, cells), indexing="ij"), axis=-1).reshape(
        -1, 3
    )
    size, found = part.cell, list[tuple[Indices, float]]()
    while len(corner):
        if len(corner) > _MOST:
            raise FormatError("the fine cells are too small: they give too many nodes")
        is_large = size > 1.001 * part.size_at(low + (corner + 0.5) * size)
        found.append((corner[~is_large], size))
        octants = np.stack(np.meshgrid(*[[0, 1]] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
        corner = (2 * corner[is_large, None] + octants).reshape(-1, 3)
        size *= 0.5
    return _numbered(low, found)


def _numbered(low: Floats, found: list[tuple[Indices, float]]) -> tuple[Floats, Floats]:
    """Return the corners of cubes of several sizes, each once, and their centres."""
    finest, corners, sizes = found[-1][1], list[Indices](), list[Floats]()
    centres: list[Floats] = []
    octants = np.stack(np.meshgrid(*[[0, 1]] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    for corner, size in found:
        step = round(size / finest)
        corners.append((step * (corner[:, None] + octants)).reshape(-1, 3))
        sizes.append(np.full(8 * len(corner), size))
        centres.append(low + (corner + 0.5) * size)
    places, number = np.unique(np.concatenate(corners), axis=0, return_inverse=True)
    smallest = np.full(len(places), np.inf)
    np.minimum.at(smallest, number.ravel(), np.concatenate(sizes))
    alone = (np.full(len(corner), size) for corner, size in found)
    sizes_there = np.concatenate([smallest, *alone])
    where = np.concatenate([low + places * finest, *centres])
    return where, sizes_there


def shaken(surface: Floats, triangles: Indices, sites: Floats, size: Floats) -> Floats:
    """Return sites that are moved a little, so that few flat tetrahedra are between them [m].

    Where cubes of two sizes meet, four sites lie nearly in a plane and on a circle, and a flat
    tetrahedron can be between them. Sites of flat ones are moved at random, again and
    again, and those of the best attempt are kept.

    Args:
        surface: Nodes that stay [m], shape (node, 3).
        triangles: Between these, shape (triangle, 3).
        sites: Nodes after them [m], shape (site, 3).
        size: Of cubes there [m], shape (site,).
    """
    random, count = np.random.default_rng(0), len(surface)
    points = np.concatenate(
        [surface, sites + size[:, None] * random.uniform(*_ALL, sites.shape)]
    )
    best, fewest = points, np.inf
    for _ in range(_ATTEMPTS):
        cells = regular_triangulation(points, triangles)
        flat = cells[(np.abs(quality(points[cells])) < _FLAT) & (cells >= count).any(axis=1)]
        if len(flat) < fewest:
            best, fewest = points.copy(), len(flat)
        moved = np.unique(flat[flat >= count]) - count
        if not len(moved):
            break
        way = random.uniform(*_SOME, (len(moved), 3))
        points[count + moved] = sites[moved] + size[moved, None] * way
    return best[count:]
