"""Checks of threads and tools: bodies that they can pass through."""

from collections.abc import Iterator
from math import ceil
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tissuec.compiler.checks import check
from tissuec.core.arrays import cross, norm
from tissuec.core.errors import Diagnostic
from tissuec.core.hints import Edit, Hint
from tissuec.core.names import key_of
from tissuec.core.source import Span
from tissuec.core.units import LENGTH, show
from tissuec.lang import syntax as s
from tissuec.lang.walk import walk
from tissuec.model.network import BodyPart, Floats, Indices, Network, ToolPart
from tissuec.scene.reading.entry_hints import missing
from tissuec.script.verbs import Shifting, follows

if TYPE_CHECKING:
    from tissuec.compiler.compile import Compiled

TOUCHING = "contact is tools only"


@check
def passing_threads(compiled: "Compiled") -> Iterator[Diagnostic]:
    """W411: a thread that is drawn at a body through which it can pass."""
    network = compiled.network
    threads = [body for body in network.bodies if body.thread is not None]
    others = [body for body in network.bodies if body.thread is None]
    for body in threads:
        for other in others:
            # A thread that is sewn to a body goes into it on purpose.
            if network.are_joined(body, other) or not _are_close(network, body, other):
                continue
            if network.contact is None:
                text = f"contact is off: {body.name} passes through {other.name}"
                yield Diagnostic("W411", text, body.span, turning_contact_on(compiled))
            elif network.contact.has_points_on(other.nodes):
                continue  # points along the thread touch its faces
            elif (found := _gap(compiled, body, other)) is not None:
                gap, hint = found
                text = f"{body.name} can pass between the nodes of {other.name}: {gap}"
                yield Diagnostic("W411", text, body.span, hint)


@check
def passing_tools(compiled: "Compiled") -> Iterator[Diagnostic]:
    """W411: a tool that is so thin that it can pass between the nodes of a body it reaches.

    A ball passes through a triangle of nodes whose circumscribed circle is larger than it; so
    does the end of a capsule.
    """
    network, contact = compiled.network, compiled.network.contact
    if contact is None:
        return
    for tool in network.tools:
        radii = [shape.radius for shape in tool.shapes if shape.kind == "capsule"]
        bodies = [body for body in network.bodies if body.thread is None] if radii else []
        for body in bodies:
            corners = network.skin_of(body)
            # The faces of others have no gaps.
            if not len(corners) or contact.has_points_on(body.nodes):
                continue
            if not _reaches(compiled, tool, body, max(radii)):
                continue
            gap = _middle(_circles(network.position[corners]))
            if gap > min(radii):
                yield Diagnostic(
                    "W411",
                    f"{tool.name} can pass between the nodes of {body.name}: a thickness of "
                    f"{show(2.0 * min(radii), LENGTH)} meets gaps of {show(2.0 * gap, LENGTH)}",
                    tool.span,
                    "use smaller cells or triangles, or a thicker tool",
                )


def _reaches(compiled: "Compiled", tool: ToolPart, body: BodyPart, radius: float) -> bool:
    """Return whether a tool comes near a body by all that the script moves it."""
    plan, network = compiled.plan, compiled.network
    ways = (
        action.shift
        for action in (event.action for event in plan.every_event)
        if follows(action, Shifting)
    )
    reach = radius + sum(ways)
    low, high = _box(network, body)
    own = network.position[tool.nodes]
    return bool(
        np.all(own.min(axis=0) - reach <= high) and np.all(low <= own.max(axis=0) + reach)
    )


def _circles(corners: Floats) -> Floats:
    """Return the radii of the circles around triangles [m], from shape (triangle, 3, 3)."""
    sides = norm(corners - np.roll(corners, 1, axis=1))
    area = norm(cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    return sides.prod(axis=1) / (2.0 * np.maximum(area, np.finfo(float).tiny))


def _are_close(network: Network, thread: BodyPart, other: BodyPart) -> bool:
    """Return whether the boxes around both overlap as they are drawn."""
    low, high = _box(network, thread)
    other_low, other_high = _box(network, other)
    reach = _radius(thread)
    return bool(np.all(low - reach <= other_high) and np.all(other_low <= high + reach))


def _box(network: Network, body: BodyPart) -> tuple[Floats, Floats]:
    position = network.position[body.nodes]
    return position.min(axis=0), position.max(axis=0)


def _radius(body: BodyPart) -> float:
    return 0.0 if body.thread is None else body.thread.radius


def turning_contact_on(compiled: "Compiled") -> Hint:
    """Return a hint that turns contact on."""
    block = compiled.scene.declarations.single["environment"]
    if (written := entry_of(block, "contact")) is not None:
        return Hint(f"write: {TOUCHING}", Edit(TOUCHING, written))
    return missing(TOUCHING, block.head)


def _gap(compiled: "Compiled", body: BodyPart, other: BodyPart) -> tuple[str, str] | None:
    """Return why nothing keeps a thread from passing between nodes, and what would.

    Surfaces keep off the nodes of a thread, and its pieces keep off the nodes of bodies. There
    is room between both if edges are longer than the thread is thick, and pieces than edges.
    """
    network, thread = compiled.network, body.thread
    assert thread is not None
    corners = network.skin_of(other)
    springs = network.line_ends[other.lines]
    edge = _middle(_sides(network, corners) if len(corners) else _lengths(network, springs))
    if edge <= 2.0 * thread.radius:
        return None
    if not len(corners):
        gap = f"it has no surface, and springs of {show(edge, LENGTH)}"
        return gap, "use a body with a surface, or a thickness above that"
    pieces = _lengths(network, network.springs.ends[thread.pieces])
    longest = float(pieces.max())
    if longest <= edge:
        return None
    gap = f"pieces of {show(longest, LENGTH)} meet edges of {show(edge, LENGTH)}"
    return gap, _more_pieces(compiled, body, ceil(len(pieces) * longest / edge))


def _lengths(network: Network, ends: NDArray[np.integer[Any]]) -> Floats:
    first, second = network.position[ends[:, 0]], network.position[ends[:, 1]]
    return np.linalg.norm(second - first, axis=1)


def _sides(network: Network, corners: Indices) -> Floats:
    """Return the lengths of the sides of triangles [m], shape (side,)."""
    sides = np.stack([corners, np.roll(corners, 1, axis=1)], axis=-1).reshape(-1, 2)
    return _lengths(network, sides)


def _middle(lengths: Floats) -> float:
    return float(np.median(lengths)) if len(lengths) else 0.0


def _more_pieces(compiled: "Compiled", body: BodyPart, count: int) -> Hint:
    """Return in how many pieces a thread lies closely enough."""
    text = f"pieces = {count}"
    block = compiled.scene.declarations.of("body")[key_of(body.name)].item
    written = entry_of(block, "pieces")
    edits = [] if written is None else [Edit(text, written)]
    return Hint(f"write: {text}", *edits)


def entry_of(block: s.Item, name: str) -> Span | None:
    """Return where a block says something of a name, in the blocks within it too."""
    entries = (part for part in walk(block) if isinstance(part, s.Assign | s.Sentence))
    return next((one.span for one in entries if one.name.key == name), None)
