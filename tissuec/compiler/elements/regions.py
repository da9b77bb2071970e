"""Which region each element of a body belongs to.

An element belongs to the region that its centre lies in; so a plane between two layers of cells
divides them there, whether or not nodes in it belong to a region. An element is in the part of
a file that names it; of other groups, and of the surface, it is a part if all of its nodes are.
The nodes of a region are those of its elements.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tissuec.compiler.selections import (
    Mask,
    PointScope,
    extents,
    group_masks,
    refuse_overlap,
    surface_mask,
    warn_of_idle_alternatives,
)
from tissuec.core.arrays import largest_side
from tissuec.core.names import key_of
from tissuec.lang import syntax as s
from tissuec.meshes.generators import ElementMesh, Mesh
from tissuec.model.network import Floats, Indices
from tissuec.scene.model import Body
from tissuec.scene.reading.expressions import Scope


def regions_of_elements(
    body: Body, mesh: Mesh, scope: Scope
) -> tuple[Indices, Indices, dict[str, Mask]]:
    """Return the regions of elements and nodes, or reject regions that overlap or are empty.

    Args:
        body: Its regions.
        mesh: With elements, which are numbered shape by shape.

    Returns:
        The number of the region of each element from 1, 0 without one, shape (element,); that
        of each node, shape (node,): where elements of several meet, the one whose condition
        holds there; and the nodes of each region by the key of its name, shape (node,) each.
    """
    if not body.regions:
        count = sum(len(one.nodes) for one in mesh.elements)
        return np.zeros(count, dtype=np.int64), np.zeros(len(mesh.position), dtype=np.int64), {}
    conditions = [region.where for region in body.regions]
    centres = [_centres(mesh, one, scope) for one in mesh.elements]
    inside_of = np.concatenate([chosen(one, conditions) for one in centres], axis=1)
    _check(body, mesh, inside_of, scope)
    for region in body.regions:
        warn_of_idle_alternatives(
            region.where, centres, missing=f"no centre of an element of {body.name} has",
            of=f"the region {region.name}",
        )  # fmt: skip
    number = np.zeros(inside_of.shape[1], dtype=np.int64)
    for row, inside in enumerate(inside_of, start=1):
        number[inside] = row
    there = np.zeros((len(body.regions) + 1, len(mesh.position)), dtype=bool)
    for own, one in zip(by_shape(number, mesh), mesh.elements, strict=True):
        there[own[:, None], one.nodes] = True
    holds = chosen(_points(mesh, mesh.position, scope), conditions)
    alone = there.sum(axis=0) == 1
    of_node = np.zeros(len(mesh.position), dtype=np.int64)
    for row in range(len(body.regions), 0, -1):
        of_node[there[row] & (alone | holds[row - 1])] = row
    names = [key_of(region.name) for region in body.regions]
    return number, of_node, dict(zip(names, there[1:], strict=True))


def by_shape(of_elements: NDArray[Any], mesh: Mesh) -> list[NDArray[Any]]:
    """Return what is known of each element shape by shape, shape (element,) each.

    Args:
        of_elements: In any unit, shape (element,).
    """
    return np.split(of_elements, np.cumsum([len(one.nodes) for one in mesh.elements])[:-1])


def _check(body: Body, mesh: Mesh, inside_of: Mask, scope: Scope) -> None:
    """Reject regions without elements, and those that have some in common.

    Args:
        inside_of: Which elements each region selects, shape (region, element).
    """
    for number, (region, inside) in enumerate(zip(body.regions, inside_of, strict=True)):
        if not inside.any():
            holds = _points(mesh, mesh.position, scope).select(region.where)
            what, hint = "contains no node", extents(mesh.position)
            if holds.any():
                what = "contains the centre of no element"
                hint = "change its limits, or use smaller cells"
            message = f'the region "{region.name}" {what}'
            scope.findings.reject("TIS302", message, region.span, hint=hint)
        refuse_overlap(body.regions, [*inside_of[: number + 1]], "element", scope.findings)


def chosen(points: PointScope, conditions: Sequence[s.Expression]) -> Mask:
    """Return which points meet each condition, shape (condition, point)."""
    none = np.zeros((0, len(points.position)), dtype=bool)
    return np.array([points.select(one) for one in conditions]) if conditions else none


def _points(mesh: Mesh, places: Floats, scope: Scope) -> PointScope:
    """Return nodes at places [m], shape (node, 3)."""
    size = largest_side(mesh.position)
    return PointScope(
        scope, places, size=size, surface=surface_mask(mesh), groups=group_masks(mesh)
    )


def _centres(mesh: Mesh, one: ElementMesh, scope: Scope) -> PointScope:
    """Return the centres of elements of one shape as points."""
    centres = mesh.position[one.nodes].mean(axis=1)
    return points_within(mesh, one, scope, centres, 1)


def points_within(
    mesh: Mesh, one: ElementMesh, scope: Scope, places: Floats, each: int
) -> PointScope:
    """Return points within elements of one shape.

    Args:
        places: Of as many in each element [m], shape (element each, 3).
        each: How many.
    """

    def whole(mask: Mask) -> Mask:
        return np.repeat(mask[one.nodes].all(axis=1), each)

    surface = surface_mask(mesh)
    groups = {name: whole(mask) for name, mask in group_masks(mesh).items()}
    for name, members in mesh.element_groups.items():
        groups[name] = np.repeat(by_shape(members, mesh)[mesh.elements.index(one)], each)
    return PointScope(
        scope,
        places,
        size=largest_side(mesh.position),
        surface=None if surface is None else whole(surface),
        groups=groups,
    )
