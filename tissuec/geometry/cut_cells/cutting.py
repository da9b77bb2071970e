"""Cuts: parts on both sides of a surface, the nodes that they get, and the faces between them.

The surface is a level: one height at each present node, linear on the roots of cells. A corner
at h ≥ 0 is in front; there is no other rule, and no tolerance. What a cell consists of on one
side is a part, with all nodes of the cell. Parts that share a part of a face are joined at all
nodes of it. The parts around a node then fall into components, each with a node of its own: the
present one where a component has matter at its place, copies in the others. (J.-H. Song,
P. Areias, T. Belytschko, Int. J. Numer. Meth. Eng. 67:868, 2006; connectivity as in Y. Wang,
C. Jiang, C. Schroeder, J. Teran, Symposium on Computer Animation 2014, but by areas of faces.)
"""

from collections.abc import Sequence

import numpy as np
from msgspec import Struct

from tissuec.core.structs import replace
from tissuec.geometry.cut_cells.clipping import Bools, ClippedSimplices, Simplices, clipped
from tissuec.geometry.cut_cells.components import node_copies
from tissuec.geometry.cut_cells.joining import PartFaces, part_faces
from tissuec.geometry.cut_cells.overlaps import offsets
from tissuec.geometry.cut_cells.parts import CellParts, PartPieces, Sides
from tissuec.geometry.cut_cells.sections import CutFacets, facing_facets
from tissuec.model.network import Floats, Indices


class DividedCells(Struct, frozen=True, eq=False):
    """What a cut makes of cells; parts of all shapes are numbered one after the other.

    Attributes:
        groups: The parts of each shape, with their new nodes. Those of one former part follow
            each other, the one behind first.
        source: The former part of each, among those of its shape, shape (part,) each.
        near: Which parts have a node of a cell that is cut, shape (part,) each.
        copied: The present node that each new node is a copy of, shape (new node,). New nodes
            have the numbers behind those of all present ones, in this order.
        joins: Faces through which near parts hold together.
        cut: Facets of the surface.
    """

    groups: tuple[CellParts, ...]
    source: tuple[Indices, ...]
    near: tuple[Bools, ...]
    copied: Indices
    joins: PartFaces
    cut: CutFacets

    def with_copies(self, values: Floats) -> Floats:
        """Return values of present nodes, and those of new nodes, shape (node + new node, …).

        Args:
            values: Of present nodes in any unit, shape (node, …).
        """
        return np.concatenate([values, values[self.copied]])


class _Division(Struct, frozen=True, eq=False):
    """Parts of one shape on both sides, still with their former nodes and sides.

    Attributes:
        parts: With sides of the former levels only.
        source: The former part of each, shape (part,).
        near: Which have a node of a cell that is cut, shape (part,).
        sign: The side of the level on which near ones are, 0 for others, shape (part,).
        side: The same of those that it divides or touches in a face, shape (part,).
        cut: Facets inside of cells, in parts of this shape.
    """

    parts: CellParts
    source: Indices
    near: Bools
    sign: Sides
    side: Sides
    cut: CutFacets


class _Crossing(Struct, frozen=True, eq=False):
    """Which parts have nodes on both sides of a surface, or on it.

    Attributes:
        touching: Whether the corners of a face or more are on the surface, shape (part,).
        sign: 1 or -1 for all corners in front or behind, else 0, shape (part,).
        divided: Whether both sides have corners, shape (part,).
    """

    touching: Bools
    sign: Sides
    divided: Bools

    @classmethod
    def of(
        cls, parts: CellParts, heights: Floats, near: Floats, active: Bools | None
    ) -> "_Crossing":
        corners = parts.nodes[:, : len(parts.division.corners)].T  # sums of rows are fast
        exact = heights[corners]
        own = np.where(np.abs(exact) < near[corners], 0.0, exact)
        # Comparisons with NaN are false: such a cell is on neither side.
        front, behind, on = own >= 0.0, own < 0.0, own == 0.0
        ahead, back = front.all(axis=0), behind.all(axis=0)
        # What is thinner than heights that count as 0 is on the side of its middle.
        flat = on.all(axis=0) & (exact.sum(axis=0) < 0.0)
        ahead, back = ahead & ~flat, back | flat
        # The pieces of a part may be on the other side than corners that are far from them.
        unsure = ~parts.are_whole & (exact >= 0.0).any(axis=0) & (exact < 0.0).any(axis=0)
        ahead, back = ahead & ~unsure, back & ~unsure
        divided = (front | behind).all(axis=0) & ~ahead & ~back
        if active is not None:
            ahead, back, divided = ahead & active, back & active, divided & active
        sign = ahead.astype(np.int8) - back.astype(np.int8)
        return cls(on.sum(axis=0) >= parts.division.dimension, sign, divided)


