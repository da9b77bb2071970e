"""Which blocks a result has, and what each of them draws in each frame.

A *cloud* is what the points of blocks are: the nodes of a body, of a joint, or those that a
tool holds, or the corners of what is seen of a tool. The springs, the skin and the single nodes
of a body are blocks of one cloud.
"""

from collections.abc import Iterator, Mapping, Sequence
from itertools import count
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.model.network import Indices, numbers_in
from tissuec.results.blocks.anatomy import Anatomy, BodyMatter
from tissuec.results.blocks.poses import ToolMesh, tool_meshes
from tissuec.results.fields import Place
from tissuec.results.mesh import CellGrid, DrawnMesh, RecordedMesh
from tissuec.results.trajectory import Trajectory

Kind: TypeAlias = Literal["body", "joint", "tool", "grip"]
Draws: TypeAlias = Literal["Vertices", "Lines", "Polygons", "Solids"]
_PLACES: Mapping[str, Place] = {"Polygons": "triangle", "Solids": "element"}
_NO_NAMES = ("Assembly", "Steps", "FieldData", "PointData", "CellData")  # of VTKHDF itself


class Cloud(Struct, frozen=True, eq=False):
    """The points of one or several blocks.

    Attributes:
        name: Of the body, joint or tool.
        kind: "body", "joint", "tool" for what is seen of one, "grip" for the nodes that one
            without a shape holds.
        number: Among the bodies and, behind them, the tools; of a joint -1.
        nodes: Network numbers of the points while they are the same, continued by those of
            riding points, shape (point,) each; of tools, from 0 on.
        of_frame: Which of ``nodes`` are shown in each frame, shape (frame,).
        lines: Range of the springs or edges of elements that belong to it.
        matter: Where strain and stress are known.
        mesh: Of a tool.
    """

    name: str
    kind: Kind
    number: int
    nodes: tuple[Indices, ...]
    of_frame: Indices
    lines: slice = slice(0, 0)
    matter: BodyMatter | None = None
    mesh: ToolMesh | None = None


class Piece(NamedTuple):
    """What a block draws while it stays the same; points are numbered within the cloud.

    Attributes:
        points: Number of points.
        grid: The cells.
        springs: Network number of the spring of each line, shape (line,).
        first: Where the cells begin among those that the result draws then.
    """

    points: int
    grid: CellGrid
    springs: NDArray[np.integer]
    first: int

    def same_as(self, other: "Piece") -> bool:
        """Return whether both draw the same."""
        return (
            (self.points, self.first) == (other.points, other.first)
            and np.array_equal(self.springs, other.springs)
            and np.array_equal(self.grid.types, other.grid.types)
            and np.array_equal(self.grid.points, other.grid.points)
        )


class ResultBlock(Struct, frozen=True, eq=False):
    """One part of a result.

    Attributes:
        name: Unique; letters, digits and underscores, for older versions of VTK.
        title: Name of the body, joint or tool, and which part of it this is.
        cloud: Its points.
        draws: Which cells.
        pieces: What it draws in turn.
        of_frame: Which of them is drawn in each frame, shape (frame,).
    """

    name: str
    title: str
    cloud: Cloud
    draws: Draws
    pieces: tuple[Piece, ...]
    of_frame: Indices

    def has(self, at: str) -> bool:
        """Return whether it shows numbers at "points", "lines", "triangles" or "elements"."""
        of_cells = {"Lines": "lines", "Polygons": "triangles", "Solids": "elements"}
        return at == "points" or at == of_cells.get(self.draws)


class Names:
    """Gives names that VTK takes, each once."""

    def __init__(self, given: Sequence[str] = ()) -> None:
        self._given: set[str] = {name.lower() for name in (*_NO_NAMES, *given)}

    def plain(self, title: str) -> str:
        """Return a name with ASCII letters, digits and underscores alone."""
        words = "".join(c if c.isascii() and c.isalnum() else "_" for c in title)
        words = words if words[:1].isalpha() else f"_{words}"
        tries = (words if n == 1 else f"{words}_{n}" for n in count(1))
        name = next(one for one in tries if one.lower() not in self._given)
        self._given.add(name.lower())
        return name


