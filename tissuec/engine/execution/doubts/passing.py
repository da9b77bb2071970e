"""Threads and tools that get into a body in spite of contact.

Surfaces keep off the nodes of threads, and tools and threads keep off the nodes of bodies. What
is thin beside the distance of nodes can pass between them, and what presses harder than contact
bears goes through. Then its line crosses the surface; a ball has its centre inside. What no
longer crosses is either pulled back, or has passed: then the place on its line where it crossed
first is on the other side of the surface than before.

Solids keep thin tools and threads outside at any depth. Such a line crosses their surface where
it has sunk in by more than its radius; that is reported where it is deep, or has passed.

So that nothing passes unseen, states are checked whenever a node has moved by a part of the
size of a triangle, and passages between two checks are found by ``geometry.sweeps``.
"""

from collections.abc import Iterator
from typing import Self

import numpy as np
from msgspec import Struct, field
from numpy.typing import NDArray

from tissuec.core.arrays import cross, norm
from tissuec.engine.execution.doubts import WATCHES, Finding
from tissuec.engine.execution.doubts.overlapping import WatchedSkin
from tissuec.geometry.edges import volume
from tissuec.geometry.inside import inside
from tissuec.geometry.neighbours import nearest_triangles
from tissuec.geometry.sweeps import Passage, near, side_of, sweeps, through
from tissuec.mechanics.state import State
from tissuec.model.network import BodyPart, Floats, Indices, Network, ToolPart
from tissuec.script.plan import Plan

KIND = "passes through a surface"
SAMPLES = np.linspace(0.0, 1.0, 33)[:, None]  # where the depth of pieces of lines is computed
APART = 0.05  # of the median edge of a surface: path of a node between two checks
_OBLIQUE = np.array([0.36, 0.48, 0.80])  # a unit vector that is at right angles to nothing
_OF_THREADS = "use more pieces, or a larger thickness or contact stiffness"
_OF_TOOLS = "use smaller cells, a thicker tool, or a larger contact stiffness"


class Begun(Struct, frozen=True):
    """The first crossing of a line that crosses now.

    Attributes:
        passage: Where the line crossed first.
        is_in_front: Whether this place on the line was in front of the surface before.
    """

    passage: Passage
    is_in_front: bool


class PassingMemory(Struct):
    """The findings so far, as a checkpoint holds them.

    Attributes:
        before: Positions at the last check [m], shape (node, 3); None before the first one.
        seen: Pairs of a line and a body that have crossed, by name.
        begun: Pairs that cross now.
    """

    before: Floats | None = None
    seen: list[str] = field(default_factory=list[str])
    begun: dict[str, Begun] = field(default_factory=dict[str, Begun])


