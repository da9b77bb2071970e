"""Ties between the faces of cuts: what is left of sections holds by springs in all directions.

The opening g of a point is the difference of the places that both parts give it: g = J x, with
one row of the sparse matrix J per point. Forces are -Jᵀ A (k g + d dg/dt), A being a third of
the area of a triangle as drawn. Sections of walls are lines with the two points of Gauss, whose
areas are halves of the length times the thickness.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from tissuec.validate.forces import ForceFormula
from tissuec.validate.forces.elements import shape_functions

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class CohesiveTies(ForceFormula):
    """The ties of a body as a field of forces.

    Args:
        tied: ``mechanics.tying.TiedSections``, read for places in cells and constants.
        body: ``mechanics.cutting.CutBody``, read for the nodes of parts.
        drawn: Places of all nodes as drawn [m], shape (node, 3).
        alive: Which entities exist.
        thickness: Of a wall by the numbers of its drawn triangles [m]; None of a solid.
    """

    def __init__(
        self,
        tied: Any,
        body: Any,
        drawn: Floats,
        alive: NDArray[np.bool_],
        thickness: Floats | None = None,
    ):
        place = {
            int(entity): (parts, row)
            for parts, entities in zip(body.parts, body.entities, strict=True)
            for row, entity in enumerate(entities)
        }
        rows: list[Floats] = []
        scale: list[tuple[float, float]] = []
        for number in np.flatnonzero(alive[tied.entities].all(axis=1)):
            count = tied.shares.shape[2]
            sides = [np.zeros((count, len(drawn))) for _ in range(2)]
            for side, entity in enumerate(tied.entities[number]):
                parts, row = place[int(entity)]
                root = parts.division.corners[tied.roots[number, side]]
                corners = tied.shares[number, side] @ root
                middle, inner = corners.mean(axis=0), 0.5 if count == 3 else 3.0**-0.5
                values = shape_functions(parts.shape, middle + inner * (corners - middle))
                np.add.at(sides[side], (slice(None), parts.nodes[row]), values)
                if side == 0:
                    ends = shape_functions(parts.shape, corners) @ drawn[parts.nodes[row]]
                    cell = parts.cell[row]
            if thickness is None:
                area = np.linalg.norm(np.cross(ends[1] - ends[0], ends[2] - ends[0])) / 6.0
            else:
                area = thickness[cell] * np.linalg.norm(ends[1] - ends[0]) / 2.0
            rows.append(sides[0] - sides[1])
            scale += [(area * tied.stiffness[number], area * tied.damping[number])] * count
        self._gaps = sparse.csr_matrix(np.concatenate(rows))
        self._pull, self._brake = np.array(scale).T[..., None]

    def add_forces(self, time: float, position: Floats, velocity: Floats, to: Floats) -> None:
        gap, speed = self._gaps @ position, self._gaps @ velocity[: len(position)]
        to -= self._gaps.T @ (self._pull * gap + self._brake * speed)

    def energy(self, time: float, position: Floats) -> float:
        return 0.5 * float((self._pull * (self._gaps @ position) ** 2).sum())

    def dissipated(self, time: float, position: Floats, velocity: Floats) -> float:
        """Return the power that dashpots lose [W]."""
        return float((self._brake * (self._gaps @ velocity[: len(position)]) ** 2).sum())

    def matrix(
        self, time: float, position: Floats, number: Indices, size: int
    ) -> sparse.coo_matrix:
        """Return the second derivative of the energy [N/m], shape (3 size, 3 size)."""
        moves = np.flatnonzero(number >= 0)
        own = self._gaps.tocsc()[:, moves]
        spread = sparse.coo_matrix(
            (np.ones(len(moves)), (np.arange(len(moves)), number[moves])),
            shape=(len(moves), size),
        )  # fmt: skip
        joined = own @ spread
        flat = joined.T @ sparse.diags(self._pull[:, 0]) @ joined
        return sparse.coo_matrix(sparse.kron(flat, sparse.identity(3)))
