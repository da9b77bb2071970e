"""Wedges as drawn, by their mean gradients, the ways in which they bend, and their sides.

Natural coordinates are those of an equilateral triangle with the height -1 to 1 along ζ, in
which squares have the mean 1/3 along all of them. A wedge has two modes, h_1 = ηζ and h_2 = ζξ.
The edge of the triangle across its corner k, from i to j, has the strain that the gradients of
the shares λ of the corners turn into a tensor,

    T_k = -(∇λ_i ⊗ ∇λ_j + ∇λ_j ⊗ ∇λ_i)/2,

which stretches this edge alone. See ``forces.solids.bent_cell`` for what follows from them.
"""

from typing import NamedTuple

import numpy as np

from tissuec.geometry.bent_cells import (
    ACROSS,
    BentPlane,
    CellForm,
    DrawnCells,
    even_part,
    side_by_side,
    volume_slopes,
    within,
)
from tissuec.geometry.elements import SHAPES
from tissuec.model.network import Floats

# Distance of the points of a triangle from its middle; corners are twice as far away.
_NEAR = np.sqrt(2.0 / 3.0)
_TURN = 2.0 * np.pi * np.arange(3) / 3.0
_FLAT = _NEAR * np.column_stack([np.cos(_TURN), np.sin(_TURN)])
#: Natural coordinates of the corners of the triangle.
TRIANGLE = 2.0 * _FLAT
_NODES = np.array([(*corner, z) for z in (-1.0, 1.0) for corner in TRIANGLE])
_VECTORS = np.vstack([_NODES.T, _NODES[:, 1] * _NODES[:, 2], _NODES[:, 2] * _NODES[:, 0]])
WEDGE = CellForm(
    _VECTORS / (_VECTORS**2).sum(axis=1)[:, None],
    np.array([(*place, z) for z in np.array([-1.0, 1.0]) / np.sqrt(3.0) for place in _FLAT]),
    4.0 * np.sqrt(3.0),
    # At three points of a triangle, squares are linear in the coordinates.
    {(0, 0): {0: 1.0 / 3.0, 1: 0.5 * _NEAR}, (1, 1): {0: 1.0 / 3.0, 1: -0.5 * _NEAR},
     (0, 1): {2: -0.5 * _NEAR}, (2, 2): {0: 1.0 / 3.0}, (1, 2): {4: 1.0}, (0, 2): {5: 1.0}},
)  # fmt: skip
#: Corners at the ends of each edge of the triangle; the edge has the number of the third.
ENDS = ACROSS
#: Energy of a triangle in torsion over that without warping (St Venant, equilateral).
_WARPED = 0.6
#: Where a wedge is longer than thick, its sections warp beyond that: by 1 + this times the
#: squared ratio. (As for shear of plates: M. Lyly, R. Stenberg, T. Vihinen, Comput. Meth. Appl.
#: Mech. Eng. 110:343, 1993.)
_THIN = 0.1
#: Turn of a side about its edge from one end to the other [rad] at which it bows by half.
_TWISTED = 0.3
#: How many numbers of a wedge each attribute has.
WEDGE_WIDTHS = {
    "modes": 6, "dual": 9, "slant": 6, "inverse_square": 3, "inverse_edge": 3,
    "tilt": 15, "out": 9, "inverse_out": 3, "inverse_height": 3, "up": 9, "side": 9,
    "bend": 18, "trace": 3, "lateral": 6,
    "torsion": 12, "axial": 6, "skew": 2, "slope": 3, "volume": 1, "steep": 1,
}  # fmt: skip


