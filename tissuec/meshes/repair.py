"""Repair of the contents of a mesh file, so that springs can follow them.

Repaired, and reported with counts: unused nodes, coincident nodes, degenerate triangles,
duplicate cells, and triangles that face another way than their neighbours. Refused: coordinates
that are not finite, corners that do not exist, folded cells, and files without any surface or
cell.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from msgspec import Struct, field
from numpy.typing import NDArray

from tissuec.core import units
from tissuec.core.errors import counted
from tissuec.geometry.edges import Edges, Floats, Indices
from tissuec.geometry.inside import depths
from tissuec.meshes.formats import FormatError, MeshCells, RawMesh
from tissuec.model.topology import pieces

#: Faces of the volume cells by corner; a face of three ends with its first corner again.
FACES = {
    "tetra": ((0, 1, 2, 0), (0, 1, 3, 0), (1, 2, 3, 1), (0, 2, 3, 0)),
    "pyramid": ((0, 1, 2, 3), (0, 1, 4, 0), (1, 2, 4, 1), (2, 3, 4, 2), (3, 0, 4, 3)),
    "wedge": ((0, 1, 2, 0), (3, 4, 5, 3), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)),
    "hexahedron": (
        (0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)
    ),
}  # fmt: skip
_CLOSE = 1e-6  # of the diagonal of the mesh: nodes that are no further apart are one node
#: A diagonal of a face counts as the shorter one if it is so by more than this part. Rounding
#: in a file must not decide, for the same mesh may come in another format.
_SHORTER = 1e-3


class RepairedMesh(Struct, frozen=True, eq=False):
    """A repaired mesh.

    Attributes:
        position: Nodes [m], shape (node, 3).
        pairs: Node pairs that an edge or a diagonal of a face joins, shape (pair, 2); may
            repeat.
        skin: The surface as triangles, shape (triangle, 3), facing outwards where it is closed.
        tetrahedra: Corners, shape (tetrahedron, 4).
        others: How many volume cells there are that are no tetrahedra.
        groups: Nodes of each named part, by name, ascending.
        remarks: What was repaired or remains wrong, in words, with counts.
    """

    position: Floats
    pairs: Indices
    skin: Indices
    tetrahedra: Indices
    others: int
    groups: Mapping[str, Indices]
    remarks: tuple[str, ...]

    @property
    def is_volume(self) -> bool:
        return bool(len(self.tetrahedra) or self.others)


class _Draft(Struct):
    """A mesh on its way."""

    position: Floats
    cells: list[MeshCells]
    groups: dict[str, Indices]
    remarks: list[str] = field(default_factory=list[str])


def repair(raw: RawMesh, scale: float, *, close: float | None = None) -> RepairedMesh:
    """Return a shape from the contents of a file.

    Args:
        raw: As read.
        scale: Metres in the file's unit.
        close: Distance up to which nodes count as one [m]; by default a millionth of the
            diagonal.

    Raises:
        FormatError: It cannot be repaired.
    """
    draft = _Draft(raw.position * scale, list(raw.cells), dict(raw.groups))
    _check(draft, raw)
    _drop_unused(draft, raw)
    _merge(draft, close)
    _check_folded(draft)
    if not any(len(cells.nodes) for cells in draft.cells):
        raise FormatError(f"nothing is left of its surface: {'; '.join(draft.remarks)}")
    triangles, pairs, tetrahedra, others = _take_apart(draft)
    if raw.polygons:
        draft.remarks.append(f"{counted(raw.polygons, 'face')} of five corners or more divided")
    skin, remarks = _faced(draft.position, triangles)
    return RepairedMesh(
        draft.position,
        pairs,
        skin,
        tetrahedra,
        others,
        draft.groups,
        (*draft.remarks, *remarks),
    )


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


def _drop_unused(draft: _Draft, raw: RawMesh) -> None:
    used = _used(draft)
    unused = len(draft.position) - len(used)
    if raw.curved:
        draft.remarks.append(
            f"{counted(raw.curved, 'curved cell')} made straight: only corners are nodes"
        )
    elif unused:
        draft.remarks.append(f"{counted(unused, 'node')} without a surface or cell removed")
    if unused:
        number = np.full(len(draft.position), -1)
        number[used] = np.arange(len(used))
        _renumber(draft, draft.position[used], number)


def _renumber(draft: _Draft, position: Floats, number: Indices) -> None:
    """Give nodes new numbers; those of groups that have none (-1) leave them."""
    draft.position = position
    draft.cells = [MeshCells(cells.kind, number[cells.nodes]) for cells in draft.cells]
    for name, nodes in draft.groups.items():
        nodes = nodes[(nodes >= 0) & (nodes < len(number))]
        draft.groups[name] = np.unique(number[nodes][number[nodes] >= 0])


def _merge(draft: _Draft, close: float | None) -> None:
    """Make nodes at one place one node, the first of them."""
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


def _check_folded(draft: _Draft) -> None:
    """Leave out faces with two corners in one node; refuse such volume cells."""
    for place, cells in enumerate(draft.cells):
        ascending = np.sort(cells.nodes, axis=1)
        folded = (ascending[:, 1:] == ascending[:, :-1]).any(axis=1)
        if not folded.any():
            continue
        number = int(folded.sum())
        if cells.kind in FACES:
            raise FormatError(
                f"{_many(number, cells.kind)} with two corners at the same position, the "
                "first of them "
                f"{cells.kind} {np.argmax(folded) + 1}",
                "write such a cell with fewer corners, or set merging distance = 0 mm",
            )
        draft.remarks.append(
            f"{_many(number, cells.kind)} with two corners in one node removed"
        )
        draft.cells[place] = MeshCells(cells.kind, cells.nodes[~folded])


def _take_apart(draft: _Draft) -> tuple[Indices, Indices, Indices, int]:
    """Return the triangles of the surface, pairs to join, tetrahedra, and other cells."""
    none = np.zeros((0, 4), dtype=np.int64)
    of_kind: dict[str, list[Indices]] = {}
    for cells in draft.cells:
        of_kind.setdefault(cells.kind, []).append(cells.nodes)
    joined = {
        kind: _once(np.concatenate(rows), kind, draft.remarks) for kind, rows in of_kind.items()
    }
    triangles = joined.get("triangle", none[:, :3])
    quads, diagonals = _halved(draft.position, joined.get("quad", none))
    faces = _once(np.concatenate([triangles, quads]), "triangle", draft.remarks)
    shells = [
        (joined[kind][:, np.array(sides)], joined[kind])
        for kind, sides in FACES.items()
        if kind in joined
    ]
    pairs = [faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]], diagonals]
    tetrahedra = joined.get("tetra", none)
    others = sum(len(joined.get(kind, none)) for kind in ("pyramid", "wedge", "hexahedron"))
    if not shells:
        return faces, _pairs(pairs), tetrahedra, others
    outer, inner_pairs = _boundary(draft.position, shells)
    return outer, _pairs([*pairs, inner_pairs]), tetrahedra, others


def _pairs(found: Sequence[Indices]) -> Indices:
    pairs = np.concatenate(found)
    return pairs[pairs[:, 0] != pairs[:, 1]]


def _halved(position: Floats, quads: Indices) -> tuple[Indices, Indices]:
    """Return two triangles for each quad, cut along its shorter diagonal, and the diagonals.

    Where both are equally long, it is the one through the lowest node: two cells that share a
    face cut it alike.
    """
    even, odd = (
        np.linalg.norm(position[quads[:, k]] - position[quads[:, k + 2]], axis=1)
        for k in (0, 1)
    )
    lowest = quads.argmin(axis=1) % 2 == 1 if len(quads) else np.zeros(0, dtype=bool)
    similar = np.abs(even - odd) <= _SHORTER * np.maximum(even, odd)
    turned = np.where(similar, lowest, odd < even)
    rows = np.where(turned[:, None], np.roll(quads, -1, axis=1), quads)
    triangles = np.concatenate([rows[:, [0, 1, 2]], rows[:, [0, 2, 3]]])
    return triangles, rows[:, [0, 2]]


def _once(cells: Indices, kind: str, remarks: list[str]) -> Indices:
    """Return cells without those that are there twice, whichever way they face."""
    _, first = np.unique(np.sort(cells, axis=1), axis=0, return_index=True)
    if again := len(cells) - len(first):
        remarks.append(f"{_many(again, kind)} removed (duplicate)")
    return cells[np.sort(first)]


def _boundary(
    position: Floats, shells: Sequence[tuple[Indices, Indices]]
) -> tuple[Indices, Indices]:
    """Return the faces that one cell alone has, as triangles facing outwards, and all edges.

    Args:
        shells: Of each kind of cell, the faces, shape (cell, face, 4), and the corners.
    """
    faces = np.concatenate([sides.reshape(-1, 4) for sides, _ in shells])
    centre = np.concatenate(
        [
            np.repeat(position[nodes].mean(axis=1), sides.shape[1], axis=0)
            for sides, nodes in shells
        ]
    )
    is_three = faces[:, 0] == faces[:, 3]
    key = np.sort(faces, axis=1)
    # A face of three names its first corner twice; which one that is must not matter.
    key[is_three] = np.sort(
        np.column_stack([faces[is_three, :3], np.full(is_three.sum(), -1)]), axis=1
    )
    _, first, number, count = np.unique(
        key, axis=0, return_index=True, return_inverse=True, return_counts=True
    )
    if many := int((count > 2).sum()):
        raise FormatError(f"{counted(many, 'face')} shared by more than two cells")
    _, diagonals = _halved(position, faces[first[~is_three[first]]])
    edges = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
    outer = count[number.ravel()] == 1
    triangles = np.concatenate(
        [faces[outer & is_three][:, :3], _halved(position, faces[outer & ~is_three])[0]]
    )
    middle = centre[outer & ~is_three]
    within = np.concatenate([centre[outer & is_three], middle, middle])
    a, b, c = position[triangles].swapaxes(0, 1)
    inwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), a - within) < 0.0
    triangles[inwards] = triangles[inwards][:, ::-1]
    return triangles, np.concatenate([edges, diagonals])


def _faced(position: Floats, triangles: Indices) -> tuple[Indices, list[str]]:
    """Return triangles that face the same way, closed ones outwards, and what remains wrong."""
    remarks: list[str] = []
    edges = Edges.among(triangles)
    turned, patch, twisted = edges.facing_alike()
    if twisted:
        remarks.append(f"{counted(twisted, 'piece')} of the surface with one side only")
    if many := int((edges.count > 2).sum()):
        first = edges.ends[edges.count > 2][0]
        remarks.append(
            f"{counted(many, 'edge')} of more than two triangles, the first of them between "
            f"{_place(position[first[0]])} and {_place(position[first[1]])}"
        )
    turned ^= _wrong_way(position, _turn(triangles, turned), edges, turned, patch)
    if many := int(turned.sum()):
        remarks.append(f"{_many(many, 'triangle')} flipped to face the same way as the others")
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
        deep = depths(position, outwards[used], patch[used], closed)
        wrong[closed] ^= deep % 2 == 1
    return wrong[patch]


def _place(point: NDArray[Any]) -> str:
    shown = ", ".join(units.show(float(value), units.LENGTH) for value in point)
    return f"({shown})"
