"""Nodes and springs by their names in the scene."""

from collections.abc import Sequence

import numpy as np

from tissuec.core import arguments
from tissuec.core.hints import alternatives
from tissuec.core.names import key_of
from tissuec.model.network import Indices, Network, numbers_in
from tissuec.results.recording import NamedGroup

NODES, SPRINGS = "nodes", "springs"


def members(network: Network, groups: Sequence[NamedGroup], name: str, what: str) -> Indices:
    """Return the network numbers of the nodes or springs with a name, ascending, shape (n,).

    Args:
        network: The network.
        groups: Its sets and regions.
        name: Of a set, body or joint, or of a region with its body, such as "scar of liver".
        what: "nodes" or "springs"; springs of a set of nodes are those with both ends in it.

    Raises:
        TypeError: The name is no text.
        ValueError: There is no such name.
    """
    key, of_springs = key_of(arguments.text(name, "a name")), what == SPRINGS
    parts = network.parts if of_springs else network.bodies
    for part in parts:
        if key_of(part.name) == key:
            place = part.springs if of_springs else getattr(part, NODES)
            found = numbers_in(place)
            return found
    known = {full_name(group): group for group in groups if group.what in (NODES, what)}
    for full, group in known.items():
        if key_of(full) == key:
            return group.indices if group.what == what else _within(network, group.indices)
    hint = alternatives(name, [*known, *(part.name for part in parts)], what="there are")
    raise ValueError(f'there are no {what} called "{name}"; {hint}')


def full_name(group: NamedGroup) -> str:
    """Return the name of a set, or that of a region with that of its body."""
    return f"{group.name} of {group.body}" if group.body else group.name


def _within(network: Network, nodes: Indices) -> Indices:
    ends = network.springs.ends[: network.first_mark]
    return np.flatnonzero(np.isin(ends, nodes).all(axis=1))
