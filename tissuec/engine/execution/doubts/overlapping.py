"""Bodies whose surfaces pass through each other.

Without contact between bodies, nothing keeps them apart; with it, bodies pass through if they
press harder than contact can bear. Then edges of one surface cross triangles of the other.
Bodies that touch or overlap as drawn, such as layers that joints connect, are left out.
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
from tissuec.geometry.sweeps import Passage, boxes, through
from tissuec.mechanics.state import State
from tissuec.model.network import Floats, Indices, Network
from tissuec.script.plan import Plan

KIND = "bodies overlap"
TOUCHING = 0.01  # of the median edge: surfaces as near as that as drawn touch
AROUND = 0.5  # of the median edge: distance within which surfaces are listed


class _Couple:
    """Two surfaces, and which of their edges and triangles are near each other.

    These hold until a node has moved by half of the distance within which they are listed.
    """

    def __init__(self, one: WatchedSkin, other: WatchedSkin):
        self.one, self.other = one, other
        self._margin = AROUND * min(one.edge, other.edge)
        self._nodes = np.unique(np.concatenate([one.triangles, other.triangles]))
        self._around: Floats | None = None
        self._near: list[tuple[WatchedSkin, WatchedSkin, Indices]] = []

    def crossings(
        self, position: Floats, alive: NDArray[np.bool_]
    ) -> list[tuple[WatchedSkin, Passage]]:
        """Return where edges go through intact triangles, with the surface of these triangles.

        Args:
            position: Of all nodes [m], shape (node, 3).
            alive: Springs that are there, shape (spring,).
        """
        here = position[self._nodes]
        if (
            self._around is None
            or norm(here - self._around).max(initial=0.0) > 0.5 * self._margin
        ):
            self._around = here
            self._near = [
                (first, second, near)
                for first, second in ((self.one, self.other), (self.other, self.one))
                if len(near := _near(first, second, position, self._margin))
            ]
        found: list[tuple[WatchedSkin, Passage]] = []
        for first, second, pairs in self._near:
            edges = first.surface.edges
            holds = np.zeros(len(edges.ends), dtype=bool)
            holds[edges.of[first.whole(alive)]] = True
            pairs = pairs[holds[pairs[:, 0]] & second.whole(alive)[pairs[:, 1]]]
            near, far = pairs.T
            meet = _meet(
                *boxes(position[edges.ends[near]]), *boxes(position[second.triangles[far]])
            )
            if not meet.any():
                continue
            passages = through(position, edges.ends, second.triangles, pairs[meet])
            found += [(second, passage) for passage in passages]
        return found

    def touch(self, drawn: Floats) -> bool:
        """Return whether the surfaces touch or cross as drawn [m], shape (node, 3)."""
        margin = TOUCHING * min(self.one.edge, self.other.edge)
        for first, second in ((self.one, self.other), (self.other, self.one)):
            edges, triangles = first.surface.edges.ends, second.triangles
            pairs = _near(first, second, drawn, margin)
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


@WATCHES.member(KIND)
class Overlapping:
    """Watches pairs of bodies with surfaces that are apart as drawn.

    Args:
        network: The network of the run.
        couples: Their surfaces.
        is_held_apart: Whether bodies touch each other.
    """

    kind = KIND

    def __init__(self, network: Network, couples: list[_Couple], *, is_held_apart: bool):
        self._network, self._couples = network, couples
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
        couples = [_Couple(*pair) for pair in combinations(skins, 2)]
        apart = [couple for couple in couples if not couple.touch(network.position)]
        contact = network.contact
        is_held_apart = contact is not None and bool(
            (contact.radius[contact.kind[: len(contact.radius)] == TRIANGLE] > 0.0).any()
        )
        return cls(network, apart, is_held_apart=is_held_apart) if apart else None

    def look(self, state: State, position: Floats) -> Iterator[Finding]:
        """Yield the pairs that overlap now."""
        for couple in self._couples:
            one, other = couple.one, couple.other
            found = couple.crossings(position, state.alive)
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


def _near(one: WatchedSkin, other: WatchedSkin, position: Floats, margin: float) -> Indices:
    """Return pairs of an edge and a triangle whose boxes are near each other, (pair, 2)."""
    edges, triangles = one.surface.edges.ends, other.triangles
    ends, corners = position[edges], position[triangles]
    low, high = boxes(ends)
    low, high = low - margin, high + margin
    least, most = boxes(corners)
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
