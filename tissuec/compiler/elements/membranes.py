"""Walls made of finite elements: triangles in plane stress, which also resist bending.

A wall of the thickness t resists bending with the rigidity E t³ / (12 (1 - ν²)) of a plate.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.compiler.bodies.drawn import Drawing
from tissuec.compiler.elements.bodies import ElementReader, turned_around
from tissuec.compiler.elements.branches import branches_of
from tissuec.compiler.elements.yielding import yielding_of
from tissuec.core.arrays import cross, norm
from tissuec.core.hints import leaving_out
from tissuec.core.source import Span
from tissuec.meshes.generators import ElementMesh
from tissuec.meshes.generators.imported import Imported
from tissuec.model.blocks import FieldBlock
from tissuec.model.network import Floats, Indices
from tissuec.scene.bodies.fibres import Direction, Helix
from tissuec.scene.bodies.prestress import PRESTRESS
from tissuec.scene.reading.findings import Findings
from tissuec.script.verbs.cut_surface import Blade

if TYPE_CHECKING:
    from tissuec.forces.surfaces.membranes import Membranes

_ACROSS = 0.1  # part of a direction that must lie within each triangle


class WallBending(Struct, frozen=True, eq=False):
    """The bending resistance of a wall, with nodes numbered within its body.

    Attributes:
        body: The name of the body.
        nodes: Patches of triangles, see ``matter.plate``, shape (triangle, 6).
        beside: Numbers of their neighbours, or -1, shape (triangle, 3).
        stiffness: Of their folds [N m], shape (triangle, 3, 3).
        delay: Retardation time [s], shape (triangle,).
        span: The entry that requires it.
    """

    body: str
    nodes: Indices
    beside: Indices
    stiffness: Floats
    delay: Floats
    span: Span

    def block(
        self,
        position: Floats,
        first_node: int,
        ends: NDArray[np.int32],
        first_edge: int,
        first: int | None,
    ) -> FieldBlock:
        """Return the block of the wall.

        Args:
            position: Of all nodes of the network [m], shape (node, 3).
            first_node: Number of the first node of the body.
            ends: Nodes of its edges in the network, shape (edge, 2).
            first_edge: Number of the first of them.
            first: The first of its triangles as an entity; None where these neither break nor
                are divided.
        """
        from tissuec.forces.surfaces.plates import Plates

        triangles = None
        if first is not None:
            own = np.arange(len(self.nodes))[:, None]
            beside = np.where(self.beside < 0, own, self.beside)
            triangles = first + np.concatenate([own, beside], axis=1)
        return Plates.of(
            self.body, self.nodes + first_node, position, self.stiffness, self.delay, ends,
            first_edge, self.span, triangles,
        ).block  # fmt: skip


class MembraneReader(ElementReader):
    """Gives the triangles of one drawing what tissues say.

    Args:
        drawing: Of a wall that is made of elements.
        findings: Takes diagnostics.
        planes: Of symmetry of the scene.
    """

    def __init__(self, drawing: Drawing, findings: Findings, planes: Sequence[Blade] = ()):
        super().__init__(drawing, findings, planes)
        if drawing.body.thickness is None:
            self.findings.reject(
                "TIS304",
                f'{self.body.name} needs "thickness": the thickness of its wall',
                self.body.span,
                hint=f"for example: thickness = 1 mm{self._or_filled()}",
                notes=self._note,
            )
        self.thickness = drawing.body.thickness
        (self.triangles,) = drawing.mesh.elements
        corners = drawing.mesh.position[self.triangles.nodes]
        normal = cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        twice = norm(normal)
        self.normal, self.area = normal / twice[:, None], 0.5 * twice

    def _or_filled(self) -> str:
        """Return the hint to fill a surface from a file, "" for other meshes."""
        is_filled = isinstance(self.body.mesh, Imported)
        return "; for a solid, filling is tetrahedra in the mesh" if is_filled else ""

    def elements(self) -> "tuple[Membranes, ...]":
        """Return the triangles, with nodes and entities counted in the body."""
        laws = tuple(map(self._law, self.parts.materials))
        young, ratio = self._constants(laws)
        shear, bulk = young / (2.0 * (1.0 + ratio)), young / (3.0 * (1.0 - 2.0 * ratio))
        from tissuec.forces.surfaces.membranes import MembraneMaterial, Membranes

        material = MembraneMaterial(
            shear, bulk, self._checked(shear, bulk), self.part.astype(np.int64), laws,
            np.full(len(self.part), self.thickness), *self._stretched(), self._fibres(),
            self.limits.limits, branches_of(self.parts, self.part, shear, 2),
            yielding_of(self.parts, self.part, 2),
        )  # fmt: skip
        nodes, position = self.triangles.nodes, self.drawing.mesh.position
        own = self.body.name, nodes, position, material, 0, self.made.span
        return (Membranes.of(*own),)

    def bending(self) -> WallBending | None:
        """Return the bending stiffness of the wall; None without any."""
        if self.body.shell is None:
            return None
        from tissuec.matter.plate import patches  # where walls need it

        young, ratio = self._constants(tuple(map(self._law, self.parts.materials)))
        rigidity = young * self.thickness**3 / (12.0 * (1.0 - ratio**2))
        shear, found = young / (2.0 * (1.0 + ratio)), patches(self.drawing.mesh)
        delay = self._viscosity(shear) / shear
        stiffness = found.stiffness(rigidity, ratio)
        parts = found.nodes, found.beside, stiffness, delay, self.body.shell
        return WallBending(self.body.name, *parts)

    def _turning(self, density: Floats) -> Floats:
        """Return the mass of nodes [kg], a third of each triangle, shape (node,)."""
        return self._lumped(density)

    def _shares(self, elements: ElementMesh) -> Floats:
        """Return a third of the volume of each triangle [m³], shape (triangle, 3)."""
        assert self.thickness is not None
        return np.repeat(self.thickness / 3.0 * self.area[:, None], 3, axis=1)

    def _stretched(self) -> tuple[Floats, Floats | None]:
        """Return the prestretch of each triangle, shape (triangle,), and its axis, if any."""
        given = self.parts.found(PRESTRESS)
        direction = self.body.prestress
        if direction is not None:
            self.require_prestress()
            if direction.is_across:
                self.findings.reject(
                    "TIS306",
                    f"the prestress of {self.body.name} needs no plane: it is that of the wall",
                    self.body.places[PRESTRESS],
                    hint=leaving_out("remove it", self.body.places[PRESTRESS]),
                )
            self._within(PRESTRESS, direction.axis)
        share = self.parts.at_elements(given, 0.0)
        # Without stress, lengths are shorter by this part, like those of springs.
        stretch = 1.0 / (1.0 - share)
        return stretch, None if direction is None else direction.axis

    # --- fibres -------------------------------------------------------------------------------

    def _along(self, name: str, direction: Direction) -> Floats:
        """Return the direction of a family of fibres in the wall, shape (triangle, 3)."""
        if isinstance(direction, str | Helix):
            return self._along_tube(name, direction)
        return self._within(name, direction)

    def _within(self, name: str, direction: Floats) -> Floats:
        """Return a direction in the planes of triangles; reject one across the wall.

        Args:
            name: The entry that gives it.
            direction: Unit vector, shape (3,).

        Returns:
            Of any length, shape (triangle, 3).
        """
        across = self.normal @ direction
        within = direction - across[:, None] * self.normal
        if norm(within).min() < _ACROSS:
            self.findings.reject(
                "TIS309",
                f"{self.body.name} cannot have this direction of {name}: it is perpendicular "
                "to the wall",
                self.body.places[name],
                hint="write a direction within the wall"
                + ("" if name == PRESTRESS else ", or, in a tube, axial or circumferential"),
            )
        return within

    def _along_tube(self, name: str, direction: str | Helix) -> Floats:
        grid, position = self.drawing.mesh.grid, self.drawing.mesh.position
        if grid is None or not grid.closed:
            self.refuse_fibres(name, direction)
        centre = position.reshape(grid.rows, grid.columns, 3).mean(axis=1)
        along = np.diff(centre, axis=0)
        ring = self.triangles.nodes.min(axis=1) // grid.columns
        axis = (along / norm(along)[:, None])[ring]
        return turned_around(axis, cross(axis, self.normal), direction)
