"""Parts of cells, and the tetrahedra or triangles that they consist of.

A whole cell is a part, too, without pieces: its roots are found when they are needed. A point
of a piece is given by shares of the corners of its root; a height that is given at nodes is
linear on roots. Its natural coordinates are the same mix of those of the corners, and its place
is that of the functions of all nodes there. (Copies of cells: A. Hansbo, P. Hansbo, Comput.
Meth. Appl. Mech. Eng. 193:3523, 2004; J.-H. Song, P. Areias, T. Belytschko, Int. J. Numer.
Meth. Eng. 67:868, 2006.)
"""

from collections.abc import Sequence
from functools import reduce
from operator import and_
from typing import Any

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.structs import replace
from tissuec.geometry.cut_cells.clipping import Bools, Simplices, turned
from tissuec.geometry.cut_cells.roots import DIVISIONS, CellDivision, CellRoots
from tissuec.geometry.divisions import OPPOSITE
from tissuec.geometry.elements import NodeFunctions
from tissuec.geometry.natural_coordinates import functions
from tissuec.model.network import Floats, Indices

Sides = NDArray[np.int8]
#: Corners of the face opposite each corner of a piece, by their number, as seen from outside.
_ACROSS = {3: np.array([[1, 2], [2, 0], [0, 1]]), 4: OPPOSITE}
#: The same in ascending order.
OTHERS = {count: np.sort(corners, axis=1) for count, corners in _ACROSS.items()}
#: Number of the lowest bit, -1 of 0.
_FIRST_BIT = np.array([-1, 0, 1, 0, 2, 0, 1, 0, 3, 0, 1, 0, 2, 0, 1, 0])


class PartPieces(Struct, frozen=True, eq=False):
    """Simplices of which parts of cells consist.

    Attributes:
        part: That each belongs to, ascending, shape (piece,).
        roots: Corners of the cell that are those of the root, shape (piece, corner).
        inside: What they are in their roots.
    """

    part: Indices
    roots: Indices
    inside: Simplices

    def __len__(self) -> int:
        return len(self.part)

    def __getitem__(self, items: Indices | Bools) -> "PartPieces":
        return PartPieces(self.part[items], self.roots[items], self.inside[items])

    @classmethod
    def none(cls, shape: str, levels: int) -> "PartPieces":
        """Return no pieces of parts of cells of a shape with so many levels."""
        index, size = np.zeros(0, dtype=np.int64), DIVISIONS[shape].dimension + 1
        inside = Simplices(
            np.zeros((0, size, size)), np.zeros(0), index,
            np.zeros((0, size, levels), dtype=bool),
        )  # fmt: skip
        return cls(index, np.zeros((0, size), dtype=np.int64), inside)

    @classmethod
    def of_whole(cls, shape: str, drawn: Indices, levels: int) -> "PartPieces":
        """Return the roots of whole cells as pieces.

        Args:
            shape: Of all of them.
            drawn: Numbers of their drawn nodes, shape (cell, node).
            levels: How many there are.
        """
        found = CellRoots.of(shape, drawn)
        cells, count = len(found.sign), DIVISIONS[shape].count
        size = int(found.corners.shape[2])
        inside = Simplices(
            np.broadcast_to(np.eye(size), (cells * count, size, size)),
            np.full(cells * count, 1.0 / count), found.sign.ravel(),
            np.zeros((cells * count, size, levels), dtype=bool),
        )  # fmt: skip
        return cls(np.repeat(np.arange(cells), count), found.corners.reshape(-1, size), inside)

    @classmethod
    def together(cls, some: "Sequence[PartPieces]") -> "PartPieces":
        """Return all of some pieces, each in ascending order of their parts."""
        if len(filled := [each for each in some if len(each)]) < 2:
            return filled[0] if filled else some[0]
        part = np.concatenate([each.part for each in some])
        every = cls(
            part,
            np.concatenate([each.roots for each in some]),
            Simplices.together([each.inside for each in some]),
        )
        return every[np.argsort(part, kind="stable")]

    def heights(self, nodes: Indices, values: Floats) -> Floats:
        """Return values at corners, linear on roots, in their unit, shape (piece, corner).

        Sums are in the order of the drawn nodes, so that neighbours find the same to the bit.

        Args:
            nodes: Of all parts, shape (part, node).
            values: At nodes, shape (node,).
        """
        own, shares = values[nodes[self.part[:, None], self.roots]], self.inside.shares
        found = shares[..., 0] * own[:, None, 0]
        for k in range(1, shares.shape[-1]):
            found = found + shares[..., k] * own[:, None, k]
        return found


def functions_at(shape: str, xi: Floats) -> NodeFunctions:
    """Return the dimensionless functions of the nodes at several points of each cell.

    Args:
        shape: Name of the shape of the cells.
        xi: Natural coordinates, shape (cell, point, dimension).
    """
    at = functions(shape, xi.reshape(-1, xi.shape[2]))
    values = at.values.reshape(*xi.shape[:2], at.values.shape[1])
    return NodeFunctions(values, at.gradients.reshape(*values.shape, xi.shape[2]))


