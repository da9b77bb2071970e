"""Hexahedra and wedges that bend; see ``solids.bent_cell`` for what they store.

Their points are strained by all nodes of a cell together.
"""

from collections.abc import Mapping, Sequence
from typing import Any, Self

import numpy as np

from tissuec.autodiff.evaluation import evaluate
from tissuec.autodiff.graph import Number
from tissuec.autodiff.points import TracedPoint
from tissuec.compiled.loops.cell_matrices import column_loop, strain_loop
from tissuec.compiled.loops.point_frame import PointTable
from tissuec.compiled.loops.point_matrices import matrix_loop
from tissuec.core.structs import replace
from tissuec.forces.matrices import BlockPattern, without_negative
from tissuec.forces.point_kernels import kernel_of
from tissuec.forces.solids.elements import SolidElements
from tissuec.forces.solids.solid_point import SolidKind, evened
from tissuec.forces.solids.solid_strain import Prestretch
from tissuec.geometry.bent_cells import HEXAHEDRON, BentCells, CellForm
from tissuec.geometry.bent_wedges import WEDGE, BentWedges
from tissuec.geometry.elements import ElementShape, Measures
from tissuec.model.network import Floats, Indices

_ALONE = "alone"
# Of one evaluation of a box, of another cell, and in addition where they are viscous.
_BOX_SECONDS, _SECONDS, _VISCOUS_SECONDS = 1.0e-7, 1.35e-7, 1.0e-7