class BentWedges(NamedTuple):
    """Wedges as drawn; each attribute has a row for each cell.

    Attributes:
        modes, dual, slant, inverse_square: As of ``geometry.bent_cells.BentCells``.
        inverse_edge: 1/|L_k|² of the edges of the triangle halfway up [1/m²], shape (cell, 3).
        tilt: Where L_k changes along ζ: its parts along L_k, H_k, and along A_1 to A_3 of what
            is across the side, shape (cell, 3, 5).
        out: N_k, a twelfth of side k over the volume, by parts along A_1 to A_3 [1/m²], shape
            (cell, 3, 3).
        inverse_out: 1/|N_k|² [m²], shape (cell, 3).
        inverse_height: 1/|H_k|² of half the heights in their middles [1/m²], shape (cell, 3).
        up: H_k/|H_k|² [1/m] times the part by which heights lean, shape (cell, 3, 3).
        side: N_k/|H_k|² [1/m³] times the part by which sides bow, shape (cell, 3, 3).
        bend, trace: Of T_k, as of ``BentCells``, shape (cell, 3, 6) and (cell, 3).
        lateral: 1/3 - n n of the plane of the triangle, flat, shape (cell, 6).
        torsion: Strains along η and along ξ due to torsion about ζ, flat, shape (cell, 2, 6).
        axial: Strain along n, without its trace, for a relative one along ζ, flat, shape
            (cell, 6).
        skew, slope, volume, steep: As of ``BentCells``, the first of the triangle alone.
    """

    modes: Floats
    dual: Floats
    slant: Floats
    inverse_square: Floats
    inverse_edge: Floats
    tilt: Floats
    out: Floats
    inverse_out: Floats
    inverse_height: Floats
    up: Floats
    side: Floats
    bend: Floats
    trace: Floats
    lateral: Floats
    torsion: Floats
    axial: Floats
    skew: Floats
    slope: Floats
    volume: Floats
    steep: Floats

    @classmethod
    def of(cls, corners: Floats) -> "BentWedges":
        """Return wedges as drawn.

        Args:
            corners: Of their nodes [m], shape (cell, node, 3).
        """
        drawn = WEDGE.measured(SHAPES["wedge"], corners)
        dual, square = drawn.dual, (drawn.edges**2).sum(axis=1)
        sides = zip(*(_side(drawn, k) for k in range(3)), strict=True)
        inverse_edge, tilt, out, inverse_out, inverse_height, high, side = (
            np.stack(each, axis=1) for each in sides
        )
        plane = BentPlane.across(2, dual)
        normal = dual[:, 2] / np.linalg.norm(dual[:, 2], axis=1)[:, None]
        flat = np.stack([within(dual[:, k], normal) for k in (0, 1)], axis=1)
        shares = np.einsum("ak,ekx->eax", TRIANGLE, flat) / (1.5 * (TRIANGLE[0] ** 2).sum())
        bends, traces = zip(
            *(even_part(shares[:, i], -0.5 * shares[:, j]) for i, j in ENDS), strict=True
        )
        flatness = square[:, :2].sum(axis=1) / square[:, 2]
        warped = np.sqrt(_WARPED / (1.0 + _THIN * flatness))[:, None]
        torsion = [
            even_part(0.5 * warped * sign * dual[:, k], dual[:, 2])[0]
            for k, sign in ((1, 1.0), (0, -1.0))
        ]
        up = dual[:, 2]
        axial, _ = even_part(up, up)
        return cls(
            drawn.parts, dual, drawn.slant, 1.0 / square,
            inverse_edge, tilt, out, inverse_out, inverse_height, high, side,
            np.stack(bends, axis=1), np.stack(traces, axis=1), plane.lateral,
            np.stack(torsion, axis=1), axial, plane.skew, volume_slopes(drawn), drawn.volume,
            (dual**2).sum(axis=(1, 2)),
        )  # fmt: skip

    @property
    def rows(self) -> Floats:
        """Return all numbers of each cell in SI units side by side, shape (cell, number)."""
        return side_by_side(self)


def _side(drawn: DrawnCells, k: int) -> tuple[Floats, ...]:
    """Return the numbers of the side across a corner, from ``inverse_edge`` to ``side``."""
    i, j = ENDS[k]
    step, middle = TRIANGLE[j] - TRIANGLE[i], -0.5 * TRIANGLE[k]
    edge, turn = (
        np.einsum("k,ekx->ex", step, each)
        for each in (drawn.edges.swapaxes(1, 2)[:, :2], drawn.modes[:, ::-1])
    )
    height = drawn.edges[:, :, 2] + np.einsum("k,ekx->ex", middle, drawn.modes[:, ::-1])
    across = np.cross(edge, height)
    unit = across / np.linalg.norm(across, axis=1)[:, None]
    frame = np.stack([edge, height, unit], axis=2)
    solved = np.asarray(np.linalg.solve(frame, turn[:, :, None]), dtype=float)
    own = solved[:, :, 0]
    beyond = np.einsum("ekx,ex->ek", drawn.dual, own[:, 2, None] * unit)
    high = (height**2).sum(axis=1)
    twist = own[:, 2] ** 2 / high / _TWISTED**2
    long = (edge**2).sum(axis=1)
    slender = long / (4.0 * high)
    # Of the shear that bending needs; see ``forces.solids.bent_wedge``.
    bows = 1.0 / ((1.0 + slender**2) * (1.0 + twist))
    leans = 1.0 / (1.0 + twist) - bows
    out = across / (6.0 * drawn.volume)[:, None]  # both halves, and a twelfth by which it bows
    return (
        1.0 / long,
        np.concatenate([own[:, :2], beyond], axis=1),
        np.einsum("ekx,ex->ek", drawn.dual, out),
        1.0 / (out**2).sum(axis=1),
        1.0 / high,
        (leans / high)[:, None] * height,
        (bows / high)[:, None] * out,
    )
