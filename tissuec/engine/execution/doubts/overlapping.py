"""Bodies whose surfaces pass through each other, or through themselves.

Without contact between bodies, nothing keeps them apart; with it, bodies pass through if they
press harder than contact can bear. Then edges of one surface cross triangles of the other, or
triangles of the same surface with which they have no node in common. Bodies that cross as
drawn, or touch without contact, such as layers that joints connect, are left out, and so are
those that pass through themselves as drawn. Solids that contact keeps apart at any depth are
watched by ``doubts.sinking``.
"""

from collections.abc import Iterator
from itertools import combinations
from typing import Self

import numpy as np
from numpy.typing import NDArray

from tissuec.core.arrays import cross, distinct, dot, norm, typical
from tissuec.engine.execution.doubts import WATCHES, Finding
from tissuec.geometry.edge_supports import SupportedTriangles
from tissuec.geometry.nearest import TRIANGLE, places
from tissuec.geometry.neighbours import in_balls
from tissuec.geometry.outline import Outline
from tissuec.geometry.sweeps import Passage, SweptSurface, boxes, through
from tissuec.mechanics.state import State
from tissuec.model.network import BodyPart, Floats, Indices, Network
from tissuec.script.plan import Plan


class WatchedSkin:
    """The surface of a body, of which parts may be cut or torn.

    Args:
        network: With the body.
        body: One with a surface.

    Attributes:
        surface: Its triangles and edges.
        edge: Median length of its edges as drawn [m].
    """

    def __init__(self, network: Network, body: BodyPart):
        skin = network.skin_of(body)
        self.body, self.surface = body, SweptSurface.of(skin)
        self.edge = typical(norm(np.diff(network.position[self.surface.edges.ends], axis=1)))
        self._supported = SupportedTriangles(
            network.springs.ends, skin, network.skin_marks_of(body)
        )
        self._alive: NDArray[np.bool_] | None = None
        self._whole = np.ones(len(skin), dtype=bool)

    @property
    def triangles(self) -> Indices:
        """Return the corners of all triangles, shape (triangle, 3)."""
        return self.surface.triangles

    def whole(self, alive: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return which triangles are neither cut nor torn, shape (triangle,)."""
        if self._alive is None or not np.array_equal(alive, self._alive):
            self._alive, self._whole = alive.copy(), self._supported.whole(alive)
        return self._whole


KIND = "bodies overlap"
TOUCHING = 0.01  # of the median edge: surfaces as near as that as drawn touch
AROUND = 0.5  # of the median edge: distance within which surfaces are listed
FLAT = 1e-6  # of the median edge: nodes as near to a plane lie in it


class _Couple:
    """Two surfaces, or one twice, and which of their edges and triangles are near each other.

    These hold until a node has moved by half of the distance within which they are listed,
    relative to the mean of all nodes.
    """

    def __init__(self, one: WatchedSkin, other: WatchedSkin):
        self.one, self.other = one, other
        self._margin = AROUND * min(one.edge, other.edge)
        self._nodes = distinct(np.concatenate([one.triangles, other.triangles]))
        self._around: Floats | None = None
        self._near: list[tuple[WatchedSkin, WatchedSkin, Indices]] = []
        self._orders = [(one, other)] if one is other else [(one, other), (other, one)]
        self._outline = Outline.of(one.surface.edges) if one is other else None
        self._is_strict = one is other

    @property
    def is_one(self) -> bool:
        """Return whether it is a single surface."""
        return self.one is self.other

    def crossings(
        self, position: Floats, alive: NDArray[np.bool_]
    ) -> list[tuple[WatchedSkin, Passage]]:
        """Return where edges go through intact triangles, with the surface of these triangles.

        Args:
            position: Of all nodes [m], shape (node, 3).
            alive: Springs that are there, shape (spring,).
        """
        if self._outline and self.one.whole(alive).all() and self._outline.is_simple(position):
            return []
        here = position[self._nodes]
        here = here - here.mean(axis=0)
        if (
            self._around is None
            or norm(here - self._around).max(initial=0.0) > 0.5 * self._margin
        ):
            self._around = here
            self._near = [
                (first, second, near)
                for first, second in self._orders
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
            pairs = pairs[meet]
            if self._is_strict:
                pairs = pairs[_are_across(position, edges.ends, second, pairs)]
            if not len(pairs):
                continue
            passages = through(position, edges.ends, second.triangles, pairs)
            found += [(second, passage) for passage in passages]
        return found

    def crosses(self, network: Network) -> bool:
        """Return whether surfaces that touch cross as drawn, other than in common planes."""
        self._is_strict = True
        return bool(self.crossings(network.position, network.present))

    def touch(self, drawn: Floats) -> bool:
        """Return whether the surfaces touch or cross as drawn [m], shape (node, 3).

        A single surface touches itself at all of its nodes, and is checked for crossings only.
        """
        margin = TOUCHING * min(self.one.edge, self.other.edge)
        for first, second in self._orders:
            edges, triangles = first.surface.edges.ends, second.triangles
            pairs = _near(first, second, drawn, margin)
            if self.is_one:
                pairs = pairs[_are_across(drawn, edges, second, pairs)]
            if through(drawn, edges, triangles, pairs):
                return True
            for end in () if self.is_one else (0, 1):
                node = edges[pairs[:, 0], end]
                kinds = np.full(len(node), TRIANGLE)
                corners = drawn[triangles[pairs[:, 1]]]
                found = places(drawn[node], kinds, corners, np.full(len(node), margin))
                if (found.depth > 0.0).any():
                    return True
        return False


@WATCHES.member(KIND)
class Overlapping:
    """Watches bodies with surfaces, and pairs of them, that are apart as drawn.

    Args:
        network: The network of the run.
        couples: Their surfaces.
    """

    kind = KIND

    def __init__(self, network: Network, couples: list[_Couple]):
        self._network, self._couples = network, couples
        self._is_held = {
            is_one: _is_held_apart(network, is_one=is_one) for is_one in (False, True)
        }

    @classmethod
    def of(cls, network: Network, plan: Plan) -> Self | None:
        """Return the watch of a run; None without bodies with surfaces."""
        bodies = [b for b in network.bodies if b.thread is None and len(network.skin_of(b))]
        skins = [WatchedSkin(network, body) for body in bodies]
        pairs = [*combinations(skins, 2), *((skin, skin) for skin in skins)]
        couples = [_Couple(*pair) for pair in pairs if not _are_kept_apart(network, *pair)]
        apart = [couple for couple in couples if _is_watched(network, couple)]
        return cls(network, apart) if apart else None

    def look(self, state: State, position: Floats) -> Iterator[Finding]:
        """Yield the bodies and the pairs that overlap now."""
        for couple in self._couples:
            found = couple.crossings(position, state.alive)
            where = ""
            if found:
                crossed, passage = found[0]
                node = int(crossed.triangles[passage.triangle, 0])
                where = f"at node {self._network.node_ids[node]} of {crossed.body.name}"
            yield self._finding(couple, len(found), where)

    def _finding(self, couple: _Couple, count: int, where: str) -> Finding:
        """Return the report that a couple overlaps."""
        one, other = couple.one.body, couple.other.body
        subject, among = f"{one.name} and {other.name}", "between"
        what = f"the surfaces of {subject} pass through each other"
        remedy = "write contact is bodies too"
        if couple.is_one:
            subject, among = one.name, "within"
            what = f"the surface of {subject} passes through itself"
            remedy = "write contact is everywhere"
        why = f"contact {among} bodies is off"
        if self._is_held[couple.is_one]:
            why = f"contact cannot hold {'it' if couple.is_one else 'them'} apart"
            remedy = "use a larger contact stiffness or smaller cells"
        return Finding(subject, count, f"{what}: {why}", where, "crossing", remedy, other.span)


def _is_watched(network: Network, couple: _Couple) -> bool:
    """Return whether surfaces are apart as drawn, or touch where contact holds them apart."""
    if not couple.touch(network.position):
        return True
    one, other = couple.one.body, couple.other.body
    if couple.is_one or network.are_joined(one, other):
        return False
    return _is_held_apart(network, is_one=False) and not couple.crosses(network)


def _are_kept_apart(network: Network, one: WatchedSkin, other: WatchedSkin) -> bool:
    """Return whether contact keeps one of two bodies outside of the other at any depth."""
    contact = network.contact
    return contact is not None and (
        contact.keeps_apart(one.body.nodes, other.body.nodes)
        or contact.keeps_apart(other.body.nodes, one.body.nodes)
    )


def _is_held_apart(network: Network, *, is_one: bool) -> bool:
    """Return whether surfaces touch other bodies, or their own."""
    if (contact := network.contact) is None:
        return False
    touches = (contact.kind[: len(contact.radius)] == TRIANGLE) & (contact.radius > 0.0)
    if is_one:
        touches &= contact.spared < 0
    return bool(touches.any())


def _near(one: WatchedSkin, other: WatchedSkin, position: Floats, margin: float) -> Indices:
    """Return pairs of an edge and a triangle whose boxes are near each other, (pair, 2).

    Those with a node in common are left out.
    """
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
    edge, triangle = edge[meet], triangle[meet]
    if one is other:
        shared = (edges[edge][:, :, None] == triangles[triangle][:, None]).any(axis=(1, 2))
        edge, triangle = edge[~shared], triangle[~shared]
    return np.stack([edge, triangle], axis=1)


def _are_across(
    position: Floats, edges: Indices, skin: WatchedSkin, pairs: Indices
) -> NDArray[np.bool_]:
    """Return which edges have their ends on different sides of the planes of triangles.

    Within flat parts of a surface, rounding would decide that. The shape is (pair,).
    """
    ends = position[edges[pairs[:, 0]]]
    a, b, c = position[skin.triangles[pairs[:, 1]]].swapaxes(0, 1)
    normal = cross(b - a, c - a)
    sides = np.stack([dot(normal, end - a) for end in ends.swapaxes(0, 1)])
    least = FLAT * skin.edge * norm(normal)
    return np.asarray((np.abs(sides).min(axis=0) > least) & (sides[0] * sides[1] < 0.0))


def _meet(low: Floats, high: Floats, least: Floats, most: Floats) -> NDArray[np.bool_]:
    """Return whether boxes have a point in common, shape (row,)."""
    return np.asarray(((low <= most) & (least <= high)).all(axis=-1))
