"""Overlaps of parts of neighbouring cells: polygons in faces, or lines in edges.

The faces of their pieces there are simplices in the same roots of the face: triangles, or lines
in edges of triangles. Mostly, they are the same; what is left over, as where a divided cell
meets a whole one, is intersected by pairs (I. E. Sutherland, G. W. Hodgman, Commun. ACM 17:32,
1974).
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from msgspec import Struct

from tissuec.geometry.cut_cells.clipping import Bools
from tissuec.geometry.cut_cells.parts import OTHERS, CellParts, PieceFaces
from tissuec.geometry.cut_cells.roots import fans
from tissuec.model.network import Floats, Indices

_LAST = np.iinfo(np.int64).max


class Overlaps(Struct, frozen=True, eq=False):
    """Polygons, or lines, that simplices of two parts in a face have in common.

    Attributes:
        parts, faces: Of both, shape (polygon, 2).
        fraction: Of the face, in natural coordinates, shape (polygon,).
        shares: Of the corners of the root of the face, which are in the order of their drawn
            numbers, of corners of the polygon; the last one is repeated. Shape
            (polygon, corner, corner of the root).
        roots: The corners of the root of the face in both cells, shape
            (polygon, 2, corner of the root).
    """

    parts: Indices
    faces: Indices
    fraction: Floats
    shares: Floats
    roots: Indices


def overlaps(
    groups: Sequence[CellParts], chosen: Sequence[Bools], alone: bool = True
) -> Overlaps:
    """Return the overlaps of faces of different cells.

    Args:
        groups: Parts of cells, those of each shape.
        chosen: Which of them count, shape (part,) each.
        alone: Whether this includes whole parts far from those that are not whole.
    """
    some = _simplices(groups, chosen, alone)
    cell = numbered_cells(groups)[some.part]
    one, other, left = _matched(some, cell)
    found: list[tuple[Indices, Indices, Floats]] = [(one, other, some.shares[one])]
    for first, second in pairs_of_equal(some.root[left]):
        first, second = left[first], left[second]
        apart = cell[first] != cell[second]
        first, second = first[apart], second[apart]
        found.append((first, second, _intersections(some.shares[first], some.shares[second])))
    count = max(shares.shape[1] for *_, shares in found)
    shares = np.concatenate(
        [
            np.concatenate([own, np.repeat(own[:, -1:], count - own.shape[1], axis=1)], axis=1)
            for *_, own in found
        ]
    )
    ends = [
        np.concatenate([each[0] for each in found]),
        np.concatenate([each[1] for each in found]),
    ]
    pair = np.stack(ends, axis=1)
    pair = np.take_along_axis(pair, np.argsort(some.part[pair], axis=1), axis=1)
    fraction = np.abs(turned_areas(shares)) * some.ratio[pair[:, 0]]
    return Overlaps(some.part[pair], some.face[pair], fraction, shares, some.corners[pair])


def offsets(groups: Sequence[CellParts]) -> Indices:
    """Return the number of the first part of each shape among all, shape (shape + 1,)."""
    return np.concatenate([[0], np.cumsum([len(each) for each in groups])])


def numbered_cells(groups: Sequence[CellParts]) -> Indices:
    """Return the cell of each part, numbered for all shapes together, shape (part,).

    Args:
        groups: Parts of cells, those of each shape.
    """
    return np.concatenate([len(groups) * each.cell + k for k, each in enumerate(groups)])


def pairs_of_equal(keys: Indices) -> Iterator[tuple[Indices, Indices]]:
    """Yield all pairs of equal keys, two arrays of shape (pair,) at a time.

    Args:
        keys: Shape (key,).
    """
    order = np.argsort(keys, kind="stable")
    ascending = keys[order]
    for step in range(1, len(keys)):
        same = np.flatnonzero(ascending[step:] == ascending[:-step])
        if not len(same):
            return
        yield order[same], order[same + step]


class FaceKeys(NamedTuple):
    """Numbers of faces by their nodes.

    Attributes:
        number: Of each node among those that count, shape (node,).
        total: Of these.
    """

    number: Indices
    total: int

    @classmethod
    def of(cls, groups: Sequence[CellParts], chosen: Sequence[Bools]) -> "FaceKeys":
        """Return keys for the faces of some parts.

        Args:
            groups: Parts of cells, those of each shape.
            chosen: Which of them count, shape (part,) each.

        Raises:
            ValueError: There are so many nodes, some million, that keys would not be unique.
        """
        size = 1 + max(int(each.nodes.max(initial=0)) for each in groups)
        counts = np.zeros(size, dtype=bool)
        for each, own in zip(groups, chosen, strict=True):
            counts[each.nodes[own]] = True
        number = np.cumsum(counts)
        count = int(number[-1]) + 1
        if 2 * count**3 > _LAST:
            raise ValueError(f"{count} nodes are too many for keys of faces")
        return cls(number, count)

    def keys(self, nodes: Indices, corners: int | Indices) -> Indices:
        """Return a key for two or three nodes in a face with so many corners, shape (…)."""
        one = self.number[nodes]
        every = one[..., 0]
        for k in range(1, min(3, int(one.shape[-1]))):
            every = every * self.total + one[..., k]
        return 2 * every + (corners == 4)


class _Simplices(NamedTuple):
    """Triangles in faces of cells, or lines in edges.

    Attributes:
        root: Number of the root of the face, the same in both cells, shape (simplex,).
        part, face: That each belongs to, shape (simplex,).
        shares: Of the corners of the root in each corner, shape (simplex, corner, corner).
        corners: Of the root among the nodes of the cell, shape (simplex, corner).
        ratio: Of the root to the face, by natural coordinates, shape (simplex,).
    """

    root: Indices
    part: Indices
    face: Indices
    shares: Floats
    corners: Indices
    ratio: Floats


def _simplices(groups: Sequence[CellParts], chosen: Sequence[Bools], alone: bool) -> _Simplices:
    """Return the simplices of parts in faces of their cells.

    Args:
        groups: Parts of cells, those of each shape.
        chosen: Which of them count, shape (part,) each.
        alone: Whether whole ones count that touch no part that is not whole.
    """
    keys = FaceKeys.of(groups, chosen)
    touched = np.full(len(keys.number), alone)
    found: list[_Simplices] = []
    for each, own, first in zip(groups, chosen, offsets(groups)[:-1], strict=True):
        touched[each.nodes[own & ~each.are_whole]] = True
        found.append(_of_pieces(each, own, int(first), keys))
    for each, own, first in zip(groups, chosen, offsets(groups)[:-1], strict=True):
        whole = np.flatnonzero(own & each.are_whole)
        found += _of_whole(each, whole, int(first), keys, touched)
    return _Simplices(*(np.concatenate(column) for column in zip(*found, strict=True)))


def _of_pieces(parts: CellParts, chosen: Bools, first: int, keys: FaceKeys) -> _Simplices:
    """Return simplices of pieces of parts; the first part has a number among all."""
    pieces = parts.own_pieces(chosen)
    faces = PieceFaces.of(parts.shape, pieces, levels=False)
    own, others = faces.piece, OTHERS[parts.division.dimension + 1][faces.across]
    rows = pieces.inside.shares[own[:, None], faces.corners]
    shares = np.take_along_axis(rows, others[:, None, :], axis=2)
    corners = np.take_along_axis(pieces.roots[own], others, axis=1)
    part = pieces.part[own]
    count = parts.division.whole_faces[faces.face]
    root = keys.keys(parts.nodes[part[:, None], corners], count)
    return _Simplices(root, first + part, faces.face, shares, corners, _share_of_roots(count))


def _of_whole(
    parts: CellParts, whole: Indices, first: int, keys: FaceKeys, touched: Bools
) -> list[_Simplices]:
    """Return simplices of whole parts, of shape (part,), in faces with touched nodes only."""
    found: list[_Simplices] = []
    count = len(parts.division.corners)
    is_touched = touched[parts.nodes[whole, :count]]
    for face, padded in enumerate(parts.division.faces):
        ring = padded[padded >= 0]
        part = whole[is_touched[:, ring].all(axis=1)]
        drawn = parts.drawn[part, :count]
        rings = np.broadcast_to(ring, (len(part), 1, len(ring)))
        corners = fans(rings, drawn[:, None])
        own = np.repeat(part, corners.shape[1])
        corners = corners.reshape(-1, corners.shape[2])
        order = np.argsort(parts.drawn[own[:, None], corners], axis=1)
        corners = np.take_along_axis(corners, order, axis=1)
        root = keys.keys(parts.nodes[own[:, None], corners], len(ring))
        size = int(corners.shape[1])
        shares = np.broadcast_to(np.eye(size), (len(own), size, size))
        ratio = np.full(len(own), _share_of_roots(np.array(len(ring))))
        found.append(
            _Simplices(root, first + own, np.full(len(own), face), shares, corners, ratio)
        )
    return found


def _share_of_roots(corners: Indices) -> Floats:
    """Return the ratio of a root to a face with a number of corners."""
    return 1.0 / np.maximum(corners - 2, 1)


def _matched(some: _Simplices, cell: Indices) -> tuple[Indices, Indices, Indices]:
    """Return pairs of simplices that are the same in two cells, and those without another."""
    size = int(some.shares.shape[1])
    place = some.shares[..., 0] * 0.7548776662466927
    if size > 2:
        place = place + some.shares[..., 1] * 0.5698402909980532
    corner = np.sort(place, axis=1)
    weights = np.array([1.0, 1.3247179572447458, 1.7548776662466927])[:size]
    order = np.lexsort((corner @ weights, some.root))
    key, at = some.root[order], corner[order]
    same = (key[1:] == key[:-1]) & (at[1:] == at[:-1]).all(axis=1)
    same &= cell[order[1:]] != cell[order[:-1]]
    one, other = order[:-1][same], order[1:][same]
    left = np.ones(len(order), dtype=bool)
    left[one] = left[other] = False
    return one, other, np.flatnonzero(left)


def turned_areas(shares: Floats) -> Floats:
    """Return areas of polygons over that of the root of their face, shape (polygon,).

    They are positive if a polygon turns as the root does. Of lines, it is their length.

    Args:
        shares: Of the corners of the root, dimensionless, shape
            (polygon, corner, corner of the root).
    """
    x, y = shares[..., 0], shares[..., 1]
    if shares.shape[2] == 2:
        return x[:, 0] - x[:, 1]
    x, y = x - x[:, :1], y - y[:, :1]
    return (x[:, 1:-1] * y[:, 2:] - x[:, 2:] * y[:, 1:-1]).sum(axis=1)


def _intersections(first: Floats, second: Floats) -> Floats:
    """Return the intersections of pairs of simplices, shape (pair, corner, corner of the root).

    Corners of polygons with fewer are repeated; those of empty ones are all the same.

    Args:
        first, second: Shares of corners, dimensionless, shape (pair, corner, corner).
    """
    if first.shape[1] == 2:
        one, other = np.sort(first[..., 0], axis=1), np.sort(second[..., 0], axis=1)
        low, high = np.maximum(one[:, 0], other[:, 0]), np.minimum(one[:, 1], other[:, 1])
        ends = np.stack([np.maximum(low, high), low], axis=1)
        return np.stack([ends, 1.0 - ends], axis=2)
    polygon: Floats = first
    count: Indices = np.full(len(first), 3)
    turn = np.sign(np.linalg.det(second))
    for k in range(3):
        a, b = second[:, k, :2], second[:, (k + 1) % 3, :2]
        way, from_a = (b - a)[:, None], polygon[..., :2] - a[:, None]
        height = turn[:, None] * (way[..., 0] * from_a[..., 1] - way[..., 1] * from_a[..., 0])
        polygon, count = _cut_off(polygon, count, height)
    return polygon


def _cut_off(polygon: Floats, count: Indices, height: Floats) -> tuple[Floats, Indices]:
    """Return convex polygons without negative heights, and their numbers of corners."""
    places = np.arange(int(polygon.shape[1]))
    is_own = places < count[:, None]
    after = np.where(places + 1 < count[:, None], places + 1, 0)
    row = np.arange(len(polygon))[:, None]
    next_height = height[row, after]
    inside = is_own & (height >= 0.0)
    crosses = is_own & ((height >= 0.0) != (next_height >= 0.0))
    part = height / np.where(crosses, height - next_height, 1.0)
    met = polygon + part[..., None] * (polygon[row, after] - polygon)
    both = np.stack([polygon, met], axis=2).reshape(len(polygon), 2 * len(places), 3)
    keeps = np.stack([inside, crosses], axis=2).reshape(len(polygon), 2 * len(places))
    found = keeps.sum(axis=1)
    most = max(int(found.max(initial=0)), 1)
    order = np.argsort(~keeps, axis=1, kind="stable")[:, :most]
    order = order[row, np.minimum(np.arange(most), np.maximum(found - 1, 0)[:, None])]
    return np.take_along_axis(both, order[..., None], axis=1), found
