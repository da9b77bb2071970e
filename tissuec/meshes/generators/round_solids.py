"""Round solids of hexahedra: cylinders, cones, balls, ellipsoids, and thick-walled tubes."""

from typing import Annotated, Self

import numpy as np
from numpy.typing import NDArray

from tissuec.core import units
from tissuec.core.arrays import cross, norm
from tissuec.core.fields import (
    Axis,
    Count,
    Length,
    LengthIfAny,
    OneOf,
    Point,
    Position,
    UnfitEntries,
    Whole,
)
from tissuec.core.structs import replace
from tissuec.core.units import LENGTH, show
from tissuec.geometry.edges import Floats, Indices
from tissuec.meshes.generators import MESHES
from tissuec.meshes.generators.centreline import BENDS, SMOOTH, Centreline
from tissuec.meshes.generators.hexahedral import Hexahedral, RoundCells, in_order_of_vtk
from tissuec.meshes.generators.joining import require_limits


def _cone(axis: Axis, first: float, last: float) -> float | None:
    """Return the volume of a straight cone between two radii [m³]; None of a curved one.

    Args:
        axis: Points that it leads through [m], shape (point, 3).
        first, last: Radii at its ends [m].
    """
    if len(axis) > 2:
        return None
    long = float(np.linalg.norm(np.asarray(axis[1]) - np.asarray(axis[0])))
    return np.pi * long * (first**2 + first * last + last**2) / 3.0


#: For each of the two directions across the axis, whether only the positive half is drawn.
CYLINDER_PARTS = {"whole": (False, False), "half": (False, True), "quarter": (True, True)}


