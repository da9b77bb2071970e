"""Threads and tools that get into a body in spite of contact.

Surfaces keep off the nodes of threads, and tools and threads keep off the nodes of bodies. What
is thin beside the distance of nodes can pass between them, and what presses harder than contact
bears goes through. Then its line crosses the surface; a ball has its centre inside.
"""

from collections.abc import Iterator
from typing import Self

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
        skins = {body.name: network.skin_of(body) for _, body in lines}
        self._skins = {
            name: SupportedTriangles(network.ends, skin) for name, skin in skins.items()
        }
        self._closed = {name: Edges.among(skin).is_closed for name, skin in skins.items()}
        self._lines = lines
        self._passing = set[tuple[str, str]]()

    @classmethod
    def of(cls, network: Network, plan: Plan) -> Self | None:
        """Return the watch of a run; None without contact, or without threads and tools.

        A thread that a joint sews to a body goes into it on purpose.
        """
        if plan.contact is None:
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
        count = len(crossings(segments, position[skin.triangles[whole]]))
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
    return network.ends[pieces][alive[pieces]].astype(np.int64)
