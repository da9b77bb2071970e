"""Matter of nets of springs: bars with a section in pascals, and volumes for densities.

A bar of the length L and section A has the spring constant E A / L. Threads are round; joints
and nets from tables or lines of a file state their section. Springs of solids and walls have
numbers of their own: these bodies consist of elements where their tissue is in pascals.
"""

from math import pi
from typing import NoReturn

import numpy as np

from tissuec.compiler.bodies.drawn import Drawing
from tissuec.core.errors import Note
from tissuec.meshes.generators import Threaded
from tissuec.meshes.stiffness_sharing import grid_areas, node_areas
from tissuec.model.network import Floats
from tissuec.scene.model import AssignedQuantity
from tissuec.scene.reading.findings import Findings
from tissuec.scene.tissues.quantities import QUANTITIES


class MatterReader:
    """Gives the springs and nodes of a drawing what follows from quantities of matter.

    Args:
        given: The quantity that needs it; named in messages.
    """

    #: Young's modulus over the shear modulus of a bar, whose Poisson's ratio is 1/4.
    shears = 2.5

    def __init__(self, drawing: Drawing, given: AssignedQuantity, findings: Findings):
        self.drawing, self.body, self.mesh = drawing, drawing.body, drawing.mesh
        self.given, self.findings = given, findings

    def section(self) -> float:
        """Return the area of the section of bars [m²]; springs of other kinds are rejected."""
        if not self.drawing.is_bars:
            self._refuse_net()
        if not self.drawing.length.all():
            self.findings.reject(
                "TIS309",
                f"a spring of {self.body.name} has zero length, so it cannot be made of matter",
                self.body.span,
                hint="write glue from A to B in place of its springs, which ties A to the "
                "elements of B, or give it a tissue with a spring constant, such as 20 kN/m",
                notes=self._notes(),
            )
        return self._section()

    def volumes(self) -> Floats:
        """Return the volume that each node represents [m³], shape (node,)."""
        mesh = self.mesh
        if self.drawing.is_bars:
            return self._section() * self._lengths()
        if mesh.volume is not None:
            self._refuse("thickness", "section")
            if not np.all(mesh.volume > 0.0):
                self.findings.reject(
                    "TIS309",
                    f"{self.body.name} cannot have a density: its cells have no known volume",
                    self.body.span,
                    hint="write a mass instead, or filling is tetrahedra",
                    notes=self._notes(),
                )
            return mesh.volume
        self._refuse("section")
        if self.body.thickness is None:
            self._missing("thickness", "thickness of its wall", "thickness = 1 mm")
        if (grid := mesh.even_grid) is None:
            return self.body.thickness * node_areas(mesh.position, mesh.skin)
        areas = grid_areas(mesh.position, grid.rows, grid.columns, closed=grid.closed)
        return self.body.thickness * areas

    def _section(self) -> float:
        """Return the area of the section of bars [m²]."""
        if isinstance(self.body.mesh, Threaded):
            self._refuse("thickness", "section")
            return pi * self.body.mesh.thread_radius() ** 2
        self._refuse("thickness")
        if self.body.section is None:
            self._missing("section", "area of the section of each spring", "section = 1 mm^2")
        return self.body.section

    def _lengths(self) -> Floats:
        """Return half of the lengths of all bars at each node [m], shape (node,)."""
        thread = self.drawing.thread
        pieces = slice(None) if thread is None else thread.pieces
        half = np.repeat(self.drawing.length[pieces] / 2.0, 2)
        ends = self.mesh.ends[pieces].ravel()
        return np.bincount(ends, half, len(self.mesh.position)).astype(float, copy=False)

    # --- findings -----------------------------------------------------------------------------

    def _refuse_net(self) -> NoReturn:
        """Reject a quantity in pascals of springs that fill a solid or a wall."""
        quantity = self.given.quantity
        own = QUANTITIES[quantity.instead].name
        self.findings.reject(
            "TIS306",
            f"springs of a solid or a wall have no {quantity.name}; elements, threads and bars "
            "have one",
            self.given.span,
            hint=f"write a {own} in the tissue, which applies to each spring",
            notes=(Note(f"used by {self.body.name}", self.body.span),),
        )

    def _notes(self) -> tuple[Note, ...]:
        return (Note("required by this entry", self.given.span),)

    def _missing(self, entry: str, what: str, example: str) -> NoReturn:
        self.findings.reject(
            "TIS304", f'{self.body.name} needs "{entry}": the {what}', self.body.span,
            hint=f"for example: {example}", notes=self._notes(),
        )  # fmt: skip

    def _refuse(self, *entries: str) -> None:
        """Reject entries that say nothing of a body like this."""
        for entry in entries:
            if getattr(self.body, entry) is not None:
                self.findings.reject(
                    "TIS306", f'body {self.body.name} cannot have "{entry}"',
                    self.body.places.get(entry, self.body.span),
                    hint=f"remove {entry}: the mesh already defines its dimensions",
                )  # fmt: skip
