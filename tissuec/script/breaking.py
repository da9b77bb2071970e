"""What breaks by itself: springs and elements that are lost, solids that tear, and glue."""

from typing import NamedTuple

import numpy as np

from tissuec.mechanics.state import State
from tissuec.model.network import Indices
from tissuec.model.torn import Peeled, Torn
from tissuec.script.verbs import stopping


class Broken(NamedTuple):
    """What has broken at one time.

    Attributes:
        entities: Springs and elements that have parted, ascending, shape (n,).
        edges: Edges that are lost with them, ascending, shape (m,).
        torn: What tore by faces, by names of bodies.
        peeled: Glue that became free; its elements are among the entities.
    """

    entities: Indices
    edges: Indices
    torn: dict[str, Torn]
    peeled: tuple[Peeled, ...]


def break_apart(state: State, broken: Indices) -> Broken:
    """Let springs break, elements be lost, solids tear, and glue come off, in place.

    Args:
        broken: Entities and glued sections above their limits, shape (n,).

    Raises:
        ActionFailed: The reserve of a body is exhausted.
    """
    torn, peeled = dict[str, Torn](), tuple[Peeled, ...]()
    is_glue = broken >= state.network.entity_count
    if is_glue.any():
        from tissuec.mechanics.peeling import peel  # where there is any

        peeled, broken = peel(state, broken[is_glue]), broken[~is_glue]
    for body in (one for one in state.network.bodies if one.reserve.nodes):
        own = (broken >= int(body.elements.start)) & (broken < int(body.elements.stop))
        if own.any():
            torn[body.name] = _torn(state, body.name, broken[own])
            broken = broken[~own]
    edges = [broken[:0], *(each.edges for each in torn.values())]
    if len(broken):
        edges.append(state.break_entities(broken))
    parted = [broken, *(each.every_element for each in torn.values())]
    parted += [each.elements for each in peeled]
    found = np.unique(np.concatenate(parted)), np.unique(np.concatenate(edges))
    return Broken(*found, torn, peeled)


def _torn(state: State, name: str, broken: Indices) -> Torn:
    """Let a body tear; see ``mechanics.tearing.tear``."""
    from tissuec.mechanics.tearing import tear  # where there are solids

    with stopping(state.network.elements_of(name)[0].span):
        return tear(state, name, broken)
