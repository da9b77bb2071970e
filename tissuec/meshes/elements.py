"""Meshes of finite elements: solids, and walls as triangles.

Nodes are those of the cells, and in the middle of each edge of tetrahedra one more. Node
pairs are the edges of elements, and the skin consists of the faces that one element alone has.
"""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from tissuec.core.arrays import cross, norm
from tissuec.core.errors import counted
from tissuec.core.structs import replace
from tissuec.geometry.divisions import volumes
from tissuec.geometry.edges import Floats, Indices
from tissuec.geometry.elements import GRID, MIDDLES, SHAPES, TRIQUADRATIC, ElementShape
from tissuec.meshes.between import BetweenNodes
from tissuec.meshes.formats import FormatError
from tissuec.meshes.generators import ElementMesh, Mesh
from tissuec.meshes.generators.joining import springs
from tissuec.meshes.slivers import poor_ones
from tissuec.model.topology import lower_and_upper

BRICKS = ("hexahedron", "wedge")  # whose nodes are the corners of their cells
_I, _J, _K = GRID.T
#: Orders of nodes that turn elements inside out; of tetrahedra, of their corners.
MIRRORED = {
    "hexahedron": [4, 5, 6, 7, 0, 1, 2, 3],
    "quadratic hexahedron": TRIQUADRATIC[_I, _J, 2 - _K].tolist(),
    "wedge": [3, 4, 5, 0, 1, 2],
    "tetrahedron": [1, 0, 2, 3],
}
_MOST_OF_FACE = 9  # nodes
_FLAT = 1e-9  # of the cube of its longest side: an element of less volume has none


def mesh_of_cells(
    position: Floats,
    bricks: Mapping[str, Indices],
    tetrahedra: Indices,
    groups: Mapping[str, Indices],
    divided: Indices | None = None,
    between: BetweenNodes | None = None,
) -> Mesh:
    """Return the mesh whose elements are given cells.

    Nodes without a cell are left out.

    Args:
        position: Of the corners [m], shape (node, 3).
        bricks: Corners of hexahedra and wedges in the order of VTK, or in its mirror image,
            shape (cell, corner), by the names of their shapes.
        tetrahedra: Corners of tetrahedra, which share no corner with other cells, in any
            order, shape (tetrahedron, 4).
        groups: Corners by the name of their group; the node in the middle of an edge joins the
            groups that have both ends.
        divided: Corners of tetrahedra that divide all cells, shape (tetrahedron, 4).
        between: Nodes of curved cells that are no corners [m]; all others lie halfway.

    Raises:
        FormatError: An element is flat or folded, or more than two share a face.
    """
    cells = {**bricks, "tetrahedron": tetrahedra}
    cells = {name: nodes for name, nodes in cells.items() if len(nodes)}
    used = np.unique(np.concatenate([nodes.ravel() for nodes in cells.values()]))
    number = np.full(len(position), -1)
    number[used] = np.arange(len(used))
    position = position[used]
    between = BetweenNodes.none() if between is None else between.renumbered(number)
    groups = {name: number[nodes][number[nodes] >= 0] for name, nodes in groups.items()}
    elements = [
        ElementMesh(name, _turned(name, position, number[nodes]))
        for name, nodes in cells.items()
    ]
    remarks: Iterator[str] = iter(())
    if "tetrahedron" in cells:
        *others, last = elements
        remarks = poor_ones(position, last.nodes)
        position, nodes, groups = _with_middles(position, last.nodes, groups, between)
        elements = [*others, replace(last, nodes=nodes)]
    mesh = mesh_of_elements(position, elements, groups)
    mesh = replace(mesh, remarks=tuple(remarks), between=between)
    return mesh if divided is None else replace(mesh, tetrahedra=number[divided])


def are_folded(cells: Mapping[str, Indices]) -> bool:
    """Return whether a cell has two corners in one node, shapes (cell, corner)."""
    ascending = [np.sort(nodes, axis=1) for nodes in cells.values()]
    return any(bool((nodes[:, 1:] == nodes[:, :-1]).any()) for nodes in ascending)


