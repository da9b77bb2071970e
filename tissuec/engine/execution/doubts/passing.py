"""Threads and tools that get into a body in spite of contact.

Surfaces keep off the nodes of threads, and tools and threads keep off the nodes of bodies. What
is thin beside the distance of nodes can pass between them, and what presses harder than contact
bears goes through. Then its line crosses the surface; a ball has its centre inside. What no
longer crosses is either drawn back, or has passed: then the middle of its line is on the other
side of the nearest triangle than before it began to cross.
"""

from collections.abc import Iterator
from typing import Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from tissuec.engine.execution.doubts import WATCHES, Finding
from tissuec.geometry.edge_supports import SupportedTriangles
from tissuec.geometry.edges import Edges
from tissuec.geometry.inside import inside
from tissuec.geometry.intersections import crossings
from tissuec.mechanics.state import State
from tissuec.model.network import BodyPart, Floats, Indices, Network, ToolPart
from tissuec.script.plan import Plan

_Side: TypeAlias = tuple[int, bool]

KIND = "passes through a surface"
_OBLIQUE = np.array([0.36, 0.48, 0.80])  # a unit vector that is at right angles to nothing
_OF_THREADS = "use more pieces, or a larger thickness or contact stiffness"
_OF_TOOLS = "use smaller cells, a thicker tool, or a larger contact stiffness"


