"""A thread: a suture between two points, or a sling."""

from typing import Annotated

import numpy as np
from msgspec import Struct

from tissuec.core import units
from tissuec.core.fields import Length, LengthIfAny, Point, PointsIfAny, PositionIfAny, Whole
from tissuec.meshes.generators import MESHES, Mesh
from tissuec.meshes.generators.centreline import perpendicular_frame
from tissuec.meshes.generators.joining import Pairs, require_limits, springs
from tissuec.model.network import Floats

DirectionIfAny = Annotated[Floats | None, Point(units.NUMBER)]


@MESHES.member("thread")
class Thread(Struct, frozen=True, eq=False):
    """A chain of ``pieces`` springs without a skin: along a line, or in a loop.

    A loop is a polygon around ``centre`` at right angles to ``normal``. Its first node lies
    where that of a tube would, and the others follow by the right-hand rule. The knot of a
    thread joins its last node and its first one, and is the last piece of a loop. Unless
    contact is off, a thread touches the nodes of other bodies with its thickness.

    Attributes:
        pieces: Number of springs along the thread.
        thickness: Diameter of the thread in contact.
        line: Both ends of an open thread.
        centre: Centre of a loop.
        normal: Axis of a loop.
        radius: Distance of the nodes of a loop from its centre.
    """

    pieces: Annotated[int, Whole(at_least=2)]
    thickness: Length
    line: PointsIfAny = None
    centre: PositionIfAny = None
    normal: DirectionIfAny = None
    radius: LengthIfAny = None

    def __post_init__(self) -> None:
        require_limits(self)
        loop = (self.centre, self.normal, self.radius)
        is_loop = [entry is not None for entry in loop]
        if (self.line is None) != all(is_loop) or (self.line is not None and any(is_loop)):
            raise ValueError(
                'it needs either a "line" (open) or "centre", "normal" and "radius" (a loop)'
            )
        if self.line is not None and np.array_equal(*self.line):
            raise ValueError('"line" must join two different points')
        if self.normal is not None and not np.any(self.normal):
            raise ValueError('"normal" cannot be (0, 0, 0)')
        if self.is_loop() and self.pieces < 3:
            raise ValueError('a loop needs "pieces" of 3 or more')

    def is_loop(self) -> bool:
        """Return whether the thread is closed."""
        return self.line is None

    def thread_radius(self) -> float:
        return 0.5 * self.thickness

    def size(self) -> tuple[int, int]:
        """Return the numbers of nodes and springs."""
        return self.pieces + (not self.is_loop()), self.pieces

    def build(self) -> Mesh:
        """Return nodes along the thread, and the springs from each to the next."""
        position = self._circle() if self.line is None else self._straight(*self.line)
        ends = springs(len(position), self._apart(1))
        return Mesh(position, ends, np.zeros((0, 3), dtype=np.int32))

    def second_neighbours_of_surface(self) -> Pairs:
        """Return the pairs that bending springs join, two pieces apart, shape (spring, 2)."""
        return self._apart(2)

    def _apart(self, steps: int) -> Pairs:
        """Return the nodes that lie some pieces apart, shape (pair, 2)."""
        nodes, _ = self.size()
        first = np.arange(nodes if self.is_loop() else nodes - steps)
        return np.stack([first, (first + steps) % nodes], axis=1)

    def _straight(self, start: Floats, end: Floats) -> Floats:
        return np.linspace(start, end, self.pieces + 1)

    def _circle(self) -> Floats:
        assert self.centre is not None and self.normal is not None
        assert self.radius is not None
        across, upward = perpendicular_frame(np.asarray(self.normal, dtype=np.float64))
        angle = np.arange(self.pieces)[:, None] * (2.0 * np.pi / self.pieces)
        return self.centre + self.radius * (np.cos(angle) * across + np.sin(angle) * upward)
