"""Parts of solid elements that blades have divided.

Each part is an element with all the nodes of the whole, on its own side of the blade those of
the body, on the other copies of them, and with points and weights that integrate over its own
matter (``geometry.cut_cells``). The volume acts on the mean of a part; points of hexahedra and
wedges are not strained by all nodes together (``solids.bent_cell``), which refers to whole
cells.
"""

from typing import ClassVar, Self

import numpy as np

from tissuec.forces.solids.elements import SolidElements
from tissuec.geometry.elements import Measures
from tissuec.model.blocks import FieldBlock
from tissuec.model.network import Indices

#: Factor of the shear modulus, up to which the bulk modulus acts at each point: of shapes that
#: have no such factor, because whole cells of them bend.
LOCAL = {"hexahedron": 0.375, "wedge": 0.375}


class CutElements(SolidElements, frozen=True):
    """Parts of elements of one shape and body.

    Attributes:
        cell: Number of the drawn element that each is a part of, among those of the same shape
            and body, shape (part,).
    """

    columns: ClassVar[tuple[str, ...]] = (*SolidElements.columns, "cell")
    is_cut: ClassVar[bool] = True
    cell: Indices

    @classmethod
    def parts_of(
        cls,
        field: SolidElements,
        cell: Indices,
        nodes: Indices,
        drawn: Measures,
        entities: Indices,
    ) -> Self:
        """Return parts of elements.

        Args:
            field: The elements of the drawn body.
            cell: Of each part, its number among these, shape (part,).
            nodes: Of the parts, shape (part, node).
            drawn: Gradients by drawn places, and volumes of their points.
            entities: Their numbers, shape (part,).
        """
        own, every = field.only(cell), np.arange(len(cell))
        factor = field.shape.local or LOCAL[field.shape.name]
        bulk, local = own.bulk_modulus, np.minimum(factor * own.shear, own.bulk_modulus)
        if own.prestretch is not None:
            turned = own.prestretch.deformation[:, None]
            drawn = Measures(np.ascontiguousarray(drawn.gradients @ turned), drawn.volume)
        return cls(
            walls=entities, walled=every, nodes=nodes, name=own.name, limits=None,
            laws=own.laws, shear=own.shear, viscosity=own.viscosity, law=own.law,
            fibres=own.fibres, branches=own.branches, yielding=own.yielding, recalled=None,
            constants=own.constants, stretches=np.zeros((len(cell), 0)), shape=own.shape,
            drawn=drawn, row=every, bulk=bulk - local, local=local,
            prestretch=own.prestretch, span=own.span, cell=cell,
        )  # fmt: skip

    @property
    def block(self) -> FieldBlock:
        """Return this as a block of a net."""
        name = f"the cut {self.shape.name} elements of {self.name}"
        return FieldBlock(name, "elements", self, self.span)