def blocks_of(trajectory: Trajectory, anatomy: Anatomy | None) -> tuple[ResultBlock, ...]:
    """Return the blocks of a result, in the order of the scene; surfaces are not among them.

    Args:
        trajectory: A result with frames.
        anatomy: Of its scene; None where that is not known.
    """
    clouds = list(_clouds(trajectory, anatomy))
    drawn = [
        _Drawing(cloud, draws, f"{cloud.name} {part}".strip())
        for cloud in clouds
        for draws, part in _parts(cloud, trajectory.mesh)
    ]
    former = -1
    for frame, part in enumerate(trajectory.parts.tolist()):
        drawing = trajectory.drawing(frame) if part != former else None
        former = part
        for one in drawn:
            one.add(drawing, frame)
    names = Names()
    return tuple(
        ResultBlock(
            names.plain(one.title), one.title, one.cloud, one.draws,
            *one.in_order(),
        )
        for one in drawn
        if one.cloud.kind in ("tool", "grip") or any(len(piece.grid) for piece in one.pieces)
    )  # fmt: skip


def _parts(cloud: Cloud, mesh: RecordedMesh) -> Sequence[tuple[Draws, str]]:
    """Return the kinds of blocks of a cloud, and the endings of their names."""
    if cloud.kind == "tool":
        return (("Polygons", ""),)
    if cloud.kind == "grip":
        return (("Vertices", "held"),)
    if cloud.kind != "body" or cloud.name in mesh.network.threads:
        return (("Lines", ""),)
    parts: list[tuple[Draws, str]] = [("Polygons", "skin"), ("Vertices", "nodes")]
    if np.isin(mesh.numbers_of_points[mesh.solids.firsts], cloud.nodes[0]).any():
        return [("Solids", "solid"), *parts]
    return (
        parts
        if mesh.network.bodies[cloud.number].is_made_of_elements
        else [("Lines", "springs"), *parts]
    )


class _Drawing:
    """A block whose pieces are collected frame after frame."""

    def __init__(self, cloud: Cloud, draws: Draws, title: str):
        self.cloud, self.draws, self.title = cloud, draws, title
        self.pieces: list[Piece] = []
        self.of_frame: list[int] = []

    def add(self, drawing: DrawnMesh | None, frame: int) -> None:
        """Add a frame.

        Args:
            drawing: What it draws; None if that is what the frame before draws.
            frame: Its number.
        """
        cloud = self.cloud
        held = int(cloud.of_frame[frame])
        moved = not frame or held != int(cloud.of_frame[frame - 1])
        if moved or (drawing is not None and cloud.kind in ("body", "joint")):
            piece = self._piece(drawing, held)
            if not self.pieces or not piece.same_as(self.pieces[-1]):
                self.pieces.append(piece)
        self.of_frame.append(len(self.pieces) - 1)

    def in_order(self) -> tuple[tuple[Piece, ...], Indices]:
        """Return the pieces, those that draw nothing last, and which each frame shows.

        From version 9.5 on, VTK counts the pieces before one by the cells that they draw.
        """
        order = sorted(range(len(self.pieces)), key=lambda n: not len(self.pieces[n].grid))
        place = np.argsort(order)
        return tuple(self.pieces[n] for n in order), place[self.of_frame]

    def _piece(self, drawing: DrawnMesh | None, variant: int) -> Piece:
        nodes = self.cloud.nodes[variant]
        none, springs = np.zeros((0, 3), dtype=np.int64), np.zeros(0, dtype=np.int64)
        if self.cloud.mesh is not None:
            skin = self.cloud.mesh.triangles(variant)
            return Piece(len(nodes), CellGrid.of_triangles(skin), springs, 0)
        if self.cloud.kind == "grip":
            held = CellGrid.of(np.arange(len(nodes))[:, None], none[:, :2], none)
            return Piece(len(nodes), held, springs, 0)
        assert drawing is not None
        grid, mesh = drawing.grid, drawing.mesh
        numbers = mesh.numbers_of_points
        row = np.full(int(max(numbers.max(), nodes.max(initial=0))) + 1, -1)
        row[nodes] = np.arange(len(nodes))
        row = row[numbers]
        if self.draws == "Lines":
            every = mesh.springs[grid.items["spring"]]
            within = self.cloud.lines.start, self.cloud.lines.stop
            low, high = np.searchsorted(every, within).tolist()
            springs = every[low:high].astype(np.int64)
            own = np.arange(low, high) + grid.rows["spring"].start
        else:
            at = _PLACES.get(self.draws)
            rows = grid.rows[at] if at else slice(0, grid.rows["spring"].start)
            if at == "triangle" and not mesh.with_skin:  # also those of parts, without numbers
                rows = slice(rows.start, grid.rows["element"].start)
            own = np.arange(rows.start, rows.stop)
            own = own[row[grid.points[grid.ends[own]]] >= 0]
        has_numbers = self.draws in ("Lines", "Solids") and len(own)
        first = int(own[0]) if has_numbers else 0
        return Piece(len(nodes), grid.some(own, row), springs, first)


