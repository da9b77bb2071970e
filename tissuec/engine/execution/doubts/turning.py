"""Hexahedra and wedges whose opposite sides are turned against each other by more than 90°.

The deformation of such an element is described by one mean gradient and a few numbers of
bending. Where opposite sides are turned against each other, they resist in proportion to the
length of the mean of their directions: less and less beyond 90°. From about 115° on, single
layers of a bar continue to turn by themselves. At 180° both sides are in line again, and whole
turns are lost although no element is inside out. Therefore the angles between edges that are
parallel as drawn are watched.
"""

from itertools import combinations
from typing import TYPE_CHECKING, ClassVar, Self

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.arrays import dot, norm
from tissuec.core.source import Span
from tissuec.engine.execution.doubts import WATCHES, Finding
from tissuec.engine.execution.doubts.following import ElementFollower, FollowedBody
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

    def found(self, position: Floats, alive: NDArray[np.bool_]) -> tuple[Indices, float]:
        """Return elements that are turned too far; as of ``ElementTest``.

        A node that moves by r turns an edge of the length l by less than asin(2 r/l).
        """
        ends = position[self.field.nodes]
        along = ends[:, self.edges[:, 1]] - ends[:, self.edges[:, 0]]
        length = norm(along)
        one, other = self.pairs.T
        cosine = dot(along[:, one], along[:, other])
        both = length[:, one] * length[:, other]
        is_turned = np.asarray((cosine < 0.0).any(axis=1))
        is_turned[self.field.lost_items(alive)] = False
        room = np.arcsin(np.clip(cosine / np.where(both > 0.0, both, 1.0), 0.0, 1.0))
        shortest = np.minimum(length[:, one], length[:, other])
        return np.flatnonzero(is_turned), float((0.5 * shortest * np.sin(0.5 * room)).min())


def _cause(state: State, body: Span) -> Span:
    """Return the order of a turn that is under way, or else the body."""
    turns = (each.span for each in state.motions.values() if each.turn is not None)
    return next(turns, body)


@WATCHES.member(TURNED)
class TurnedTooFar(ElementFollower):
    """Watches hexahedra and wedges."""

    kind: ClassVar[str] = TURNED

    @classmethod
    def of(cls, network: Network, plan: Plan) -> Self | None:
        """Return the watch of a run; None without such elements."""
        bodies: list[FollowedBody] = []
        for body in network.bodies:
            tests = [
                _Edges.of(field)
                for field in network.elements_of(body.name)
                if not body.is_wall and field.shape.name in PARALLEL
            ]
            if tests:
                bodies.append(FollowedBody(network, body, tests))
        return cls(bodies) if bodies else None

    def describe(self, state: State, body: BodyPart, count: int, place: str) -> Finding:
        """Return the finding for a body; see ``ElementFollower``."""
        return Finding(
            body.name, count,
            f"opposite sides of elements of {body.name} are turned by more than 90°",
            place, "element",
            "they resist less and less, and lose whole turns beyond 180°; use shorter elements "
            "along the axis of the turn, or turn the body less", _cause(state, body.span),
        )  # fmt: skip
