"""Which parts of neighbouring cells meet in a face, and over how much of it.

Two parts of different cells can meet in a face whose nodes have the same present numbers in
both. Connectivity follows from areas and needs no labels of fragments, so that blades through
nodes, edges and faces are no special cases.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.structs import replace
from tissuec.geometry.cut_cells.clipping import Bools
from tissuec.geometry.cut_cells.overlaps import (
    FaceKeys,
    Overlaps,
    numbered_cells,
    offsets,
    overlaps,
    pairs_of_equal,
)
from tissuec.geometry.cut_cells.parts import CellParts
from tissuec.geometry.cut_cells.roots import MOST_ON_FACE
from tissuec.model.network import Floats, Indices

#: Of the area or length of a face: parts that share less do not hold together there.
LEAST_SHARED = 1e-12
_LAST = np.iinfo(np.int64).max


class PartFaces(Struct, frozen=True, eq=False):
    """Pairs of parts that meet in a face. Parts of all shapes are numbered one after the other.

    Attributes:
        parts: Shape (pair, 2), the lower first.
        faces: Of their cells, in the order of ``roots.DIVISIONS``, shape (pair, 2).
        fraction: Of the face that both have, in natural coordinates, shape (pair,).
        nodes: Of the face among those of both cells, corresponding ones, padded by -1, shape
            (pair, 2, 9).
    """

    parts: Indices
    faces: Indices
    fraction: Floats
    nodes: Indices

    def __len__(self) -> int:
        return len(self.parts)

    def __getitem__(self, items: Indices | Bools) -> "PartFaces":
        return PartFaces(
            self.parts[items], self.faces[items], self.fraction[items], self.nodes[items]
        )


def part_faces(groups: Sequence[CellParts], chosen: Sequence[Bools] | None = None) -> PartFaces:
    """Return which parts share a part of a face, wherever sides of levels are the same or 0.

    Args:
        groups: Parts of cells, those of each shape.
        chosen: Which of them count, shape (part,) each; all by default.
    """
    chosen = [np.ones(len(each), dtype=bool) for each in groups] if chosen is None else chosen
    whole = _whole_pairs(groups, chosen)
    pairs, faces, fraction = _summed(overlaps(groups, chosen, alone=False))
    are_whole = np.concatenate([each.are_whole for each in groups])
    keeps = (fraction > LEAST_SHARED) & ~are_whole[pairs].all(axis=1)
    parts = np.concatenate([whole[0], pairs[keeps]])
    faces = np.concatenate([whole[1], faces[keeps]])
    fraction = np.concatenate([np.ones(len(whole[0])), fraction[keeps]])
    fits = sides_fit(groups, parts)
    parts, faces, fraction = parts[fits], faces[fits], fraction[fits]
    return PartFaces(parts, faces, fraction, _face_nodes(groups, parts, faces))


def sides_fit(groups: Sequence[CellParts], parts: Indices) -> Bools:
    """Return which pairs of parts are on different sides of no level, shape (pair,).

    Args:
        groups: Parts of cells, those of each shape.
        parts: Numbers among all of them, shape (pair, 2).
    """
    sides = np.concatenate([each.sides for each in groups])
    return np.asarray((sides[parts[:, 0]] * sides[parts[:, 1]] >= 0).all(axis=1))


def _whole_pairs(
    groups: Sequence[CellParts], chosen: Sequence[Bools]
) -> tuple[Indices, Indices]:
    """Return pairs of whole parts with a common face, and its number in both."""
    numbers, first = FaceKeys.of(groups, chosen), offsets(groups)
    keys, parts, faces = (
        [np.zeros(0, np.int64)],
        [np.zeros(0, np.int64)],
        [np.zeros(0, np.int64)],
    )
    for k, each in enumerate(groups):
        part = np.flatnonzero(chosen[k] & each.are_whole)
        for face, corners in enumerate(each.division.faces):
            own = np.sort(each.nodes[part][:, corners[corners >= 0]], axis=1)
            keys.append(numbers.keys(own, own.shape[1]))
            parts.append(first[k] + part)
            faces.append(np.full(len(part), face))
    part, face = np.concatenate(parts), np.concatenate(faces)
    found = [np.zeros((2, 0), dtype=np.int64)]
    found += [np.stack(pair) for pair in pairs_of_equal(np.concatenate(keys))]
    pair = np.concatenate(found, axis=1).T
    cell = numbered_cells(groups)[part]
    pair = pair[cell[pair[:, 0]] != cell[pair[:, 1]]]
    pair = np.take_along_axis(pair, np.argsort(part[pair], axis=1), axis=1)
    return part[pair], face[pair]


def _summed(found: Overlaps) -> tuple[Indices, Indices, Floats]:
    """Return pairs of parts and faces, each once, and what they have in common."""
    if not len(found.parts):
        return found.parts, found.faces, found.fraction
    one, other = (found.parts * 8 + found.faces).T
    order = np.lexsort((other, one))
    one, other = one[order], other[order]
    starts = np.flatnonzero(
        np.concatenate([[True], (one[1:] != one[:-1]) | (other[1:] != other[:-1])])
    )
    first = order[starts]
    return (
        found.parts[first],
        found.faces[first],
        np.add.reduceat(found.fraction[order], starts),
    )


def _face_nodes(groups: Sequence[CellParts], parts: Indices, faces: Indices) -> Indices:
    """Return corresponding nodes of faces of both cells, padded by -1, shape (pair, 2, 9)."""
    found = np.full((*parts.shape, MOST_ON_FACE), -1)
    for k, (low, high) in enumerate(
        zip(offsets(groups)[:-1], offsets(groups)[1:], strict=True)
    ):
        pair, end = np.nonzero((parts >= low) & (parts < high))
        own = groups[k].division.face_nodes[faces[pair, end]]
        drawn = groups[k].drawn[parts[pair, end][:, None] - low, own]
        order = np.argsort(np.where(own >= 0, drawn, _LAST), axis=1)
        found[pair, end] = np.take_along_axis(own, order, axis=1)
    return found


def free_faces(groups: Sequence[CellParts]) -> tuple[Bools, ...]:
    """Return which faces of the cells of parts have nodes of no neighbour, (part, face) each.

    Args:
        groups: Parts of all cells of a body, those of each shape.
    """
    key = _keys(groups)
    # Parts of a cell have its faces, too: what counts is how many cells have one.
    cell = _by_face(groups, numbered_cells(groups))
    order = np.lexsort((cell, key))
    key, cell = key[order], cell[order]
    starts = np.ones(len(key), dtype=bool)
    starts[1:] = key[1:] != key[:-1]
    changes = np.zeros(len(key), dtype=bool)
    changes[1:] = ~starts[1:] & (cell[1:] != cell[:-1])
    face = np.cumsum(starts) - 1
    alone = np.bincount(face, changes) == 0.0
    flat = np.zeros(len(key), dtype=bool)
    flat[order] = alone[face]
    return _split(groups, flat)


def parting_levels(groups: Sequence[CellParts]) -> tuple[Indices, ...]:
    """Return the level that parts the cells on both sides of faces, shape (part, face) each.

    Of several, it is one that is alone between a part and some part on the other side; -1 where
    there is none.

    Args:
        groups: Parts of all cells of a body, those of each shape.
    """
    key = _keys([replace(each, nodes=each.drawn) for each in groups])
    sides = np.concatenate([each.sides for each in groups])
    cell, part = (
        _by_face(groups, each) for each in (numbered_cells(groups), np.arange(len(sides)))
    )
    found, least = np.full((2, len(key)), [[-1], [sides.shape[1] + 1]])
    some = np.flatnonzero(sides.any(axis=1)[part])
    for pair in pairs_of_equal(key[some]):
        first, second = (some[each] for each in pair)
        apart = cell[first] != cell[second]
        first, second = first[apart], second[apart]
        opposed = sides[part[first]] * sides[part[second]] < 0
        count = opposed.sum(axis=1)
        for own in (first, second):
            better = (count > 0) & (count < least[own])
            found[own[better]] = opposed[better].argmax(axis=1)
            least[own[better]] = count[better]
    return _split(groups, found)


def _keys(groups: Sequence[CellParts]) -> Indices:
    """Return keys of the faces of all parts by their nodes, flat, shape (face,)."""
    keys = FaceKeys.of(groups, [np.ones(len(each), dtype=bool) for each in groups])
    every: list[Indices] = []
    for each in groups:
        own = np.zeros((len(each), len(each.division.faces)), dtype=np.int64)
        for face, corners in enumerate(each.division.faces):
            ring = corners[corners >= 0]
            own[:, face] = keys.keys(np.sort(each.nodes[:, ring], axis=1), len(ring))
        every.append(own.ravel())
    return np.concatenate(every)


def _by_face(groups: Sequence[CellParts], values: Indices) -> Indices:
    """Return values of parts at each of their faces, flat, shape (face,)."""
    count = np.concatenate([np.full(len(each), len(each.division.faces)) for each in groups])
    return np.repeat(values, count)


def _split(groups: Sequence[CellParts], values: NDArray[Any]) -> tuple[NDArray[Any], ...]:
    """Return flat values of faces, shape by shape, shape (part, face) each."""
    shapes = [(len(each), len(each.division.faces)) for each in groups]
    parts = np.split(values, np.cumsum([rows * columns for rows, columns in shapes])[:-1])
    return tuple(own.reshape(shape) for own, shape in zip(parts, shapes, strict=True))