class BentElements(SolidElements, frozen=True):
    """Hexahedra or wedges that bend.

    ``drawn`` has gradients without prestretch, which is ``stretches`` here.

    Attributes:
        cells: Numbers of ``BentCells`` or ``BentWedges``, as ``drawn`` one row for all that are
            alike.
        are_boxes: Whether they are those of ``BentCells.boxes``.
    """

    cells: Floats
    are_boxes: bool

    @staticmethod
    def _stretched(
        prestretch: Prestretch, drawn: Measures, row: Indices
    ) -> tuple[Measures, Indices]:
        return drawn, row

    @classmethod
    def _with(cls, attributes: Mapping[str, Any], corners: Floats) -> Self:
        own = dict(attributes)
        drawn, prestretch = own.pop("drawn"), own["prestretch"]
        # Points are of equal weight, so that bending has no mean.
        mean = drawn.volume.mean(axis=1, keepdims=True)
        even = np.repeat(mean, drawn.volume.shape[1], axis=1)
        _, first = np.unique(own["row"], return_index=True)
        numbers, are_boxes = _numbers_of(own["shape"], corners[first])
        stretches = np.zeros((len(corners), 0))
        if prestretch is not None:
            stretches = prestretch.deformation.reshape(-1, 9)
        return cls(
            **own, drawn=Measures(drawn.gradients, even), stretches=stretches,
            cells=numbers, are_boxes=are_boxes,
        )  # fmt: skip

    @property
    def kind(self) -> SolidKind:
        """Return the kind of the points, of which forces are."""
        is_wedge = self.form is WEDGE
        return super().kind._replace(is_bent=True, is_box=self.are_boxes, is_wedge=is_wedge)

    @property
    def form(self) -> CellForm:
        """Return the natural coordinates."""
        return WEDGE if self.shape.name == "wedge" else HEXAHEDRON

    @property
    def with_stretches(self) -> Self:
        """Return the elements with ``stretches``; see ``PointField``."""
        if self.stretches.size:
            return self
        return replace(self, stretches=np.tile(np.eye(3).ravel(), (self.item_count, 1)))

    @property
    def steepness(self) -> Floats:
        """Return ∂N/∂X by places without stress; see ``PointField``."""
        slopes = super().steepness
        if not self.stretches.size:
            return slopes
        return np.asarray(slopes @ self.stretches.reshape(-1, 1, 3, 3))

    def volumetric(self) -> dict[str, Floats]:
        """Return the bulk modulus; see ``PointField``."""
        return {"bulk": self.bulk}

    def _with_volumetric(self, numbers: Mapping[str, Floats]) -> dict[str, Any]:
        return {"bulk": numbers["bulk"]}

    # --- states -------------------------------------------------------------------------------

    def deformations(self, position: Floats) -> Floats:
        """Return F (1 + D), with prestretch, at all points; see ``PointField``."""
        flat = np.stack(self.seen("deformation", position), axis=-1)
        return flat.reshape(*flat.shape[:-1], 3, 3)

    def _strains(
        self, position: Floats, outputs: Sequence[Number], kind: SolidKind,
        numbers: Mapping[str, Floats],
    ) -> dict[str, Floats]:  # fmt: skip
        """Return inputs of a point by name, shape (…, element, point), or (…, element, 1).

        Among them is what a cell stores besides its points, ``_ALONE`` [J].
        """
        point = self.traced(kind)
        cell = point.cell
        assert cell is not None
        needed, begins = point.needed_by(point.graph.inputs_of(outputs)), cell.begins
        some = [q for k in needed for q in range(begins[k], begins[k + 1])]
        wanted = [*(cell.strains[q] for q in some), cell.swell, cell.energy]
        *found, swell, alone = evaluate(wanted, {**self._of_cell(position), **numbers})
        terms, values = self.form.terms, {"swell": swell, _ALONE: alone}
        for k in needed:
            own = [found[some.index(q)] for q in range(begins[k], begins[k + 1])]
            values[f"f.{k}"] = own[0] + sum(
                a * b for a, b in zip(own[1:], terms[1:], strict=False)
            )
        return values

    def _of_cell(self, position: Floats) -> dict[str, Floats]:
        """Return inputs of whole cells by name, shape (…, element, 1)."""
        vectors = np.einsum("va,...eax->...evx", self.form.shares, position[..., self.nodes, :])
        flat = vectors.reshape(*vectors.shape[:-2], -1)
        values = {f"x.{k}": flat[..., k, None] for k in range(flat.shape[-1])}
        drawn, cell = self.cells[self.row], self.traced(self.kind).cell
        assert cell is not None
        for k, each in enumerate(cell.drawn):
            values[str(each.operation.detail)] = drawn[:, k, None]
        return values

    def _alone(
        self, point: TracedPoint, pooled: Floats, values: dict[str, Floats]
    ) -> Floats:  # fmt: skip
        """Return the energy that cells store besides their points [J]; see ``PointField``."""
        return np.asarray(values[_ALONE][..., 0])

    # --- matrices -----------------------------------------------------------------------------

    def element_matrices(self, position: Floats, *, exact: bool) -> Floats:
        """Return ∂²E/∂x∂x of each element; see ``PointField``.

        Without ``exact``, negative eigenvalues of each element count as zero.
        """
        count = self.shape.nodes
        apart = np.arange(count * self.item_count).reshape(-1, count)
        pattern, (kind, points) = BlockPattern.of(apart, apart.size), self._stiffened
        table = self._table(kind, self.nodes, self.slots)
        room, kernel = pattern.room, kernel_of(matrix_loop, self.traced, kind, count, points)
        self._run(kernel, position, room, table._replace(targets=pattern.places.ravel()))
        found = pattern.blocks(room).reshape(-1, 3 * count, 3 * count)
        if not exact:
            found = without_negative(found)
        return found.reshape(-1, count, 3, count, 3)

    def damping_of_elements(self, position: Floats) -> Floats:
        """Return minus the derivative of viscous forces by velocities; see ``ElementField``."""
        return self._columns_of("v", position)

    def braking_by_position(self, position: Floats, velocity: Floats) -> Floats:
        """Return minus the derivative of viscous forces by positions; see ``PointField``."""
        return self._columns_of("x", position, velocity)

    def _columns_of(self, by: str, position: Floats, velocity: Floats | None = None) -> Floats:
        """Return minus derivatives of viscous forces, shape (element, node, 3, node, 3).

        Args:
            by: See ``column_loop``.
            position, velocity: Of all nodes [m], [m/s], shape (node, 3).
        """
        counts = self.shape.nodes, self.points
        kernel = kernel_of(column_loop, self.traced, self._present, by, *counts)
        shares, count = self.form.shares, len(self.form.shares)
        shape = count, 3, count, 3
        columns = self._recorded_by(kernel, self._present, shape, position, velocity)
        return np.einsum("ewyvx,va,wb->eaxby", columns, shares, shares, optimize=True)

    def strain_slopes(self, position: Floats) -> Floats:
        """Return the derivatives of strains of points by positions; see ``PointField``."""
        # Of all that acts, also what is remembered.
        point, shares = self.traced(self.kind), self.form.shares
        assert point.cell is not None
        active, begins = point.cell.active, point.cell.begins
        counts = self.shape.nodes, self.points
        kernel = kernel_of(strain_loop, self.traced, self.kind, *counts)
        shape = len(shares), 3, len(active)
        slopes = self._recorded_by(kernel, self.kind, shape, position)
        by_node = np.einsum("evxq,va->eqax", slopes, shares)
        to = np.zeros((len(self.form.points), len(point.f), len(active)))
        for k in point.active:
            for q, term in zip(range(begins[k], begins[k + 1]), self.form.terms, strict=False):
                to[:, k, active.index(q)] = term
        return np.einsum("pkq,eqax->epkax", to, by_node)

    # --- for the engine -----------------------------------------------------------------------

    @property
    def _bare_seconds(self) -> float:
        """Return ``seconds`` without what points remember; see ``PointField``."""
        one = _BOX_SECONDS if self.are_boxes else _SECONDS
        return self.item_count * (one + _VISCOUS_SECONDS * self.is_damped)

    def _counted(self, kind: SolidKind) -> tuple[SolidKind, int]:
        """Return the kind that kernels use for a kind, and their number of points."""
        own = evened(kind)
        return own, 1 if own.is_even else self.points

    def _table(self, kind: SolidKind, nodes: Indices, slots: Indices) -> PointTable:
        used, row = np.unique(self.row, return_inverse=True)
        at, weight = self.form.points, self.drawn.volume[used]
        if kind.is_even:
            at, weight = np.zeros((1, 3)), weight.sum(axis=1, keepdims=True)
        places = np.broadcast_to(at[:, :, None], (len(used), *at.shape, 1))
        return PointTable.of(
            nodes, self._numbers(kind), row.reshape(-1), places, weight,
            slots[: kind.tensors], self.cells[used],
        )  # fmt: skip


def _numbers_of(shape: ElementShape, corners: Floats) -> tuple[Floats, bool]:
    """Return the numbers of cells as drawn, shape (cell, number), and whether all are boxes.

    Args:
        shape: Of the cells.
        corners: Of their nodes [m], shape (cell, node, 3).
    """
    if shape.name == "wedge":
        return BentWedges.of(corners).rows, False
    cells = BentCells.of(corners)
    return (cells.boxes, True) if cells.are_boxes else (cells.rows, False)


def kind_of(shape: ElementShape) -> type[SolidElements]:
    """Return the class of elements of a shape."""
    if shape.functions > 1:
        from tissuec.forces.solids.quadratic import QuadraticHexahedra  # where they are needed

        return QuadraticHexahedra
    return BentElements if shape.bends else SolidElements
