"""A solid ball or ellipsoid, such as a gland or a tumour."""

from typing import Annotated

import numpy as np

from tissuec.core import units
from tissuec.core.fields import Length, OneOf, Point, Position
from tissuec.geometry.edges import Floats, Indices
from tissuec.meshes.generators import MESHES
from tissuec.meshes.generators.hexahedral import Hexahedral, in_order_of_vtk
from tissuec.meshes.generators.limits import require_limits
from tissuec.meshes.generators.round_cells import RoundCells

#: For each axis, whether only the positive half is drawn.
PARTS = {
    "whole": (False, False, False),
    "half": (False, False, True),
    "quarter": (False, True, True),
    "eighth": (True, True, True),
}


@MESHES.member("ellipsoid")
class Ellipsoid(Hexahedral, frozen=True, eq=False):
    """A solid ellipsoid of hexahedra, without poles: layers around a core of cubes.

    Its axes are x, y and z; a ball has three equal radii. Corners of the outer cells lie on the
    surface of the ellipsoid, so the mesh has somewhat less volume: 23 % less with four cells
    across, 7 % less with eight, 2 % less with sixteen. A half (positive z), a quarter (positive
    y and z) or an eighth ends at planes of symmetry through the centre.

    Nodes of the surface of the ellipsoid are the group ``surface``.

    A net of springs has springs along the edges of the cells and the diagonals of their faces.

    Attributes:
        centre: Centre of the ellipsoid.
        radii: Half its width along x, y and z.
        cell: Typical edge of a cell; there are at least four cells across.
        part: The part of the ellipsoid that is drawn: whole, half, quarter or eighth.
    """

    centre: Position
    radii: Annotated[Floats, Point(units.LENGTH)]
    cell: Length
    part: Annotated[str, OneOf(tuple(PARTS))] = "whole"

    def __post_init__(self) -> None:
        require_limits(self)
        if not (np.asarray(self.radii) > 0.0).all():
            raise ValueError('"radii" must be three lengths above 0 m')

    def counts(self) -> tuple[int, int, int]:
        """Return the numbers of nodes, edges and faces."""
        return self._round.counts()

    def cells(self) -> tuple[Floats, Indices, dict[str, Indices]]:
        """Return nodes, hexahedra, and the surface; see ``Hexahedral``."""
        place, cells, surface = self._round.build()
        position = np.asarray(self.centre) + place * np.asarray(self.radii)
        return position, in_order_of_vtk(cells), {"surface": surface}

    @property
    def _round(self) -> RoundCells:
        return RoundCells.of(self.radii.tolist(), self.cell, PARTS[self.part])
