"""Holders of nodes, and the effect of their changes on motions.

The latest order wins: a node that is fixed, held or grasped leaves every motion that drove it
and rests, and one that is driven follows its new path, whoever else holds it.
"""

from collections.abc import Callable
from typing import Protocol, TypeAlias, runtime_checkable

import numpy as np
from msgspec import Struct

from tissuec.core.arrays import distinct, divided
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.mechanics.guiding import DirectedHold, across, overlap, without
from tissuec.mechanics.state import State
from tissuec.model.network import Floats, Indices
from tissuec.script.verbs import Action, Group, Mover, Order, follows

FIX = "fix"
_NOTHING = np.zeros(0, dtype=np.int64)


class Fixed(Struct, frozen=True, eq=False):
    """Nodes are held until they are freed, whatever else is released.

    ``directions`` are those in which nodes are held, here and below, shape (direction, 3); None
    for all.
    """

    nodes: Indices
    directions: Floats | None = None


class Taken(Struct, frozen=True, eq=False):
    """Nodes are held by a tool or set until they are released."""

    holder: str
    nodes: Indices
    directions: Floats | None = None


class Driven(Struct, frozen=True, eq=False):
    """A mover takes and drives its nodes, for a time [s] or without an end (None)."""

    mover: Mover
    duration: float | None
    directions: Floats | None = None


class JawsMoved(Struct, frozen=True, eq=False):
    """The jaws of forceps open or close, which they cannot do while the forceps move."""

    tool: str


class Stopped(Struct, frozen=True, eq=False):
    """The motion of a mover ends."""

    mover: str


class Released(Struct, frozen=True, eq=False):
    """A tool, or whoever holds them (None), releases nodes, or all that it holds (None)."""

    group: Group | None
    tool: str | None


class Freed(Struct, frozen=True, eq=False):
    """Every hold on nodes ends."""

    nodes: Indices


HoldChange: TypeAlias = Fixed | Taken | Driven | JawsMoved | Stopped | Released | Freed


@runtime_checkable
class Holding(Protocol):
    """An action that changes which nodes are held or driven."""

    def holding(self) -> HoldChange | None:
        """Return the change that it makes; None if nothing."""
        ...


def nodes_held_by(action: Action) -> Indices:
    """Return the nodes that an action holds or drives, shape (n,)."""
    if not follows(action, Holding):
        return _NOTHING
    match action.holding():
        case Fixed(nodes=nodes) | Taken(nodes=nodes):
            return nodes
        case Driven(mover=mover):
            return _NOTHING if mover.nodes is None else mover.nodes
        case _:
            return _NOTHING


def sentence(span: Span) -> str:
    """Return the text of a span on one line, for the event log."""
    return " ".join(span.text.split())


def held_by(state: State, holder: str) -> Indices:
    """Return the nodes that a tool or set holds, ascending, shape (n,)."""
    return state.holders.get(holder, _NOTHING)


def gripped(state: State, tool: str) -> Indices:
    """Return the nodes that a tool holds beside those of its own shape, ascending."""
    own = [t.nodes for t in state.network.tools if t.name == tool]
    held = held_by(state, tool)
    return held[held < own[0].start] if own else held


def take(state: State, holder: str, nodes: Indices) -> None:
    """Add nodes to those that a holder holds; they rest from now on.

    Args:
        state: Changed in place.
        holder: Name of a tool or set.
        nodes: Indices, shape (n,).
    """
    state.place_held()
    halt(state, nodes, lambda name: True)
    add_to_held(state, holder, nodes)
    state.place_held()


def add_to_held(state: State, holder: str, nodes: Indices) -> None:
    """Add nodes to those of a holder, which keep their order.

    Args:
        state: Changed in place.
        holder: Name of a tool or set.
        nodes: Indices, shape (n,).
    """
    held = np.zeros(state.network.node_count, dtype=bool)
    held[held_by(state, holder)] = held[nodes] = True
    state.holders[holder] = np.flatnonzero(held)


