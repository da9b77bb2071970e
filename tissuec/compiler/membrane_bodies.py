"""Walls made of finite elements: triangles in plane stress, and hinges between them.

A wall of the thickness t resists bending with the rigidity E t³ / (12 (1 - ν²)) of a plate.
"""

import numpy as np

from tissuec.compiler.drawn_bodies import Drawing
from tissuec.compiler.element_bodies import BodyElements, ElementReader
from tissuec.core.hints import leaving_out
from tissuec.core.vectors import cross, norm
from tissuec.forces.bending import Hinges, hinges_at
from tissuec.meshes.generators import ElementMesh
from tissuec.meshes.generators.imported import Imported
from tissuec.model.network import Floats
from tissuec.model.topology import springs_between
from tissuec.scene.fibres import AXIAL
from tissuec.scene.findings import Findings
from tissuec.scene.prestress import PRESTRESS

_ACROSS = 0.1  # part of a direction that must lie within each triangle
#: Pairs of nodes of a hinge that edges may join: all but its two tips.
_SIDES = np.array([[0, 1], [0, 2], [0, 3], [1, 2], [1, 3]])


class MembraneReader(ElementReader):
    """Gives the triangles of one drawing what tissues say.

    Args:
        drawing: Of a wall that is made of elements.
        findings: Takes diagnostics.
    """

    def __init__(self, drawing: Drawing, findings: Findings):
        super().__init__(drawing, findings)
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
        """Return how a surface from a file becomes a solid, "" of others."""
        is_filled = isinstance(self.body.mesh, Imported)
        return "; for a solid, filling is tetrahedra in the mesh" if is_filled else ""

    def elements(self) -> tuple[BodyElements, ...]:
        """Return the triangles with their moduli."""
        laws = tuple(map(self._law, self.parts.materials))
        young, ratio = self._constants(laws)
        shear, bulk = young / (2.0 * (1.0 + ratio)), young / (3.0 * (1.0 - 2.0 * ratio))
        from tissuec.forces.membranes import MembraneMaterial

        material = MembraneMaterial(
            shear, bulk, self._viscosity(shear), self.part.astype(np.int64), laws,
            np.full(len(self.part), self.thickness), *self._stretched(), self._fibres(),
        )  # fmt: skip
        one = self.triangles
        return (BodyElements(self.body.name, one.shape, one.nodes, material, self.made.span),)

    def hinges(self) -> Hinges | None:
        """Return the hinges of the wall; None where it does not resist bending."""
        mesh = self.drawing.mesh
        if self.body.shell is None:
            return None
        from tissuec.matter.plate import plate  # where walls need it

        found = plate(mesh)
        if not len(found.nodes):
            return None
        young, ratio = self._constants(tuple(map(self._law, self.parts.materials)))
        shear = young / (2.0 * (1.0 + ratio))
        rigidity = young * self.thickness**3 / (12.0 * (1.0 - ratio**2))
        delay = self._viscosity(shear) / shear
        stiffness, damping = (
            found.constant * self._at_nodes(each)[found.nodes].mean(axis=1)
            for each in (rigidity, rigidity * delay)
        )
        pairs = found.nodes[:, _SIDES].reshape(-1, 2)
        walls, which = springs_between(mesh.ends, pairs)
        owners = which // len(_SIDES)
        return hinges_at(mesh.position, found.nodes, stiffness, damping, walls, owners)

    def _at_nodes(self, values: Floats) -> Floats:
        """Return the means of the triangles around nodes, shape (node,), in the same unit."""
        nodes, count = self.triangles.nodes.ravel(), len(self.drawing.mesh.position)
        total = np.bincount(nodes, np.repeat(values * self.area, 3), count)
        share = np.bincount(nodes, np.repeat(self.area, 3), count)
        return total / np.where(share > 0.0, share, 1.0)

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
        share = np.array([0.0 if one is None else one.value for one in given])
        # Without stress, lengths are shorter by this part, like those of springs.
        stretch = 1.0 / (1.0 - share[self.part])
        return stretch, None if direction is None else direction.axis

    # --- fibres -------------------------------------------------------------------------------

    def _along(self, name: str, direction: Floats | str) -> Floats:
        """Return the direction of a family of fibres in the wall, shape (triangle, 3)."""
        if isinstance(direction, str):
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

    def _along_tube(self, name: str, direction: str) -> Floats:
        grid, position = self.drawing.mesh.grid, self.drawing.mesh.position
        if grid is None or not grid.closed:
            self.refuse_fibres(name, direction)
        axis = position[grid.columns] - position[0]
        axis = np.broadcast_to(axis / np.linalg.norm(axis), self.normal.shape)
        return axis if direction == AXIAL else cross(self.normal, axis)
