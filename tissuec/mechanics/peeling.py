"""Glue that comes apart: faces of two bodies that are tied until they are free."""

from typing import TYPE_CHECKING

import numpy as np

from tissuec.model.network import Indices
from tissuec.model.torn import Peeled

if TYPE_CHECKING:
    from tissuec.mechanics.state import State


def peel(state: "State", broken: Indices) -> tuple[Peeled, ...]:
    """Free glued sections that are above their limits; the state is changed in place.

    Args:
        broken: Their numbers, among those of entities, shape (n,).
    """
    found = list[Peeled]()
    for block in [each for each in state.blocks.values() if each.kind == "glue"]:
        glue = block.field.intact(state.alive)
        is_free = np.isin(glue.sections, broken)
        if not is_free.any():
            continue
        lost, free = glue.only(np.flatnonzero(is_free)), np.flatnonzero(is_free)
        energy = float(lost.energy(state.time, state.position))
        elements, area = np.unique(lost.elements), float(lost.areas.sum())
        found.append(Peeled(f"the glue {glue.name}", glue.span, elements, area, energy))
        left = glue.without(free)
        (state.put if left.item_count else state.remove)(left.block)
    return tuple(found)
