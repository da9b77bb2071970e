"""The drawn part of the network in a frame, and the cells by which VTK shows it.

Springs are lines, triangles of walls and of skins are triangles, and nodes without anything are
vertices. A body of solid elements that frames contain as a whole is shown by its elements, in
place of their edges and of its skin: slices are filled, and integrals are those of the volume.
Parts of elements that were cut are shown by tetrahedra, whose corners are nodes and riding
points; these follow the nodes in frames.
"""

from collections.abc import Mapping
from functools import cached_property
from typing import Any, NamedTuple, Self

import numpy as np
from msgspec import Struct
from numpy.typing import ArrayLike, NDArray

from tissuec.core.arrays import counted_up
from tissuec.core.structs import replace
from tissuec.geometry.edge_supports import SupportedTriangles
from tissuec.model.cut_cells import CutCells, reserved_entities
from tissuec.model.network import Indices, Network, numbers_in
from tissuec.results.cut_cells import RecordedCutCells
from tissuec.results.element_cells import (
    LINE,
    PIECE,
    TRIANGLE,
    VERTEX,
    ElementCells,
    ends_of,
)
from tissuec.results.fields import FieldChannel, Place
from tissuec.results.recording import Recording


class Cells(NamedTuple):
    """What exists at a time; nodes are numbered as in the frames.

    Attributes:
        vertices: Nodes that nothing below touches, shape (vertex, 1).
        lines: Ends of springs and edges of elements that are alive, shape (line, 2).
        triangles: Skin that is whole, followed by triangles of parts, shape (triangle, 3).
        line_numbers: Network number of each line, shape (line,).
        faces: Place of each triangle of the skin among those of the mesh, shape (face,).
        elements: Places of the cells of elements that exist among the ``solids`` of the mesh,
            shape (element,).
        borders: Places of the triangles of parts among those of the mesh, shape (border,).
        points: How many points a frame has: nodes, and behind them riding points.
    """

    vertices: Indices
    lines: NDArray[np.integer]
    triangles: NDArray[np.integer]
    line_numbers: NDArray[np.integer]
    faces: Indices
    elements: Indices
    borders: Indices
    points: int

    def same_as(self, other: "Cells | None") -> bool:
        """Return whether both draw the same."""
        return other is self or (other is not None and all(map(np.array_equal, self, other)))