def cut(
    groups: Sequence[CellParts],
    heights: Floats,
    active: Sequence[Bools] | None = None,
    near: Floats | None = None,
) -> DividedCells:
    """Return cells divided by a surface.

    Args:
        groups: Parts of all cells around it, those of each shape; cells of a shape have
            different numbers.
        heights: Of present nodes above the surface [m], NaN where it does not divide cells,
            shape (node,).
        active: Which parts it divides if it crosses them, shape (part,) each; all by default.
        near: Heights that count as 0 [m], shape (node,); see ``near_heights``. 0 by default.
    """
    near = np.zeros(len(heights)) if near is None else near
    masks = [None] * len(groups) if active is None else active
    crossings = [
        _Crossing.of(each, heights, near, own) for each, own in zip(groups, masks, strict=True)
    ]
    marked = np.zeros(len(heights), dtype=bool)
    for each, crossing in zip(groups, crossings, strict=True):
        marked[each.nodes[crossing.divided]] = True
    divisions = [
        _division(each, crossing, marked, heights, near)
        for each, crossing in zip(groups, crossings, strict=True)
    ]
    source = np.concatenate(
        [own.source + k for own, k in zip(divisions, offsets(groups)[:-1], strict=True)]
    )
    return _joined(divisions, source, heights, marked)


def parted(groups: Sequence[CellParts], sides: Sequence[Sides], count: int) -> DividedCells:
    """Return cells parted along the faces between two kinds of them; none is divided.

    Where cells of other kinds hold both together, at the rim of such faces, they stay so. Those
    in front keep the present nodes.

    Args:
        groups: Parts of all cells, those of each shape.
        sides: 1 of the kind in front, -1 of the one behind, 0 of others, shape (part,) each.
        count: Of present nodes.
    """
    beside = np.zeros((2, count), dtype=bool)
    for each, side in zip(groups, sides, strict=True):
        for k, own in enumerate((side > 0, side < 0)):
            beside[k, each.nodes[own]] = True
    marked = beside.all(axis=0)
    near = [marked[each.nodes].any(axis=1) for each in groups]
    signs = [
        np.where(own, side, 0).astype(np.int8) for own, side in zip(near, sides, strict=True)
    ]
    first, sign = offsets(groups), np.concatenate(signs)
    faces = part_faces(groups, near)
    meets = np.zeros(first[-1], dtype=bool)
    meets[faces.parts[sign[faces.parts].prod(axis=1) < 0]] = True
    divisions = [
        _Division(
            _with_another_level(each), np.arange(len(each)), own, one,
            np.where(meets[low:high], one, 0).astype(np.int8), CutFacets.none(each.division),
        )
        for each, own, one, low, high in zip(
            groups, near, signs, first[:-1], first[1:], strict=True
        )
    ]  # fmt: skip
    return _joined(divisions, np.arange(first[-1]), np.zeros(count), marked)


def _joined(
    divisions: Sequence[_Division], source: Indices, heights: Floats, marked: Bools
) -> DividedCells:
    """Return parts with the nodes at which they hold together.

    Args:
        divisions: Those of each shape.
        source: Former part of each of all parts, shape (part,).
        heights: Of present nodes [m], shape (node,).
        marked: Nodes of cells that are cut, shape (node,).
    """
    former = [each.parts for each in divisions]
    first = offsets(former)
    sign = np.concatenate([each.sign for each in divisions])
    faces = part_faces(former, [each.near for each in divisions])
    opposed = sign[faces.parts[:, 0]] * sign[faces.parts[:, 1]] < 0
    copies = node_copies(former, faces[~opposed], faces[opposed], source, sign, heights, marked)
    inside = [each.cut.shifted(int(k)) for each, k in zip(divisions, first[:-1], strict=True)]
    between = facing_facets(former, faces[opposed], sign)
    return DividedCells(
        tuple(map(_finished, divisions, copies.nodes)),
        tuple(each.source for each in divisions),
        tuple(each.near for each in divisions),
        copies.copied, faces[~opposed], CutFacets.together([*inside, between]),
    )  # fmt: skip


