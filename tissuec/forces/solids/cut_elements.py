"""Parts of solid elements that blades have divided.

Each part is an element with all the nodes of the whole, on its own side of the blade those of
the body, on the other copies of them, and with points and weights that integrate over its own
matter (``geometry.cut_cells``). The volume acts on the mean of a part, or on four functions in
hexahedra with 27 nodes; points of hexahedra with eight and of wedges are not strained by all
nodes together (``solids.bent_cell``), which refers to whole cells.
"""

from typing import Any, ClassVar

import numpy as np

from tissuec.forces.solids.elements import SolidElements
from tissuec.forces.solids.quadratic import QuadraticHexahedra
from tissuec.geometry.cut_cells.quadrature import linear_functions
from tissuec.geometry.elements import Measures
from tissuec.model.blocks import FieldBlock
from tissuec.model.network import Indices

#: Factor of the shear modulus, up to which the bulk modulus acts at each point: of shapes that
#: have no such factor, because whole cells of them bend.
LOCAL = {"hexahedron": 0.375, "wedge": 0.375}


class _Parts:
    """What parts of elements of all shapes have."""

    is_cut: ClassVar[bool] = True

    @property
    def block(self: Any) -> FieldBlock:
        """Return this as a block of a net."""
        name = f"the cut {self.shape.name} elements of {self.name}"
        return FieldBlock(name, "elements", self, self.span)


class CutElements(_Parts, SolidElements, frozen=True):
    """Parts of elements of one shape and body.

    Attributes:
        cell: Number of the drawn element that each is a part of, among those of the same shape
            and body, shape (part,).
    """

    columns: ClassVar[tuple[str, ...]] = (*SolidElements.columns, "cell")
    cell: Indices


class CutQuadraticHexahedra(_Parts, QuadraticHexahedra, frozen=True):
    """Parts of hexahedra with 27 nodes of one body.

    Attributes:
        cell: As of ``CutElements``.
    """

    columns: ClassVar[tuple[str, ...]] = (*QuadraticHexahedra.columns, "cell")
    cell: Indices


def parts_of(
    field: SolidElements, cell: Indices, nodes: Indices, drawn: Measures, entities: Indices
) -> CutElements | CutQuadraticHexahedra:
    """Return parts of elements.

    Args:
        field: The elements of the drawn body.
        cell: Of each part, its number among these, shape (part,).
        nodes: Of the parts, shape (part, node).
        drawn: Gradients by drawn places, and volumes of their points.
        entities: Their numbers, shape (part,).
    """
    own, every, shape = field.only(cell), np.arange(len(cell)), field.shape
    factor = LOCAL.get(shape.name, shape.local)
    bulk, local = own.bulk_modulus, np.minimum(factor * own.shear, own.bulk_modulus)
    if own.prestretch is not None:
        turned = own.prestretch.deformation[:, None]
        drawn = Measures(np.ascontiguousarray(drawn.gradients @ turned), drawn.volume)
    attributes = {
        "walls": entities, "walled": every, "nodes": nodes, "name": own.name, "limits": None,
        "laws": own.laws, "shear": own.shear, "viscosity": own.viscosity, "law": own.law,
        "fibres": own.fibres, "branches": own.branches, "yielding": own.yielding,
        "recalled": None, "constants": own.constants, "stretches": np.zeros((len(cell), 0)),
        "shape": shape, "drawn": drawn, "row": every, "bulk": bulk - local, "local": local,
        "prestretch": own.prestretch, "span": own.span, "cell": cell,
    }  # fmt: skip
    if shape.functions == 1:
        return CutElements(**attributes)
    linear = linear_functions(shape.name)
    linear = np.broadcast_to(linear, (len(cell), *linear.shape))
    return CutQuadraticHexahedra(**attributes, linear=linear)