class CellGrid(Struct, frozen=True, eq=False):
    """Cells of VTK: vertices, lines, triangles, and solid elements behind one another.

    Attributes:
        types: VTK's number of the type of each, shape (cell,).
        points: Of all cells one after another, shape (row,).
        ends: Where each begins in ``points``, and the end of the last, shape (cell + 1,).
        rows: Where springs, triangles of the skin and elements stand among the cells.
        items: Places of these among those of the mesh, those of parts among the elements.
    """

    types: NDArray[np.uint8]
    points: NDArray[np.integer]
    ends: Indices
    rows: Mapping[Place, slice]
    items: Mapping[Place, Indices]

    @classmethod
    def of(
        cls,
        vertices: NDArray[np.integer],
        lines: NDArray[np.integer],
        triangles: NDArray[np.integer],
        solids: ElementCells | None = None,
        items: Mapping[Place, Indices] | None = None,
    ) -> Self:
        """Return cells as VTK has them.

        Args:
            vertices, lines, triangles: Points, shapes (cell, 1), (cell, 2) and (cell, 3).
            solids: Elements with numbers of points.
            items: As for the class; if there are fewer triangles, the others have no numbers.
        """
        solids = ElementCells.none() if solids is None else solids
        tables = {VERTEX: vertices, LINE: lines, TRIANGLE: triangles}
        types = [np.full(len(t), kind, dtype=np.uint8) for kind, t in tables.items()]
        sizes = [np.full(len(t), t.shape[1]) for t in tables.values()]
        points = [*(t.reshape(-1) for t in tables.values()), solids.nodes]
        stops = np.cumsum([len(vertices), len(lines), len(triangles), len(solids)]).tolist()
        places: tuple[Place, ...] = ("spring", "triangle", "element")
        rows = {at: slice(*stops[n : n + 2]) for n, at in enumerate(places)}
        if items is not None:
            rows["triangle"] = slice(stops[1], stops[1] + len(items["triangle"]))
        return cls(
            np.concatenate([*types, solids.types]),
            np.concatenate(points),
            ends_of(np.concatenate([*sizes, solids.sizes])),
            rows,
            {} if items is None else items,
        )

    @classmethod
    def of_triangles(cls, triangles: NDArray[np.integer]) -> Self:
        """Return triangles alone, shape (triangle, 3), as cells."""
        vertices, lines = (np.zeros((0, width), dtype=np.int64) for width in (1, 2))
        return cls.of(vertices, lines, triangles)

    def __len__(self) -> int:
        return len(self.types)

    def some(self, cells: Indices, number: Indices) -> Self:
        """Return some cells with other numbers of points.

        Args:
            cells: Which, shape (n,).
            number: Of each point, shape (point,).
        """
        first, sizes = self.ends[cells], np.diff(self.ends)[cells]
        rows = np.repeat(first, sizes) + counted_up(sizes)
        return type(self)(self.types[cells], number[self.points[rows]], ends_of(sizes), {}, {})

    def table(self, points: int) -> dict[str, ArrayLike]:
        """Return the columns of a part of so many points by name, as VTKHDF has them.

        They have no unit; counts have the shape (1,), types (cell,), offsets (cell + 1,) and
        connectivity (row,).
        """
        return {
            "NumberOfPoints": [points],
            "NumberOfCells": [len(self)],
            "NumberOfConnectivityIds": [len(self.points)],
            "Types": self.types,
            "Offsets": self.ends,
            "Connectivity": self.points,
        }

    def over(self, at: Place, values: NDArray[Any]) -> NDArray[Any]:
        """Return numbers at all cells, elsewhere 0, or -1 of integers.

        Args:
            at: What has the numbers.
            values: Of all that the mesh has of it, in any unit, shape (item, …).

        Returns:
            In the same unit, shape (cell, …).
        """
        is_whole = np.issubdtype(values.dtype, np.integer)
        none, kind = (-1, np.int64) if is_whole else (0.0, values.dtype)
        found = np.full((len(self), *values.shape[1:]), none, dtype=kind)
        found[self.rows[at]] = values[self.items[at]]
        return found

    def of_type(self, kind: int, width: int) -> NDArray[np.integer]:
        """Return the points of the cells of a type, shape (cell, width)."""
        first = self.ends[:-1][self.types == kind]
        return self.points[first[:, None] + np.arange(width)]


class DrawnMesh(Struct, frozen=True, eq=False, dict=True):
    """What frames show while the same exists.

    Attributes:
        mesh: All that they may show.
        cells: What exists of it.
        alive: Entities of the network that exist, shape (entity,).
    """

    mesh: "RecordedMesh"
    cells: Cells
    alive: NDArray[np.bool_]

    @cached_property
    def grid(self) -> CellGrid:
        """The same as VTK has it."""
        return self.mesh.grid(self.cells)

    @property
    def labels(self) -> dict[str, NDArray[Any]]:
        """Return numbers of cells that do not change with time and have no unit.

        The shape is (cell,), or (cell, 3) of directions.
        """
        return {name: self.grid.over(at, each) for name, (at, each) in self.mesh.labels.items()}

    @property
    def node_ids(self) -> Indices:
        """Return the ids of nodes, and -1 of riding points, shape (point,)."""
        ids = self.mesh.network.node_ids[self.mesh.nodes]
        return np.append(ids, np.full(self.cells.points - len(ids), -1))


