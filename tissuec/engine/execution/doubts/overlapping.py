"""Bodies whose surfaces pass through each other, or through themselves.

Without contact between bodies, nothing keeps them apart; with it, bodies pass through if they
press harder than contact can bear. Then edges of one surface cross triangles of the other, or
triangles of the same surface with which they have no node in common. Bodies that cross as
drawn, or touch without contact, such as layers that joints connect, are left out, and so are
those that pass through themselves as drawn. Solids that contact keeps apart at any depth are
watched by ``doubts.sinking``.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import cache
from itertools import combinations
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from tissuec.compiled.calls import Shipped
from tissuec.core.arrays import distinct, norm, typical
from tissuec.engine.execution.doubts import WATCHES, Finding
from tissuec.geometry.edge_supports import SupportedTriangles
from tissuec.geometry.nearest import TRIANGLE, places
from tissuec.geometry.neighbours import in_balls
from tissuec.geometry.sweeps import SweptSurface, boxes
from tissuec.kernels.crossing import MOST_CELLS, find_crossings, place_triangles
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
            network.line_ends, skin, network.skin_elements_of(body)
        )
        self._alive: NDArray[np.bool_] | None = None
        self._whole = np.ones(len(skin), dtype=bool)
        self._intact = self.surface.edges.ends, self.triangles

    @property
    def triangles(self) -> Indices:
        """Return the corners of all triangles, shape (triangle, 3)."""
        return self.surface.triangles

    def whole(self, alive: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return which triangles are neither cut nor torn, shape (triangle,)."""
        if self._alive is None or not np.array_equal(alive, self._alive):
            self._alive, self._whole = alive.copy(), self._supported.whole(alive)
            edges = self.surface.edges
            own = distinct(edges.of[self._whole])
            self._intact = edges.ends[own], self.triangles[self._whole]
        return self._whole

    def intact(self, alive: NDArray[np.bool_]) -> tuple[Indices, Indices]:
        """Return the edges and the corners of these triangles.

        Args:
            alive: Springs that are there, shape (spring,).

        Returns:
            Nodes, of shapes (edge, 2) and (triangle, 3).
        """
        self.whole(alive)
        return self._intact


KIND = "bodies overlap"
TOUCHING = 0.01  # of the median edge: surfaces as near as that as drawn touch
FLAT = 1e-6  # of the median edge: nodes as near to a plane lie in it


class _PlacedSurface:
    """The intact part of a surface, where its nodes are.

    Where compiled code finds all arrays is looked up once: that takes longer than a search.

    Args:
        edges: Their ends, shape (edge, 2).
        triangles: Their corners, shape (triangle, 3).
        position: Of all nodes [m], shape (node, 3); ``place`` uses what it holds then.
    """

    def __init__(self, edges: Indices, triangles: Indices, position: Floats):
        number = len(triangles)
        self._edges, self._position = edges, position
        self._grid = (
            np.zeros(number, dtype=np.int64),
            np.zeros((number, 3), dtype=np.int64),
            np.zeros((number, 6)),
            np.zeros(MOST_CELLS * number + 1, dtype=np.int64),
            np.zeros((3, 3)),
            np.zeros(3, dtype=np.int64),
        )
        self._bounds = np.full((2, 3), np.nan)
        self._found = np.zeros(2, dtype=np.int64)
        self._searches: dict[tuple[_PlacedSurface, float], Callable[[], None]] = {}
        self._place: Callable[[], None] | None = None
        if number:
            room = np.zeros((number, 6)), np.zeros(number, dtype=np.int64)
            places = position, triangles, *room, *self._grid, self._bounds
            self._place = _compiled(place_triangles).of_first(*places)

    def place(self) -> None:
        """Take the nodes to be where they are now."""
        if self._place is not None:
            self._place()

    def meets(self, other: "_PlacedSurface") -> bool:
        """Return whether the boxes around both have a point in common."""
        (low, high), (least, most) = self._bounds, other._bounds
        return bool(_meet(low, high, least, most))

    def crossings(self, other: "_PlacedSurface", flat: float) -> tuple[int, int]:
        """Return how often edges go through triangles of another shape, and the least of these.

        Args:
            other: One that ``meets`` this one.
            flat: Ends as near to the plane of a triangle as this lie in it [m].
        """
        search = self._searches.get((other, flat))
        if search is None:
            values = self._position, self._edges, *other._grid, flat, self._found
            search = self._searches[other, flat] = _compiled(find_crossings).of_first(*values)
        search()
        pairs, least = self._found.tolist()
        return pairs, least


@cache
def _compiled(function: Callable[..., None]) -> Shipped:
    """Return a compiled function of ``kernels.crossing``."""
    return Shipped(function, "crossing")


