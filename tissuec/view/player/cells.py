"""Filled bodies as tetrahedra: the insides that cuts, tears and sections show.

A tetrahedron lives while all of its edges hold, as triangles of the skin do. Where one is gone
and its neighbour is there, their common face is a *cap* of the neighbour.
"""

from collections.abc import Iterable, Sequence
from itertools import combinations

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.geometry.divisions import OPPOSITE, filling_tetrahedra, volumes
from tissuec.geometry.edge_supports import SupportedEdges
from tissuec.geometry.edges import Edges
from tissuec.model import topology
from tissuec.model.network import BodyPart, Floats, Indices, Network
from tissuec.results.element_cells import PIECE, TYPES
from tissuec.results.trajectory import Trajectory
from tissuec.view.player.lifetimes import (
    FOREVER,
    Lifetimes,
    Mask,
    is_there,
    sharpened_triangles,
)

MOST_NODES = 30_000
"""Nodes of a body up to which it is divided by default: that takes 10 s."""

_BOX = [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]]
#: Tetrahedra of the corners of elements, by VTK's number of their shape.
_DIVISIONS = {
    number: np.array(tetrahedra)
    for number, tetrahedra in (
        (PIECE, [[0, 1, 2, 3]]),
        (TYPES["tetrahedron"], [[0, 1, 2, 3]]),
        (TYPES["wedge"], [[0, 1, 2, 3], [1, 2, 3, 4], [2, 3, 4, 5]]),
        (TYPES["hexahedron"], _BOX),
        (TYPES["quadratic hexahedron"], _BOX),
    )
}
_PAIRS = np.array(list(combinations(range(4), 2)))
_MOSTLY = 0.5  # of the volume: a body is filled if springs join the corners of so much
Change = tuple[float, Mask]  # a frame, and the recorded springs that are there from then on


class SolidCells(Struct, frozen=True, eq=False):
    """Tetrahedra of filled bodies.

    Attributes:
        tetrahedra: Corners, shape (tetrahedron, 4).
        death: The frame until which each is there, shape (tetrahedron,).
        filled: Names of the bodies that they fill.
        left_out: Names of filled bodies that are too large to be divided.
        births: The frame from which on each is there; 0 if none are given, shape
            (tetrahedron,).
    """

    tetrahedra: Indices
    death: Floats
    filled: tuple[str, ...]
    left_out: tuple[str, ...]
    births: Floats | None = None

    @property
    def birth(self) -> Floats:
        """Return from when on each is there, in units of frames, shape (tetrahedron,)."""
        return np.zeros(len(self.death)) if self.births is None else self.births

    def there(self, frame: float) -> Indices:
        """Return the tetrahedra that exist in a frame, or between two, shape (n, 4)."""
        return self.tetrahedra[is_there(self.life, frame)]

    @property
    def life(self) -> Floats:
        """Return from when until when each is there, in units of frames, shape (n, 2)."""
        return np.stack([self.birth, self.death], axis=1)

    def joined(self, more: "SolidCells") -> "SolidCells":
        """Return these and those of other bodies."""
        if not len(more.tetrahedra):
            return self
        return SolidCells(
            np.concatenate([self.tetrahedra, more.tetrahedra]),
            np.concatenate([self.death, more.death]),
            (*self.filled, *more.filled),
            (*self.left_out, *more.left_out),
            np.concatenate([self.birth, more.birth]),
        )

    @property
    def sorted(self) -> "SolidCells":
        """Return the same in ascending order of nodes, which packs well."""
        corners = np.sort(self.tetrahedra, axis=1)
        order = np.lexsort(corners.T[::-1])
        return SolidCells(
            corners[order], self.death[order], self.filled, self.left_out, self.birth[order]
        )

    def on_nodes(self, place: Indices) -> "SolidCells":
        """Return those that have four corners left after nodes were brought together.

        Args:
            place: The node that each node represents, shape (node,).
        """
        corners = np.sort(place[self.tetrahedra], axis=1)
        apart = (np.diff(corners, axis=1) > 0).all(axis=1)
        drawn, inverse = np.unique(corners[apart], axis=0, return_inverse=True)
        death, birth = np.zeros(len(drawn)), np.full(len(drawn), FOREVER)
        np.maximum.at(death, inverse.reshape(-1), self.death[apart])
        np.minimum.at(birth, inverse.reshape(-1), self.birth[apart])
        return SolidCells(drawn.reshape(-1, 4), death, self.filled, self.left_out, birth)