class RecordedMesh(Struct, frozen=True, eq=False, dict=True):
    """The part of a network that frames show.

    A triangle of the skin vanishes with the first of its edges that tears, or with the element
    that it belongs to: a cut opens the skin along the cut springs (see
    ``tissuec/geometry/edges.py`` for edges without springs).

    Attributes:
        network: The whole.
        nodes: Network numbers of the nodes shown, shape (node,).
        line_numbers: Network numbers of the springs and edges shown, shape (line,).
        lines: Ends of those as rows of ``nodes``, shape (line, 2).
        triangles: Triangles among those nodes, as rows of ``nodes``, shape (triangle, 3).
        faces: Numbers of these triangles in the skin of the network, shape (triangle,).
        solids: The solid elements of bodies that are shown as a whole, as rows of ``nodes``,
            followed by the tetrahedra of their parts.
        elements: Numbers of these elements, and of the parts that there can be, among all
            ``solid_entities``, shape (item,).
        all_solids: All solid elements, with the nodes of the network.
        with_skin: Whether VTK shows the skins of solid elements, too, as their triangles have
            numbers.
        cut: Parts of elements that were cut; None before the first cut.
    """

    network: Network
    nodes: NDArray[np.integer]
    line_numbers: NDArray[np.integer]
    lines: NDArray[np.integer]
    triangles: NDArray[np.integer]
    faces: Indices
    solids: ElementCells
    elements: Indices
    all_solids: ElementCells
    with_skin: bool = False
    cut: RecordedCutCells | None = None

    @classmethod
    def of(
        cls,
        network: Network,
        nodes: NDArray[np.integer],
        line_numbers: NDArray[np.integer],
        solids: ElementCells | None = None,
        *,
        with_skin: bool = False,
    ) -> "RecordedMesh":
        """Return the part of a network with some nodes and springs.

        Args:
            network: The whole.
            nodes: Ascending indices, shape (node,).
            line_numbers: Ascending indices, shape (line,).
            solids: All solid elements of a network that was read from a file, which has none
                of its own.
            with_skin: As for the class.

        Raises:
            ValueError: Numbers do not ascend within the network, or a line ends elsewhere.
        """
        nodes = _ascending(nodes, network.node_count, "node")
        line_numbers = _ascending(line_numbers, network.line_count, "line")
        row = np.full(network.node_count, -1, dtype=np.int32)
        row[nodes] = np.arange(len(nodes), dtype=np.int32)
        # Of a network that is recorded as a whole, its own array serves.
        ends, count = network.line_ends, network.line_count
        whole = len(nodes) == network.node_count and len(line_numbers) == count
        lines = ends if whole else row[ends[line_numbers]].reshape(-1, 2)
        if (lines < 0).any():
            line = line_numbers[(lines < 0).any(axis=1)][0]
            raise ValueError(f"line {line} is recorded, but not both of its ends are")
        faces = np.flatnonzero((row[network.skin] >= 0).all(axis=1))
        triangles = row[network.skin[faces].reshape(-1, 3)]
        solids = ElementCells.of(network) if solids is None else solids
        bodies = np.array([body.nodes.stop for body in network.bodies])
        partial = np.zeros(len(bodies) + 1, dtype=bool)
        partial[np.searchsorted(bodies, np.flatnonzero(row < 0), side="right")] = True
        elements = np.flatnonzero(
            ~partial[np.searchsorted(bodies, solids.firsts, side="right")]
        )
        own = solids.some(elements)
        own = replace(own, nodes=row[own.nodes])
        reserved, of = reserved_entities(network, solids.entities)
        if len(reserved):
            shown = np.flatnonzero(~partial[of])
            elements = np.concatenate([elements, len(solids) + shown])
        return cls(
            network, nodes, line_numbers, lines, triangles, faces, own, elements, solids,
            with_skin,
        )  # fmt: skip

    def with_cut_cells(self, table: CutCells | None) -> "RecordedMesh":
        """Return this with the parts of elements of a table, in place of others."""
        if table is None:
            return self
        whole = self.solids.some(np.flatnonzero(self.solids.types != PIECE))
        items: Indices = np.full(self.network.entity_count, -1)
        items[self.solid_entities[self.elements]] = np.arange(len(self.elements))
        cut = RecordedCutCells.of(table, self.nodes, items, whole)
        return replace(self, cut=cut, solids=whole.followed_by(cut.pieces))

    @cached_property
    def solid_entities(self) -> Indices:
        """Entities of solid elements, then of parts that there can be, shape (item,)."""
        reserved, _ = reserved_entities(self.network, self.all_solids.entities)
        return np.concatenate([self.all_solids.entities, reserved]).astype(np.int64)

    @property
    def points(self) -> int:
        """Return how many points frames have after the last cut: nodes, and riding points."""
        return len(self.nodes) + (0 if self.cut is None else len(self.cut.sums))

    @property
    def numbers_of_points(self) -> Indices:
        """Return network numbers of nodes, continued by riding points, shape (point,)."""
        nodes = self.nodes.astype(np.int64)
        if self.cut is None:
            return nodes
        return np.concatenate([nodes, self.network.node_count + self.cut.riding])

    @cached_property
    def representatives(self) -> Indices:
        """Return numbers of nodes, and of main hosts of riding points, shape (point,)."""
        nodes = self.nodes.astype(np.int64)
        if self.cut is None:
            return nodes
        return np.concatenate([nodes, nodes[self.cut.sums.main_hosts]])

    @cached_property
    def are_matter(self) -> NDArray[np.bool_]:
        """Which points are places of matter, or may be, shape (point,).

        Nodes that parts have on the far side of a cut are not.
        """
        found = np.ones(self.points, dtype=bool)
        if self.network.phantoms:
            found[: len(self.nodes)] = self._may_be_lonely
        if self.cut is not None:
            found[self.cut.pieces.nodes] = True
            found[self.cut.triangles] = True
        return found

    def at_points(self, values: NDArray[Any], channel: FieldChannel) -> NDArray[Any]:
        """Return numbers of nodes with those of riding points behind them, shape (point, …).

        Args:
            values: Of recorded nodes in the unit of the channel, shape (node, …).
            channel: What they are.
        """
        return values if self.cut is None else self.cut.beside(values[None], channel)[0]

    @cached_property
    def items(self) -> Indices:
        """The place among ``elements`` of each cell of ``solids``, shape (cell,)."""
        if self.cut is None:
            return np.arange(len(self.solids))
        whole = len(self.solids) - len(self.cut.items)
        return np.concatenate([np.arange(whole), self.cut.items])

    @property
    def labels(self) -> dict[str, tuple[Place, NDArray[Any]]]:
        """Return numbers that do not change with time, with the cells that have them, by name.

        They have no unit and the shape (item,), or (item, 3) of directions.
        """
        own = self.solids.labels if len(self.solids) else {}
        of_solids = {name: ("element", self._of_items(each)) for name, each in own.items()}
        if len(self.solids) and not self.drawn("spring"):
            return of_solids
        return {"spring_id": ("spring", self.network.springs.ids[self.springs]), **of_solids}

    def _of_items(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return labels of cells as those of elements and parts, shape (item, …)."""
        if len(self.elements) == len(values):
            return values
        found = np.zeros((len(self.elements), *values.shape[1:]), dtype=values.dtype)
        found[self.items] = values
        return found

    @cached_property
    def _is_solid(self) -> NDArray[np.bool_]:
        """Which points belong to bodies that are shown by their elements, shape (point,)."""
        found = np.zeros(self.points, dtype=bool)
        found[self.solids.nodes] = True
        return found

    @property
    def springs(self) -> NDArray[np.integer]:
        """Network numbers of the springs shown, which VTK has as lines, shape (spring,)."""
        return self.line_numbers[self.line_numbers < self.network.spring_count]

    @cached_property
    def are_faces(self) -> NDArray[np.bool_]:
        """Which triangles VTK shows: none of the skins of solid elements, shape (triangle,)."""
        if self.with_skin:
            return np.ones(len(self.triangles), dtype=bool)
        return ~self._is_solid[self.triangles].all(axis=1)

    @cached_property
    def _skin(self) -> SupportedTriangles:
        skin, every = self.network.skin[self.faces], self.network.skin_elements
        own = None if every is None else every[self.faces]
        return SupportedTriangles(self.network.line_ends, skin.astype(np.int64), own)

    @cached_property
    def _may_be_lonely(self) -> NDArray[np.bool_]:
        """Which nodes are drawn where nothing touches them: no phantoms, shape (node,)."""
        return self.network.parents[self.nodes] == self.nodes

    def cells(self, alive: NDArray[np.bool_], points: int | None = None) -> Cells:
        """Return the cells that are drawn at a time.

        Args:
            alive: Entities that exist, shape (entity,).
            points: How many points there are; all by default.
        """
        shown = alive[self.line_numbers]
        everything = slice(None) if shown.all() else shown  # which copies nothing
        lines, numbers = self.lines[everything], self.line_numbers[everything]
        faces = np.flatnonzero(self._skin.whole(alive))
        triangles, elements = self.triangles[faces], np.flatnonzero(alive[self.solids.entities])
        borders = np.zeros(0, dtype=np.int64)
        if self.cut is not None:
            borders = np.flatnonzero(alive[self.cut.borders])
            triangles = np.concatenate([triangles, self.cut.triangles[borders]])
        lonely = np.ones(self.points, dtype=bool)
        lonely[lines] = False
        lonely[triangles] = False
        lonely[self.solids.some(elements).nodes] = False
        lonely = lonely[: len(self.nodes)]
        if self.network.phantoms:
            lonely &= self._may_be_lonely
        vertices = np.flatnonzero(lonely)[:, None]
        count = self.points if points is None else points
        return Cells(vertices, lines, triangles, numbers, faces, elements, borders, count)

    def grid(self, cells: Cells) -> CellGrid:
        """Return the cells by which VTK shows others."""
        count = int(np.searchsorted(cells.line_numbers, self.network.spring_count))
        faces = self.are_faces[cells.faces]
        shown = faces
        if self.cut is not None:
            shown = np.append(faces, self.with_skin | self.cut.are_bare[cells.borders])
        return CellGrid.of(
            cells.vertices,
            cells.lines[:count],
            cells.triangles[shown],
            self.solids.some(cells.elements),
            {
                "spring": np.searchsorted(self.line_numbers, cells.line_numbers[:count]),
                "triangle": cells.faces[faces],
                "element": self.items[cells.elements],
            },
        )

    def drawn(self, at: Place) -> int:
        """Return how many springs, triangles or elements VTK shows before anything is gone."""
        if at == "element":
            return len(self.solids)
        return len(self.springs) if at == "spring" else int(self.are_faces.sum())

    def numbers(self, at: Place) -> NDArray[np.integer]:
        """Return the number of each recorded item among all of its kind, shape (item,)."""
        of_place: Mapping[Place, NDArray[np.integer]] = {
            "node": self.nodes, "spring": self.springs, "triangle": self.faces,
            "element": self.elements,
        }  # fmt: skip
        return of_place[at]


def _ascending(numbers: NDArray[np.integer], count: int, what: str) -> NDArray[np.integer]:
    numbers = np.asarray(numbers).reshape(-1)
    inside = not len(numbers) or (numbers[0] >= 0 and numbers[-1] < count)
    if not inside or (numbers[1:] <= numbers[:-1]).any():
        raise ValueError(f"{what} numbers must ascend and be less than {count}")
    return numbers


def mesh_of(
    network: Network, recording: Recording, solids: ElementCells | None = None
) -> RecordedMesh:
    """Return the part of a network in the frames of a recording; see ``RecordedMesh.of``."""
    with_skin = any(channel.at == "triangle" for channel in recording.fields)
    return RecordedMesh.of(
        network, recording.nodes, recording.lines, solids, with_skin=with_skin
    )


def everything(network: Network) -> RecordedMesh:
    """Return all that frames could show of a compiled network."""
    nodes = numbers_in(slice(0, network.body_nodes))
    ends = network.line_ends
    return RecordedMesh.of(network, nodes, np.flatnonzero((ends < len(nodes)).all(axis=1)))