class _Couple(NamedTuple):
    """Two surfaces, or one twice.

    Attributes:
        is_strict: Whether what crosses in a common plane does not count; see ``FLAT``.
    """

    one: WatchedSkin
    other: WatchedSkin
    is_strict: bool

    @property
    def is_one(self) -> bool:
        """Return whether it is a single surface."""
        return self.one is self.other

    @property
    def orders(self) -> list[tuple[WatchedSkin, WatchedSkin]]:
        """Return whose edges and whose triangles may cross."""
        pair = self.one, self.other
        return [pair] if self.is_one else [pair, (self.other, self.one)]

    def crossings(self, shapes: "_Shapes") -> tuple[int, tuple[WatchedSkin, int] | None]:
        """Return how often edges go through triangles, and the first of these triangles."""
        count, place = 0, None
        if shapes[self.one].meets(shapes[self.other]):
            for first, second in self.orders:
                flat = FLAT * second.edge if self.is_strict else 0.0
                more, triangle = shapes[first].crossings(shapes[second], flat)
                if more and place is None:
                    place = second, triangle
                count += more
        return count, place

    def touch(self, shapes: "_Shapes", drawn: Floats) -> bool:
        """Return whether the surfaces touch or cross as drawn.

        A single surface touches itself at all of its nodes, and is checked for crossings only.

        Args:
            shapes: As drawn.
            drawn: Positions of all nodes [m], shape (node, 3).
        """
        if self.crossings(shapes)[0]:
            return True
        if self.is_one:
            return False
        margin = TOUCHING * min(self.one.edge, self.other.edge)
        for first, second in self.orders:
            edges, triangles = first.surface.edges.ends, second.triangles
            pairs = _near(edges, triangles, drawn, margin)
            for end in (0, 1):
                node = edges[pairs[:, 0], end]
                kinds = np.full(len(node), TRIANGLE)
                corners = drawn[triangles[pairs[:, 1]]]
                found = places(drawn[node], kinds, corners, np.full(len(node), margin))
                if (found.depth > 0.0).any():
                    return True
        return False


class _Shapes:
    """Surfaces where they are.

    Args:
        skins: Whose surfaces.
    """

    def __init__(self, skins: Sequence[WatchedSkin]):
        self._skins = skins
        self._position = np.zeros((0, 3))
        self._intact: list[tuple[Indices, Indices]] = []
        self._shapes: dict[WatchedSkin, _PlacedSurface] = {}

    def __getitem__(self, skin: WatchedSkin) -> _PlacedSurface:
        return self._shapes[skin]

    def place(self, position: Floats, alive: NDArray[np.bool_]) -> None:
        """Take the surfaces to be as they are in a state.

        Args:
            position: Of all nodes [m], shape (node, 3).
            alive: Springs that are there, shape (spring,).
        """
        if not self._intact:
            self._position = np.empty(position.shape)
        self._position[...] = position
        intact = [skin.intact(alive) for skin in self._skins]
        if [id(one) for one in intact] != [id(one) for one in self._intact]:
            self._intact = intact
            self._shapes = {
                skin: _PlacedSurface(*own, self._position)
                for skin, own in zip(self._skins, intact, strict=True)
            }
        for shape in self._shapes.values():
            shape.place()


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
        pairs = [(couple.one, couple.other) for couple in couples]
        self._shapes = _Shapes(list(dict.fromkeys(skin for pair in pairs for skin in pair)))
        self._is_held = {
            is_one: _is_held_apart(network, is_one=is_one) for is_one in (False, True)
        }

    @classmethod
    def of(cls, network: Network, plan: Plan) -> Self | None:
        """Return the watch of a run; None without bodies with surfaces."""
        bodies = [b for b in network.bodies if b.thread is None and len(network.skin_of(b))]
        skins = [WatchedSkin(network, body) for body in bodies]
        pairs = [*combinations(skins, 2), *((skin, skin) for skin in skins)]
        pairs = [pair for pair in pairs if not _are_kept_apart(network, *pair)]
        drawn = network.position
        shapes = _Shapes(skins)
        shapes.place(drawn, network.present)
        couples = [_Couple(one, other, is_strict=one is other) for one, other in pairs]
        watched = (_watched(network, couple, shapes, drawn) for couple in couples)
        apart = [couple for couple in watched if couple is not None]
        return cls(network, apart) if apart else None

    def look(self, state: State, position: Floats) -> Iterator[Finding]:
        """Yield the bodies and the pairs that overlap now."""
        self._shapes.place(position, state.alive)
        for couple in self._couples:
            count, place = couple.crossings(self._shapes)
            where = ""
            if place is not None:
                skin, triangle = place
                node = self._network.node_ids[skin.intact(state.alive)[1][triangle, 0]]
                where = f"at node {node} of {skin.body.name}"
            yield self._finding(couple, count, where)

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


def _watched(
    network: Network, couple: _Couple, shapes: _Shapes, drawn: Floats
) -> _Couple | None:
    """Return surfaces that are apart as drawn, or touch where contact holds them apart."""
    if not couple.touch(shapes, drawn):
        return couple
    one, other = couple.one.body, couple.other.body
    if couple.is_one or network.are_joined(one, other):
        return None
    strict = couple._replace(is_strict=True)
    is_held = _is_held_apart(network, is_one=False)
    return strict if is_held and not strict.crossings(shapes)[0] else None


def _are_kept_apart(network: Network, one: WatchedSkin, other: WatchedSkin) -> bool:
    """Return whether contact keeps one of two bodies outside of the other at any depth."""
    if network.contact is None:
        return False
    from tissuec.forces.contact.readings import keeps_apart  # where something touches

    both = (one.body.nodes, other.body.nodes)
    return any(keeps_apart(network.contact, *nodes) for nodes in (both, both[::-1]))


def _is_held_apart(network: Network, *, is_one: bool) -> bool:
    """Return whether surfaces touch other bodies, or their own."""
    if (contact := network.contact) is None:
        return False
    touches = (contact.kind[: len(contact.radius)] == TRIANGLE) & (contact.radius > 0.0)
    if is_one:
        touches &= contact.spared < 0
    return bool(touches.any())


def _near(edges: Indices, triangles: Indices, position: Floats, margin: float) -> Indices:
    """Return pairs of an edge and a triangle whose boxes are near each other, (pair, 2)."""
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
