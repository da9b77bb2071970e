"""Sentences about elements that break and volumes that leak: where, and why."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec.structs import replace

from tissuec.core.errors import counted
from tissuec.core.units import LENGTH, TIME, show
from tissuec.mechanics.state import State
from tissuec.model.network import Floats, Indices, Network
from tissuec.script.verbs import LoggedEvent

if TYPE_CHECKING:
    from tissuec.forces.kept_volumes import KeptVolumes


#: By limit: what of an element exceeds it, and what it is called.
_EXCEEDED = {
    "strain": ("strain", "breaking strain"),
    "stress": ("stress", "strength"),
    "toughness": ("energy", "toughness"),
}


def broken_elements(
    network: Network, position: Floats, marks: Indices, edges: Indices
) -> Iterator[LoggedEvent]:
    """Yield an event for all that broke by one entry of a scene.

    Args:
        network: The network.
        position: Of all nodes [m], shape (node, 3).
        marks: Of the elements that break now, shape (n,).
        edges: Springs that are lost with them, shape (m,); they are entered with the first.
    """
    known = network.provenance["strength"]
    for index in np.unique(known.index[marks]).tolist():
        of_part = marks[known.index[marks] == index]
        limit = np.array([_exceeded(network, position, mark) for mark in of_part.tolist()])
        for name in dict.fromkeys(limit.tolist()):
            own = of_part[limit == name]
            springs = (*own.tolist(), *edges.tolist())
            # The first origin of a part is that of its strain, if it has two.
            place = int(index) + int(str(name) == "stress")
            span = known.origins[place].span
            yield LoggedEvent("rupture", springs, _cause(network, own, name), span)
            edges = edges[:0]


def _exceeded(network: Network, position: Floats, mark: int) -> str:
    """Return which limit an element exceeded: the one that it exceeds the most."""
    field, item = _element(network, mark)
    limits = [name for name in _EXCEEDED if np.isfinite(getattr(field.limits, name)[item])]
    if len(limits) < 2:
        return limits[0]
    breakable = field.breakable
    alone = breakable.some(np.flatnonzero(breakable.limits.marks == mark))

    def load(name: str) -> float:
        without = {one: np.array([np.inf]) for one in limits if one != name}
        limited = alone.limits._replace(**without)
        return float(replace(alone, limits=limited).loads(position)[0])

    return max(limits, key=load)


def _element(network: Network, mark: int) -> tuple[Any, int]:
    """Return the field of the element that a mark belongs to, and its number there."""
    body = network.owner(mark).name
    field = next(one for one in network.elements_of(body) if mark in one.limits.marks)
    return field, int(np.flatnonzero(field.limits.marks == mark)[0])


def _cause(network: Network, marks: Indices, limit: str) -> str:
    """Return why elements of one body broke, with the number and place of the first."""
    first = int(marks[0])
    body, (field, item) = network.owner(first).name, _element(network, first)
    corners = network.position[field.nodes[item]]
    centre = ", ".join(show(float(x), LENGTH) for x in corners.mean(axis=0))
    what, of = _EXCEEDED[limit]
    place = f"element {network.springs.ids[first]} of {body} around ({centre})"
    if len(marks) == 1:
        return f"the {what} of {place} exceeded the {of}"
    return f"the {what} of {counted(len(marks), 'element')} exceeded the {of}, first {place}"


Log = Sequence[tuple[float, LoggedEvent]]

#: Kinds of events that take springs away, and how they do before and after the time.
_TEARING = {
    "cut": ("torn", " by:"),
    "rupture": ("ruptured", ", as"),
    "crush": ("crushed", ", as"),
}


def leaking(enclosure: "KeptVolumes", cells: int, state: State, log: Log) -> str:
    """Describe the leak of an enclosure, with the event that tore it.

    Args:
        enclosure: As it was before.
        cells: Number of torn cells.
        state: The present state.
        log: What has happened until now, with times [s].
    """
    torn = torn_by(enclosure.lost_walls(state.alive), state.time, log)
    if enclosure.item_count == 1:
        return f"the surface of {enclosure.name} is torn and no longer holds pressure{torn}"
    if enclosure.block.kind == "fluid":
        which = "1 cavity" if cells == 1 else f"{cells} cavities"
        return f"{which} of {enclosure.name} {'leaks' if cells == 1 else 'leak'}{torn}"
    verb, holds = ("is", "holds") if cells == 1 else ("are", "hold")
    which = counted(cells, "cell")
    return f"{which} of {enclosure.name} {verb} torn and no longer {holds} pressure{torn}"


def torn_by(springs: Indices, time: float, log: Log) -> str:
    """Name the last event that removed any of the springs: "; torn by: cut … (scene.tis:7)".

    It includes the time of the event unless that is the present one. It is empty if no event
    in the log removed one of them.

    Args:
        springs: Indices, shape (n,).
        time: The present time [s].
        log: What has happened until now, with times [s].
    """
    for when, event in reversed(log):
        if event.kind in _TEARING and np.isin(springs, list(event.springs)).any():
            at = "" if when == time else f" at {show(when, TIME, digits=6)}"
            verb, joint = _TEARING[event.kind]
            return f"; {verb}{at}{joint} {event.cause} ({event.span.place})"
    return ""
