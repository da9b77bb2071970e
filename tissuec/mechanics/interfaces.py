"""Interfaces: faces between regions of a solid that are tied, and can come apart.

Before the first event, both regions get nodes of their own at these faces, which are tied by
the same law as the faces of tears (``forces.solids.ties``) with the toughness of the interface.
Nothing is divided. At the rim of the faces, where other elements hold both regions together,
nodes are common to all.
"""

from typing import TYPE_CHECKING

import numpy as np

from tissuec.mechanics.cut_body import CutBody
from tissuec.mechanics.cut_effects import put_ties
from tissuec.mechanics.cutting import carry_out, parted_along
from tissuec.mechanics.tying import TiedSections
from tissuec.model.network import BodyPart, Indices

if TYPE_CHECKING:
    from tissuec.mechanics.state import State


def part_interfaces(state: "State") -> None:
    """Part and tie the interfaces of all bodies as drawn; the state is changed in place.

    At least one body has one.

    Raises:
        NotDivisible: The reserve of a body is exhausted.
    """
    found = [
        _parted(state, body, number)
        for body in state.network.bodies
        for number in range(len(body.interfaces))
    ]
    state.interface_nodes = np.concatenate(found, axis=1)


def _parted(state: "State", body: BodyPart, number: int) -> Indices:
    """Part and tie an interface of a body; return new nodes and their drawn ones, (2, n)."""
    network, name = state.network, body.name
    before, fields = CutBody.of(state, name), network.elements_of(name)
    of_element = body.interfaces[number].sides
    sides = [
        of_element[field.walls[parts.cell] - int(body.elements.start)]
        for field, parts in zip(fields, before.parts, strict=True)
    ]
    division = parted_along(state, name, sides, f"interface {number}")
    carry_out(state, division)
    nowhere = np.full(network.node_count, np.nan)
    found = division.body, division.triangles
    tied = TiedSections.of(network, name, *found, nowhere, number)
    if division.tied is not None:
        tied = division.tied.followed_by(tied, division.body)
    put_ties(state, name, tied)
    return np.stack([division.copies, network.parents[division.copied]])
