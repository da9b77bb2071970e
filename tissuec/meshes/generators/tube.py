"""A tube: rings of nodes around an axis, such as a vessel or a Fallopian tube."""

from typing import Annotated, Self

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.fields import Axis, Length, LengthIfAny, OneOf, Whole
from tissuec.core.structs import replace
from tissuec.meshes.generators import MESHES, Mesh
from tissuec.meshes.generators.centreline import BENDS, SMOOTH, Centreline
from tissuec.meshes.generators.joining import (
    Pairs,
    grid_pairs,
    grid_triangles,
    require_limits,
    springs,
)
from tissuec.model.network import Grid


@MESHES.member("tube")
class Tube(Struct, frozen=True, eq=False):
    """An open tube of ``rings`` times ``sides`` nodes, numbered ring by ring.

    Springs run around each ring and from each ring to the next. 16 rings of 10 sides have 160
    nodes and, with ``interior is crossed`` or with ``diagonals is both``, 610 springs. Side 0
    lies towards the coordinate direction that is most nearly at right angles to the axis (x
    before y before z). The sides are numbered around the axis by the right-hand rule.

    Crossed springs join each node to two nodes of the next ring: half of the sides (rounded
    down) minus one further, in both directions. With 10 sides, these are the neighbours of the
    opposite node. Crossed springs need 6 sides. Spokes cross each ring to the opposite node or,
    if the number of sides is odd, to the two nodes nearest to it. Spokes need 4 sides.

    The axis is straight, or leads through a list of points. Along a curve, rings are at right
    angles to it and do not twist about it. They must not intersect: the radius of curvature is
    everywhere larger than the radius of the tube.

    Nodes of the ends are the groups ``first end`` and ``last end``.

    Attributes:
        axis: Centres of the first and the last ring, or points of a curve.
        radius: Distance of every node from the axis; with an end radius, at the first end.
        rings: Number of rings of nodes, both ends included.
        sides: Number of nodes in each ring.
        end_radius: Radius at the last end; by default, that of the first end.
        bends: How a curve leads through its points: smooth, or sharp with straight pieces.
        diagonals: Springs across the faces of the wall: none, one or both of each face.
        interior: Springs through the inside: none, crossed (to the next ring) or spokes.
    """

    axis: Axis
    radius: Length
    rings: Annotated[int, Whole(at_least=2)]
    sides: Annotated[int, Whole(at_least=3)]
    end_radius: LengthIfAny = None
    bends: Annotated[str, OneOf(BENDS)] = SMOOTH
    diagonals: Annotated[str, OneOf(("none", "one", "both"))] = "none"
    interior: Annotated[str, OneOf(("none", "crossed", "spokes"))] = "none"

    def __post_init__(self) -> None:
        require_limits(self)
        self._line.require_rings(self.rings, self.radius, self._last)
        if self.interior == "crossed" and self.sides < 6:
            raise ValueError(
                f'"interior is crossed" needs "sides" of 6 or more, not {self.sides}: '
                "with fewer, the springs would be in the wall"
            )
        if self.interior == "spokes" and self.sides < 4:
            raise ValueError(
                '"interior is spokes" needs "sides" of 4 or more: '
                "in a ring of 3, every node is already joined to every other"
            )

    def refined(self) -> Self:
        """Return the same shape with cells half as long."""
        return replace(self, rings=2 * self.rings - 1, sides=2 * self.sides)

    def size(self) -> tuple[int, int]:
        """Return the numbers of nodes and springs."""
        nodes = self.rings * self.sides
        between = nodes - self.sides
        count = nodes + between + ("none", "one", "both").index(self.diagonals) * between
        if self.interior == "crossed":
            count += 2 * between
        if self.interior == "spokes":
            count += nodes if self.sides % 2 else nodes // 2
        return nodes, count

    def build(self) -> Mesh:
        """Return nodes, springs, and the wall with its normals pointing outwards."""
        shape = (self.rings, self.sides)
        pairs = [grid_pairs(shape, step, wrap=True) for step in self._steps()]
        ends = springs(self.rings * self.sides, *pairs)
        skin = grid_triangles(shape, wrap=True)
        number = np.arange(self.rings * self.sides).reshape(shape)
        groups = {"first end": number[0], "last end": number[-1]}
        position = self._position()
        return Mesh(position, ends, skin, groups, grid=Grid(*shape, closed=True))

    def _steps(self) -> list[tuple[int, int]]:
        """Return how far springs reach, as (rings, sides)."""
        steps = [(0, 1), (1, 0)]
        steps += [(1, 1), (1, -1)][: ("none", "one", "both").index(self.diagonals)]
        if self.interior == "crossed":
            # Equally far on either hand of the opposite node: the net is its own mirror image.
            beside = self.sides // 2 - 1
            steps += [(1, beside), (1, -beside)]
        if self.interior == "spokes":
            steps.append((0, self.sides // 2))
        return steps

    def second_neighbours_of_surface(self) -> Pairs:
        """Return the pairs that bending springs join, two steps along or round the tube.

        The shape is (spring, 2).
        """
        shape = (self.rings, self.sides)
        steps = [(0, 2)] + ([(2, 0)] if self.rings > 2 else [])
        return np.concatenate([grid_pairs(shape, step, wrap=True) for step in steps])

    @property
    def _line(self) -> Centreline:
        return Centreline(self.axis, self.bends)

    @property
    def _last(self) -> float:
        """Return the radius at the last end [m]."""
        return self.radius if self.end_radius is None else self.end_radius

    def _position(self) -> NDArray[np.float64]:
        centre, across, share = self._line.rings(self.rings, self.radius, self._last)
        angle = np.arange(self.sides)[:, None] * (2.0 * np.pi / self.sides)
        first, second = across[:, :1], across[:, 1:]
        radius = self.radius
        if self.end_radius is not None:
            radius = ((1.0 - share) * radius + share * self.end_radius)[:, None, None]
        ring = radius * (np.cos(angle) * first + np.sin(angle) * second)
        return (centre[:, None, :] + ring).reshape(-1, 3)