def held_in(along: Floats | None, along_all_but: Floats | None) -> Floats | None:
    """Return the directions in which a sentence holds nodes.

    Args:
        along: The one in which they are held, a unit vector, shape (3,).
        along_all_but: The one in which they are free, likewise.

    Returns:
        Unit vectors, shape (direction, 3); None for all directions.
    """
    if along is not None:
        return along[None]
    return None if along_all_but is None else across(along_all_but)


def refuse_both(along: Floats | None, along_all_but: Floats | None, order: Order) -> None:
    """Refuse a sentence that states both a held direction and a free one.

    Args:
        along, along_all_but: As of ``held_in``, dimensionless, shape (3,).
    """
    if along is not None and along_all_but is not None:
        order.reject(
            "TIS304",
            "nodes are held along a direction, or across one, but not both in one sentence",
            hint="write two sentences",
            word="across",
        )


def unguide(state: State, hold: DirectedHold) -> None:
    """End a hold in some directions; its nodes keep the velocities that they have now."""
    state.place_held()
    halt(state, hold.nodes, lambda name: name == hold.key)
    state.directed = {n: one for n, one in state.directed.items() if n != hold.key}
    state.guide()


def guide(state: State, hold: DirectedHold) -> None:
    """Hold nodes in some directions from now on; what held them in these before ends.

    Args:
        state: Changed in place.
        hold: The hold, or more nodes of one that is there.
    """
    state.place_held()
    if hold.holder != FIX and (whole := state.holders.get(hold.holder)) is not None:
        _, stays = divided(whole, hold.nodes)
        state.holders = {n: each for n, each in state.holders.items() if n != hold.holder}
        if len(stays):
            state.holders[hold.holder] = stays
    directed = dict[str, DirectedHold]()
    for name, other in state.directed.items():
        shared, stays = divided(other.nodes, hold.nodes)
        if (
            name == hold.key
            or not len(shared)
            or not overlap(other.directions, hold.directions)
        ):
            directed[name] = other
            continue
        halt(state, shared, lambda moving, name=name: moving == name)
        left = without(other.directions, hold.directions)
        for part in (
            replace(other, nodes=stays),
            replace(other, nodes=shared, directions=left),
        ):
            if len(part.nodes) and len(part.directions):
                directed[part.key] = part.joined(directed.get(part.key))
    directed[hold.key] = hold.joined(directed.get(hold.key))
    state.directed = directed
    state.guide()
    state.place_held()


def halt(state: State, nodes: Indices, concerns: Callable[[str], bool]) -> None:
    """Remove nodes from the motions selected by ``concerns``.

    Args:
        state: Changed in place.
        nodes: Indices, shape (n,).
        concerns: Returns whether a motion of this name is selected.
    """
    for name in filter(concerns, tuple(state.motions)):
        motion = state.motions[name]
        stays = np.flatnonzero(~np.isin(motion.nodes, nodes))
        if not len(stays):
            del state.motions[name]
        elif len(stays) < len(motion.nodes):
            state.motions[name] = motion.some(motion.nodes[stays], stays)


def let_go(state: State, nodes: Indices, concerns: Callable[[str], bool]) -> Indices:
    """End the hold of selected holders on some nodes, in all directions or in some.

    A node that is no longer held keeps the velocity that it has at this time.

    Args:
        state: Changed in place.
        nodes: Indices, shape (n,).
        concerns: Returns whether a holder of this name is selected.

    Returns:
        The nodes that were released, ascending.
    """
    state.place_held()
    kept = {name: hold for name, hold in state.directed.items() if not concerns(hold.holder)}
    ended = state.directed.keys() - kept.keys()
    halt(state, nodes, lambda name: name in ended or (name not in kept and concerns(name)))
    found = [_NOTHING]
    for name in ended:
        released, stays = divided(state.directed[name].nodes, nodes)
        found.append(released)
        if len(stays):
            kept[name] = replace(state.directed[name], nodes=stays)
    if ended:
        state.directed = kept
        state.guide()
    for name in filter(concerns, tuple(state.holders)):
        held = state.holders.pop(name)
        released, stays = divided(held, nodes)
        found.append(released)
        if len(stays):
            state.holders[name] = stays
        else:
            state.hold_ends.pop(name, None)
    state.place_held()
    return distinct(np.concatenate(found))
