"""Which parts of neighbouring cells meet in a face, and over how much of it.

Two parts of different cells can meet in a face whose nodes have the same present numbers in
both. Connectivity follows from areas and needs no labels of fragments, so that blades through
nodes, edges and faces are no special cases.
"""

from collections.abc import Sequence

import numpy as np
from msgspec import Struct

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
            (pair, 2, 6).
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
    """Return corresponding nodes of faces of both cells, padded by -1, shape (pair, 2, 6)."""
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


def outer_faces(groups: Sequence[CellParts]) -> tuple[Bools, ...]:
    """Return which faces of the cells of parts have no neighbour as drawn, (part, face) each.

    Args:
        groups: Parts of all cells of a body, those of each shape.
    """
    return free_faces([replace(each, nodes=each.drawn) for each in groups])


def free_faces(groups: Sequence[CellParts]) -> tuple[Bools, ...]:
    """Return which faces of the cells of parts have nodes of no neighbour, (part, face) each.

    Args:
        groups: Parts of all cells of a body, those of each shape.
    """
    first, cells = offsets(groups), numbered_cells(groups)
    keys = FaceKeys.of(groups, [np.ones(len(each), dtype=bool) for each in groups])
    every: list[Indices] = []
    for each in groups:
        own = np.zeros((len(each), len(each.division.faces)), dtype=np.int64)
        for face, corners in enumerate(each.division.faces):
            ring = corners[corners >= 0]
            own[:, face] = keys.keys(np.sort(each.nodes[:, ring], axis=1), len(ring))
        every.append(own)
    # Parts of a cell have its faces, too: what counts is how many cells have one.
    key = np.concatenate([each.ravel() for each in every])
    cell = np.concatenate(
        [
            np.repeat(cells[low:high], own.shape[1])
            for own, low, high in zip(every, first[:-1], first[1:], strict=True)
        ]
    )
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
    sizes = np.cumsum([each.size for each in every])[:-1]
    return tuple(
        values.reshape(own.shape)
        for own, values in zip(every, np.split(flat, sizes), strict=True)
    )
