"""Repair of the contents of a mesh file, so that springs can follow them.

Repaired, and reported with counts: unused nodes, coincident nodes, degenerate triangles,
duplicate cells, and triangles that face another way than their neighbours. Refused: coordinates
that are not finite, corners that do not exist, folded tetrahedra, faces that cross themselves,
and files without any surface or cell.

Pyramids, wedges and hexahedra are divided into tetrahedra: their corner of the lowest number is
joined to the faces that do not have it, and each face of four is cut through its own lowest
corner. So two cells that share a face cut it alike (J. Dompierre and others, How to subdivide
pyramids, prisms and hexahedra into tetrahedra, 8th Int. Meshing Roundtable, 195, 1999).
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, NoReturn

import numpy as np
from msgspec import Struct, field
from numpy.typing import NDArray

from tissuec.core import units
from tissuec.core.errors import counted
from tissuec.core.hints import alternatives
from tissuec.core.structs import replace
from tissuec.geometry.divisions import CrossingError, triangles_of
from tissuec.geometry.edges import Edges, Floats, Indices
from tissuec.geometry.inside import Overlap, depths
from tissuec.meshes.between import BetweenNodes
from tissuec.meshes.formats import FormatError, MeshCells, RawMesh
from tissuec.model.topology import pieces

#: Faces of the volume cells by corner, all facing outwards (or, in some formats, all inwards).
FACES = {
    "pyramid": ((0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)),
    "wedge": ((0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)),
    "hexahedron": (
        (0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)
    ),
}  # fmt: skip
_SIDES = ((1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1))  # faces of a tetrahedron
_CLOSE = 1e-6  # of the diagonal of the mesh: nodes that are no further apart are one node
#: A diagonal of a face counts as the shorter one if it is so by more than this part. Rounding
#: in a file must not decide, for the same mesh may come in another format.
_SHORTER = 1e-3
_FLAT = 1e-6  # of its longest edge: the height of a triangle that has no area


class PartCells(Struct, frozen=True, eq=False):
    """Which volume cells each named part of a file has.

    Attributes:
        corners: Of all volume cells, ascending, and -1 beyond them, shape (cell, 8).
        element: Their numbers in the file, shape (cell,).
        parts: Numbers of the elements of each part, by name.
    """

    corners: Indices
    element: Indices
    parts: Mapping[str, Indices]

    def members(
        self, cells: Indices, groups: Mapping[str, Indices]
    ) -> Mapping[str, NDArray[np.bool_]]:
        """Return which cells each part has, shape (cell,), by name.

        Cells that are not in the file, because others were divided, belong to the parts that
        have all of their corners.

        Args:
            cells: Corners, shape (cell, corner).
            groups: Nodes of the parts, by name.
        """
        every = np.concatenate([self.corners, _ascending_corners(cells)])
        _, where = np.unique(every, axis=0, return_inverse=True)
        where, known = where.reshape(-1), np.full(len(every), -1)
        known[where[: len(self.corners)]] = self.element
        element = known[where[len(self.corners) :]]
        return {
            name: np.where(
                element >= 0,
                np.isin(element, members),
                np.isin(cells, groups.get(name, cells[:0])).all(axis=1),
            )
            for name, members in self.parts.items()
        }


def _ascending_corners(cells: Indices) -> Indices:
    """Return corners of cells in ascending order, followed by -1, shape (cell, 8)."""
    rows = np.full((len(cells), 8), -1)
    rows[:, : cells.shape[1]] = np.sort(cells, axis=1)
    return rows


class RepairedMesh(Struct, frozen=True, eq=False):
    """A repaired mesh.

    Attributes:
        position: Nodes [m], shape (node, 3).
        pairs: Node pairs that an edge or a diagonal joins, shape (pair, 2); may repeat.
        skin: The surface as triangles, shape (triangle, 3), facing outwards where it is closed.
        tetrahedra: Corners, shape (tetrahedron, 4).
        cells: Corners of the volume cells before they are divided, shape (cell, corner), by
            kind.
        divided: How many cells of other kinds these tetrahedra were.
        ignored: How many lines, beams and points of the file are left out.
        parts: Names of parts that can be imported alone.
        groups: Nodes of each named part or set of nodes, by name, ascending.
        remarks: What was repaired or remains wrong, in words, with counts.
        part_cells: The volume cells of the named parts.
        between: Nodes of curved cells that are no corners [m].
    """

    position: Floats
    pairs: Indices
    skin: Indices
    tetrahedra: Indices
    cells: Mapping[str, Indices]
    divided: int
    ignored: Mapping[str, int]
    parts: tuple[str, ...]
    groups: Mapping[str, Indices]
    remarks: tuple[str, ...]
    part_cells: PartCells
    between: BetweenNodes = field(default_factory=BetweenNodes.none)

    @property
    def is_volume(self) -> bool:
        return bool(len(self.tetrahedra))


class _Draft(Struct):
    """A mesh on its way."""

    position: Floats
    cells: list[MeshCells]
    groups: dict[str, Indices]
    between: BetweenNodes
    remarks: list[str] = field(default_factory=list[str])


def repair(
    raw: RawMesh, scale: float, *, close: float | None = None, part: str | None = None
) -> RepairedMesh:
    """Return a shape from the contents of a file.

    Args:
        raw: As read.
        scale: Metres in the file's unit.
        close: Distance up to which nodes count as one [m], 0 for none; by default a millionth
            of the diagonal.
        part: Name of the part that is taken; by default all of the file is.

    Raises:
        FormatError: It cannot be repaired, or there is no such part.
    """
    raw = raw if part is None else _part_of(raw, part)
    groups = {name: _nodes_of(raw, elements) for name, elements in raw.parts.items()}
    for name, nodes in raw.groups.items():
        groups[name] = np.concatenate([groups.get(name, nodes[:0]), nodes])
    between = raw.between.scaled(scale)
    draft = _Draft(raw.position * scale, list(raw.cells), groups, between, list(raw.remarks))
    _check(draft, raw)
    _divide_polygons(draft)
    _drop_unused(draft, raw, is_whole=part is None)
    _merge(draft, close)
    _name_walls(draft)
    shape = _Shape.of(draft)
    if not (len(shape.triangles) or len(shape.tetrahedra)):
        raise FormatError(f"nothing is left of its surface: {'; '.join(draft.remarks)}")
    skin, remarks = _faced(
        draft.position, shape.triangles, is_known=bool(len(shape.tetrahedra))
    )
    return RepairedMesh(
        draft.position,
        shape.pairs,
        skin,
        shape.tetrahedra,
        shape.cells,
        shape.divided,
        raw.ignored,
        tuple(raw.parts),
        draft.groups,
        (*draft.remarks, *remarks),
        _part_cells(draft, raw.parts),
        draft.between,
    )


def _part_cells(draft: _Draft, parts: Mapping[str, Indices]) -> PartCells:
    """Return the volume cells of a draft with their numbers in the file."""
    solid = [cells for cells in draft.cells if cells.kind in ("tetra", *FACES)]
    rows = [np.zeros((0, 8), np.int64), *(_ascending_corners(cells.nodes) for cells in solid)]
    element = [np.zeros(0, np.int64), *(cells.element for cells in solid)]
    return PartCells(np.concatenate(rows), np.concatenate(element), parts)


def _part_of(raw: RawMesh, name: str) -> RawMesh:
    """Return the cells of one part of a file."""
    if name not in raw.parts:
        what = (
            "is a set of nodes, which has no cells"
            if name in raw.groups
            else "is not a part of it"
        )
        raise FormatError(f'"{name}" {what}', alternatives(name, raw.parts, what="parts"))
    members = raw.parts[name]
    cells = tuple(cells.at(np.isin(cells.element, members)) for cells in raw.cells)
    # Nodes of other parts at the border of this one are no reason to name them here.
    parts = {
        other: common
        for other, elements in raw.parts.items()
        if len(common := np.intersect1d(elements, members))
    }
    return replace(raw, cells=cells, parts=parts)


def _nodes_of(raw: RawMesh, elements: Indices) -> Indices:
    """Return the nodes of some elements of a file, ascending."""
    rows = [cells.nodes[np.isin(cells.element, elements)].ravel() for cells in raw.cells]
    return np.unique(np.concatenate([np.zeros(0, np.int64), *rows]))


def _check(draft: _Draft, raw: RawMesh) -> None:
    """Refuse what has no cells, names nodes that are not there, or is nowhere."""
    if not sum(len(cells.nodes) for cells in draft.cells):
        parts = [counted(len(draft.position), "node")]
        parts += [counted(number, word) for word, number in raw.ignored.items()]
        raise FormatError(f"it contains no surface and no cell, only {' and '.join(parts)}")
    count = len(draft.position)
    for cells in draft.cells:
        wrong = (cells.nodes < 0) | (cells.nodes >= count)
        if wrong.any():
            rows = np.flatnonzero(wrong.any(axis=1))
            corner = cells.nodes[rows[0]][wrong[rows[0]]][0]
            raise FormatError(
                f"{_many(len(rows), cells.kind)} with a corner that does not exist, the "
                "first of "
                f"them {cells.kind} {rows[0] + 1}: node {corner + 1} of {count}"
            )
    used = _used(draft)
    lost = used[~np.isfinite(draft.position[used]).all(axis=1)]
    if len(lost):
        raise FormatError(
            f"{counted(len(lost), 'node')} with a coordinate that is not finite, the first of "
            f"them node {lost[0] + 1}"
        )


def _many(number: int, kind: str) -> str:
    return f"1 {kind}" if number == 1 else f"{number} {PLURALS.get(kind, kind + 's')}"


PLURALS = {"tetra": "tetrahedra", "hexahedron": "hexahedra"}


def _used(draft: _Draft) -> Indices:
    return np.unique(np.concatenate([cells.nodes.ravel() for cells in draft.cells]))


def _divide_polygons(draft: _Draft) -> None:
    """Divide faces of five corners or more into triangles."""
    many = 0
    for row, cells in enumerate(draft.cells):
        if cells.kind != "polygon":
            continue
        try:
            triangles = triangles_of(draft.position, cells.nodes)
        except CrossingError as error:
            at = draft.position[cells.nodes[error.row]].mean(axis=0)
            raise FormatError(
                f"a face of {cells.nodes.shape[1]} corners around {place(at)} crosses itself",
                "divide it into triangles in the program that made it",
            ) from None
        many += len(cells.nodes)
        each = np.repeat(cells.element, cells.nodes.shape[1] - 2)
        draft.cells[row] = MeshCells("triangle", triangles, each)
    if many:
        draft.remarks.append(f"{counted(many, 'face')} of five corners or more divided")


def _drop_unused(draft: _Draft, raw: RawMesh, *, is_whole: bool) -> None:
    """Leave out nodes that no cell has; those of other parts without a word."""
    used = _used(draft)
    unused = len(draft.position) - len(used)
    if raw.curved:
        draft.remarks.append(
            f"{counted(raw.curved, 'curved cell')} made straight: only corners are nodes"
        )
    elif (lost := unused - len(raw.between.corners)) > 0 and is_whole:
        draft.remarks.append(f"{counted(lost, 'node')} without a surface or cell removed")
    if unused:
        number = np.full(len(draft.position), -1)
        number[used] = np.arange(len(used))
        _renumber(draft, draft.position[used], number)


def _renumber(draft: _Draft, position: Floats, number: Indices) -> None:
    """Give nodes new numbers; those of groups that have none (-1) leave them."""
    draft.position, draft.between = position, draft.between.renumbered(number)
    draft.cells = [replace(cells, nodes=number[cells.nodes]) for cells in draft.cells]
    for name, nodes in draft.groups.items():
        nodes = nodes[(nodes >= 0) & (nodes < len(number))]
        draft.groups[name] = np.unique(number[nodes][number[nodes] >= 0])


def _merge(draft: _Draft, close: float | None) -> None:
    """Make nodes at one place one node, the first of them."""
    if close == 0.0:
        return
    if close is None:
        close = _CLOSE * float(np.linalg.norm(np.ptp(draft.position, axis=0)))
    pairs = close_pairs(draft.position, close)
    if not len(pairs):
        return
    label = pieces(len(draft.position), pairs).astype(np.int64)
    _, first = np.unique(label, return_index=True)
    draft.remarks.append(
        f"{counted(len(label) - len(first), 'node')} merged with another node that is no more "
        f"than {units.show(close, units.LENGTH)} away"
    )
    _renumber(draft, draft.position[first], label)


def _name_walls(draft: _Draft) -> None:
    """Report faces that are not sides of solid cells, where there are such cells."""
    solid = [cells.nodes.ravel() for cells in draft.cells if cells.kind in ("tetra", *FACES)]
    if not solid:
        return
    corners = np.unique(np.concatenate(solid))
    count: Counter[str] = Counter()
    for cells in draft.cells:
        if cells.kind in ("triangle", "quad"):
            loose = ~np.isin(cells.nodes, corners).all(axis=1)
            many = len(cells.nodes) if cells.label else int(loose.sum())
            count[cells.label or cells.kind] += many
    draft.remarks += [
        f"{counted(many, name)} besides the solid cells, left out in bodies of elements"
        for name, many in count.items()
        if many
    ]


def close_pairs(position: Floats, distance: float) -> Indices:
    """Return pairs of nodes that are no further apart than a distance, shape (pair, 2).

    Nodes are sorted along a direction that is no axis of symmetry of usual meshes; then only
    neighbours in that order can be close. Of nodes at the same place each is paired with the
    next.

    Args:
        position: Of the nodes [m], shape (node, 3).
        distance: Largest distance [m].
    """
    order = np.lexsort(position.T)
    same = (position[order[1:]] == position[order[:-1]]).all(axis=1)
    found = [np.stack([order[:-1][same], order[1:][same]], axis=1)]
    single = order[np.concatenate([[True], ~same])]
    along = (position[single] - position[single].mean(axis=0)) @ (0.5161, 0.6337, 0.5761)
    single, along = single[np.argsort(along, kind="stable")], np.sort(along)
    for ahead in range(1, len(single)):
        near = np.flatnonzero(along[ahead:] - along[:-ahead] <= distance)
        if not len(near):
            break
        one, other = single[near], single[near + ahead]
        apart = np.linalg.norm(position[one] - position[other], axis=1)
        found.append(np.stack([one, other], axis=1)[apart <= distance])
    return np.concatenate(found)


class _Shape(NamedTuple):
    """What cells consist of: triangles of the surface, pairs to join, and tetrahedra.

    Attributes:
        cells: The volume cells, by kind.
        divided: How many of them are no tetrahedra.
    """

    triangles: Indices
    pairs: Indices
    tetrahedra: Indices
    cells: Mapping[str, Indices]
    divided: int

    @classmethod
    def of(cls, draft: _Draft) -> "_Shape":
        """Take the cells of a draft apart."""
        joined: dict[str, Indices] = {}
        for kind in sorted({cells.kind for cells in draft.cells if len(cells.nodes)}):
            found = np.concatenate([c.nodes for c in draft.cells if c.kind == kind])
            if kind == "triangle":
                found = _without_folded(found, draft.remarks)
            joined[kind] = _once(found, kind, draft.remarks)
        tetrahedra = _tetrahedra(draft, joined)
        solid = {kind: joined[kind] for kind in ("tetra", *FACES) if kind in joined}
        divided = sum(len(solid[kind]) for kind in FACES if kind in solid)
        triangles = joined.get("triangle", np.zeros((0, 3), dtype=np.int64))
        quads = joined.get("quad", np.zeros((0, 4), dtype=np.int64))
        halves = _without_folded(_halved(draft.position, quads), draft.remarks)
        faces = _once(np.concatenate([triangles, halves]), "triangle", draft.remarks)
        if not len(tetrahedra):
            faces = _without_flat(draft, faces)
            return cls(faces, _edges(faces), tetrahedra, solid, divided)
        outer = _boundary(draft.position, tetrahedra)
        own = solid.get("tetra", tetrahedra[:0])
        sides = [
            solid[kind][:, face]
            for kind, around in FACES.items()
            if kind in solid
            for face in around
        ]
        pairs = np.concatenate([_edges(cells) for cells in (faces, own, *sides)])
        return cls(outer, pairs, tetrahedra, solid, divided)


def _edges(cells: Indices) -> Indices:
    """Return all pairs of corners of faces or tetrahedra."""
    corners = range(cells.shape[1])
    return np.concatenate([cells[:, [a, b]] for a in corners for b in corners if a < b])


def _tetrahedra(draft: _Draft, joined: Mapping[str, Indices]) -> Indices:
    """Return the tetrahedra of a file, and those into which its other volume cells divide."""
    own = joined.get("tetra", np.zeros((0, 4), dtype=np.int64))
    folded = _is_folded(own)
    if folded.any():
        raise FormatError(
            f"{_many(int(folded.sum()), 'tetra')} with two corners at the same position, the "
            f"first of them tetra {np.argmax(folded) + 1}",
            "remove it, or write: merging is off",
        )
    found = [own]
    for kind, faces in FACES.items():
        cells = joined.get(kind, np.zeros((0, 8), dtype=np.int64))
        made, cell = _coned(cells, faces)
        solid = ~_is_folded(made)  # of a cell that a program wrote with fewer corners
        made, cell = made[solid], cell[solid]
        empty = np.setdiff1d(np.arange(len(cells)), cell)
        if len(empty):
            at = draft.position[cells[empty[0]]].mean(axis=0)
            raise FormatError(
                f"{_many(len(empty), kind)} without any volume, the first of them "
                f"{kind} {empty[0] + 1} around {place(at)}",
                "repair it in the program that made the mesh; if its corners are only close to "
                "each other, write: merging is off",
            )
        a, b, c, d = draft.position[made].swapaxes(0, 1)
        content = np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a)
        low, high = np.zeros(len(cells)), np.zeros(len(cells))
        np.minimum.at(low, cell, content)
        np.maximum.at(high, cell, content)
        bent = np.minimum(-low, high) > _FLAT * np.maximum(-low, high)
        if many := int(bent.sum()):
            at = draft.position[cells[np.argmax(bent)]].mean(axis=0)
            draft.remarks.append(
                f"{_many(many, kind)} so distorted that parts of them are inside out, the "
                f"first of them around {place(at)}"
            )
        found.append(made)
    return np.concatenate(found)


def _coned(cells: Indices, faces: Sequence[tuple[int, ...]]) -> tuple[Indices, Indices]:
    """Return tetrahedra from the lowest corner of each cell to its other faces.

    Args:
        cells: Corners, shape (cell, corner).
        faces: Of such a cell by corner.

    Returns:
        Corners, shape (tetrahedron, 4), and the cell of each, shape (tetrahedron,).
    """
    found, owner = [np.zeros((0, 4), dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
    lowest = cells.argmin(axis=1) if len(cells) else np.zeros(0, dtype=np.int64)
    for apex in np.unique(lowest).tolist():
        rows = np.flatnonzero(lowest == apex)
        for face in faces:
            if apex in face:
                continue
            sides = [cells[rows][:, face]]
            if len(face) == 4:
                turned = sides[0].argmin(axis=1) % 2 == 1
                quad = np.where(turned[:, None], np.roll(sides[0], -1, axis=1), sides[0])
                sides = [quad[:, [0, 1, 2]], quad[:, [0, 2, 3]]]
            for side in sides:
                found.append(np.column_stack([cells[rows, apex], side]))
                owner.append(rows)
    order = np.argsort(np.concatenate(owner), kind="stable")
    return np.concatenate(found)[order], np.concatenate(owner)[order]


def _is_folded(cells: Indices) -> NDArray[np.bool_]:
    """Return which cells have two corners in one node."""
    ascending = np.sort(cells, axis=1)
    return (ascending[:, 1:] == ascending[:, :-1]).any(axis=1)


def _without_folded(triangles: Indices, remarks: list[str]) -> Indices:
    folded = _is_folded(triangles)
    if folded.any():
        many = counted(int(folded.sum()), "triangle")
        remarks.append(f"{many} with two corners in one node removed")
    return triangles[~folded]


def _without_flat(draft: _Draft, triangles: Indices) -> Indices:
    """Return triangles without those that have no area and hang on a closed surface.

    A triangle without area that fills the gap between a long edge and two short ones stays.
    """
    removed = 0
    while len(triangles):
        corners = draft.position[triangles]
        sides = np.roll(corners, -1, axis=1) - corners
        longest = np.linalg.norm(sides, axis=2).max(axis=1)
        area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
        edges = Edges.among(triangles)
        loose = (edges.count[edges.of] != 2).any(axis=1) & (area <= _FLAT * longest**2)
        if not loose.any():
            break
        removed += int(loose.sum())
        triangles = triangles[~loose]
    if removed:
        draft.remarks.append(f"{counted(removed, 'triangle')} without area removed")
        used = np.unique(triangles)
        number = np.full(len(draft.position), -1)
        number[used] = np.arange(len(used))
        _renumber(draft, draft.position[used], number)
        triangles = number[triangles]
    return triangles


def _halved(position: Floats, quads: Indices) -> Indices:
    """Return two triangles for each quad, cut along its shorter diagonal.

    Where both are equally long, it is the one through the lowest node. A quad with a corner
    that points inwards, or is straight, is cut through that corner.
    """
    if not len(quads):
        return np.zeros((0, 3), dtype=np.int64)
    corner = position[quads]
    first, second = corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]
    even, odd = (np.linalg.norm(one, axis=1) for one in (first, second))
    similar = np.abs(even - odd) <= _SHORTER * np.maximum(even, odd)
    lowest = np.asarray(quads.argmin(axis=1) % 2 == 1)
    turned = np.where(similar, lowest, odd < even)
    normal = np.cross(first, second)  # twice the area
    before, behind = np.roll(corner, 1, axis=1), np.roll(corner, -1, axis=1)
    turns = np.cross(corner - before, behind - corner)
    size = np.einsum("ij,ij->i", normal, normal)[:, None]
    inwards = np.einsum("ikj,ij->ik", turns, normal) < _SHORTER * size
    through = np.asarray(inwards.argmax(axis=1) % 2 == 1)
    turned = np.where(inwards.sum(axis=1) == 1, through, turned)
    rows = np.where(turned[:, None], np.roll(quads, -1, axis=1), quads)
    return np.concatenate([rows[:, [0, 1, 2]], rows[:, [0, 2, 3]]])


def _once(cells: Indices, kind: str, remarks: list[str]) -> Indices:
    """Return cells without those that are there twice, whichever way they face."""
    _, first = np.unique(np.sort(cells, axis=1), axis=0, return_index=True)
    if again := len(cells) - len(first):
        remarks.append(f"{_many(again, kind)} removed (duplicate)")
    return cells[np.sort(first)]


def _boundary(position: Floats, tetrahedra: Indices) -> Indices:
    """Return the faces that one tetrahedron alone has, facing outwards, shape (face, 3)."""
    faces = tetrahedra[:, np.array(_SIDES)].reshape(-1, 3)
    _, first, count = np.unique(
        np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True
    )
    if many := int((count > 2).sum()):
        raise FormatError(f"{counted(many, 'face')} shared by more than two cells")
    outer = np.sort(first[count == 1])
    triangles = faces[outer]
    within = position[tetrahedra[outer // 4]].mean(axis=1)
    a, b, c = position[triangles].swapaxes(0, 1)
    inwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), a - within) < 0.0
    triangles[inwards] = triangles[inwards][:, ::-1]
    return triangles


def _faced(
    position: Floats, triangles: Indices, *, is_known: bool
) -> tuple[Indices, list[str]]:
    """Return triangles that face the same way, closed ones outwards, and what remains wrong.

    Args:
        is_known: Whether they face outwards already, as those of volume cells do.
    """
    remarks: list[str] = []
    edges = Edges.among(triangles)
    if many := int((edges.count > 2).sum()):
        first = edges.ends[edges.count > 2][0]
        remarks.append(
            f"{counted(many, 'edge')} of more than two triangles, the first of them between "
            f"{place(position[first[0]])} and {place(position[first[1]])}"
        )
    if is_known:
        return triangles, remarks
    turned, patch, twisted = edges.facing_alike()
    if twisted:
        remarks.append(f"{counted(twisted, 'piece')} of the surface with one side only")
    turned ^= _wrong_way(position, _turn(triangles, turned), edges, turned, patch)
    if many := int(turned.sum()):
        remarks.append(
            "the surface turned inside out: all of its triangles faced inwards"
            if many == len(turned)
            else f"{_many(many, 'triangle')} flipped to face the same way as the others"
        )
    return _turn(triangles, turned), remarks


def _turn(triangles: Indices, which: NDArray[np.bool_]) -> Indices:
    return np.where(which[:, None], triangles[:, ::-1], triangles)


def _wrong_way(
    position: Floats,
    triangles: Indices,
    edges: Edges,
    turned: NDArray[np.bool_],
    patch: Indices,
) -> NDArray[np.bool_]:
    """Return which triangles to turn, patch by patch, all those of a patch facing alike.

    A closed patch is to face outwards, or inwards where it is the wall of a cavity. An open one
    is to face as most of its triangles did.
    """
    size = len(triangles)
    a, b, c = (position[triangles] - position.mean(axis=0)).swapaxes(0, 1)
    content = np.bincount(patch, np.einsum("ij,ij->i", a, np.cross(b, c)), size)
    is_open = np.bincount(patch, (edges.count[edges.of] != 2).any(axis=1), size) > 0
    most = 2 * np.bincount(patch, turned, size) > np.bincount(patch, minlength=size)
    wrong = is_open & most
    closed = np.unique(patch)[~is_open[np.unique(patch)]]
    wrong[closed] = content[closed] < 0.0
    if len(closed) > 1:
        outwards = _turn(triangles, wrong[patch])
        used = np.isin(patch, closed)
        deep, overlap = depths(position, outwards[used], patch[used], closed)
        if overlap is not None:
            _refuse_overlap(position, triangles, patch, overlap)
        wrong[closed] ^= deep % 2 == 1
    return wrong[patch]


def _refuse_overlap(
    position: Floats, triangles: Indices, patch: Indices, overlap: Overlap
) -> NoReturn:
    """Reject two closed shells one of which lies partly inside the other."""

    def shell(number: int) -> str:
        faces = triangles[patch == number]
        middle = position[np.unique(faces)].mean(axis=0)
        return f"the shell of {counted(len(faces), 'triangle')} around {place(middle)}"

    verb = "lies" if overlap.inside == 1 else "lie"
    raise FormatError(
        f"{shell(overlap.patch)} intersects {shell(overlap.other)}: {overlap.inside} of its "
        f"{counted(overlap.corners, 'corner')} {verb} inside",
        "unite them in a mesh program, or draw them apart; only a shell that lies inside of "
        "another with all corners is a cavity",
    )


def place(point: NDArray[Any]) -> str:
    """Return a point as messages name it: "(1 mm, 2 mm, 0 m)".

    Args:
        point: [m], shape (3,).
    """
    shown = ", ".join(units.show(float(value), units.LENGTH) for value in point)
    return f"({shown})"