def _turned(name: str, position: Floats, nodes: Indices) -> Indices:
    """Return cells of one shape in the order that has a positive volume."""
    if name == "tetrahedron":
        content = volumes(position, nodes)
    else:
        content = SHAPES[name].volumes(position[nodes])
    return np.where((content < 0.0)[:, None], nodes[:, MIRRORED[name]], nodes)


def _with_middles(
    position: Floats, corners: Indices, groups: Mapping[str, Indices], between: BetweenNodes
) -> tuple[Floats, Indices, Mapping[str, Indices]]:
    """Return positions, tetrahedra with ten nodes, and groups with nodes in middles of edges.

    These nodes follow all others, in the order of the ends of their edges.
    """
    count = len(position)
    low, high = lower_and_upper(corners[:, MIDDLES].reshape(-1, 2))
    keys, edge = np.unique(low * count + high, return_inverse=True)
    ends = np.stack(np.divmod(keys, count), axis=1)
    found: dict[str, Indices] = {}
    for name, nodes in groups.items():
        inside = np.zeros(count, dtype=bool)
        inside[nodes] = True
        middles = count + np.flatnonzero(inside[ends].all(axis=1))
        found[name] = np.concatenate([nodes, middles])
    middle = count + edge.reshape(-1, len(MIDDLES))
    halfway = between.places(ends, position[ends].mean(axis=1))
    every = np.concatenate([position, halfway])
    return every, np.concatenate([corners, middle], axis=1), found


def mesh_of_elements(
    position: Floats, elements: Sequence[ElementMesh], groups: Mapping[str, Indices]
) -> Mesh:
    """Return the mesh of elements in the order of their shapes.

    Args:
        position: Of the nodes [m], shape (node, 3).
        elements: Shape by shape.
        groups: Nodes by the name of their group.

    Raises:
        FormatError: An element is flat or folded, or more than two share a face.
    """
    pairs, volume = [np.zeros((0, 2), dtype=np.int64)], np.zeros(len(position))
    for one in elements:
        shape = SHAPES[one.shape]
        of_points = shape.point_volumes(position[one.nodes])
        _refuse_flat(one, position, of_points)
        _add_shares(volume, one, of_points @ shape.lumped)
        pairs.append(one.nodes[:, shape.edges].reshape(-1, 2))
    return Mesh(
        position,
        springs(len(position), *pairs),
        _skin(elements).astype(np.int32),
        groups=groups,
        volume=volume,
        elements=tuple(elements),
    )


def volumes_of_nodes(position: Floats, elements: Sequence[ElementMesh]) -> Floats:
    """Return the share of each node in the volume of elements [m³], shape (node,).

    Args:
        position: Of all nodes [m], shape (node, 3).
    """
    found = np.zeros(len(position))
    for one in elements:
        _add_shares(found, one, node_shares(SHAPES[one.shape], position[one.nodes]))
    return found


def _add_shares(to: Floats, elements: ElementMesh, share: Floats) -> None:
    """Add what each node has of each element, shape (element, node), to a sum for each node."""
    to += np.bincount(elements.nodes.ravel(), share.ravel(), len(to))


def node_shares(shape: ElementShape, corners: Floats) -> Floats:
    """Return the volume that each node has of each element [m³], shape (element, node).

    Args:
        corners: Positions of their nodes [m], shape (element, node, 3).
    """
    return shape.point_volumes(corners) @ shape.lumped


def _refuse_flat(elements: ElementMesh, position: Floats, volume: Floats) -> None:
    """Reject elements of one shape that are flat or folded at one of their points.

    Args:
        position: Nodes [m], shape (node, 3).
        volume: Of their points [m³], shape (element, point).
    """
    corners = position[elements.nodes]
    longest = np.ptp(corners, axis=1).max(axis=1)
    wrong = volume.min(axis=1) * volume.shape[1] <= _FLAT * longest**3
    if not wrong.any():
        return
    from tissuec.meshes.repair import place

    many, first = int(wrong.sum()), int(np.argmax(wrong))
    least, most = volume[first].min(), volume[first].max()
    what = "flat" if most <= _FLAT * longest[first] ** 3 or least >= 0.0 else "folded"
    raise FormatError(
        f"{counted(many, f'{what} {elements.shape}')}, the first of them {elements.shape} "
        f"{first + 1} around {place(corners[first].mean(axis=0))}",
        "repair it in the program that made the mesh, or remove it there",
    )


