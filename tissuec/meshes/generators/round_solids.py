"""Round solids: cylinders and cones, balls and ellipsoids."""

from typing import Annotated

import numpy as np

from tissuec.core import units
from tissuec.core.fields import Axis, Length, LengthIfAny, OneOf, Point, Position
from tissuec.geometry.edges import Floats, Indices
from tissuec.meshes.generators import MESHES
from tissuec.meshes.generators.centreline import BENDS, SMOOTH, Centreline
from tissuec.meshes.generators.hexahedral import Hexahedral, RoundCells, in_order_of_vtk
from tissuec.meshes.generators.joining import require_limits

#: For each of the two directions across the axis, whether only the positive half is drawn.
CYLINDER_PARTS = {"whole": (False, False), "half": (False, True), "quarter": (True, True)}


@MESHES.member("cylinder")
class Cylinder(Hexahedral, frozen=True, eq=False):
    """A solid cylinder of hexahedra, tapered if both ends have different radii.

    Corners of the outer cells lie on the surface of the cylinder, so the mesh has somewhat less
    volume: 10 % less with four cells across, 3 % less with eight. A half or a quarter ends at
    planes of symmetry through the axis. They face the direction in which a tube has its first
    side, and the direction at right angles to it.

    The axis can lead through a list of points, as that of a tube; then the cylinder is whole.

    Nodes of the ends and of the surface around the axis are the groups ``first end``, ``last
    end`` and ``side``.

    A net of springs has springs along the edges of the cells and the diagonals of their faces.

    Attributes:
        axis: Centres of the first and the last end, or points of a curve.
        radius: Radius of the cylinder at its first end.
        end_radius: Radius at its last end; by default, that of the first end.
        cell: Typical edge of a cell; there are at least four cells across.
        bends: How a curve leads through its points: smooth, or sharp with straight pieces.
        part: The part of the cylinder that is drawn: whole, half or quarter.
    """

    axis: Axis
    radius: Length
    cell: Length
    end_radius: LengthIfAny = None
    bends: Annotated[str, OneOf(BENDS)] = SMOOTH
    part: Annotated[str, OneOf(tuple(CYLINDER_PARTS))] = "whole"

    def __post_init__(self) -> None:
        require_limits(self)
        if self.part != "whole" and len(self.axis) > 2:
            raise ValueError(f'"part is {self.part}" needs a straight axis')
        self._line.require_rings(self._along + 1, self.radius, self._last)

    def counts(self) -> tuple[int, int, int]:
        """Return the numbers of nodes, edges and faces."""
        (nodes, edges, faces), along = self._round.counts(), self._along
        return (
            nodes * (along + 1),
            edges * (along + 1) + nodes * along,
            faces * (along + 1) + edges * along,
        )

    def cells(self) -> tuple[Floats, Indices, dict[str, Indices]]:
        """Return nodes, hexahedra, and the ends and the side; see ``Hexahedral``."""
        place, squares, circle = self._round.build()
        count, along = len(place), self._along
        centre, across, share = self._line.rings(along + 1, self.radius, self._last)
        radius = (1.0 - share) * self.radius + share * self._last
        position = centre[:, None] + radius[:, None, None] * (place @ across)
        layer = count * np.arange(along)[:, None, None] + squares
        cells = np.concatenate([layer, layer + count], axis=2).reshape(-1, 8)
        first = np.arange(count)
        groups = {
            "first end": first,
            "last end": count * along + first,
            "side": (count * np.arange(along + 1)[:, None] + circle).ravel(),
        }
        return position.reshape(-1, 3), in_order_of_vtk(cells), groups

    @property
    def _along(self) -> int:
        """Return the number of cells along the axis."""
        line = self._line
        least = 1 if line.is_straight else len(self.axis) - 1
        return max(round(line.length / self.cell), least)

    @property
    def _line(self) -> Centreline:
        return Centreline(self.axis, self.bends)

    @property
    def _last(self) -> float:
        """Return the radius at the last end [m]."""
        return self.radius if self.end_radius is None else self.end_radius

    @property
    def _round(self) -> RoundCells:
        radii = [max(self.radius, self.end_radius or 0.0)] * 2
        return RoundCells.of(radii, self.cell, CYLINDER_PARTS[self.part])


#: For each axis, whether only the positive half is drawn.
BALL_PARTS = {
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
    part: Annotated[str, OneOf(tuple(BALL_PARTS))] = "whole"

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
        return RoundCells.of(self.radii.tolist(), self.cell, BALL_PARTS[self.part])