def no_cells() -> SolidCells:
    """Return the cells of a scene without filled bodies: none."""
    return SolidCells(np.zeros((0, 4), dtype=np.int64), np.zeros(0), (), ())


def read_cells(
    trajectory: Trajectory, changes: Sequence[Change], ends: Floats, *, most: int | None
) -> SolidCells:
    """Return the tetrahedra of the filled bodies of a result, between its recorded nodes.

    Bodies whose elements are cut in parts have those of ``cut_solids`` instead.

    Args:
        changes: In order; the first one is the start.
        ends: When springs end, in units of frames, shape (spring,).
        most: Larger bodies are left out; None for none.
    """
    network, found = trajectory.network, [np.zeros((0, 4), dtype=np.int64)]
    filled: list[str] = []
    left_out: list[str] = []
    for body in network.bodies:
        if not _is_recorded(trajectory, body) or not _may_be_filled(network, body):
            continue
        if body.name in _cut_bodies(trajectory):
            continue
        if most is not None and body.nodes.stop - body.nodes.start > most:
            left_out.append(body.name)
        elif len(cells := _filling(network, body)):
            filled.append(body.name)
            found.append(np.searchsorted(trajectory.nodes, cells))
    tetrahedra = np.concatenate(found)
    death = _deaths(trajectory, tetrahedra, changes, ends)
    return SolidCells(tetrahedra, death, tuple(filled), tuple(left_out))


def cut_solids(trajectory: Trajectory, elements: Lifetimes) -> SolidCells:
    """Return tetrahedra that divide the elements of bodies that are cut in parts, and parts.

    Args:
        elements: When each cell of the solid elements of a result is there.
    """
    names = _cut_bodies(trajectory)
    if not names:
        return no_cells()
    mesh = trajectory.mesh
    cells = mesh.solids.some(elements.of)
    own = np.zeros(len(cells), dtype=bool)
    for body in trajectory.network.bodies:
        if body.name in names:
            entities = body.elements.start, body.elements.stop
            own |= (cells.entities >= entities[0]) & (cells.entities < entities[1])
    found: list[NDArray[np.integer]] = [np.zeros((0, 4), dtype=np.int64)]
    life = [np.zeros((0, 2))]
    for kind, items, nodes in cells.by_shape():
        division = _DIVISIONS[kind]
        shown = own[items]
        found.append(nodes[shown][:, division].reshape(-1, 4))
        life.append(np.repeat(elements.life[items[shown]], len(division), axis=0))
    birth, death = np.concatenate(life).T
    return SolidCells(np.concatenate(found).astype(np.int64), death, names, (), birth)


def _cut_bodies(trajectory: Trajectory) -> tuple[str, ...]:
    """Return the names of the bodies with elements that were cut in parts."""
    cut = trajectory.cut_cells
    return tuple(
        body.name
        for body in trajectory.network.bodies
        if cut is not None
        and ((cut.parts >= body.elements.start) & (cut.parts < body.elements.stop)).any()
    )


def _is_recorded(trajectory: Trajectory, body: BodyPart) -> bool:
    first, last = np.searchsorted(trajectory.nodes, [body.nodes.start, body.nodes.stop])
    return int(last - first) == body.nodes.stop - body.nodes.start


def _may_be_filled(network: Network, body: BodyPart) -> bool:
    """Return whether a body has a closed skin, and nodes or springs besides those of it."""
    skin = network.skin_of(body)
    if not Edges.among(skin).is_closed:
        return False
    return _has_nodes_inside(network, body) or len(_others(network, body)) > 0


def _has_nodes_inside(network: Network, body: BodyPart) -> bool:
    return len(np.unique(network.skin_of(body))) < body.nodes.stop - body.nodes.start


def _others(network: Network, body: BodyPart) -> Indices:
    """Return keys of the springs of a body that do not lie along its skin, shape (spring,)."""
    size = network.node_count
    along = Edges.among(network.skin_of(body)).ends @ [size, 1]
    springs = np.sort(network.line_ends[body.lines].astype(np.int64), axis=1) @ [size, 1]
    return springs[~np.isin(springs, along)]


