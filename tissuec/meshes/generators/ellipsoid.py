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

#: Along which axes only the positive half is drawn.
PARTS = {
    "whole": (False, False, False),
    "half": (False, False, True),
    "quarter": (False, True, True),
    "eighth": (True, True, True),
}


@MESHES.member("ellipsoid")
class Ellipsoid(Hexahedral, frozen=True, eq=False):
    """A solid ellipsoid of hexahedra, without a pole: a core of cubes in layers.

    Its axes are x, y and z; a ball has three equal radii. Corners of the outer cells are on the
    surface of the ellipsoid, so that the mesh is somewhat smaller: with four cells across by
    23 % of the volume, with eight by 7 %, with sixteen by 2 %. A half, which has the positive
    z, a quarter (y and z) or an eighth end at planes of symmetry through the centre.

    Nodes of the surface of the ellipsoid are the group ``surface``.

    A net of springs has springs along the edges of the cells, and across all of their faces.

    Attributes:
        centre: Centre of the ellipsoid.
        radii: Half its width along x, y and z.
        cell: Usual edge of a cell; at least four cells are across.
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
