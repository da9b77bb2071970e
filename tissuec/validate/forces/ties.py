"""Ties between the faces of cuts: springs in all directions that hold what is left of sections.

The opening g of a point is the difference of the places that both parts give it: g = J x, with
one row of the sparse matrix J per point. Forces are -Jᵀ A (k g + d dg/dt), A being a third of
the area of a triangle as drawn. Where tissue has torn, k falls by the factor f, and d by f⁴.
Sections of walls are lines with the two points of Gauss, whose areas are halves of the length
times the thickness. Of glue, rows and areas are those that the faces have in common as drawn.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from tissuec.validate.forces import ForceFormula
from tissuec.validate.forces.elements import shape_functions

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class TiedPoints(ForceFormula):
    """Points that are tied, as a field of forces.

    Args:
        rows: J, shape (point, node).
        scale: k and d times areas [N/m] [N s/m], both openings [m], and 1 if the section has
            begun to soften, shape (5, point).
        sections: The section of each, shape (point,).
    """

    def __init__(self, rows: sparse.csr_matrix, scale: Floats, sections: Indices):
        self._gaps = rows
        self._pull, self._brake, self._first, self._last, self._begun = scale
        self._sections = sections
        tears = np.isfinite(self._first)
        #: Sections that may open, by their names, as entities.
        self.breakable: Indices = np.unique(self._sections[tears])

    def burdens(self, position: Floats) -> Floats:
        """Return openings of sections divided by their limits.

        They are dimensionless, shape (section,).

        The limit of a section is the opening at which the first point begins to soften, and
        then that at which the last is free.
        """
        size = np.linalg.norm(self._gaps @ position, axis=1)
        found: list[float] = []
        for section in self.breakable:
            own = self._sections == section
            begun = self._begun[own][0] > 0.0
            limit = self._last[own] if begun else self._first[own]
            found.append(float((np.min if begun else np.max)(size[own] / limit)))
        return np.array(found)

    def _traction(self, gap: Floats) -> Floats:
        """Return forces over openings [N/m], shape (point, 1)."""
        size = np.linalg.norm(gap, axis=1)
        tears = np.isfinite(self._first) & (size > self._first)
        found = self._pull.copy()
        first, last, own = self._first[tears], self._last[tears], size[tears]
        fall = np.clip((last - own) / (last - first), 0.0, None)
        found[tears] = self._pull[tears] * first * fall / own
        return found[:, None]

    def add_forces(self, time: float, position: Floats, velocity: Floats, to: Floats) -> None:
        gap, speed = self._gaps @ position, self._gaps @ velocity[: len(position)]
        pull = self._traction(gap)
        fall = pull / self._pull[:, None]
        to -= self._gaps.T @ (pull * gap + self._brake[:, None] * fall**4 * speed)

    def energy(self, time: float, position: Floats) -> float:
        size = np.linalg.norm(self._gaps @ position, axis=1)
        first, last = (np.where(np.isinf(e), 1e9, e) for e in (self._first, self._last))
        near, far = np.minimum(size, first), np.clip(size, first, np.maximum(last, first))
        # The traction falls evenly: its integral is the mean of both ends times the way.
        span = np.where(last > first, last - first, 1.0)
        ends = 1.0 + np.clip((last - far) / span, 0.0, 1.0)
        return float((self._pull * (0.5 * near**2 + 0.5 * first * ends * (far - first))).sum())

    def dissipated(self, time: float, position: Floats, velocity: Floats) -> float:
        """Return the power that dashpots lose [W]."""
        speed = self._gaps @ velocity[: len(position)]
        fall = self._traction(self._gaps @ position)[:, 0] / self._pull
        return float(((self._brake * fall**4)[:, None] * speed**2).sum())

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
        joined = sparse.kron(own @ spread, sparse.identity(3)).tocsr()
        middle = sparse.block_diag(list(self._slopes(self._gaps @ position)), format="csr")
        return sparse.coo_matrix(joined.T @ middle @ joined)

    def _slopes(self, gap: Floats) -> Floats:
        """Return derivatives of forces by openings [N/m], shape (point, 3, 3)."""
        pull, size = self._traction(gap)[:, :, None], np.linalg.norm(gap, axis=1)
        found = pull * np.eye(3)
        tears = np.isfinite(self._first) & (size > self._first)
        along = gap[tears] / size[tears, None]
        both = along[:, :, None] * along[:, None, :]
        first, last = self._first[tears], self._last[tears]
        fall = np.where(size[tears] < last, -self._pull[tears] * first / (last - first), 0.0)
        found[tears] += (fall[:, None, None] - pull[tears]) * both
        return found


class CohesiveTies(TiedPoints):
    """The ties of a body as a field of forces.

    Args:
        tied: ``mechanics.tying.TiedSections``, read for places in cells and constants.
        body: ``mechanics.cut_body.CutBody``, read for the nodes of parts.
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
        scale: list[tuple[float, ...]] = []
        sections, names = list[int](), tied.names
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
            area *= tied.soft[number]
            rows.append(sides[0] - sides[1])
            first, last = tied.first[number], tied.last[number]
            constants = area * tied.stiffness[number], area * tied.damping[number], first, last
            scale += [(*constants, float(tied.softens[number]))] * count
            sections += [int(names[number])] * count
        gaps = sparse.csr_matrix(np.concatenate(rows))
        super().__init__(gaps, np.array(scale).T, np.array(sections))


class GluedFaces(TiedPoints):
    """Glue that can come apart, as a field of forces.

    Args:
        field: ``forces.solids.ties.GlueTies``, read for nodes, weights and constants.
        count: Number of all nodes.
    """

    def __init__(self, field: Any, count: int):
        point, _ = np.indices(field.nodes.shape)
        at = point.ravel(), field.nodes.ravel()
        rows = sparse.csr_matrix((field.weights.ravel(), at), shape=(len(field.nodes), count))
        scale = field.stiffness, field.damping, field.first, field.last, field.softens
        super().__init__(rows, np.array(scale, dtype=float), field.sections)