def _filling(network: Network, body: BodyPart) -> Indices:
    """Return the tetrahedra of a body, none of a hollow one, shape (tetrahedron, 4)."""
    position = network.position[body.nodes]
    skin = network.skin_of(body) - body.nodes.start
    cells = filling_tetrahedra(position, skin)
    # Springs that resist the bending of a shell pass through its inside, but fill it not.
    if len(cells) and not _has_nodes_inside(network, body):
        ends = (
            np.sort(network.line_ends[body.lines].astype(np.int64), axis=1) - body.nodes.start
        )
        content = volumes(position, cells)
        joined = _are_joined(cells, ends, len(position))
        if content[joined].sum() < _MOSTLY * content.sum():
            return cells[:0]
    return cells + body.nodes.start


def _are_joined(cells: Indices, ends: Indices, count: int) -> Mask:
    """Return which tetrahedra have corners that springs along their edges join."""
    keys = np.sort(cells[:, _PAIRS], axis=2) @ np.array([count, 1])
    has = np.isin(keys, ends @ [count, 1])
    number, pair = np.nonzero(has)
    corner = 4 * number[:, None] + _PAIRS[pair]
    labels = topology.pieces(4 * len(cells), corner.astype(np.int32)).reshape(-1, 4)
    return np.asarray((labels == labels[:, :1]).all(axis=1))


def _deaths(
    trajectory: Trajectory, tetrahedra: Indices, changes: Iterable[Change], ends: Floats
) -> Floats:
    """Return until which frame each tetrahedron is there, shape (tetrahedron,)."""
    death = np.full(len(tetrahedra), FOREVER)
    later = list(changes)[1:]
    if not len(tetrahedra) or not later:
        return death
    size = len(trajectory.nodes)
    keys = np.sort(tetrahedra[:, _PAIRS], axis=2) @ np.array([size, 1])
    edges, of = np.unique(keys, return_inverse=True)
    supported = SupportedEdges.of(trajectory.ends, np.stack(np.divmod(edges, size), axis=1))
    of = of.reshape(-1, 6)
    for frame, alive in later:
        torn = ~supported.holding(alive)[of].all(axis=1)
        death[torn & (death > frame)] = frame
    return sharpened_triangles(np.stack([np.zeros(len(death)), death], axis=1), ends)[:, 1]


class CappedSkin(Struct, frozen=True, eq=False):
    """The skin of all bodies with the caps of those that are filled.

    Attributes:
        triangles: Shape (triangle, 3).
        life: In frames, shape (triangle, 2).
        is_cap: Shape (triangle,).
    """

    triangles: Indices
    life: Floats
    is_cap: Mask


def capped(triangles: NDArray[np.integer], life: Floats, cells: SolidCells) -> CappedSkin:
    """Return a skin whose triangles end with the tetrahedra behind them, and caps.

    What is drawn at any time is then the surface of the tetrahedra that are there.

    Args:
        triangles: Skin, between the nodes of ``cells``, shape (triangle, 3).
        life: Of the skin, in units of frames, shape (triangle, 2).
        cells: Filled bodies.
    """
    skin = triangles.astype(np.int64)
    if not (cells.death < FOREVER).any():
        return CappedSkin(skin, life, np.zeros(len(skin), dtype=bool))
    base = int(max(skin.max(initial=0), cells.tetrahedra.max())) + 1
    powers = np.array([base * base, base, 1])
    faces = cells.tetrahedra[:, OPPOSITE].reshape(-1, 3)
    death = np.repeat(cells.death, 4)
    keys = np.sort(faces, axis=1) @ powers
    order = np.lexsort((death, keys))  # of two at a face, the one that lives longer is second
    faces, death, keys = faces[order], death[order], keys[order]
    first = np.flatnonzero(keys[1:] == keys[:-1])
    ends = first[death[first] < death[first + 1]]
    caps, spans = faces[ends + 1], np.stack([death[ends], death[ends + 1]], axis=1)
    at = np.minimum(np.searchsorted(keys, own := np.sort(skin, axis=1) @ powers), len(keys) - 1)
    life = life.copy()
    behind = keys[at] == own
    life[behind, 1] = np.minimum(life[behind, 1], death[at[behind]])
    return CappedSkin(
        np.concatenate([skin, caps]),
        np.concatenate([life, spans]),
        np.repeat([False, True], [len(skin), len(caps)]),
    )
