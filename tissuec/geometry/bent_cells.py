"""Hexahedra as drawn, by their mean gradients and the ways in which they bend.

With the natural coordinates ξ of the nodes, -1 or 1, the edges and modes of a hexahedron are

    A_k = Σ ξ_k X_a / 8,    h_1 = ηζ, h_2 = ζξ, h_3 = ξη, h_4 = ξηζ;

b_a is the mean of ∂N_a/∂X over its volume. A^k are the duals of A_k, and n_k is the direction
of A^k. With r_k = Σ ξ_k x/8 and q_h = Σ h x/8 of nodes x, F = Σ x_a ⊗ b_a has

    F A_k = r_k + Σ_h (Σ h b·A_k) (q_h - Σ_m (Σ h X/8·A^m) r_m).

See ``forces.solids.bent_cell`` for what follows from them. (Mean gradients, and modes
that uniform strain leaves at rest: D. P. Flanagan, T. Belytschko, Int. J. Numer. Meth. Eng.
17:679, 1981.)
"""

from typing import NamedTuple

import numpy as np

from tissuec.autodiff.tensors import PLACES
from tissuec.geometry.elements import CUBE, SHAPES
from tissuec.model.network import Floats

#: Modes at the nodes.
MODES = np.stack(
    [CUBE[:, 1] * CUBE[:, 2], CUBE[:, 2] * CUBE[:, 0], CUBE[:, 0] * CUBE[:, 1],
     CUBE.prod(axis=1)]
)  # fmt: skip
#: Of the nodes in r_k and q_h.
SHARES = np.vstack([CUBE.T, MODES]) / 8.0
#: Natural coordinates of the points, of which each stands for an eighth of the volume.
POINTS = CUBE / np.sqrt(3.0)
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
        shape, count = SHAPES["hexahedron"], len(corners)
        sides = shape.sides(corners)
        size = np.linalg.det(sides)
        volume = size.sum(axis=1)
        inverse = np.linalg.inv(sides)
        mean = np.einsum("qak,eqkx,eq->eax", shape.gradients, inverse, size)
        mean = mean / volume[:, None, None]
        edges = np.einsum("ak,eax->exk", CUBE, corners) / 8.0
        modes = np.einsum("ha,eax->ehx", MODES, corners) / 8.0
        dual = np.asarray(np.linalg.inv(edges), dtype=float)  # rows
        square = (edges**2).sum(axis=1)
        bend, trace = np.empty((count, 3, 3, 6)), np.empty((count, 3, 3))
        lateral, skew = np.empty((count, 3, 6)), np.empty((count, 3, 2))
        for k, (i, j) in enumerate(ACROSS):
            normal = dual[:, k] / np.linalg.norm(dual[:, k], axis=1)[:, None]
            p, q = (
                dual[:, m] - np.einsum("ex,ex->e", dual[:, m], normal)[:, None] * normal
                for m in (i, j)
            )
            pairs = (p, p), (q, q), (p, q)
            for c, (one, other) in enumerate(pairs):
                outer = np.einsum("ex,ey->exy", one, other)
                whole = outer if c < 2 else outer + outer.swapaxes(1, 2)
                trace[:, k, c] = np.trace(whole, axis1=1, axis2=2)
                part = whole - trace[:, k, c, None, None] / 3.0 * np.eye(3)
                bend[:, k, c] = _half(part)
            out = np.eye(3) / 3.0 - np.einsum("ex,ey->exy", normal, normal)
            lateral[:, k] = _half(out)
            over = (dual[:, k] ** 2).sum(axis=1)
            for n, m in enumerate((i, j)):
                skew[:, k, n] = np.einsum("ex,ex->e", dual[:, m], dual[:, k]) / over
        slant = np.einsum("ha,eax->ehx", MODES, mean) @ edges
        return cls(
            modes @ dual.swapaxes(1, 2), dual, slant, 1.0 / square,
            bend, trace, lateral, _twists(square), skew, _slopes(edges, modes), volume,
            (dual**2).sum(axis=(1, 2)),
        )  # fmt: skip

    @property
    def rows(self) -> Floats:
        """Return all numbers of each cell in SI units side by side, shape (cell, number)."""
        count = len(self.volume)
        return np.concatenate([each.reshape(count, -1) for each in self], axis=1)

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
        count = len(self.volume)
        parts = np.sqrt(self.inverse_square), self.twist, self.volume
        return np.concatenate([each.reshape(count, -1) for each in parts], axis=1)


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


def _half(tensors: Floats) -> Floats:
    """Return the numbers of symmetric tensors in any unit, shape (cell, 6)."""
    return np.stack([tensors[:, m, n] for m, n in PLACES[3]], axis=1)


def _slopes(edges: Floats, modes: Floats) -> Floats:
    """Return the slopes of det ∂X/∂ξ at the centre [m³], shape (cell, 3).

    Args:
        edges, modes: As of ``BentCells``.
    """
    sides, found = edges.swapaxes(1, 2), np.empty((len(edges), 3))
    for k, (i, j) in enumerate(ACROSS):
        # Edge m changes along ξ_k by the mode of the two.
        one = np.cross(sides[:, j], sides[:, k])
        other = np.cross(sides[:, k], sides[:, i])
        found[:, k] = (modes[:, j] * one + modes[:, i] * other).sum(axis=1)
    return found
