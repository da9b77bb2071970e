"""Mesh generators: a member is one file with a dataclass of parameters and its ``build``."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from tissuec.core.registry import Family
from tissuec.network import Grid


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """Drawn topology, before any tissue: where nodes are and which springs join them.

    Attributes:
        position: Node positions [m], shape (node, 3).
        ends: Node pair of each spring, shape (spring, 2), lower index first.
        skin: Closed or open surface as triangles, for viewers, shape (triangle, 3); may be
            empty.
        grid: How the nodes stand in rows and columns, if they do; smooth surfaces follow it.
    """

    position: NDArray[np.float64]
    ends: NDArray[np.int32]
    skin: NDArray[np.int32]
    grid: Grid | None = None


class Generator(Protocol):
    """What a member of ``MESHES`` can do; its fields are its entries in the language."""

    def build(self) -> Mesh: ...

    def size(self) -> tuple[int, int]:
        """Return upper bounds of (nodes, springs) without building, to refuse absurd counts."""
        ...


MESHES: Family[type[Generator]] = Family("tissuec.meshes", "mesh")