def near_heights(groups: Sequence[CellParts], position: Floats, part: float = 1e-4) -> Floats:
    """Return heights that count as 0, so that no sliver is thinner [m], shape (node,).

    Without them, a blade that grazes nodes cuts off skins whose faces are too small to hold
    together. They are far above the root of ``joining.LEAST_SHARED``, of a length.

    Args:
        groups: Parts of cells, those of each shape.
        position: Of the present nodes [m], shape (node, 3).
        part: Of the length of the shortest edge at each node.
    """
    found = np.full(len(position), np.inf)
    for each in groups:
        ends = each.division.edges
        place = position[each.nodes[:, : len(each.division.corners)]]
        length = np.linalg.norm(place[:, ends[:, 0]] - place[:, ends[:, 1]], axis=2)
        for k in range(2):
            np.minimum.at(found, each.nodes[:, ends[:, k]], length)
    return np.where(np.isfinite(found), part * found, 0.0)


def _division(
    parts: CellParts, crossing: _Crossing, marked: Bools, heights: Floats, near: Floats
) -> _Division:
    """Return parts of one shape on both sides; see ``_Division``."""
    close = np.zeros(len(parts), dtype=bool)
    for column in parts.nodes.T:
        close |= marked[column]
    whole = parts.with_roots(crossing.divided)
    pieces = replace(whole, inside=_with_level(whole.inside))
    high = pieces.heights(parts.nodes, heights)
    flat_side = np.where(high.sum(axis=1) >= 0.0, 1, -1)
    high = np.where(np.abs(high) < pieces.heights(parts.nodes, near), 0.0, high)
    found = clipped(pieces.inside, high, flat_side)
    part = pieces.part[found.source]
    there = np.zeros((len(parts), 2), dtype=bool)
    there[part, (found.side + 1) // 2] = True
    # Nothing else is left of a cell that the surface only touches.
    there[~crossing.divided, 0] = True
    source, _ = np.nonzero(there)
    number = np.cumsum(there.ravel()).reshape(-1, 2) - 1
    both: Bools = there[:, 0] & there[:, 1]
    sign = crossing.sign.copy()
    only = crossing.divided & ~both
    sign[only] = np.where(there[only, 1], 1, -1)
    new_sign = sign[source]
    new_sign[number[both]] = [-1, 1]
    new_sign[~close[source]] = 0
    has_side = (crossing.divided | crossing.touching)[source]
    halves = number[part, (found.side + 1) // 2]
    own = np.flatnonzero(both[part])
    own = own[np.argsort(halves[own], kind="stable")]
    mine = PartPieces(halves[own], pieces.roots[found.source[own]], found.inside[own])
    kept = parts.pieces[~both[parts.pieces.part]]
    kept = PartPieces(number[kept.part].max(axis=1), kept.roots, _with_level(kept.inside))
    new = CellParts(
        parts.shape, parts.cell[source], parts.nodes[source], parts.drawn[source],
        parts.sides[source], PartPieces.together([kept, mine]),
    )  # fmt: skip
    inside = _cut_inside(parts, pieces, found, number, both)
    side = np.where(has_side, new_sign, 0).astype(np.int8)
    return _Division(new, source, close[source], new_sign, side, inside)


def _with_another_level(parts: CellParts) -> CellParts:
    """Return parts whose pieces have another level, on which nothing is."""
    inside = _with_level(parts.pieces.inside)
    return replace(parts, pieces=replace(parts.pieces, inside=inside))


def _with_level(inside: Simplices) -> Simplices:
    """Return simplices with another level, on which no corner is yet."""
    none = np.zeros((*inside.on.shape[:2], 1), dtype=bool)
    return replace(inside, on=np.concatenate([inside.on, none], axis=2))


def _cut_inside(
    parts: CellParts, pieces: PartPieces, found: ClippedSimplices, number: Indices, both: Bools
) -> CutFacets:
    """Return facets of the cut inside of cells that have matter on both sides."""
    part, roots = pieces.part[found.cut], pieces.roots[found.cut]
    # A face of a cell is found from both cells.
    bits = 1 << roots
    in_face = parts.division.face_of[bits.sum(axis=1, keepdims=True) - bits] >= 0
    outer = ((found.facets == 0.0).all(axis=1) & in_face).any(axis=1)
    keeps = np.flatnonzero(both[part] & ~outer & ~found.is_known)
    pair = number[part[keeps]][:, ::-1]
    return CutFacets(
        pair, np.repeat(roots[keeps, None], 2, axis=1),
        np.repeat(found.facets[keeps, None], 2, axis=1),
    )  # fmt: skip


def _finished(division: _Division, nodes: Indices) -> CellParts:
    """Return parts with their new nodes and the sides of the new level."""
    sides = np.concatenate([division.parts.sides, division.side[:, None]], axis=1)
    return replace(division.parts, nodes=nodes, sides=sides)
