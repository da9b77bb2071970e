"""Nodes of curved cells that are no corners: in the middle of edges, faces and cells.

They are known by the corners that they are between, so that they survive the repair of a mesh,
in which nodes get other numbers.
"""

from typing import Self

import numpy as np
from msgspec import Struct

from tissuec.geometry.edges import Floats, Indices
from tissuec.geometry.elements import CUBE, CUBE_27, MIDDLES

_MOST = 8  # corners that a node is between
#: Corners between which the nodes of tetrahedra and hexahedra lie behind these, by the number
#: of all nodes.
_BETWEEN = {
    10: [pair.tolist() for pair in MIDDLES],
    27: [np.flatnonzero(one).tolist() for one in (CUBE_27[8:, None] * CUBE >= 0.0).all(axis=2)],
}


class BetweenNodes(Struct, frozen=True, eq=False):
    """Where nodes between corners are.

    Attributes:
        corners: Ascending, and -1 beyond them, one row for each node, shape (node, 8).
        position: In the unit of the corners, shape (node, 3).
    """

    corners: Indices
    position: Floats

    @classmethod
    def none(cls) -> Self:
        """Return no nodes."""
        return cls(np.zeros((0, _MOST), dtype=np.int64), np.zeros((0, 3)))

    @classmethod
    def of(cls, cells: Indices, position: Floats) -> Self:
        """Return the nodes between corners of tetrahedra or hexahedra.

        Args:
            cells: Nodes in the order of VTK, shape (cell, 10) or (cell, 27).
            position: Of all nodes, in any unit, shape (node, 3).
        """
        keys = keys_of(cells).reshape(-1, _MOST)
        corners, first = np.unique(keys, axis=0, return_index=True)
        behind = cells[:, cells.shape[1] - len(_BETWEEN[cells.shape[1]]) :]
        return cls(corners, position[behind.ravel()[first]])

    def joined(self, other: Self) -> Self:
        """Return these and others."""
        corners = np.concatenate([self.corners, other.corners])
        return type(self)(corners, np.concatenate([self.position, other.position]))

    def scaled(self, scale: float) -> Self:
        """Return these in another unit."""
        return type(self)(self.corners, self.position * scale)

    def renumbered(self, number: Indices) -> Self:
        """Return these between corners of other numbers, shape (node,); -1 has none."""
        found = np.where(self.corners >= 0, number[self.corners], -1)
        stays = ((found >= 0) == (self.corners >= 0)).all(axis=1)
        return type(self)(_ascending(found[stays]), self.position[stays])

    def places(self, corners: Indices, others: Floats) -> Floats:
        """Return where nodes between some corners are, shape (n, 3).

        Args:
            corners: Rows as of ``corners``, shape (n, 8) or fewer columns.
            others: Where those are that are not known, in the same unit, shape (n, 3).
        """
        if not len(self.corners):
            return others
        wanted = np.full((len(corners), _MOST), -1)
        wanted[:, : corners.shape[1]] = corners
        _, where = np.unique(
            np.concatenate([self.corners, wanted]), axis=0, return_inverse=True
        )
        where, known = where.reshape(-1), np.full(len(self.corners) + len(wanted), -1)
        known[where[: len(self.corners)]] = np.arange(len(self.corners))
        row = known[where[len(self.corners) :]]
        return np.where((row >= 0)[:, None], self.position[row], others)


def keys_of(cells: Indices) -> Indices:
    """Return the corners between which the nodes of cells lie, shape (cell, node, 8).

    Args:
        cells: Nodes, or corners alone, in the order of VTK; of hexahedra, at least 8 columns.
    """
    between = _BETWEEN[27 if cells.shape[1] in (8, 27) else 10]
    keys = np.full((len(cells), len(between), _MOST), -1)
    for k, corners in enumerate(between):
        keys[:, k, : len(corners)] = np.sort(cells[:, corners], axis=1)
    return keys


def _ascending(rows: Indices) -> Indices:
    """Return rows in ascending order, and -1 behind."""
    most = np.iinfo(np.int64).max
    found = np.sort(np.where(rows < 0, most, rows), axis=1)
    return np.where(found == most, -1, found)
