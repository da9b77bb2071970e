"""Bodies whose surfaces pass through each other.

Without contact between bodies, nothing keeps them apart; with it, what presses harder than
contact bears goes through. Then edges of one surface cross triangles of the other. Bodies that
touch or overlap as drawn, such as layers that joints connect, are left out.
"""

from collections.abc import Iterator
from itertools import combinations
from typing import Self

import numpy as np
from numpy.typing import NDArray

from tissuec.core.vectors import norm
from tissuec.engine.execution.doubts import WATCHES, Finding
from tissuec.engine.execution.doubts.watched_skin import WatchedSkin
from tissuec.geometry.balls import in_balls
from tissuec.geometry.nearest import TRIANGLE, places
from tissuec.geometry.sweeps import Passage, through
from tissuec.mechanics.state import State
from tissuec.model.network import Floats, Indices, Network
from tissuec.script.plan import Plan

KIND = "bodies overlap"
TOUCHING = 0.01  # of the median edge: surfaces as near as that as drawn touch


@WATCHES.member(KIND)
class Overlapping:
    """Watches pairs of bodies with surfaces that are apart as drawn.

    Args:
        network: Of the run.
        pairs: Their surfaces.
        is_held_apart: Whether bodies touch each other.
    """

    kind = KIND

    def __init__(
        self,
        network: Network,
        pairs: list[tuple[WatchedSkin, WatchedSkin]],
        *,
        is_held_apart: bool,
    ):
        self._network, self._pairs = network, pairs
        self._why, self._remedy = (
            (
                "contact cannot hold them apart",
                "use a larger contact stiffness or smaller cells",
            )
            if is_held_apart
            else ("contact between bodies is off", "write contact is bodies too")
        )

    @classmethod
    def of(cls, network: Network, plan: Plan) -> Self | None:
        """Return the watch of a run; None without two bodies with surfaces."""
        bodies = [b for b in network.bodies if b.thread is None and len(network.skin_of(b))]
        if len(bodies) < 2:
            return None
        skins = [WatchedSkin(network, body) for body in bodies]
        drawn = network.position
        apart = [pair for pair in combinations(skins, 2) if not _touch(*pair, drawn)]
        contact = network.contact
        is_held_apart = contact is not None and bool(
            (contact.radius[contact.kind[: len(contact.radius)] == TRIANGLE] > 0.0).any()
        )
        return cls(network, apart, is_held_apart=is_held_apart) if apart else None

    def look(self, state: State, position: Floats) -> Iterator[Finding]:
        """Yield the pairs that overlap now."""
        for one, other in self._pairs:
            found = [
                (crossed, passage)
                for crossing, crossed in ((one, other), (other, one))
                for passage in _crossings(crossing, crossed, position, state.alive)
            ]
            where = ""
            if found:
                crossed, passage = found[0]
                node = int(crossed.triangles[passage.triangle, 0])
                where = f"at node {self._network.node_ids[node]} of {crossed.body.name}"
            yield Finding(
                f"{one.body.name} and {other.body.name}",
                len(found),
                f"the surfaces of {one.body.name} and {other.body.name} pass through each "
                f"other: {self._why}",
                where,
                "crossing",
                self._remedy,
                other.body.span,
            )


def _crossings(
    one: WatchedSkin, other: WatchedSkin, position: Floats, alive: NDArray[np.bool_]
) -> list[Passage]:
    """Return where edges of one surface go through triangles of another."""
    edges, triangles = one.surface.edges.ends, other.triangles
    pairs = _near(edges, triangles, position, 0.0)
    if not len(pairs):
        return []
    holds = np.zeros(len(edges), dtype=bool)
    holds[one.surface.edges.of[one.whole(alive)]] = True
    pairs = pairs[holds[pairs[:, 0]] & other.whole(alive)[pairs[:, 1]]]
    return through(position, edges, triangles, pairs)


def _near(edges: Indices, triangles: Indices, position: Floats, margin: float) -> Indices:
    """Return pairs of an edge and a triangle that may come near each other, (pair, 2)."""
    ends, corners = position[edges], position[triangles]
    low, high = ends.min(axis=1) - margin, ends.max(axis=1) + margin
    least, most = corners.min(axis=1), corners.max(axis=1)
    own = np.flatnonzero(_meet(low, high, least.min(axis=0), most.max(axis=0)))
    others = np.flatnonzero(_meet(least, most, low.min(axis=0), high.max(axis=0)))
    if not len(own) or not len(others):
        return np.zeros((0, 2), dtype=np.int64)
    middle = corners[others].mean(axis=1)
    size = norm(corners[others] - middle[:, None]).max(axis=1)
    half = 0.5 * norm(ends[own, 1] - ends[own, 0])
    triangle, edge = in_balls(middle, size + half.max() + margin, ends[own].mean(axis=1))
    edge, triangle = own[edge], others[triangle]
    meet = _meet(low[edge], high[edge], least[triangle], most[triangle])
    return np.stack([edge[meet], triangle[meet]], axis=1)


def _meet(low: Floats, high: Floats, least: Floats, most: Floats) -> NDArray[np.bool_]:
    """Return whether boxes have a point in common, shape (row,)."""
    return np.asarray(((low <= most) & (least <= high)).all(axis=-1))


def _touch(one: WatchedSkin, other: WatchedSkin, drawn: Floats) -> bool:
    """Return whether two surfaces touch or cross as drawn."""
    margin = TOUCHING * min(one.edge, other.edge)
    for first, second in ((one, other), (other, one)):
        edges, triangles = first.surface.edges.ends, second.triangles
        pairs = _near(edges, triangles, drawn, margin)
        if through(drawn, edges, triangles, pairs):
            return True
        for end in (0, 1):
            node = edges[pairs[:, 0], end]
            kinds = np.full(len(node), TRIANGLE)
            corners = drawn[triangles[pairs[:, 1]]]
            found = places(drawn[node], kinds, corners, np.full(len(node), margin))
            if (found.depth > 0.0).any():
                return True
    return False
