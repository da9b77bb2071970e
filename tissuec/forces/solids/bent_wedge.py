"""Wedges that bend at any ratio of their edges; see ``solids.bent_cell`` for what is not here.

With the numbers of a wedge as drawn (``geometry.bent_wedges``), its edges r and modes q, the
side k between two corners of the triangle has, halfway up, the edge l_k and half the height
h_k, and

    c_k = l_k·(what l_k changes by along ζ, without what F gives it).

In a layer that bends without shear, the sides bow by c_k/12|h_k|² of h_k: sides that stay
straight shear wedges that are longer than thick, which lock. So F has in addition

    Σ c_k (b_k h_k/|h_k|² ⊗ N_k + (1 - b_k) |N_k|² n_k/|n_k|² ⊗ H_k/|H_k|²),

N_k being a twelfth of the area of the side over the volume as drawn, and n_k the part of F N_k
across l_k. The first part bows sides, the second one leans heights. Both are the same shear,
but under stress along the heights the first one, and under stress along the edges the second
one lets wedges give way sideways: b_k = 1/(1 + (|L_k|/2|H_k|)⁴) is 1/2 in even cells, and
little in thin ones. Squares of lengths are at least 4/25 of those as drawn. Neighbours share a
side and all of this but for F, so that uniform strain leaves no forces within a body whose
sides are flat; those that are twisted by an angle a bow by 1/(1 + (a/0.3)²) as much. (Compare
the shear of plates that is sampled along edges of triangles: P.-S. Lee, K.-J. Bathe, Comput.
Struct. 82:945, 2004.)

The plane of the triangle has the curvatures κ_k = c_k/s_k relative to each present edge, with
s_k = max(|l_k|²/|L_k|², 4/25). Along ζ, there are e_3·g_2/s and e_3·g_1/s, s being that of the
edge 3, strains that grow along ξ and η, with free sides; and torsion,
3 (e_2·g_2 - e_1·g_1)/2 Σ s_k. These are six numbers of six modes. With the factor

    β' = √(3/4 (E - k0)/μ)

of the strains along ζ, a wedge stores what a bar in tension does. In the plane of its triangle,
strain is uniform.
"""

from collections.abc import Sequence
from typing import ClassVar

from tissuec import autodiff
from tissuec.autodiff import Number, Numbers, Tensor, Vector
from tissuec.forces.solids.bent_cell import (
    LEAST_SQUARE,
    BendingModuli,
    CellBending,
    CellModes,
    bent_in_plane,
    combined,
)
from tissuec.geometry.bent_cells import CellForm
from tissuec.geometry.bent_wedges import ENDS, TRIANGLE, WEDGE


class WedgeModes(CellModes):
    """Edges and modes of a wedge.

    Attributes:
        turns: c_k.
        edges: s_k.
    """

    cell: ClassVar[CellForm] = WEDGE

    def __init__(self, vectors: Sequence[Vector], c: Numbers):
        super().__init__(vectors, c)
        self.turns, self.edges = list[Number](), list[Number]()
        mean = self.mean
        for k, (i, j) in enumerate(ENDS):
            step, middle = (TRIANGLE[j] - TRIANGLE[i]).tolist(), (-0.5 * TRIANGLE[k]).tolist()
            edge, turn = (_along(step, *each) for each in (self.r[:2], self.q[::-1]))
            height = self.r[2] + _along(middle, *self.q[::-1])
            drawn = combined([edge, height, *self.e], c.tilt[5 * k : 5 * k + 5])
            self.turns.append(autodiff.dot(edge, turn - drawn))
            size = autodiff.dot(edge, edge) * c.inverse_edge[k]
            self.edges.append(autodiff.maximum(size, LEAST_SQUARE))
            out = combined(self.e, c.out[3 * k : 3 * k + 3])
            beside = autodiff.dot(edge, out) * c.inverse_edge[k] / self.edges[k]
            out = out - beside * edge
            far, high = (
                autodiff.maximum(autodiff.dot(each, each) * inverse, LEAST_SQUARE)
                for each, inverse in ((out, c.inverse_out[k]), (height, c.inverse_height[k]))
            )
            leans = self.turns[k] / far * out, c.up[3 * k : 3 * k + 3]
            bows = self.turns[k] / high * height, c.side[3 * k : 3 * k + 3]
            for moved, by in (leans, bows):
                mean = mean + Tensor([each * one for one in by] for each in moved)
        self.mean = mean

    def bending(
        self, squares: Sequence[Number], moduli: BendingModuli, c: Numbers
    ) -> CellBending:
        """Return how the cell bends; see ``CellModes``."""
        edges = self.edges
        kappa = [turn / edge for turn, edge in zip(self.turns, edges, strict=True)]
        bend, uneven = bent_in_plane(kappa, moduli.lateral, c.bend, c.trace, c.lateral)
        axial = autodiff.sqrt(0.75 * (moduli.young - moduli.slow) / moduli.shear)
        stretch = [autodiff.dot(self.e[2], g) / squares[2] for g in self.g[::-1]]
        torsion = autodiff.dot(self.e[1], self.g[1]) - autodiff.dot(self.e[0], self.g[0])
        torsion = 1.5 * torsion / (edges[0] + edges[1] + edges[2])
        along = [
            autodiff.from_half([
                axial * stretch[k] * c.axial[m] + torsion * c.torsion[6 * k + m]
                for m in range(6)
            ])
            for k in range(2)
        ]  # fmt: skip
        narrowing = autodiff.from_half([uneven * each for each in c.lateral])
        return CellBending([*along, bend], narrowing, [*kappa, *stretch, torsion])

    @property
    def volume(self) -> Number:
        """Return the volume over that of natural coordinates; see ``CellModes``."""
        (one, other, up), (first, second) = self.r, self.q
        more = autodiff.dot(up, autodiff.cross(second, first)) / 3.0
        return autodiff.dot(up, autodiff.cross(one, other)) + more

    @property
    def slopes(self) -> list[Number]:
        """Return the slopes of ``volume`` along ξ_k; see ``CellModes``."""
        (one, other, up), (first, second) = self.r, self.q
        across = autodiff.cross(one, other)
        rising = autodiff.dot(second, autodiff.cross(other, up))
        rising = rising + autodiff.dot(first, autodiff.cross(up, one))
        return [autodiff.dot(second, across), autodiff.dot(first, across), rising]

    def skewed(self, c: Numbers) -> list[Number]:
        """Return the slopes that j_k leave out, which is one along ζ; see ``CellModes``."""
        out = self.cell.volume / c.volume * autodiff.cross(self.e[0], self.e[1])
        parts = zip(c.skew, self.g[::-1], strict=True)
        one, other = (share * autodiff.dot(out, g) for share, g in parts)
        none = one.graph.number(0.0)
        return [none, none, one + other]

    @property
    def last(self) -> list[Number]:
        """Return an empty list: all modes of a wedge bend."""
        return []


def _along(step: Sequence[float], one: Vector, other: Vector) -> Vector:
    """Return the change of a vector along a step of natural coordinates, by its slopes."""
    return step[0] * one + step[1] * other
