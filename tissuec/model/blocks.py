"""What a net consists of beside its nodes and springs, and how large it is."""

from typing import Any, NamedTuple

from msgspec import Struct

from tissuec.core.errors import counted
from tissuec.core.source import Span

#: Kinds of blocks that are no ``force`` blocks, in the order in which their forces are added.
KINDS = (
    "elements",
    "membranes",
    "volume",
    "fluid",
    "pressure",
    "activation",
    "plates",
    "ties",
    "glue",
    "contact",
    "jet",
)
#: Kinds of finite elements that resist deformation: solids and walls.
OF_ELEMENTS = ("elements", "membranes")
#: The kind whose forces follow those of all others, of ``force`` blocks as well.
EMBEDDING = "embedding"


def name_of_force(name: str) -> str:
    """Return the name of the block of a ``force`` block, which is that of no other kind."""
    return f"the force {name}"


class FieldBlock(Struct, frozen=True, eq=False):
    """Elements that act by the positions of their nodes.

    Attributes:
        name: What messages call it; no two blocks of a net have the same.
        kind: One of ``KINDS``, that of a ``force`` block or ``EMBEDDING``.
        field: Nodes and numbers of the elements, with their force: a ``forces.Field``.
        span: The entry or order behind it; None where there are several.
    """

    name: str
    kind: str
    field: Any
    span: Span | None


class NetSize(NamedTuple):
    """Numbers of nodes, springs and finite elements.

    Attributes:
        nodes: None of joints, which join nodes of bodies.
    """

    nodes: int
    springs: int
    elements: int = 0

    def __str__(self) -> str:
        parts = [counted(self.nodes, "node")] if self.nodes else []
        if self.elements:
            parts.append(counted(self.elements, "element"))
        if self.springs or not self.elements:
            parts.append(counted(self.springs, "spring"))
        return ", ".join(parts)

    @property
    def facts(self) -> dict[str, int]:
        """Return the numbers by name; elements only where there are any."""
        found = self._asdict()
        return found if self.elements else {name: found[name] for name in ("nodes", "springs")}
