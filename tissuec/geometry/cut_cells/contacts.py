"""Slots of parts at nodes, and where cells touch in edges and nodes alone, as voxels do."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from msgspec import Struct

from tissuec.core.arrays import distinct
from tissuec.geometry.cut_cells.clipping import Bools
from tissuec.geometry.cut_cells.joining import PartFaces, sides_fit
from tissuec.geometry.cut_cells.overlaps import offsets, pairs_of_equal
from tissuec.geometry.cut_cells.parts import CellParts, Sides
from tissuec.model.network import Floats, Indices


class SlotTable(Struct, frozen=True, eq=False):
    """Slots: nodes of parts that are near a cut.

    Attributes:
        start: The first slot of each of all parts, -1 if it is not near, shape (part,).
        part: Of each slot, shape (slot,).
        local: Number of its node among those of the part, shape (slot,).
        node: Its present node, shape (slot,).
        fraction: Of the volume of its cell that its part has, shape (slot,).
    """

    start: Indices
    part: Indices
    local: Indices
    node: Indices
    fraction: Floats

    def __len__(self) -> int:
        return len(self.part)

    @classmethod
    def of(cls, groups: Sequence[CellParts], marked: Bools) -> "SlotTable":
        """Return the slots of all parts that have a marked node, a mask of shape (node,)."""
        starts: list[Indices] = []
        parts: list[Indices] = []
        locals_: list[Indices] = []
        nodes: list[Indices] = []
        fractions: list[Floats] = []
        count = 0
        for each, first in zip(groups, offsets(groups)[:-1], strict=True):
            near = np.flatnonzero(marked[each.nodes].any(axis=1))
            width = int(each.nodes.shape[1])
            start = np.full(len(each), -1)
            start[near] = count + width * np.arange(len(near))
            starts.append(start)
            count += width * len(near)
            parts.append(np.repeat(first + near, width))
            locals_.append(np.tile(np.arange(width), len(near)))
            nodes.append(each.nodes[near].ravel())
            fractions.append(np.repeat(each.fractions[near], width))
        return cls(
            np.concatenate(starts), np.concatenate(parts), np.concatenate(locals_),
            np.concatenate(nodes), np.concatenate(fractions),
        )  # fmt: skip

    def paired(self, faces: PartFaces) -> Indices:
        """Return the slots that faces join, shape (pair, 2)."""
        slots = self.start[faces.parts][..., None] + faces.nodes
        return slots.swapaxes(1, 2)[(faces.nodes >= 0).all(axis=1)]

    def divided(self, source: Indices) -> Indices:
        """Return the slots of parts with the same source, shape (pair, 2).

        Args:
            source: Former part of each, ascending, shape (part,).
        """
        after = np.flatnonzero((source[1:] == source[:-1]) & (self.start[1:] >= 0))
        width = self.start[after + 1] - self.start[after]
        slots = np.arange(len(self))
        own = np.zeros(len(self.start) + 1, dtype=np.int64)
        own[after] = width
        step = own[self.part]
        return np.stack([slots, slots + step], axis=1)[step > 0]

    def renumbered(self, groups: Sequence[CellParts], number: Indices) -> tuple[Indices, ...]:
        """Return the nodes of parts, shape (part, node) each.

        Args:
            groups: Parts of cells, those of each shape.
            number: Of the node of each slot, shape (slot,).
        """
        found: list[Indices] = []
        for each, first in zip(groups, offsets(groups)[:-1], strict=True):
            nodes = each.nodes.copy()
            own = np.flatnonzero((self.part >= first) & (self.part < first + len(each)))
            nodes[self.part[own] - first, self.local[own]] = number[own]
            found.append(nodes)
        return tuple(found)


class Contacts(Struct, frozen=True, eq=False):
    """Where parts touch.

    Attributes:
        slots: Of both at a node, shape (pair, 2).
        number: Of the contact, the same at all nodes of an edge, shape (pair,).
    """

    slots: Indices
    number: Indices

    def __getitem__(self, items: Indices | Bools) -> "Contacts":
        return Contacts(self.slots[items], self.number[items])


def contacts(
    groups: Sequence[CellParts], table: SlotTable, special: Bools, sign: Sides
) -> Contacts:
    """Return pairs of slots at a node where parts touch.

    Two parts touch at a node if both have matter at its place, and at the nodes of an edge if
    both have matter along the same part of it.

    Args:
        groups: Parts of cells, those of each shape.
        table: Slots of the parts near a cut.
        special: Nodes of which parts count, shape (node,).
        sign: The side of a level on which each part is, or 0, shape (part,).
    """
    edges: list[_PartEdges] = []
    for each, first in zip(groups, offsets(groups)[:-1], strict=True):
        start = table.start[first : first + len(each)]
        chosen = np.flatnonzero(special[each.nodes].any(axis=1) & (start >= 0))
        edges.append(_PartEdges.of(each, chosen, start[chosen]))
    every = _PartEdges(*(np.concatenate(column) for column in zip(*edges, strict=True)))
    found = every.touching(table, special)
    parts = table.part[found.slots]
    fits = sides_fit(groups, parts) & (sign[parts[:, 0]] * sign[parts[:, 1]] >= 0)
    return found[fits]


class _PartEdges(NamedTuple):
    """Edges of parts.

    Attributes:
        slots: Of both ends, that of the lower drawn node first, and of the middle; -1 if there
            is none. Shape (edge, 3).
        low, high: From where to where a part has matter, from 0 to 1, shape (edge,).
    """

    slots: Indices
    low: Floats
    high: Floats

    @classmethod
    def of(cls, parts: CellParts, chosen: Indices, start: Indices) -> "_PartEdges":
        """Return those of chosen parts, of shape (part,), with their first slots."""
        edges = parts.division.edges
        drawn = parts.drawn[chosen][:, edges]
        upward = drawn[..., 0] < drawn[..., 1]
        ends = np.where(upward[..., None], edges, edges[:, ::-1])
        middle = np.full((*upward.shape, 1), -1)
        if parts.nodes.shape[1] > len(parts.division.corners):
            numbers = len(parts.division.corners) + np.arange(len(edges))
            middle[..., 0] = start[:, None] + numbers
        slots = np.concatenate([start[:, None, None] + ends, middle], axis=2)
        low, high = _extents(parts, chosen, ends)
        return cls(slots.reshape(-1, 3), low.ravel(), high.ravel())

    def touching(self, table: SlotTable, special: Bools) -> Contacts:
        """Return where edges overlap, and where both of two parts have matter at a node."""
        found, numbers = [np.zeros((0, 2), dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
        ends = np.sort(table.node[self.slots[:, :2]], axis=1)
        count = 0
        for one, other in pairs_of_equal(ends[:, 0] * len(special) + ends[:, 1]):
            high = np.minimum(self.high[one], self.high[other])
            overlap = np.flatnonzero(high > np.maximum(self.low[one], self.low[other]))
            pair = np.stack([self.slots[one[overlap]], self.slots[other[overlap]]], axis=2)
            number = np.repeat(count + np.arange(len(pair)), 3)
            count += len(pair)
            there = (pair >= 0).all(axis=2).ravel()
            found.append(pair.reshape(-1, 2)[there])
            numbers.append(number[there])
        at_end = np.stack([self.low == 0.0, self.high == 1.0], axis=1)
        there = distinct(self.slots[:, :2][at_end])
        there = there[special[table.node[there]]]
        for one, other in pairs_of_equal(table.node[there]):
            found.append(np.stack([there[one], there[other]], axis=1))
            numbers.append(count + np.arange(len(one)))
            count += len(one)
        return Contacts(np.concatenate(found), np.concatenate(numbers))


def _extents(parts: CellParts, chosen: Indices, ends: Indices) -> tuple[Floats, Floats]:
    """Return from where to where parts have matter along their edges, shape (part, edge).

    Args:
        parts: Of one shape.
        chosen: Those that count, shape (part,).
        ends: Corners of their edges, shape (part, edge, 2).
    """
    mask = np.zeros(len(parts), dtype=bool)
    mask[chosen] = True
    place = np.cumsum(mask) - 1
    pieces = parts.with_roots(mask)
    own = place[pieces.part]
    size = int(pieces.roots.shape[1])
    shares = np.zeros((len(pieces), size, len(parts.division.corners)))
    row = np.arange(len(pieces))[:, None, None]
    shares[row, np.arange(size)[:, None], pieces.roots[:, None, :]] = pieces.inside.shares
    low = np.full(ends.shape[:2], np.inf)
    high = np.full(ends.shape[:2], -np.inf)
    filled = (shares > 0.0).sum(axis=2)
    for edge in range(ends.shape[1]):
        pair = ends[own, edge]
        both = np.take_along_axis(shares, pair[:, None, :].repeat(size, axis=1), axis=2)
        piece, corner = np.nonzero((both > 0.0).sum(axis=2) == filled)
        np.minimum.at(low[:, edge], own[piece], both[piece, corner, 1])
        np.maximum.at(high[:, edge], own[piece], both[piece, corner, 1])
    return low, high
