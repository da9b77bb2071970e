"""Sentences about elements that break: which limit they exceeded, and where they are."""

from collections.abc import Iterator

import numpy as np

from tissuec.core.errors import counted
from tissuec.core.units import LENGTH, show
from tissuec.model.network import Indices, Network
from tissuec.script.verbs import LoggedEvent

#: By limit: what of an element exceeds it, and what it is called.
_EXCEEDED = {
    "strain": ("strain", "breaking strain"),
    "stress": ("stress", "strength"),
    "toughness": ("energy", "toughness"),
}


def broken_elements(network: Network, marks: Indices, edges: Indices) -> Iterator[LoggedEvent]:
    """Yield an event for all that broke by one entry of a scene.

    Args:
        network: The network.
        marks: Of the elements that break now, shape (n,).
        edges: Springs that are lost with them, shape (m,); they are entered with the first.
    """
    known = network.provenance["strength"]
    for index in np.unique(known.index[marks]).tolist():
        own = marks[known.index[marks] == index]
        springs = (*own.tolist(), *edges.tolist())
        yield LoggedEvent("rupture", springs, _cause(network, own), known[int(own[0])].span)
        edges = edges[:0]


def _cause(network: Network, marks: Indices) -> str:
    """Return why elements of one body broke, with the number and place of the first."""
    first = int(marks[0])
    body = network.owner(first).name
    field = next(one for one in network.elements_of(body) if first in one.limits.marks)
    item = int(np.flatnonzero(field.limits.marks == first)[0])
    corners, limits = network.position[field.nodes[item]], field.limits
    centre = ", ".join(show(float(x), LENGTH) for x in corners.mean(axis=0))
    limit = next(name for name in _EXCEEDED if np.isfinite(getattr(limits, name)[item]))
    what, of = _EXCEEDED[limit]
    place = f"element {network.springs.ids[first]} of {body} around ({centre})"
    if len(marks) == 1:
        return f"the {what} of {place} exceeded the {of}"
    return f"the {what} of {counted(len(marks), 'element')} exceeded the {of}, first {place}"
