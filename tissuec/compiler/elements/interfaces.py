"""Interfaces between regions of a solid: which faces of elements can come apart."""

import numpy as np

from tissuec.compiler.bodies.drawn import Drawing, numbered
from tissuec.compiler.elements.regions import by_shape
from tissuec.core.hints import leaving_out
from tissuec.geometry.cut_cells.cutting import parted
from tissuec.geometry.cut_cells.parts import CellParts, Sides
from tissuec.model.interfaces import NO_PARTING, Interface, Parting
from tissuec.scene.model import RegionInterface
from tissuec.scene.reading.findings import Findings


def interfaces_of(
    drawing: Drawing, findings: Findings
) -> tuple[tuple[Interface, ...], Parting]:
    """Return the interfaces of a body, and what parting them takes.

    Those of regions without common faces are rejected.
    """
    if not drawing.body.interfaces:
        return (), NO_PARTING
    found, mesh = list[Interface](), drawing.mesh
    groups = [CellParts.whole(one.shape, one.nodes) for one in mesh.elements]
    parent, elements = np.arange(len(mesh.position)), 0
    for said in drawing.body.interfaces:
        sides = _sides(drawing, said, findings)
        made = parted(groups, by_shape(sides, mesh), len(parent))
        if not len(made.cut):
            findings.reject(
                "TIS309",
                f"the regions of the interface {said.name} have no face of elements in common",
                said.span,
                hint=leaving_out("name two regions that adjoin, or remove it", said.span),
            )
        # Faces of one element in front are free together: as few as possible.
        if len(np.unique(made.cut.parts[:, 0])) < len(np.unique(made.cut.parts[:, 1])):
            sides = -sides
            made = parted(groups, by_shape(sides, mesh), len(parent))
        found.append(Interface(said.name, sides, said.toughness, said.span))
        parent = np.append(parent, parent[made.copied])
        elements += sum(int(near.sum()) for near in made.near)
        groups = made.groups
    copies = int(np.bincount(parent).max(initial=1)) - 1
    return tuple(found), Parting(copies, elements)


def _sides(drawing: Drawing, said: RegionInterface, findings: Findings) -> Sides:
    """Return 1 for elements of the first region, and -1 for those of the second, (element,)."""
    number = drawing.element_part
    assert number is not None
    first, second = numbered(drawing, said.sides, findings)
    return (number == first).astype(np.int8) - (number == second).astype(np.int8)
