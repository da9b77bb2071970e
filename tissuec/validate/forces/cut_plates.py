"""The bending of walls that blades have divided, from the outlines of parts.

A part of a triangle has the share f of its area, by determinants of barycentric coordinates,
and intervals of its edges. At an edge it holds on to a part of the neighbour with the share g,
where both have the same nodes and some of the edge, as far as h = min(1, g/f). Its folds act on
the stiffness K of the whole triangle through springs of the stiffness

    k_i = h/((1 - h) S_ii),    S = K⁻¹,

whose elongations e are eliminated: K' = f (K - K_e (K_ee + diag k)⁻¹ K_eᵀ).
"""

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from tissuec.forces.surfaces.plates import Plates

Floats = NDArray[np.float64]
ROUNDING = 1e-9  # of an edge


def fractions_of(parts: Any) -> Floats:
    """Return the dimensionless shares of the areas of triangles that parts have, shape (part,).

    Args:
        parts: ``geometry.cut_cells.parts.CellParts`` of triangles, read for their pieces.
    """
    sizes = np.abs(np.linalg.det(parts.pieces.inside.shares))
    found = np.bincount(parts.pieces.part, sizes, len(parts.cell))
    found[np.setdiff1d(np.arange(len(found)), parts.pieces.part)] = 1.0
    return np.asarray(found)


def held_stiffness(plates: "Plates", drawn: "Plates", body: Any) -> Floats:
    """Return the stiffness of plates beside cuts [N m], shape (plate, 3, 3).

    Args:
        plates: Read for the parts that each joins.
        drawn: Of the drawn wall, read for the stiffness of whole triangles.
        body: ``mechanics.cut_body.CutBody``, read for parts.
    """
    (parts,), (entities,) = body.parts, body.entities
    row = {int(entity): k for k, entity in enumerate(entities)}
    share, edges = fractions_of(parts), _Outlines(parts)
    found = np.zeros((len(plates.nodes), 3, 3))
    for item, patch in enumerate(plates.nodes):
        own, *others = (row[int(each)] for each in plates.walls[plates.walled == item])
        whole = drawn.stiffness[parts.cell[own]]
        hinges = np.flatnonzero(np.diag(whole) > 0.0)
        holds, weight = np.zeros(3), share[own]
        for edge, other in zip(np.flatnonzero(patch[3:] != patch[:3]), others, strict=True):
            lengths = edges.common(own, int(edge))
            weight *= lengths[other] / sum(lengths.values())
            holds[edge] = share[other]
        holds = np.minimum(holds / weight, 1.0)
        own_k = whole[np.ix_(hinges, hinges)]
        loose = np.flatnonzero(holds[hinges] < 1.0)
        h, soft = holds[hinges][loose], np.diag(np.linalg.inv(own_k))[loose]
        inner = own_k[np.ix_(loose, loose)] + np.diag(h / ((1.0 - h) * soft))
        side = own_k[:, loose]
        bent = own_k - side @ np.linalg.solve(inner, side.T)
        found[np.ix_([item], hinges, hinges)] = weight * bent
    return found


class _Outlines:
    """Intervals of edges that parts of triangles have.

    Args:
        parts: As of ``fractions_of``.
    """

    def __init__(self, parts: Any):
        self._parts = parts
        self._at: dict[tuple[int, ...], list[int]] = {}
        for part, nodes in enumerate(parts.nodes):
            for edge in range(3):
                key = tuple(sorted(np.delete(nodes, edge).tolist()))
                self._at.setdefault(key, []).append(part)

    def common(self, part: int, edge: int) -> dict[int, float]:
        """Return the lengths of an edge of a part that other parts share, by their numbers."""
        parts = self._parts
        ends = sorted(np.delete(parts.drawn[part], edge).tolist())
        own, found = self._intervals(part, ends), dict[int, float]()
        for other in self._at[tuple(sorted(np.delete(parts.nodes[part], edge).tolist()))]:
            if parts.cell[other] != parts.cell[part]:
                length = sum(
                    max(min(b, d) - max(a, c), 0.0)
                    for a, b in own
                    for c, d in self._intervals(other, ends)
                )
                if length > ROUNDING:
                    found[other] = length
        return found

    def _intervals(self, part: int, ends: list[int]) -> list[tuple[float, float]]:
        """Return from where to where a part has an edge between two drawn nodes."""
        pieces = self._parts.pieces
        own = np.flatnonzero(pieces.part == part)
        if not len(own):
            return [(0.0, 1.0)]
        found: list[tuple[float, float]] = []
        for piece in own:
            drawn = self._parts.drawn[part][pieces.roots[piece]].tolist()
            shares = pieces.inside.shares[piece]
            first, second = drawn.index(ends[0]), drawn.index(ends[1])
            third = 3 - first - second
            on = np.flatnonzero(shares[:, third] == 0.0)
            if len(on) == 2:
                low, high = sorted(shares[on, second].tolist())
                found.append((low, high))
        return found