def own_elements(drawing: DrawnMesh, row: Indices) -> Indices:
    """Return which elements that exist belong to a cloud, shape (element,).

    Args:
        drawing: What exists.
        row: The point of the cloud of each point of frames, or -1, shape (point,).
    """
    elements = drawing.mesh.solids.some(drawing.cells.elements)
    return np.flatnonzero(row[elements.firsts] >= 0)


def _clouds(trajectory: Trajectory, anatomy: Anatomy | None) -> Iterator[Cloud]:
    network, shown = trajectory.network, trajectory.nodes
    always = np.zeros(len(trajectory.times), dtype=np.int64)
    matter: Mapping[str, BodyMatter] = {} if anatomy is None else anatomy.matter
    for number, body in enumerate(network.bodies):
        low, high = np.searchsorted(shown, (body.nodes.start, body.nodes.stop))
        if high > low:
            is_whole = high - low == body.nodes.stop - body.nodes.start
            own = matter.get(body.name) if is_whole else None
            nodes, of_frame = _with_riding(trajectory, shown[low:high])
            yield Cloud(body.name, "body", number, nodes, of_frame, body.lines, own)
    for joint in network.joints:
        springs = np.intersect1d(numbers_in(joint.springs), trajectory.springs)
        if len(springs):
            nodes = (np.unique(network.line_ends[springs]).astype(np.int64),)
            yield Cloud(joint.name, "joint", -1, nodes, always, joint.springs)
    meshes = tool_meshes(trajectory, anatomy.tools if anatomy else {})
    for number, mesh in enumerate(meshes, start=len(network.bodies)):
        nodes = tuple(np.arange(mesh.size(variant)) for variant in range(len(mesh.variants)))
        yield Cloud(mesh.name, "tool", number, nodes, mesh.of_frame, mesh=mesh)
        grip = _grip(trajectory, mesh.name, number)
        if any(map(len, grip.nodes)):
            yield grip


def _with_riding(trajectory: Trajectory, nodes: Indices) -> tuple[tuple[Indices, ...], Indices]:
    """Return the points of a body as more and more elements are cut, and those of each frame.

    Args:
        nodes: The recorded nodes of the body, ascending, shape (node,).
    """
    mesh, frames = trajectory.mesh, len(trajectory.times)
    if mesh.cut is None:
        return (nodes,), np.zeros(frames, dtype=np.int64)
    count, riding = len(mesh.nodes), mesh.numbers_of_points[len(mesh.nodes) :]
    own = np.isin(mesh.representatives[count:], nodes)
    counts = np.cumsum(np.append(0, own))
    points = [trajectory.cells(frame).points - count for frame in range(frames)]
    shown, of_frame = np.unique(counts[points], return_inverse=True)
    return tuple(np.append(nodes, riding[own][:n]) for n in shown), of_frame.reshape(-1)


def _grip(trajectory: Trajectory, name: str, number: int) -> Cloud:
    """Return the nodes that a tool without a shape holds, as far as frames show them."""
    none = np.zeros(0, dtype=np.int64)
    held, since = [none], [-np.inf]
    for hold in trajectory.holds:
        if hold.holder == name:
            held.append(np.intersect1d(hold.nodes, trajectory.nodes))
            since.append(hold.time)
    of_frame = np.searchsorted(since, trajectory.times, side="right") - 1
    shown, of_frame = np.unique(of_frame, return_inverse=True)
    nodes = tuple(held[int(n)] for n in shown)
    return Cloud(name, "grip", number, nodes, of_frame.astype(np.int64))
