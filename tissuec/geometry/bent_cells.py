"""Cells as drawn, by their mean gradients and the ways in which they bend.

With the natural coordinates ξ of the nodes, -1 or 1, the edges and modes of a hexahedron are

    A_k = Σ ξ_k X_a / 8,    h_1 = ηζ, h_2 = ζξ, h_3 = ξη, h_4 = ξηζ;

b_a is the mean of ∂N_a/∂X over its volume. A^k are the duals of A_k, and n_k is the direction
of A^k. With r_k = Σ ξ_k x/8 and q_h = Σ h x/8 of nodes x, F = Σ x_a ⊗ b_a has

    F A_k = r_k + Σ_h (Σ h b·A_k) (q_h - Σ_m (Σ h X/8·A^m) r_m).

Wedges are in ``geometry.bent_wedges``; see ``forces.solids.bent_cell`` for what follows from
both. (Mean gradients, and modes that uniform strain leaves at rest: D. P. Flanagan,
T. Belytschko, Int. J. Numer. Meth. Eng. 17:679, 1981.)
"""

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np

from tissuec.autodiff.cells import TERMS
from tissuec.autodiff.tensors import PLACES
from tissuec.geometry.elements import CUBE, SHAPES, ElementShape
from tissuec.model.network import Floats


class CellForm(NamedTuple):
    """The natural coordinates of cells of one shape.

    Means of squares of coordinates over all points are 1/3, and those of other products 0.

    Attributes:
        shares: Of the nodes in r_k and q_h, shape (vector, node).
        points: Of which each stands for an equal part of the volume, shape (point, 3).
        volume: In natural coordinates.
        products: Of two coordinates i <= j at the points: factors of ``TERMS`` by place.
    """

    shares: Floats
    points: Floats
    volume: float
    products: Mapping[tuple[int, int], Mapping[int, float]]

    @property
    def terms(self) -> list[Floats]:
        """Return ``TERMS``, which are dimensionless, at all points, shape (point,) each."""
        return [self.points[:, list(axes)].prod(axis=1) for axes in TERMS]

    def measured(self, shape: ElementShape, corners: Floats) -> "DrawnCells":
        """Return edges and modes of cells as drawn.

        Args:
            shape: Of the cells.
            corners: Of their nodes [m], shape (cell, node, 3).
        """
        sides = shape.sides(corners)
        size = np.linalg.det(sides) * shape.weights
        volume = size.sum(axis=1)
        mean = np.einsum("qak,eqkx,eq->eax", shape.gradients, np.linalg.inv(sides), size)
        vectors = np.einsum("va,eax->evx", self.shares, corners)
        edges, modes = vectors[:, :3].swapaxes(1, 2), vectors[:, 3:]
        dual = np.asarray(np.linalg.inv(edges), dtype=float)  # rows
        by_mode = self.shares[3:] / (self.shares[3:] ** 2).sum(axis=1)[:, None]
        slopes = np.einsum("ha,eax->ehx", by_mode, mean / volume[:, None, None])
        return DrawnCells(
            edges, modes, dual, modes @ dual.swapaxes(1, 2), slopes @ edges, volume
        )


class DrawnCells(NamedTuple):
    """Edges and modes of cells; each attribute has a row for each cell.

    Attributes:
        edges: A_k [m], shape (cell, 3, 3), by component and k.
        modes: q_h of the nodes as drawn [m], shape (cell, mode, 3).
        dual: A^k [1/m], shape (cell, 3, 3), by k and component.
        parts: Of modes, m_k in Σ m_k A_k, shape (cell, mode, 3).
        slant: Σ h b·A_k of all modes, shape (cell, mode, 3).
        volume: V [m³], shape (cell,).
    """

    edges: Floats
    modes: Floats
    dual: Floats
    parts: Floats
    slant: Floats
    volume: Floats


