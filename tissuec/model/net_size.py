"""How large a net is, in words and numbers for readers."""

from typing import NamedTuple

from tissuec.core.errors import counted


class NetSize(NamedTuple):
    """Numbers of nodes, springs and finite elements.

    Attributes:
        nodes: None of joints, which join nodes of bodies.
        springs: Without the edges of elements, which resist nothing.
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
