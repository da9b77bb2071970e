"""Jets on solids and walls that blades have divided: they hit parts, and faces of cuts."""

from typing import TYPE_CHECKING

import numpy as np

from tissuec.core.structs import replace
from tissuec.forces.acting.jets import Jet
from tissuec.model.cut_cells import PartTriangles

if TYPE_CHECKING:
    from tissuec.mechanics.state import State


def jet_on_parts(state: "State", jet: Jet, parts: PartTriangles) -> Jet:
    """Return a jet on parts of triangles, and on faces of cuts.

    Faces of cuts in elements all of whose nodes are pushed are pushed, too.

    Args:
        parts: Triangles that bound the parts of solids and walls.
    """
    network, cells, skin = state.network, state.cut_cells, jet.skin.torn(state.alive)
    assert cells is not None
    parts = parts.chosen((parts.skin >= 0) | (parts.cuts != 0))
    is_pushed = np.zeros(network.entity_count, dtype=bool)
    for each in network.elements:
        is_pushed[each.walls] = np.isin(each.nodes, skin.nodes).all(axis=1)
    drawn, pushed = state.drawn[parts.corners], is_pushed[cells.wholes_of(parts.parts)]
    return replace(jet, skin=skin.with_parts(parts, drawn, pushed, jet.width))
