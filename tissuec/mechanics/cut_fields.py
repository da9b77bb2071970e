"""Fields of parts of elements: what differs between solids and walls."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from tissuec.forces.surfaces.membranes import Membranes
from tissuec.geometry.cut_cells.masses import node_volumes
from tissuec.geometry.cut_cells.parts import CellParts
from tissuec.geometry.cut_cells.quadrature import measures
from tissuec.geometry.cut_cells.sections import CutFacets
from tissuec.geometry.elements import Measures
from tissuec.model.network import Floats, Indices

if TYPE_CHECKING:
    from tissuec.forces.solids.elements import SolidElements
    from tissuec.mechanics.state import State


def measures_of(
    field: "SolidElements | Membranes", parts: CellParts, position: Floats
) -> Measures:
    """Return gradients and volumes at the points of parts, those of walls without stress.

    Args:
        field: The elements of the drawn body.
        parts: Of some of them, none whole.
        position: Of all nodes as drawn [m], shape (node, 3).
    """
    if isinstance(field, Membranes):
        volume = field.weight[parts.cell] * parts.fractions
        return Measures(field.gradients[parts.cell][:, None], volume[:, None])
    return measures(parts, position[parts.drawn])


def volumes_at_nodes(
    field: "SolidElements | Membranes", parts: CellParts, measured: Measures, position: Floats
) -> Floats:
    """Return the volumes that the nodes of parts stand for [m³], shape (part, node).

    Args:
        field, parts, position: As of ``measures_of``.
        measured: Of the parts.
    """
    if isinstance(field, Membranes):
        return np.repeat(measured.volume / 3.0, 3, axis=1)
    stiff = field.only(parts.cell)
    return node_volumes(
        parts, position[parts.drawn], measured, stiff.bulk_modulus / stiff.shear
    )


def field_of(
    field: "SolidElements | Membranes", parts: CellParts, measured: Measures, entities: Indices
) -> "SolidElements | Membranes":
    """Return parts as elements.

    Args:
        field, parts: As of ``measures_of``.
        measured: Of the parts.
        entities: Their numbers, shape (part,).
    """
    if isinstance(field, Membranes):
        from tissuec.forces.surfaces.cut_membranes import CutMembranes

        return CutMembranes.parts_of(field, parts.cell, parts.nodes, parts.fractions, entities)
    from tissuec.forces.solids.cut_elements import parts_of

    return parts_of(field, parts.cell, parts.nodes, measured, entities)


def facet_areas(
    fields: "Sequence[SolidElements | Membranes]",
    groups: Sequence[CellParts],
    found: CutFacets,
    position: Floats,
) -> Floats:
    """Return the areas of facets of a cut, through walls with their thickness [m²], (facet,).

    Args:
        fields: The elements of the drawn body, shape by shape.
        groups: Their parts, in the numbers of which the facets are.
        position: Of the nodes of the parts as drawn [m], shape (node, 3).
    """
    sizes = found.sizes(groups, position)
    if isinstance(wall := fields[0], Membranes):
        return sizes * wall.thickness[groups[0].cell[found.parts[:, 0]]]
    return sizes


def put_bending(state: "State", name: str, parts: CellParts, entities: Indices) -> None:
    """Let a wall resist bending beside cuts as it does elsewhere; the state is changed.

    Args:
        name: Of the wall.
        parts: Its triangles and parts that exist.
        entities: Their numbers, shape (part,).
    """
    drawn = (each for each in state.network.of_kind("plates") if each.name == name)
    if (plates := next(drawn, None)) is None:
        return
    from tissuec.forces.surfaces.cut_plates import plates_beside_cuts

    (wall,) = state.network.elements_of(name)
    lost = plates.lost_items(state.alive)
    block = plates_beside_cuts(plates, wall, parts, entities, lost)
    if block is not None:
        state.put(block)