def _skin(elements: Sequence[ElementMesh]) -> Indices:
    """Return the triangles of faces that one element alone has, facing outwards.

    Shape (triangle, 3). Raises FormatError where more than two elements share a face.
    """
    keys: list[Indices] = []
    triangles: list[Indices] = []
    owner: list[Indices] = []  # of each triangle, the place of its face among the keys
    first = 0
    for one in elements:
        shape = SHAPES[one.shape]
        count = int(shape.faces.max()) + 1
        corners = [np.unique(shape.triangles[shape.faces == face]) for face in range(count)]
        for face in corners:
            key = np.full((len(one.nodes), _MOST_OF_FACE), -1)
            key[:, : len(face)] = np.sort(one.nodes[:, face], axis=1)
            keys.append(key)
        triangles.append(one.nodes[:, shape.triangles].reshape(-1, 3))
        place = first + shape.faces * len(one.nodes) + np.arange(len(one.nodes))[:, None]
        owner.append(place.ravel())
        first += count * len(one.nodes)
    _, face, shared = np.unique(
        np.concatenate(keys), axis=0, return_inverse=True, return_counts=True
    )
    if many := int((shared > 2).sum()):
        raise FormatError(f"{counted(many, 'face')} shared by more than two cells")
    outer: NDArray[np.bool_] = (shared == 1)[face.ravel()]
    return np.concatenate(triangles)[outer[np.concatenate(owner)]]


TRIANGLE = "triangle"  # the shape of elements of walls
_STRAIGHT = 1e-9  # sine of an angle that is none
_FLAT_WALL = 1e-9  # of the square of its longest side: a triangle of less area has none


def wall_of_triangles(mesh: Mesh) -> Mesh:
    """Return a surface whose elements are its triangles, and whose node pairs are their edges.

    Raises:
        FormatError: It is no surface, or a triangle has no area.
    """
    if mesh.volume is not None:
        raise FormatError("it has an inside, so it has no thickness", "remove thickness")
    if not len(mesh.skin):
        raise FormatError("it has no surface", "write spring constants in its tissue")
    triangles = mesh.skin.astype(np.int64)
    corners = mesh.position[triangles]
    longest = np.ptp(corners, axis=1).max(axis=1)
    area = 0.5 * norm(cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    if (flat := area <= _FLAT_WALL * longest**2).any():
        from tissuec.meshes.repair import place

        first = int(np.argmax(flat))
        raise FormatError(
            f"{int(flat.sum())} triangles without an area, the first of them around "
            f"{place(corners[first].mean(axis=0))}",
            "repair it in the program that made the mesh",
        )
    pairs = (triangles[:, [k, (k + 1) % 3]] for k in range(3))
    ends = springs(len(mesh.position), *pairs)
    elements = (ElementMesh(TRIANGLE, triangles),)
    return replace(mesh, ends=ends, shares=None, elements=elements, sheets=_straight(mesh))


def _straight(mesh: Mesh) -> tuple[Indices, ...]:
    """Return the rows and the columns of a grid that are joined by straight lines."""
    if mesh.grid is None:
        return ()
    rows, columns, closed = mesh.grid
    number = np.arange(rows * columns).reshape(rows, columns)
    found: list[Indices] = []
    for sheets in (number,) if closed else (number, number.T):
        way = np.diff(mesh.position[sheets], axis=0)
        turned = norm(cross(way[1:], way[:-1])).max(initial=0.0)
        if turned <= _STRAIGHT * (way**2).sum(axis=-1).max(initial=0.0):
            found.append(sheets)
    return tuple(found)