@MESHES.member("cylinder")
class Cylinder(Hexahedral, frozen=True, eq=False):
    """A solid cylinder of hexahedra, tapered if both ends have different radii.

    The cells of a body of elements have the sections of the cylinder: their outer corners lie
    5 % of the radius outside of its surface with four cells across, 1.3 % with eight. In a net
    of springs, corners lie on the surface, and the mesh has less volume: 10 % and 3 %. A half
    or a quarter ends at planes of symmetry through the axis. They face the direction in which a
    tube has its first side, and the direction at right angles to it.

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

    @property
    def shape_volume(self) -> float | None:
        """The volume of a straight cylinder or cone, or of its part [m³]; None of a curve."""
        whole = _cone(self.axis, self.radius, self._last)
        return whole and whole / 2 ** sum(CYLINDER_PARTS[self.part])

    def refined(self) -> Self:
        """Return the same shape with cells half as long."""
        return replace(self, cell=0.5 * min(self.cell, 0.5 * self.radius))

    def counts(self) -> tuple[int, int, int]:
        """Return the numbers of nodes, edges and faces."""
        (nodes, edges, faces), along = self._round.counts(), self._along
        return (
            nodes * (along + 1),
            edges * (along + 1) + nodes * along,
            faces * (along + 1) + edges * along,
        )

    def cells(self, *, swollen: bool) -> tuple[Floats, Indices, dict[str, Indices]]:
        """Return nodes, hexahedra, and the ends and the side; see ``Hexahedral``."""
        place, squares, circle = self._round.build(swollen=swollen)
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
    def sheets(self) -> tuple[Indices, ...]:
        """The sections of nodes, one behind the other."""
        return (np.arange(self.counts()[0]).reshape(self._along + 1, -1),)

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

    Its axes are x, y and z; a ball has three equal radii. The cells of a body of elements have
    the volume of the ellipsoid: their outer corners lie 9 % of a radius outside of its surface
    with four cells across, 2.3 % with eight. In a net of springs, corners lie on the surface,
    and the mesh has less volume: 23 % and 7 %. A half (positive z), a quarter (positive y and
    z) or an eighth ends at planes of symmetry through the centre.

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

    @property
    def shape_volume(self) -> float | None:
        """The volume of the ellipsoid, or of its part [m³]."""
        whole = 4.0 / 3.0 * np.pi * float(np.prod(self.radii))
        return whole / 2 ** sum(BALL_PARTS[self.part])

    def refined(self) -> Self:
        """Return the same shape with cells half as long."""
        return replace(self, cell=0.5 * min(self.cell, 0.5 * float(min(self.radii))))

    def counts(self) -> tuple[int, int, int]:
        """Return the numbers of nodes, edges and faces."""
        return self._round.counts()

    def cells(self, *, swollen: bool) -> tuple[Floats, Indices, dict[str, Indices]]:
        """Return nodes, hexahedra, and the surface; see ``Hexahedral``."""
        place, cells, surface = self._round.build(swollen=swollen)
        position = np.asarray(self.centre) + place * np.asarray(self.radii)
        return position, in_order_of_vtk(cells), {"surface": surface}

    @property
    def _round(self) -> RoundCells:
        return RoundCells.of(self.radii.tolist(), self.cell, BALL_PARTS[self.part])


PARTS = {"whole": 1, "half": 2, "quarter": 4}


@MESHES.member("thick tube")
class ThickTube(Hexahedral, frozen=True, eq=False):
    """A tube whose wall is a solid of hexahedra, numbered ring by ring from the inside.

    A whole tube has ``rings`` × ``sides`` × (``layers`` + 1) nodes. Each ring
    begins where that of a thin tube would; half a tube, or a quarter, also begins there, and
    ends at a plane of symmetry. All layers are equally thick. The cells of a body of elements
    have the sections of the tube and of its lumen: nodes lie outside of the radii by 1.3 % with
    16 sides, 0.3 % with 32. In a net of springs, they lie on the radii.

    The axis can lead through a list of points, as that of a thin tube; then the tube is whole.

    Nodes of the ends and of both surfaces are the groups ``first end``, ``last end``,
    ``inside`` and ``outside``.

    A net of springs has springs along the edges of the cells and the diagonals of their faces.

    Attributes:
        axis: Centres of the first and the last ring, or points of a curve.
        inner_radius: Distance of the innermost nodes from the axis.
        outer_radius: Distance of the outermost nodes from the axis.
        rings: Number of rings of nodes, both ends included.
        sides: Number of cells around the axis of the whole tube. Where the wall is bent, as by
            a ring that is pressed flat, 32 are 2 % too stiff if it is a tenth of the radius
            thick, and 7 % if it is a fiftieth.
        layers: Number of cells across the wall.
        end_inner_radius: Inner radius at the last end; by default, that of the first end.
        end_outer_radius: Outer radius at the last end; by default, that of the first end.
        bends: How a curve leads through its points: smooth, or sharp with straight pieces.
        part: The part of the tube that is drawn: whole, half or quarter.
    """

    axis: Axis
    inner_radius: Length
    outer_radius: Length
    rings: Annotated[int, Whole(at_least=2)]
    sides: Annotated[int, Whole(at_least=3)] = 32
    layers: Count = 3
    end_inner_radius: LengthIfAny = None
    end_outer_radius: LengthIfAny = None
    bends: Annotated[str, OneOf(BENDS)] = SMOOTH
    part: Annotated[str, OneOf(tuple(PARTS))] = "whole"

    def __post_init__(self) -> None:
        require_limits(self)
        if not self.inner_radius < self.outer_radius:
            inner, outer = (show(r, LENGTH) for r in (self.inner_radius, self.outer_radius))
            raise UnfitEntries(
                f'"outer radius" is {outer}; it must be larger than "inner radius", {inner}',
                f"if both are interchanged: inner radius = {outer}; outer radius = {inner}"
                if self.inner_radius > self.outer_radius
                else "the difference of both is the thickness of the wall",
            )
        (_, inner), (_, outer) = self._radii
        if not inner < outer:
            raise ValueError(
                "the outer radius at the last end must be larger than the inner one"
            )
        if self.part != "whole" and len(self.axis) > 2:
            raise ValueError(f'"part is {self.part}" needs a straight axis')
        if self.sides % PARTS[self.part]:
            raise ValueError(
                f'"sides" must be a multiple of {PARTS[self.part]} for "part is {self.part}"'
            )
        self._line.require_rings(self.rings, *self._radii[1])

    @property
    def shape_volume(self) -> float | None:
        """The volume of a straight tube, or of its part [m³]; None of a curve."""
        inner, outer = (_cone(self.axis, *radii) for radii in self._radii)
        if inner is None or outer is None:
            return None
        return (outer - inner) / PARTS[self.part]

    def refined(self) -> Self:
        """Return the same shape with cells half as long."""
        rings, sides = 2 * self.rings - 1, 2 * self.sides
        return replace(self, rings=rings, sides=sides, layers=2 * self.layers)

    def counts(self) -> tuple[int, int, int]:
        """Return the numbers of nodes, edges and faces."""
        columns, layers, around = self._columns, self.layers, self.sides // PARTS[self.part]
        along = self.rings - 1
        edges = along * columns * (layers + 1)
        edges += self.rings * (around * (layers + 1) + columns * layers)
        faces = self.rings * around * layers + along * columns * layers
        faces += along * around * (layers + 1)
        return self.rings * columns * (layers + 1), edges, faces

    def cells(self, *, swollen: bool) -> tuple[Floats, Indices, dict[str, Indices]]:
        """Return nodes, hexahedra, and the ends and surfaces; see ``Hexahedral``."""
        shape = self.rings, self._columns, self.layers + 1
        number = np.arange(np.prod(shape)).reshape(shape)
        groups = {
            "first end": number[0],
            "last end": number[-1],
            "inside": number[:, :, 0],
            "outside": number[:, :, -1],
        }
        named = {name: nodes.ravel() for name, nodes in groups.items()}
        return self._position(swollen=swollen), self._cells(number), named

    @property
    def sheets(self) -> tuple[Indices, ...]:
        """Rings of nodes along the axis, and layers from the inside on."""
        number = np.arange(self.counts()[0]).reshape(self.rings, self._columns, -1)
        layers = number.transpose(2, 0, 1).reshape(self.layers + 1, -1)
        return number.reshape(self.rings, -1), layers

    @property
    def on_shape(self) -> Floats:
        """Places of nodes on the radii [m], shape (node, 3)."""
        return self._position(swollen=False)

    @property
    def _columns(self) -> int:
        """Return the number of nodes around the axis in one layer of a ring."""
        return self.sides // PARTS[self.part] + (self.part != "whole")

    def _cells(self, number: NDArray[np.int64]) -> Indices:
        """Return the corners of the hexahedra, shape (cell, 8)."""
        ahead = np.roll(number, -1, axis=1)
        lower = [number[:, :, :-1], number[:, :, 1:], ahead[:, :, 1:], ahead[:, :, :-1]]
        if self.part != "whole":
            lower = [part[:, :-1] for part in lower]
        corners = [part[:-1] for part in lower] + [part[1:] for part in lower]
        return np.stack([part.ravel() for part in corners], axis=1)

    @property
    def _radii(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return the inner and the outer radius, at the first and the last end each."""
        inner, outer = self.inner_radius, self.outer_radius
        return (inner, self.end_inner_radius or inner), (outer, self.end_outer_radius or outer)

    @property
    def _line(self) -> Centreline:
        return Centreline(self.axis, self.bends)

    @property
    def is_even(self) -> bool:
        """Return whether it is straight and equally wide everywhere."""
        return len(self.axis) == 2 and all(first == last for first, last in self._radii)

    def _position(self, *, swollen: bool) -> Floats:
        centre, across, share = self._line.rings(self.rings, *self._radii[1])
        turn = 2.0 * np.pi / self.sides
        angle = np.arange(self._columns)[:, None] * turn
        swelling = np.sqrt(turn / np.sin(turn)) if swollen else 1.0
        ring = np.cos(angle) * across[:, :1] + np.sin(angle) * across[:, 1:]
        first, last = np.linspace(*self._radii, self.layers + 1).T
        radius = first + share[:, None] * (last - first)
        wall = ring[:, :, None] * (swelling * radius)[:, None, :, None]
        return (centre[:, None, None, :] + wall).reshape(-1, 3)


def along_and_around(corners: Floats) -> tuple[Floats, Floats]:
    """Return unit vectors along and around a tube in its cells, shape (cell, 3) each.

    Args:
        corners: Of the hexahedra of a thick tube, also of one that was moved, shape
            (cell, 8, 3).
    """
    along = corners[:, 4:].sum(axis=1) - corners[:, :4].sum(axis=1)
    outward = corners[:, [1, 2, 5, 6]].sum(axis=1) - corners[:, [0, 3, 4, 7]].sum(axis=1)
    around = cross(along, outward)
    return along / norm(along)[:, None], around / norm(around)[:, None]