#: Modes at the nodes.
MODES = np.stack(
    [CUBE[:, 1] * CUBE[:, 2], CUBE[:, 2] * CUBE[:, 0], CUBE[:, 0] * CUBE[:, 1],
     CUBE.prod(axis=1)]
)  # fmt: skip
HEXAHEDRON = CellForm(
    np.vstack([CUBE.T, MODES]) / 8.0, CUBE / np.sqrt(3.0), 8.0,
    {(0, 0): {0: 1.0 / 3.0}, (1, 1): {0: 1.0 / 3.0}, (2, 2): {0: 1.0 / 3.0},
     (1, 2): {4: 1.0}, (0, 2): {5: 1.0}, (0, 1): {6: 1.0}},
)  # fmt: skip
#: The two directions of the plane across each.
ACROSS = ((1, 2), (2, 0), (0, 1))
#: Part of a twist about one direction that those about the others take over: a single cell and
#: two side by side are then too stiff in torsion by equal parts.
COUPLING = 0.25
#: The numbers of boxes: 1/|A_k|, and two of the others.
BOX_WIDTHS = {"inverse_length": 3, "twist": 9, "volume": 1}
_STRAIGHT = 1e-13  # of the edges: rounding
#: How many numbers of a cell each attribute has.
WIDTHS = {
    "modes": 12, "dual": 9, "slant": 12, "inverse_square": 3, "bend": 54, "trace": 9,
    "lateral": 18, "twist": 9, "skew": 6, "slope": 3, "volume": 1, "steep": 1,
}  # fmt: skip


class BentCells(NamedTuple):
    """Hexahedra as drawn; each attribute has a row for each cell.

    Attributes:
        modes: Of all modes, Σ h X / 8 = Σ m_k A_k; shape (cell, 4, 3).
        dual: A^k [1/m], shape (cell, 3, 3), by k and component.
        slant: Σ h b·A_k of all modes, shape (cell, 4, 3).
        inverse_square: 1/|A_k|² [1/m²], shape (cell, 3).
        bend: Tensors without trace of the three curvatures of each plane, for relative ones
            [1/m²], flat, shape (cell, plane, curvature, 6).
        trace: Their traces before that was taken away [1/m²], shape (cell, plane, curvature).
        lateral: 1/3 - n n of each plane, flat, shape (cell, plane, 6).
        twist: What couples the twists, shape (cell, 3, 3); see ``COUPLING``.
        skew: A^m·A^k/|A^k|² for both m across k, shape (cell, 3, 2).
        slope: Slopes of det ∂X/∂ξ at the centre along each ξ_k [m³], shape (cell, 3).
        volume: V [m³], shape (cell,).
        steep: Σ |A^k|² [1/m²], shape (cell,).
    """

    modes: Floats
    dual: Floats
    slant: Floats
    inverse_square: Floats
    bend: Floats
    trace: Floats
    lateral: Floats
    twist: Floats
    skew: Floats
    slope: Floats
    volume: Floats
    steep: Floats

    @classmethod
    def of(cls, corners: Floats) -> "BentCells":
        """Return cells as drawn.

        Args:
            corners: Of their nodes [m], shape (cell, node, 3).
        """
        drawn = HEXAHEDRON.measured(SHAPES["hexahedron"], corners)
        square = (drawn.edges**2).sum(axis=1)
        planes = [BentPlane.across(k, drawn.dual) for k in range(3)]
        bend, trace, lateral, skew = (
            np.stack(each, axis=1) for each in zip(*planes, strict=True)
        )
        return cls(
            drawn.parts, drawn.dual, drawn.slant, 1.0 / square, bend, trace, lateral,
            _twists(square), skew, volume_slopes(drawn), drawn.volume,
            (drawn.dual**2).sum(axis=(1, 2)),
        )  # fmt: skip

    @property
    def rows(self) -> Floats:
        """Return all numbers of each cell in SI units side by side, shape (cell, number)."""
        return side_by_side(self)

    @property
    def are_boxes(self) -> bool:
        """Return whether all have edges along the axes, so that ``BOX_WIDTHS`` are enough."""
        length = 1.0 / np.sqrt(self.inverse_square)
        upright = np.einsum("ekx,ek->ekx", self.dual, length) - np.eye(3)
        ends = (np.abs(each).max(initial=0.0) for each in (upright, self.modes))
        return bool(max(ends) <= _STRAIGHT)

    @property
    def boxes(self) -> Floats:
        """Return the numbers of ``BOX_WIDTHS`` in SI units, shape (cell, number)."""
        return side_by_side((np.sqrt(self.inverse_square), self.twist, self.volume))


