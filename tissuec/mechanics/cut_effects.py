"""Effects on surfaces and in elements of solids that blades have divided."""

from typing import TYPE_CHECKING

from tissuec.core.structs import replace
from tissuec.mechanics.cut_surfaces import part_triangles
from tissuec.model.blocks import FieldBlock
from tissuec.model.network import FRICTION

if TYPE_CHECKING:
    from tissuec.mechanics.state import State


def on_parts(state: "State", block: FieldBlock) -> FieldBlock:
    """Return what acts on the drawn net, also on what cuts have made of its solids.

    Bristles of friction on parts begin anew.
    """
    assert state.cut_cells is not None
    field, network = block.field, state.network
    if block.kind == "activation":
        return replace(block, field=field.with_parts(state.cut_elements, state.cut_cells))
    if block.kind == "pressure":
        assert network.skin_elements is not None, "solids that are cut have them"
        parts = part_triangles(state)
        made = field.with_parts(parts, state.alive, network.skin_elements)
        return replace(block, field=made)
    if block.kind == "contact":
        from tissuec.mechanics.cut_contact import contact_on_parts  # where something touches

        rows = network.remembering(FRICTION)[len(network.contact.memory) :]
        state.velocity[rows] = 0.0
        return replace(block, field=contact_on_parts(state, part_triangles(state)))
    return block
