"""Forces that act from outside: what a ``force`` block names, loads, jets and planes.

``FORCES`` registers the kinds that a ``force`` block can name.
"""

from abc import abstractmethod
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.registry import Family
from tissuec.core.units import Dimension
from tissuec.forces.effects import AbstractStruct
from tissuec.forces.fields import Field
from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:
    from tissuec.forces.surfaces.triangles import SkinTriangles


class Acted(Struct, frozen=True, eq=False):
    """The nodes that a force acts on, as they are drawn.

    Attributes:
        nodes: Ascending, shape (n,).
        position: [m], shape (n, 3).
        mass: [kg], shape (n,).
        area: Area of skin that each represents [m²], shape (n,); zero inside of a body.
        skin: Triangles of the skin of the whole network, shape (triangle, 3).
        ends: Nodes of each spring of the network, shape (spring, 2).
        skin_elements: The element of each triangle of the skin, an entity, or -1, shape
            (triangle,); None where no element may break.
    """

    nodes: Indices
    position: Floats
    mass: Floats
    area: Floats
    skin: NDArray[np.integer]
    ends: NDArray[np.integer]
    skin_elements: Indices | None = None

    def drawn(self, nodes: Indices) -> Floats:
        """Return where some of these nodes are drawn [m], shape (…, 3).

        Args:
            nodes: Their indices, shape (…).
        """
        return self.position[np.searchsorted(self.nodes, nodes)]

    @property
    def triangles(self) -> "SkinTriangles":
        """Return the triangles of the skin all of whose corners are among the nodes.

        Raises:
            ValueError: There is none.
        """
        from tissuec.forces.surfaces.triangles import (  # where a force needs them
            Areas,
            SkinTriangles,
        )

        rows = np.flatnonzero(np.isin(self.skin, self.nodes).all(axis=1))
        if not len(rows):
            raise ValueError(
                "it acts on the triangles of surfaces, but these nodes are the corners of none"
            )
        corners = self.skin[rows].astype(np.int64)
        drawn = Areas.at(np.searchsorted(self.nodes, corners), self.position).area
        elements = None if self.skin_elements is None else self.skin_elements[rows]
        return SkinTriangles(corners, rows, drawn, self.ends, elements)


class ForceOutput(Struct, frozen=True, eq=False):
    """Numbers of a force at nodes or triangles, which a scene can record in trajectories.

    Attributes:
        name: As in ``trajectory with NAME``.
        at: What has a number.
        dimension: Of the numbers.
        text: What they are, such as "tension of each triangle of a film".
        numbers: Takes a field of the force, times [s] of shape (…), and positions [m] of shape
            (…, node, 3). It returns the nodes, or the rows of the skin, shape (n,), and their
            numbers in the SI unit, shape (…, n). Several forces at the same place add up.
        signed: Whether numbers below 0 have a meaning of their own; colours then part at 0.
        remark: Further sentences for the reference.
    """

    name: str
    at: Literal["node", "triangle"]
    dimension: Dimension
    text: str
    numbers: Callable[[Any, Floats | float, Floats], tuple[Indices, Floats]]
    signed: bool = False
    remark: str = ""


class Force(Struct, metaclass=AbstractStruct, frozen=True, eq=False):
    """Base of the members of ``FORCES``; their fields are entries in the language.

    Attributes:
        outputs: What trajectories can contain of it.
    """

    outputs: ClassVar[tuple[ForceOutput, ...]] = ()

    @abstractmethod
    def on(self, acted: Acted) -> Field:
        """Return the field on some nodes.

        Raises:
            ValueError: It cannot act on them, and why, as the end of a sentence about it.
        """


FORCES: Family[type[Force]] = Family("tissuec.forces.acting", "force")
