"""Parts of triangles of walls that blades have divided.

Each part is a triangle with all nodes of the whole: those of the body on its own side of the
blade, and copies on the other. Strain is the same everywhere in a triangle, so that a part
stores its share of the area times what the whole triangle would.
"""

from typing import ClassVar, Self

import numpy as np

from tissuec.core.structs import replace
from tissuec.forces.surfaces.membranes import Membranes
from tissuec.model.blocks import FieldBlock
from tissuec.model.network import Floats, Indices


class CutMembranes(Membranes, frozen=True):
    """Parts of triangles of one wall. Areas are those of the whole triangles.

    Attributes:
        cell: Number of the drawn triangle that each is a part of, shape (part,).
        fraction: Of its area, dimensionless, shape (part,).
    """

    columns: ClassVar[tuple[str, ...]] = (*Membranes.columns, "cell", "fraction")
    is_cut: ClassVar[bool] = True
    cell: Indices
    fraction: Floats

    @classmethod
    def parts_of(
        cls,
        field: Membranes,
        cell: Indices,
        nodes: Indices,
        fraction: Floats,
        entities: Indices,
    ) -> Self:
        """Return parts of triangles.

        Args:
            field: The triangles of the drawn wall.
            cell: Of each part, its number among these, shape (part,).
            nodes: Of the parts, shape (part, 3).
            fraction: Of the area of the triangle, dimensionless, shape (part,).
            entities: Their numbers, shape (part,).
        """
        own = replace(
            field.only(cell), nodes=nodes, walls=entities, walled=np.arange(len(cell)),
            weight=field.weight[cell] * fraction,
        )  # fmt: skip
        known = {name: getattr(own, name) for name in own.__struct_fields__}
        return cls(**known, cell=cell, fraction=fraction)

    @property
    def volume(self) -> Floats:
        return super().volume * self.fraction

    @property
    def block(self) -> FieldBlock:
        """Return this as a block of a net."""
        return FieldBlock(f"the cut triangles of {self.name}", "membranes", self, self.span)
