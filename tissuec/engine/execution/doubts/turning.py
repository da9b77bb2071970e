"""Hexahedra and wedges whose opposite sides are turned against each other by more than 90°.

The deformation of such an element is described by one mean gradient and a few numbers of
bending. Turned by the angle θ, opposite sides resist in proportion to the mean of their
directions: less and less beyond 90°, and from some 115° on a bar lets single layers turn on by
themselves. At 180° both sides are in line again, and whole turns are lost without any element
being inside out. So the angle between edges that are parallel as drawn is watched.
"""

from collections.abc import Iterator
from itertools import combinations
from typing import TYPE_CHECKING, ClassVar, Self

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.arrays import dot, norm
from tissuec.core.source import Span
from tissuec.core.units import LENGTH, show
from tissuec.engine.execution.doubts import WATCHES, Finding
from tissuec.mechanics.state import State
from tissuec.model.network import BodyPart, Floats, Indices, Network
from tissuec.script.plan import Plan

if TYPE_CHECKING:
    from tissuec.forces.solids.elements import SolidElements

TURNED = "turned too far"
#: Edges of elements that are parallel in a box or a prism, by the name of their shape.
PARALLEL: dict[str, tuple[tuple[tuple[int, int], ...], ...]] = {
    "hexahedron": (
        ((0, 1), (3, 2), (4, 5), (7, 6)),
        ((0, 3), (1, 2), (4, 7), (5, 6)),
        ((0, 4), (1, 5), (2, 6), (3, 7)),
    ),
    "wedge": (
        ((0, 1), (3, 4)), ((1, 2), (4, 5)), ((2, 0), (5, 3)), ((0, 3), (1, 4), (2, 5)),
    ),
}  # fmt: skip


class _Edges(Struct, eq=False):
    """Edges of some elements of a body.

    Attributes:
        field: With the elements.
        edges: Corners of each, shape (edge, 2).
        pairs: Of edges that are parallel as drawn, shape (pair, 2).
    """

    field: "SolidElements"
    edges: Indices
    pairs: Indices

    @classmethod
    def of(cls, field: "SolidElements") -> Self:
        """Return the edges of elements of a shape in ``PARALLEL``."""
        groups = PARALLEL[field.shape.name]
        edges = np.array([edge for group in groups for edge in group])
        begin = np.cumsum([0, *map(len, groups)])
        pairs = [
            pair
            for first, group in zip(begin, groups, strict=False)
            for pair in combinations(range(first, first + len(group)), 2)
        ]
        return cls(field, edges, np.array(pairs))

    def turned(self, position: Floats, alive: NDArray[np.bool_]) -> tuple[Indices, float]:
        """Return elements that are turned too far, and how far nodes can move before others.

        A node that moves by r turns an edge of the length l by less than asin(2 r/l).

        Args:
            position: Of all nodes [m], shape (node, 3).
            alive: Springs that are there, shape (spring,).
        """
        ends = position[self.field.nodes]
        along = ends[:, self.edges[:, 1]] - ends[:, self.edges[:, 0]]
        length = norm(along)
        one, other = self.pairs.T
        cosine = dot(along[:, one], along[:, other])
        both = length[:, one] * length[:, other]
        is_turned = (cosine < 0.0).any(axis=1)
        is_turned[self.field.lost_items(alive)] = False
        room = np.arcsin(np.clip(cosine / np.where(both > 0.0, both, 1.0), 0.0, 1.0))
        shortest = np.minimum(length[:, one], length[:, other])
        return np.flatnonzero(is_turned), float((0.5 * shortest * np.sin(0.5 * room)).min())


class _TurningBody:
    """The elements of one body, of which the last look is kept."""

    def __init__(self, network: Network, body: BodyPart, parts: list[_Edges]):
        self._network, self._body, self._parts = network, body, parts
        self._seen: Floats | None = None
        self._close, self._count = 0.0, 0

    def look(self, state: State, position: Floats) -> Iterator[Finding]:
        """Yield the elements that are turned too far; as ``Watch.look``."""
        own = position[self._body.nodes]
        if self._seen is not None and not self._count:
            moved = own - self._seen
            if norm(moved - moved.mean(axis=0)).max() < self._close:
                return
        found = [part.turned(position, state.alive) for part in self._parts]
        self._seen, self._close = own.copy(), min(margin for _, margin in found)
        count = sum(len(which) for which, _ in found)
        if not count and not self._count:
            return
        self._count = count
        name = self._body.name
        yield Finding(
            name, count, f"opposite sides of elements of {name} are turned by more than 90°",
            self._place([which for which, _ in found]), "element",
            "they resist less and less, and lose whole turns beyond 180°; use shorter elements "
            "along the axis of the turn, or turn the body less", _cause(state, self._body.span),
        )  # fmt: skip

    def _place(self, numbers: list[Indices]) -> str:
        """Return where the first element is, as drawn; "" without any."""
        for part, which in zip(self._parts, numbers, strict=True):
            if len(which):
                corners = self._network.position[part.field.nodes[which[0]]]
                centre = ", ".join(show(float(x), LENGTH) for x in corners.mean(axis=0))
                return f"in {part.field.shape.name} {which[0] + 1} around ({centre})"
        return ""


def _cause(state: State, body: Span) -> Span:
    """Return the order of a turn that is under way, or else the body."""
    turns = (each.span for each in state.motions.values() if each.turn is not None)
    return next(turns, body)


@WATCHES.member(TURNED)
class TurnedTooFar:
    """Watches hexahedra and wedges."""

    kind: ClassVar[str] = TURNED

    def __init__(self, bodies: list[_TurningBody]):
        self._bodies = bodies

    @classmethod
    def of(cls, network: Network, plan: Plan) -> Self | None:
        """Return the watch of a run; None without such elements."""
        bodies: list[_TurningBody] = []
        for body in network.bodies:
            parts = [
                _Edges.of(field)
                for field in network.elements_of(body.name)
                if not body.is_wall and field.shape.name in PARALLEL
            ]
            if parts:
                bodies.append(_TurningBody(network, body, parts))
        return cls(bodies) if bodies else None

    def look(self, state: State, position: Floats) -> Iterator[Finding]:
        """Yield the bodies with such elements; as ``Watch.look``."""
        for body in self._bodies:
            yield from body.look(state, position)
