"""The elements of a body after cuts."""

from typing import TYPE_CHECKING

from msgspec import Struct

from tissuec.core.structs import replace
from tissuec.geometry.cut_cells.parts import CellParts
from tissuec.model.network import Indices

if TYPE_CHECKING:
    from tissuec.mechanics.state import State


class CutBody(Struct, frozen=True, eq=False):
    """The elements of a body after cuts, shape by shape.

    Attributes:
        parts: Whole elements and parts.
        entities: Of each of them, shape (part,) each.
        slots: Where each keeps its tensors, see ``StoredTensors``, shape (tensor, part) each.
        cuts: Names of the cuts by which levels divide, one for each level.
        used: How many entities of the reserve have been used.
        stored: How many components of internal variables of the reserve have been used.
    """

    parts: tuple[CellParts, ...]
    entities: tuple[Indices, ...]
    slots: tuple[Indices, ...]
    cuts: tuple[str, ...] = ()
    used: int = 0
    stored: int = 0

    def with_level(self, by: str) -> "CutBody":
        """Return the same with a level of the cut of that name."""
        return replace(self, cuts=(*self.cuts, by))

    @classmethod
    def of(cls, state: "State", name: str) -> "CutBody":
        """Return the elements of a body that exist."""
        known = state.cut_bodies.get(name)
        if known is None:
            fields = state.network.elements_of(name)
            whole = [CellParts.whole(one.cell_shape, one.nodes) for one in fields]
            slots = tuple(one.slots for one in fields)
            known = cls(tuple(whole), tuple(one.walls for one in fields), slots)
        alive = [state.alive[each] for each in known.entities]
        if all(each.all() for each in alive):
            return known
        return replace(
            known,
            parts=tuple(
                each.some(there) for each, there in zip(known.parts, alive, strict=True)
            ),
            entities=tuple(
                each[there] for each, there in zip(known.entities, alive, strict=True)
            ),
            slots=tuple(each[:, there] for each, there in zip(known.slots, alive, strict=True)),
        )
