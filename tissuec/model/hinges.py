"""Hinges: edges between two triangles of a wall, and what it takes to fold them."""

from collections.abc import Sequence
from typing import Self

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
_OF_HINGES = ("nodes", "stiffness", "damping", "drawn", "squares")


class Hinges(Struct, frozen=True, eq=False):
    """The hinges of walls that resist bending; see ``tissuec.forces.bending``.

    Attributes:
        nodes: i, j, k and l of each, shape (hinge, 4).
        stiffness: k [N m], shape (hinge,).
        damping: d [N m s], shape (hinge,).
        drawn: θ0 [rad], shape (hinge,).
        squares: a0² and b0² [m⁴], shape (hinge, 2).
        walls: Springs between nodes of one hinge: where one is missing, the hinge gives way.
        walled: The hinge of each of them, shape of ``walls``.
    """

    nodes: Indices
    stiffness: Floats
    damping: Floats
    drawn: Floats
    squares: Floats
    walls: Indices
    walled: Indices

    def lost_items(self, alive: NDArray[np.bool_]) -> Indices:
        """Return the hinges that have lost a spring, ascending.

        Args:
            alive: False for springs that were cut or broke, shape (spring,).
        """
        return np.unique(self.walled[~alive[self.walls]])

    def whole(self, alive: NDArray[np.bool_]) -> "Hinges":
        """Return the hinges that have all their springs.

        Args:
            alive: False for springs that were cut or broke, shape (spring,).
        """
        torn = self.lost_items(alive)
        if not len(torn):
            return self
        stays = np.ones(len(self.nodes), dtype=bool)
        stays[torn] = False
        kept = stays[self.walled]
        walled = (np.cumsum(stays) - 1)[self.walled[kept]]
        whole = self.only(np.flatnonzero(stays))
        return replace(whole, walls=self.walls[kept], walled=walled)

    def only(self, items: Indices) -> Self:
        """Return some hinges, by indices of shape (n,), with the walls of all."""
        return replace(self, **{name: getattr(self, name)[items] for name in _OF_HINGES})

    @classmethod
    def joined(cls, parts: Sequence["Hinges"]) -> "Hinges | None":
        """Return the hinges of several bodies in one numbering; None without any."""
        if not parts:
            return None
        first = np.cumsum([0, *(len(part.nodes) for part in parts)])
        walled = [part.walled + start for part, start in zip(parts, first, strict=False)]
        names = (*_OF_HINGES, "walls")
        arrays = {
            name: np.concatenate([getattr(part, name) for part in parts]) for name in names
        }
        return cls(**arrays, walled=np.concatenate(walled))

    def behind(self, nodes: int, springs: int) -> "Hinges":
        """Return these with the numbers that they have behind other nodes and springs."""
        return replace(self, nodes=self.nodes + nodes, walls=self.walls + springs)
