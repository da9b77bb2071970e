"""A tube with a thick wall, such as an artery: layers of hexahedra around an axis."""

from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from tissuec.core.fields import Axis, Count, Length, LengthIfAny, OneOf, UnfitEntries, Whole
from tissuec.core.units import LENGTH, show
from tissuec.core.vectors import cross, norm
from tissuec.geometry.edges import Floats, Indices
from tissuec.meshes.generators import MESHES
from tissuec.meshes.generators.centreline import BENDS, SMOOTH, Centreline
from tissuec.meshes.generators.hexahedral import Hexahedral
from tissuec.meshes.generators.joining import require_limits

PARTS = {"whole": 1, "half": 2, "quarter": 4}


@MESHES.member("thick tube")
class ThickTube(Hexahedral, frozen=True, eq=False):
    """A tube whose wall is a solid of hexahedra, numbered ring by ring from the inside.

    A whole tube has ``rings`` × ``sides`` × (``layers`` + 1) nodes. Each ring
    begins where that of a thin tube would; half a tube, or a quarter, also begins there, and
    ends at a plane of symmetry. All layers are equally thick.

    The axis can lead through a list of points, as that of a thin tube; then the tube is whole.

    Nodes of the ends and of both surfaces are the groups ``first end``, ``last end``,
    ``inside`` and ``outside``.

    A net of springs has springs along the edges of the cells and the diagonals of their faces.

    Attributes:
        axis: Centres of the first and the last ring, or points of a curve.
        inner_radius: Distance of the innermost nodes from the axis.
        outer_radius: Distance of the outermost nodes from the axis.
        rings: Number of rings of nodes, both ends included.
        sides: Number of cells around the axis of the whole tube.
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
    sides: Annotated[int, Whole(at_least=3)]
    layers: Count = 2
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

    def counts(self) -> tuple[int, int, int]:
        """Return the numbers of nodes, edges and faces."""
        columns, layers, around = self._columns, self.layers, self.sides // PARTS[self.part]
        along = self.rings - 1
        edges = along * columns * (layers + 1)
        edges += self.rings * (around * (layers + 1) + columns * layers)
        faces = self.rings * around * layers + along * columns * layers
        faces += along * around * (layers + 1)
        return self.rings * columns * (layers + 1), edges, faces

    def cells(self) -> tuple[Floats, Indices, dict[str, Indices]]:
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
        return self._position(), self._cells(number), named

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

    def _position(self) -> Floats:
        centre, across, share = self._line.rings(self.rings, *self._radii[1])
        angle = np.arange(self._columns)[:, None] * (2.0 * np.pi / self.sides)
        ring = np.cos(angle) * across[:, :1] + np.sin(angle) * across[:, 1:]
        first, last = np.linspace(*self._radii, self.layers + 1).T
        radius = first + share[:, None] * (last - first)
        wall = ring[:, :, None] * radius[:, None, :, None]
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