class _WatchedLine:
    """The axes of a tool, or a thread."""

    def __init__(self, network: Network, part: BodyPart | ToolPart):
        self.part, self.name = part, part.name
        self.is_thread = isinstance(part, BodyPart)
        if isinstance(part, ToolPart):
            self.pieces, self._springs = _axes(part), None
            thinnest = min(shape.radius for shape in part.shapes if shape.radius)
            # Tools are often drawn in the middle of cells, where their axis meets the shared
            # edge of two triangles and crosses neither.
            self.aside = 1e-3 * thinnest * _OBLIQUE
        else:
            assert part.thread is not None
            self._springs, self.aside = part.thread.pieces, np.zeros(3)
            self.pieces = network.springs.ends[self._springs].astype(np.int64)
        self.nodes = np.unique(self.pieces)

    def there(self, alive: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return which pieces are intact, shape (piece,)."""
        return (
            np.ones(len(self.pieces), bool) if self._springs is None else alive[self._springs]
        )


class _WatchedPair:
    """A line and the surface of a body that may stop it."""

    def __init__(self, line: _WatchedLine, skin: WatchedSkin):
        self.line, self.skin = line, skin
        self.key = f"{line.name} in {skin.body.name}"
        self._is_closed = skin.surface.edges.is_closed
        pieces = line.pieces
        self._balls = pieces[pieces[:, 0] == pieces[:, 1], 0]

    def passages(
        self, before: Floats, now: Floats, alive: NDArray[np.bool_]
    ) -> tuple[list[Passage], list[Passage]]:
        """Return where the line crosses the surface now, and where it passed since before.

        Args:
            before, now: Positions of all nodes [m], shape (node, 3).
            alive: Springs that are there, shape (spring,).
        """
        pieces, triangles = self.line.pieces, self.skin.triangles
        before, now = self._beside(before), self._beside(now)
        pairs = near(before, now, pieces, triangles)
        if not len(pairs):
            return [], []
        holds = self.line.there(alive)[pairs[:, 0]] & self.skin.whole(alive)[pairs[:, 1]]
        pairs = pairs[holds]
        return (
            through(now, pieces, triangles, pairs),
            sweeps(before, now, pieces, self.skin.surface, pairs),
        )

    def balls_inside(self, now: Floats, alive: NDArray[np.bool_]) -> int:
        """Return the number of balls with their centre inside the body; arguments as above."""
        if not len(self._balls) or not self._is_closed or not self.skin.whole(alive).all():
            return 0
        return int(np.count_nonzero(inside(now[self._balls], now, self.skin.triangles)))

    def depth(
        self, network: Network, position: Floats, alive: NDArray[np.bool_]
    ) -> float | None:
        """Return how deep the line is inside the body [m]; None if contact may let it pass.

        Args:
            position: Of all nodes [m], shape (node, 3).
            alive: Springs that are there, shape (spring,).
        """
        contact, line, body = network.contact, self.line.part.nodes, self.skin.body.nodes
        if contact is None:
            return None
        from tissuec.forces.contact.readings import keeps_outside  # where something touches

        if not keeps_outside(contact, line, body, alive):
            return None
        start, end = position[self.line.pieces].swapaxes(0, 1)[:, :, None]
        points = (start + SAMPLES * (end - start)).reshape(-1, 3)
        found = nearest_triangles(points, position, self.skin.triangles, 0.0)
        return float(found.distance.max(initial=0.0))

    def deepest(self, drawn: Floats) -> float:
        """Return the depth from which a line is reported that contact keeps outside [m].

        It is half of an edge, as tools that are kept outside are thinner than half of a face,
        or half of the way to the middle of a plate of equal volume and surface: beyond the
        middle, contact pushes on.

        Args:
            drawn: Positions of all nodes [m], shape (node, 3).
        """
        a, b, c = drawn[self.skin.triangles.T]
        area = 0.5 * float(norm(cross(b - a, c - a)).sum())
        return 0.5 * min(self.skin.edge, volume(drawn, self.skin.triangles) / area)

    def holds(self, passage: Passage, alive: NDArray[np.bool_]) -> bool:
        """Return whether both the piece and the triangle of a passage are intact."""
        return bool(
            self.line.there(alive)[passage.piece] and self.skin.whole(alive)[passage.triangle]
        )

    def side(
        self, passage: Passage, position: Floats, alive: NDArray[np.bool_]
    ) -> tuple[bool, int]:
        """Return whether a place on the line is in front of the surface, and the nearest node.

        Args:
            passage: At this place.
            position: Of all nodes [m], shape (node, 3).
            alive: Springs that are there, shape (spring,).
        """
        start, end = position[self.line.pieces[passage.piece]] + self.line.aside
        place = start + passage.share * (end - start)
        return side_of(place, position, self.skin.triangles[self.skin.whole(alive)])

    def node(self, passage: Passage, position: Floats) -> int:
        """Return the corner of a passage's triangle that is nearest to it."""
        start, end = position[self.line.pieces[passage.piece]]
        corners = self.skin.triangles[passage.triangle]
        away = position[corners] - (start + passage.share * (end - start))
        return int(corners[norm(away).argmin()])

    def _beside(self, position: Floats) -> Floats:
        """Return positions with the line moved aside a little [m], shape (node, 3)."""
        if not self.line.aside.any():
            return position
        moved = position.copy()
        moved[self.line.nodes] += self.line.aside
        return moved


@WATCHES.member(KIND)
class Passing:
    """Watches the lines of threads and tools, except where they cross a body as drawn."""

    kind = KIND

    def __init__(self, network: Network, pairs: list[_WatchedPair]):
        self._network, self._pairs = network, pairs
        self.memory = PassingMemory()
        skins = [pair.skin for pair in pairs]
        self._apart = APART * min(skin.edge for skin in skins)
        nodes = [skin.triangles.ravel() for skin in skins] + [pair.line.nodes for pair in pairs]
        self._nodes = np.unique(np.concatenate(nodes))

    @classmethod
    def of(cls, network: Network, plan: Plan) -> Self | None:
        """Return the watch of a run; None without contact, or without threads and tools.

        A thread that a joint sews to a body goes into it on purpose.
        """
        if network.contact is None:
            return None
        threads = [body for body in network.bodies if body.thread is not None]
        tools = [_WatchedLine(network, tool) for tool in network.tools if len(_axes(tool))]
        bodies = [b for b in network.bodies if b.thread is None and len(network.skin_of(b))]
        if not bodies or not (threads or tools):
            return None
        lines = [_WatchedLine(network, one) for one in threads]
        pairs: list[_WatchedPair] = []
        for body in bodies:
            skin = WatchedSkin(network, body)
            sewn = [network.are_joined(one, body) for one in threads]
            free = [line for line, is_sewn in zip(lines, sewn, strict=True) if not is_sewn]
            pairs += [_WatchedPair(line, skin) for line in (*free, *tools)]
        drawn, present = network.position, network.present
        pairs = [
            pair
            for pair in pairs
            if not pair.passages(drawn, drawn, present)[0]
            and not pair.balls_inside(drawn, present)
        ]
        return cls(network, pairs) if pairs else None

    def leeway(self, position: Floats) -> float:
        """Return 0 if nodes have moved so far that a line may have passed, otherwise infinity.

        The run comes back when it leaves the lists of near pairs.
        """
        way = position[self._nodes] - self._before[self._nodes]
        return 0.0 if np.abs(way).max(initial=0.0) > self._apart else np.inf

    def look(self, state: State, position: Floats) -> Iterator[Finding]:
        before, memory, alive = self._before, self.memory, state.alive
        for pair in self._pairs:
            now, swept = pair.passages(before, position, alive)
            count = len(now) + pair.balls_inside(position, alive)
            if not count and not swept and pair.key not in (*memory.seen, *memory.begun):
                continue
            first, most = [*swept, *now][:1], max(count, 1 if swept else 0)
            depth = pair.depth(self._network, position, alive)
            is_in = bool(count or depth)
            if depth is not None:
                is_deep = depth > pair.deepest(self._network.position)
                most = count = max(count, 1) if is_deep else 0
            if most and pair.key not in memory.seen:
                memory.seen.append(pair.key)
            if pair.key in memory.seen:
                place = self._at(pair.node(first[0], position), pair) if first else ""
                yield self._finding(pair, most, place, is_kept=depth is not None)
                if most != count:
                    yield self._finding(pair, count, place)
            if first and pair.key not in memory.begun:
                is_in_front, _ = pair.side(first[0], before, alive)
                memory.begun[pair.key] = Begun(first[0], is_in_front)
            if not is_in:
                yield from self._passed(pair, position, alive)
        memory.before = position.copy()

    @property
    def _before(self) -> Floats:
        """Return the positions at the last check, or those drawn [m], shape (node, 3)."""
        return self._network.position if self.memory.before is None else self.memory.before

    def _at(self, node: int, pair: _WatchedPair) -> str:
        return f"at node {self._network.node_ids[node]} of {pair.skin.body.name}"

    def _finding(
        self, pair: _WatchedPair, count: int, where: str, *, is_kept: bool = False
    ) -> Finding:
        """Return the report that a line crosses a surface, or has sunk deep into it."""
        line, body = pair.line, pair.skin.body
        how = f"passes through the surface of {body.name}: contact cannot hold it back there"
        if is_kept:
            how = f"sinks deep into {body.name}: contact is too soft there"
        return Finding(
            pair.key,
            count,
            f"{line.name} {how}",
            where,
            "crossing",
            _OF_THREADS if line.is_thread else _OF_TOOLS,
            line.part.span,
        )

    def _passed(
        self, pair: _WatchedPair, position: Floats, alive: NDArray[np.bool_]
    ) -> Iterator[Finding]:
        """Yield a finding if a line has come to the other side of a surface by crossing it."""
        begun = self.memory.begun.pop(pair.key, None)
        if begun is None or not pair.holds(begun.passage, alive):
            return
        is_in_front, node = pair.side(begun.passage, position, alive)
        if is_in_front == begun.is_in_front:
            return  # drawn back
        line, body = pair.line, pair.skin.body
        yield Finding(
            f"{line.name} through {body.name}",
            1,
            f"{line.name} has passed through {body.name} and holds it no longer",
            self._at(node, pair),
            "passage",
            _OF_THREADS if line.is_thread else _OF_TOOLS,
            line.part.span,
        )


def _axes(tool: ToolPart) -> Indices:
    """Return the nodes at both ends of the axes of the capsules of a tool, shape (axis, 2)."""
    number = [n for n, shape in enumerate(tool.shapes) if shape.kind == "capsule"]
    return tool.nodes.start + 2 * np.array(number, dtype=np.int64)[:, None] + np.arange(2)
