"""Sentences about elements that break: which limit they exceeded, and where they are."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from msgspec.structs import replace

from tissuec.core.errors import counted
from tissuec.core.units import LENGTH, show
from tissuec.model.network import Floats, Indices, Network
from tissuec.script.verbs import LoggedEvent

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