def _twists(square: Floats) -> Floats:
    """Return the root of the matrix that couples three twists, for relative curvatures.

    Args:
        square: |A_k|² [m²], shape (cell, 3).
    """
    length = np.sqrt(square)
    pairs = square[:, :, None] + square[:, None, :]
    matrix = COUPLING * 2.0 * length[:, :, None] * length[:, None, :] / pairs
    matrix[:, range(3), range(3)] = 1.0
    values, ways = np.linalg.eigh(matrix)
    root = np.einsum("eik,ek,ejk->eij", ways, np.sqrt(values), ways)
    unit = np.stack([length[:, i] * length[:, j] for i, j in ACROSS], axis=1)
    return root * unit[:, :, None] / unit[:, None, :]


class BentPlane(NamedTuple):
    """How cells bend in a plane; each attribute has a row for each cell.

    Attributes:
        bend, trace, lateral, skew: As of ``BentCells``, of one plane.
    """

    bend: Floats
    trace: Floats
    lateral: Floats
    skew: Floats

    @classmethod
    def across(cls, k: int, dual: Floats) -> "BentPlane":
        """Return the plane across a direction.

        Args:
            k: Number of the direction.
            dual: A^k [1/m], shape (cell, 3, 3).
        """
        i, j = ACROSS[k]
        normal = dual[:, k] / np.linalg.norm(dual[:, k], axis=1)[:, None]
        p, q = (within(dual[:, m], normal) for m in (i, j))
        bends, traces = zip(
            *(even_part(*each) for each in ((p, p), (q, q), (p, q))), strict=True
        )
        out = np.eye(3) / 3.0 - np.einsum("ex,ey->exy", normal, normal)
        over = (dual[:, k] ** 2).sum(axis=1)
        skew = [np.einsum("ex,ex->e", dual[:, m], dual[:, k]) / over for m in (i, j)]
        return cls(
            np.stack(bends, axis=1), np.stack(traces, axis=1), half(out), np.stack(skew, axis=1)
        )


def side_by_side(numbers: Iterable[Floats]) -> Floats:
    """Return numbers of cells in SI units side by side, shape (cell, number)."""
    return np.concatenate([each.reshape(len(each), -1) for each in numbers], axis=1)


def within(vectors: Floats, normal: Floats) -> Floats:
    """Return vectors without their parts along unit normals, shape (cell, 3) each."""
    return vectors - np.einsum("ex,ex->e", vectors, normal)[:, None] * normal


def even_part(one: Floats, other: Floats) -> tuple[Floats, Floats]:
    """Return the symmetric product of two vectors, without its trace; and the trace.

    It is their outer product, plus its transpose if they differ.

    Args:
        one, other: In any units, shape (cell, 3); the same array for a square.

    Returns:
        In the product of these units, shape (cell, 6) and (cell,).
    """
    outer = np.einsum("ex,ey->exy", one, other)
    whole = outer if one is other else outer + outer.swapaxes(1, 2)
    trace = np.trace(whole, axis1=1, axis2=2)
    return half(whole - trace[:, None, None] / 3.0 * np.eye(3)), trace


def half(tensors: Floats) -> Floats:
    """Return the numbers of symmetric tensors in any unit, shape (cell, 6)."""
    return np.stack([tensors[:, m, n] for m, n in PLACES[3]], axis=1)


def volume_slopes(drawn: DrawnCells) -> Floats:
    """Return the slopes of det ∂X/∂ξ at the centre [m³], shape (cell, 3)."""
    sides, modes = drawn.edges.swapaxes(1, 2), drawn.modes
    found = np.zeros((len(sides), 3))
    for k, (i, j) in enumerate(ACROSS):
        # Edge m changes along ξ_k by the mode of the two.
        for mode, side in ((j, (j, k)), (i, (k, i))):
            if mode < modes.shape[1]:
                across = np.cross(sides[:, side[0]], sides[:, side[1]])
                found[:, k] += (modes[:, mode] * across).sum(axis=1)
    return found
