"""Elements that are watched as closely as their nodes move, also between two outputs.

An examination tells how far the nodes of a body can move, apart from a common translation,
before further elements can be found. The loop over steps comes back when nodes may have moved
that far.
"""

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar, Protocol

import numpy as np
from msgspec import Struct, field
from numpy.typing import NDArray

from tissuec.core.arrays import norm
from tissuec.core.units import LENGTH, show
from tissuec.engine.execution.doubts import Finding
from tissuec.mechanics.state import State
from tissuec.model.network import BodyPart, Floats, Indices, Network

if TYPE_CHECKING:
    from collections.abc import Iterator

    from tissuec.forces.solids.elements import SolidElements

# Parts of the margin as drawn. Nodes move by at least the first one between two examinations,
# so that elements that hover at the limit are not examined at each step. While elements are
# found, which only remain to be counted, it is the second one.
LEAST, AGAIN = 0.1, 0.5


class ElementTest(Protocol):
    """Tells which elements of one shape are to be reported."""

    field: "SolidElements"

    def found(self, position: Floats, alive: NDArray[np.bool_]) -> tuple[Indices, float]:
        """Return the elements, and how far nodes can move before others are found [m].

        Args:
            position: Of all nodes [m], shape (node, 3).
            alive: Springs that are there, shape (spring,).
        """
        ...


class Examined(Struct):
    """The last examination of a body.

    Attributes:
        position: Of its nodes then [m], shape (node, 3).
        margin: By which they can move before the next one [m].
        count: Elements that were found.
    """

    position: Floats
    margin: float
    count: int = 0


class FollowedMemory(Struct):
    """The last examinations, as a checkpoint holds them.

    Attributes:
        bodies: By name of the body.
    """

    bodies: dict[str, Examined] = field(default_factory=dict[str, Examined])


class FollowedBody:
    """The elements of one body.

    Args:
        network: With the body as drawn.
        body: Is made of elements.
        tests: One for each shape.
    """

    def __init__(self, network: Network, body: BodyPart, tests: Sequence[ElementTest]):
        self._network, self.body, self._tests = network, body, tests

    @cached_property
    def drawn(self) -> Examined:
        """Return the examination as drawn."""
        network = self._network
        found = [test.found(network.position, network.present) for test in self._tests]
        margin = min(margin for _, margin in found)
        return Examined(network.position[self.body.nodes], margin)

    def leeway(self, last: Examined, position: Floats) -> float:
        """Return how far nodes can still move before the next examination [m].

        Args:
            last: The last one.
            position: Of all nodes [m], shape (node, 3).
        """
        moved = position[self.body.nodes] - last.position
        return last.margin - float(norm(moved - moved.mean(axis=0)).max())

    def examine(self, position: Floats, alive: NDArray[np.bool_]) -> tuple[Examined, str]:
        """Return an examination, and where the first element is, as drawn; "" without any.

        Args:
            position: Of all nodes [m], shape (node, 3).
            alive: False for springs that were cut or broke, shape (spring,).
        """
        found = [test.found(position, alive) for test in self._tests]
        count = sum(len(numbers) for numbers, _ in found)
        usual = self.drawn.margin
        margin = AGAIN * usual if count else max(min(m for _, m in found), LEAST * usual)
        place = self._place([numbers for numbers, _ in found])
        return Examined(position[self.body.nodes], margin, count), place

    def _place(self, numbers: Sequence[Indices]) -> str:
        for test, found in zip(self._tests, numbers, strict=True):
            if len(found):
                corners = self._network.position[test.field.nodes[found[0]]]
                centre = ", ".join(show(float(x), LENGTH) for x in corners.mean(axis=0))
                return f"in {test.field.shape.name} {found[0] + 1} around ({centre})"
        return ""


class ElementFollower:
    """A watch of elements that follows the motion; see ``Follower``."""

    kind: ClassVar[str]

    def __init__(self, bodies: Sequence[FollowedBody]):
        self._bodies, self.memory = bodies, FollowedMemory()

    def describe(self, state: State, body: BodyPart, count: int, place: str) -> Finding:
        """Return the finding for a body.

        Args:
            state: As of ``Watch.look``.
            body: With the elements.
            count: Elements that are found now.
            place: Where the first one is.
        """
        raise NotImplementedError

    def leeway(self, position: Floats) -> float:
        """Return how far nodes can move before a look is due; as of ``Follower``."""
        return min(body.leeway(self._last(body), position) for body in self._bodies)

    def look(self, state: State, position: Floats) -> "Iterator[Finding]":
        """Yield the bodies with such elements; as ``Watch.look``."""
        for body in self._bodies:
            last = self._last(body)
            if not last.count and body.leeway(last, position) > 0.0:
                continue
            now, place = body.examine(position, state.alive)
            self.memory.bodies[body.body.name] = now
            if now.count or last.count:
                yield self.describe(state, body.body, now.count, place)

    def _last(self, body: FollowedBody) -> Examined:
        return self.memory.bodies.get(body.body.name, body.drawn)
