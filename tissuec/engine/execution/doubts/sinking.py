"""Bodies that sink deep into solids in spite of contact.

Contact keeps points and nodes of bodies outside of solids at any depth, but pushes them to the
nearest surface: beyond the middle of a body, that is the far side. So what is about to pass is
deep first, and that is reported. So that nothing passes unseen, states are checked whenever a
node has moved by a part of the size of a triangle.
"""

from collections.abc import Iterator
from typing import Self

import numpy as np
from msgspec import Struct, field

from tissuec.core.arrays import cross, norm, typical
from tissuec.core.units import LENGTH, show
from tissuec.engine.execution.doubts import WATCHES, Finding
from tissuec.geometry.edges import volume
from tissuec.mechanics.state import State
from tissuec.model.network import BodyPart, Floats, Network
from tissuec.script.plan import Plan

KIND = "sinks into a body"
APART = 0.25  # of the median edge of a surface: path of a node between two checks
DEEP = 0.5  # of an edge, and of half the thickness of a body


class SinkingMemory(Struct):
    """What a checkpoint holds.

    Attributes:
        before: Positions at the last check [m], shape (node, 3); None before the first one.
        seen: Pairs that have been deep in one another, as numbers of bodies.
    """

    before: Floats | None = None
    seen: list[tuple[int, int]] = field(default_factory=list[tuple[int, int]])


@WATCHES.member(KIND)
class Sinking:
    """Watches how deep points and nodes of bodies are in solids that keep them outside."""

    kind = KIND

    def __init__(self, network: Network):
        self._network, self.memory = network, SinkingMemory()
        sizes = [_sizes(network, body) for body in network.bodies]
        edges = [edge for edge, _ in sizes if edge > 0.0]
        self._apart = APART * min(edges)
        self._deepest = np.array([DEEP * min(pair) for pair in sizes])

    @classmethod
    def of(cls, network: Network, plan: Plan) -> Self | None:
        """Return the watch of a run; None where no body is kept outside of another one."""
        contact = network.contact
        is_kept = contact is not None and np.isfinite(contact.meetings.distances).any()
        return cls(network) if is_kept else None

    def leeway(self, position: Floats) -> float:
        """Return 0 if nodes have moved so far that a body may have passed, otherwise infinity.

        The run comes back when it leaves the lists of near pairs.
        """
        before = self._network.position if self.memory.before is None else self.memory.before
        nodes = slice(self._network.body_nodes)
        way = position[nodes] - before[nodes]
        return 0.0 if np.abs(way).max(initial=0.0) > self._apart else np.inf

    def look(self, state: State, position: Floats) -> Iterator[Finding]:
        """Yield the bodies that are deep in others now, and those that were."""
        from tissuec.forces.contact.readings import depths_inside  # where something touches

        contact, bodies = state.contact, self._network.bodies
        assert contact is not None, "otherwise there is no watch"
        self.memory.before = position.copy()
        found = depths_inside(contact, position)
        number = found.owner * len(bodies) + found.body
        pairs = [tuple(divmod(int(one), len(bodies))) for one in np.unique(number)]
        for a, b in sorted({*pairs, *self.memory.seen}):
            depth = found.depth[(found.owner == a) & (found.body == b)]
            count = int(np.count_nonzero(depth > self._deepest[b]))
            if not count and (a, b) not in self.memory.seen:
                continue
            if (a, b) not in self.memory.seen:
                self.memory.seen.append((a, b))
            deep = float(depth.max(initial=0.0))
            yield Finding(
                f"{bodies[a].name} in {bodies[b].name}",
                count,
                f"{bodies[a].name} sinks deep into {bodies[b].name}: contact is too soft there",
                f"by {show(deep, LENGTH)}",
                "point",
                "use a larger contact surface stiffness, or smaller cells",
                bodies[a].span,
            )


def _sizes(network: Network, body: BodyPart) -> tuple[float, float]:
    """Return the median edge of a body, and half its thickness as a plate [m]; 0 without."""
    skin = network.skin_of(body)
    if body.thread is not None or not len(skin):
        return 0.0, 0.0
    a, b, c = network.position[skin.T]
    edge = typical(norm(np.concatenate([b - a, c - b, a - c])))
    area = 0.5 * float(norm(cross(b - a, c - a)).sum())
    return edge, abs(volume(network.position, skin)) / area