@WATCHES.member(KIND)
class Passing:
    """Watches the lines of threads and tools, except where they cross a body as drawn."""

    kind = KIND

    def __init__(self, network: Network, lines: list[tuple[BodyPart | ToolPart, BodyPart]]):
        self._network = network
        bodies = {body.name: body for _, body in lines}
        skins = {name: network.skin_of(body) for name, body in bodies.items()}
        self._skins = {
            name: SupportedTriangles(
                network.springs.ends, skin, network.skin_marks_of(bodies[name])
            )
            for name, skin in skins.items()
        }
        self._closed = {name: Edges.among(skin).is_closed for name, skin in skins.items()}
        self._lines = lines
        self._passing = set[tuple[str, str]]()
        self._before: Floats | None = None  # positions at the last look
        #: Of what crosses now: the piece of its line, and on which side it was before.
        self._begun = dict[tuple[str, str], _Side]()

    @classmethod
    def of(cls, network: Network, plan: Plan) -> Self | None:
        """Return the watch of a run; None without contact, or without threads and tools.

        A thread that a joint sews to a body goes into it on purpose.
        """
        if network.contact is None:
            return None
        bodies = [body for body in network.bodies if body.thread is None]
        threads = [body for body in network.bodies if body.thread is not None]
        tools = [tool for tool in network.tools if len(_axes(tool))]
        lines: list[tuple[BodyPart | ToolPart, BodyPart]] = [
            *((one, b) for b in bodies for one in threads if not network.are_joined(one, b)),
            *((tool, body) for body in bodies for tool in tools),
        ]
        lines = [(line, body) for line, body in lines if len(network.skin_of(body))]
        if not lines:
            return None
        watch, drawn = cls(network, lines), network.position
        watch._lines = [
            (line, body)
            for line, body in lines
            if not watch._count(line, body, network.present, drawn)
        ]
        return watch

    def look(self, state: State, position: Floats) -> Iterator[Finding]:
        for line, body in self._lines:
            count = self._count(line, body, state.alive, position)
            pair = line.name, body.name
            if not count and pair not in self._passing:
                continue
            self._passing.add(pair)
            yield from self._passed(line, body, count, state, position)
            is_thread = isinstance(line, BodyPart)
            yield Finding(
                f"{line.name} in {body.name}",
                count,
                f"{line.name} passes through the surface of {body.name}: contact cannot hold "
                "it back there",
                "",
                "crossing",
                _OF_THREADS if is_thread else _OF_TOOLS,
                line.span,
            )
        self._before = position.copy()

    def _passed(
        self,
        line: BodyPart | ToolPart,
        body: BodyPart,
        count: int,
        state: State,
        position: Floats,
    ) -> Iterator[Finding]:
        """Yield that a line is on the other side of a surface than before it crossed it."""
        pair = line.name, body.name
        if count and pair not in self._begun and self._before is not None:
            pairs = self._crossings(line, body, state.alive, position)
            if len(pairs):
                piece = int(pairs[0, 0])
                self._begun[pair] = piece, self._side(line, body, state, self._before, piece)[0]
            return
        if count or pair not in self._begun:
            return
        piece, side = self._begun.pop(pair)
        now, node = self._side(line, body, state, position, piece)
        if now == side:
            return  # drawn back
        ids = self._network.node_ids
        yield Finding(
            f"{line.name} through {body.name}",
            1,
            f"{line.name} has passed through {body.name} and holds it no longer",
            f"at node {ids[node]} of {body.name}",
            "passage",
            _OF_THREADS if isinstance(line, BodyPart) else _OF_TOOLS,
            line.span,
        )

    def _side(
        self, line: BodyPart | ToolPart, body: BodyPart, state: State, position: Floats,
        piece: int,
    ) -> tuple[bool, int]:  # fmt: skip
        """Return whether a piece of a line is in front of a surface, and the nearest node.

        Args:
            position: Of all nodes [m], shape (node, 3).
            piece: Its number in the line.
        """
        skin = self._skins[body.name]
        triangles = skin.triangles[skin.whole(state.alive)]
        middle = position[_pieces(self._network, line, state.alive)[piece]].mean(axis=0)
        corners = position[triangles]
        nearest = int(np.linalg.norm(corners.mean(axis=1) - middle, axis=1).argmin())
        a, b, c = corners[nearest]
        nodes = triangles[nearest]
        node = int(nodes[np.linalg.norm(corners[nearest] - middle, axis=1).argmin()])
        return bool(np.cross(b - a, c - a) @ (middle - a) > 0.0), node

    def _crossings(
        self, line: BodyPart | ToolPart, body: BodyPart, alive: NDArray[np.bool_],
        position: Floats,
    ) -> Indices:  # fmt: skip
        """Return pairs of a piece of a line and a whole triangle that it crosses."""
        skin = self._skins[body.name]
        segments = position[_pieces(self._network, line, alive)] + _aside(line)
        return crossings(segments, position[skin.triangles[skin.whole(alive)]])

    def _count(
        self, line: BodyPart | ToolPart, body: BodyPart, alive: NDArray[np.bool_],
        position: Floats,
    ) -> int:  # fmt: skip
        """Return how often a thread or tool goes through the whole part of a surface.

        Args:
            line: The thread or tool.
            body: With this surface.
            alive: Springs that are there, shape (spring,).
            position: Of all nodes [m], shape (node, 3).
        """
        skin = self._skins[body.name]
        whole = skin.whole(alive)
        segments = position[_pieces(self._network, line, alive)] + _aside(line)
        count = len(self._crossings(line, body, alive, position))
        balls = segments[(segments[:, 0] == segments[:, 1]).all(axis=1), 0]
        if len(balls) and whole.all() and self._closed[body.name]:
            count += int(np.count_nonzero(inside(balls, position, skin.triangles)))
        return count


def _aside(line: BodyPart | ToolPart) -> Floats:
    """Return a way to move a line aside [m], shape (3,).

    By a thousandth of its radius: tools are often drawn in the middle of cells, and what goes
    through the edge of two triangles goes through neither.
    """
    if isinstance(line, BodyPart):
        return np.zeros(3)
    return 1e-3 * min(shape.radius for shape in line.shapes if shape.radius) * _OBLIQUE


def _axes(tool: ToolPart) -> Indices:
    """Return the nodes at both ends of the axes of the capsules of a tool, shape (axis, 2)."""
    number = [n for n, shape in enumerate(tool.shapes) if shape.kind == "capsule"]
    return tool.nodes.start + 2 * np.array(number, dtype=np.int64)[:, None] + np.arange(2)


def _pieces(network: Network, line: BodyPart | ToolPart, alive: NDArray[np.bool_]) -> Indices:
    """Return the nodes at the ends of the pieces of a line, shape (piece, 2)."""
    if isinstance(line, ToolPart):
        return _axes(line)
    assert line.thread is not None
    pieces = line.thread.pieces
    return network.springs.ends[pieces][alive[pieces]].astype(np.int64)
