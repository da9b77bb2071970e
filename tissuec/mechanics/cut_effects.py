"""Effects on surfaces and in elements of solids that blades have divided, and their ties."""

from typing import TYPE_CHECKING

from tissuec.core.structs import replace
from tissuec.mechanics.cut_surfaces import part_triangles
from tissuec.mechanics.tying import TiedSections
from tissuec.model.blocks import FieldBlock
from tissuec.model.cut_cells import PartTriangles
from tissuec.model.network import FRICTION

if TYPE_CHECKING:
    from tissuec.mechanics.state import State

_ON_SURFACES = ("pressure", "contact", "fluid", "jet")


def on_parts(state: "State", blocks: tuple[FieldBlock, ...]) -> tuple[FieldBlock, ...]:
    """Return what acts on the drawn net, also on what cuts have made of its solids.

    Bristles of friction on parts begin anew. Fluids need to know what is tied.
    """
    surfaces = any(block.kind in _ON_SURFACES for block in blocks)
    parts = part_triangles(state) if surfaces else None
    return tuple(_on_parts(state, block, parts) for block in blocks)


def _on_parts(state: "State", block: FieldBlock, parts: PartTriangles | None) -> FieldBlock:
    assert state.cut_cells is not None
    field, network = block.field, state.network
    if block.kind == "activation":
        return replace(block, field=field.with_parts(state.cut_elements, state.cut_cells))
    if block.kind == "pressure":
        assert network.skin_elements is not None, "solids that are cut have them"
        made = field.with_parts(parts, state.alive, network.skin_elements)
        return replace(block, field=made)
    if block.kind == "fluid":
        from tissuec.mechanics.cut_cavities import cavities_on_parts  # where there are any

        assert parts is not None
        return replace(block, field=cavities_on_parts(state, field, parts))
    if block.kind == "jet":
        from tissuec.mechanics.cut_jets import jet_on_parts  # where there are any

        assert parts is not None
        return replace(block, field=jet_on_parts(state, field, parts))
    if block.kind == "contact":
        from tissuec.mechanics.cut_contact import contact_on_parts  # where something touches

        assert parts is not None
        rows = network.remembering(FRICTION)[len(network.contact.memory) :]
        state.velocity[rows] = 0.0
        return replace(block, field=contact_on_parts(state, parts))
    return block


def put_ties(state: "State", name: str, tied: TiedSections) -> None:
    """Let a body have these ties and no others; the state is changed in place.

    Fluids fill cuts where nothing is tied.
    """
    if len(tied):
        tied = tied.softened(state, name)
    state.tied = {**state.tied, name: tied}
    if len(tied):
        state.put(tied.field(state.network, name, state.cut_bodies[name]).block)
    else:
        own = [b for b in state.blocks.values() if b.kind == "ties" and b.field.name == name]
        state.remove(*own)
    fluids = [each for each in state.blocks.values() if each.kind == "fluid"]
    state.put(*on_parts(state, tuple(fluids)))