class PieceFaces(Struct, frozen=True, eq=False):
    """Faces of pieces in faces of their cells, or on levels.

    Attributes:
        piece: That each belongs to, shape (face,).
        corners: Of the piece, in turn as seen from outside, or with it on their left, shape
            (face, corner).
        face: Of the cell, in the order of ``roots.DIVISIONS``; -1 inside, shape (face,).
        across: The corner of the root that the face of the cell does not have; -1 inside, shape
            (face,).
        level: The first of the levels that it lies on; -1 if there is none, shape (face,).
    """

    piece: Indices
    corners: Indices
    face: Indices
    across: Indices
    level: Indices

    @classmethod
    def of(cls, shape: str, pieces: PartPieces, levels: bool = True) -> "PieceFaces":
        """Return the surface of parts of cells of a shape.

        Args:
            shape: Name of it.
            pieces: That the parts consist of.
            levels: Whether faces inside of cells count.
        """
        inside = pieces.inside
        count = int(inside.shares.shape[1])
        # Bits are corners of the root, of which the corners of a face have no share.
        lacks = np.packbits(inside.shares == 0.0, axis=2, bitorder="little")[..., 0]
        lacking = _all_of(lacks, count)
        outer = _FIRST_BIT[lacking]
        bits = (1 << pieces.roots).astype(np.int64)
        in_face = DIVISIONS[shape].face_of[bits.sum(axis=1, keepdims=True) - bits]
        face = np.where(outer >= 0, in_face[np.arange(len(pieces))[:, None], outer], -1)
        level = np.full(face.shape, -1)
        if levels and inside.on.shape[2]:
            on = _all_of(inside.on, count)
            level = np.where(on.any(axis=2), on.argmax(axis=2), -1)
        piece, corner = np.nonzero((face >= 0) | (level >= 0))
        face, level, across = face[piece, corner], level[piece, corner], outer[piece, corner]
        corners, is_left = _ACROSS[count][corner], inside.sign[piece] < 0
        corners = np.where(is_left[:, None], turned(corners[..., None])[..., 0], corners)
        return cls(piece, corners, face, np.where(face >= 0, across, -1), level)


def _all_of(bits: NDArray[Any], count: int) -> NDArray[Any]:
    """Combine by ``and`` the bits of all corners of each face, shape (simplex, face, …).

    Args:
        bits: Of each corner, shape (simplex, corner, …).
        count: Of corners.
    """
    each = [reduce(and_, (bits[:, k] for k in corners)) for corners in OTHERS[count]]
    return np.stack(each, axis=1)


class CellParts(Struct, frozen=True, eq=False):
    """Parts of cells of one shape, whole ones among them.

    Attributes:
        shape: Name of the shape of the cells.
        cell: That each is a part of, shape (part,).
        nodes: Present numbers of the nodes, shape (part, node).
        drawn: Numbers of the drawn nodes in whose place these are, shape (part, node).
        sides: Of levels on which a part is: 1 in front, -1 behind, 0 if the level does not
            divide its cell, shape (part, level).
        pieces: Of the parts that are not whole.
    """

    shape: str
    cell: Indices
    nodes: Indices
    drawn: Indices
    sides: Sides
    pieces: PartPieces

    def __len__(self) -> int:
        return len(self.cell)

    @classmethod
    def whole(cls, shape: str, nodes: Indices) -> "CellParts":
        """Return whole cells.

        Args:
            shape: Of all of them.
            nodes: As drawn, shape (cell, node).
        """
        sides = np.zeros((len(nodes), 0), dtype=np.int8)
        return cls(shape, np.arange(len(nodes)), nodes, nodes, sides, PartPieces.none(shape, 0))

    @property
    def division(self) -> CellDivision:
        """Return how the cells are divided."""
        return DIVISIONS[self.shape]

    @property
    def are_whole(self) -> Bools:
        """Return which parts are whole cells, shape (part,)."""
        found = np.ones(len(self), dtype=bool)
        found[self.pieces.part] = False
        return found

    @property
    def fractions(self) -> Floats:
        """Return dimensionless parts of the volumes or areas of cells, shape (part,)."""
        found = np.bincount(self.pieces.part, self.pieces.inside.fraction, len(self))
        return np.where(self.are_whole, 1.0, found)

    def some(self, chosen: Bools) -> "CellParts":
        """Return some of the parts; a mask of shape (part,)."""
        pieces = self.own_pieces(chosen)
        number = np.cumsum(chosen) - 1
        return CellParts(
            self.shape, self.cell[chosen], self.nodes[chosen], self.drawn[chosen],
            self.sides[chosen], replace(pieces, part=number[pieces.part]),
        )  # fmt: skip

    def own_pieces(self, chosen: Bools) -> PartPieces:
        """Return the pieces of some parts that are not whole; a mask of shape (part,)."""
        counts = chosen[self.pieces.part]
        return self.pieces if counts.all() else self.pieces[counts]

    def with_roots(self, chosen: Bools) -> PartPieces:
        """Return the pieces of some parts, those of whole ones as well; shape (part,)."""
        whole = np.flatnonzero(self.are_whole & chosen)
        found = PartPieces.of_whole(
            self.shape, self.drawn[whole], self.pieces.inside.on.shape[2]
        )
        return PartPieces.together(
            [self.own_pieces(chosen), replace(found, part=whole[found.part])]
        )

    def natural(self, pieces: PartPieces, shares: Floats | None = None) -> Floats:
        """Return natural coordinates of points of pieces, shape (piece, point, dimension).

        Args:
            pieces: Of some parts.
            shares: Of the corners of their roots, dimensionless, shape (piece, point, corner);
                those of the corners of the pieces by default.
        """
        shares = pieces.inside.shares if shares is None else shares
        return shares @ self.division.corners[pieces.roots]

    def weights(self, pieces: PartPieces, shares: Floats | None = None) -> Floats:
        """Return the functions of all nodes at points of pieces, shape (piece, point, node).

        Args:
            pieces: Of some parts.
            shares: As of ``natural``, dimensionless.
        """
        xi = self.natural(pieces, shares)
        return functions_at(self.shape, xi).values
