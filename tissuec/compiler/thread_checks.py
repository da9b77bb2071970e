"""Checks of threads: bodies that a thread passes through as drawn."""

from collections.abc import Iterator
from math import ceil
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tissuec.core.errors import Diagnostic
from tissuec.core.hints import Edit, Hint
from tissuec.core.names import key_of
from tissuec.core.source import Span
from tissuec.core.units import LENGTH, show
from tissuec.lang import syntax as s
from tissuec.lang.walk import walk
from tissuec.model.network import BodyPart, Floats, Network
from tissuec.scene.schema import missing

if TYPE_CHECKING:
    from tissuec.compiler.compile import Compiled

TOUCHING = "contact is tools only"


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
            if compiled.plan.contact is None:
                text = f"contact is off: {body.name} passes through {other.name}"
                yield Diagnostic("W411", text, body.span, turning_contact_on(compiled))
            elif (found := _gap(compiled, body, other)) is not None:
                gap, hint = found
                text = f"{body.name} can pass between the nodes of {other.name}: {gap}"
                yield Diagnostic("W411", text, body.span, hint)


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
    """Return what turns contact on."""
    block = compiled.scene.declarations.single["environment"]
    if (written := _entry(block, "contact")) is not None:
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
    sides = np.stack([corners, np.roll(corners, 1, axis=1)], axis=-1).reshape(-1, 2)
    edge = _middle(_lengths(network, sides if len(corners) else network.ends[other.springs]))
    if edge <= 2.0 * thread.radius:
        return None
    if not len(corners):
        gap = f"it has no surface, and springs of {show(edge, LENGTH)}"
        return gap, "use a body with a surface, or a thickness above that"
    pieces = _lengths(network, network.ends[thread.pieces])
    longest = float(pieces.max())
    if longest <= edge:
        return None
    gap = f"pieces of {show(longest, LENGTH)} meet edges of {show(edge, LENGTH)}"
    return gap, _more_pieces(compiled, body, ceil(len(pieces) * longest / edge))


def _lengths(network: Network, ends: NDArray[np.integer[Any]]) -> Floats:
    first, second = network.position[ends[:, 0]], network.position[ends[:, 1]]
    return np.linalg.norm(second - first, axis=1)


def _middle(lengths: Floats) -> float:
    return float(np.median(lengths)) if len(lengths) else 0.0


def _more_pieces(compiled: "Compiled", body: BodyPart, count: int) -> Hint:
    """Return in how many pieces a thread lies closely enough."""
    text = f"pieces = {count}"
    block = compiled.scene.declarations.of("body")[key_of(body.name)].item
    written = _entry(block, "pieces")
    edits = [] if written is None else [Edit(text, written)]
    return Hint(f"write: {text}", *edits)


def _entry(block: s.Item, name: str) -> Span | None:
    """Return where a block says something of a name, in the blocks within it too."""
    entries = (part for part in walk(block) if isinstance(part, s.Assign | s.Sentence))
    return next((one.span for one in entries if one.name.key == name), None)
