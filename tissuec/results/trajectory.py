"""Reading a result file: data is loaded on request only."""

import shutil
import weakref
from collections.abc import Callable
from functools import cached_property, partial
from pathlib import Path
from typing import Any, Self

import numpy as np

from tissuec.core.scale import AxisUnit, scale_of
from tissuec.core.source import Source
from tissuec.model.cut_cells import CutCells
from tissuec.model.network import BodyPart, Floats, Indices, Network, Provenance
from tissuec.results import ResultError, access
from tissuec.results.access import ResultGroup
from tissuec.results.arrays import (
    read_channels_of_frames,
    read_groups,
    read_network,
    read_solids,
    read_volume_cells,
)
from tissuec.results.checkpoint import Checkpoint, read_checkpoint
from tissuec.results.cut_cells import read_cut_cells
from tissuec.results.datasets import GroupSpec
from tissuec.results.fields import FieldChannel, Place
from tissuec.results.frame_columns import (
    POSITION,
    VELOCITY,
    CellFrames,
    Drawn,
    Frames,
    Numbers,
    OverFrames,
    column_of,
)
from tissuec.results.frames import Sides
from tissuec.results.grid_frames import alive_in
from tissuec.results.kept_open import KeptFile
from tissuec.results.layout import open_result
from tissuec.results.manifest import read_manifest, read_origins
from tissuec.results.mesh import Cells, DrawnMesh, RecordedMesh
from tissuec.results.places import temporary_folder
from tissuec.results.promise import Doubt, Promise, doubts_of
from tissuec.results.recording import (
    Event,
    ExpectationResult,
    NamedGroup,
    WithoutEffect,
    members,
)
from tissuec.results.schema import (
    CELLS,
    COMPANION,
    ENERGIES,
    ERRORS,
    RECORDING,
    SCENE,
    TOOL_FRAMES,
)
from tissuec.results.surface_table import Surfaces
from tissuec.results.tables import Log, Logs, read_events
from tissuec.results.tools import HoldInterval, read_holds
from tissuec.results.volume_cells import VolumeCells


class TemporaryFolder:
    """A folder that is removed along with this object."""

    def __init__(self, path: Path):
        weakref.finalize(self, shutil.rmtree, path, ignore_errors=True)


class Trajectory:
    """A result file, finished or not; use it in a ``with`` statement, or `close` it.

    Data is read on request only, and all numbers are in SI units. Frames number the
    recorded nodes from 0; `nodes` and `springs` are their numbers in the network and `node_ids`
    and `spring_ids` those of the scene. `nodes_of` and `springs_of` find those of a set.

    Args:
        path: The file.
        folder: Removed once nothing of the result can be read.

    Raises:
        ResultError: There is none, or it is truncated, or no result, or of another layout.
    """

    _is_one_of_many = False  # which are not to be open all the time

    def __init__(self, path: Path, *, folder: "TemporaryFolder | None" = None):
        self.path, self._folder = Path(path), folder
        through = partial(KeptFile, keeps=folder) if self._is_one_of_many else None
        self._opened = open_result(self.path, through)
        self._steps: dict[str, Indices] = {}
        self._drawing: tuple[int, DrawnMesh] | None = None  # of the part requested last

    @property
    def _file(self) -> ResultGroup:
        if not self.is_open:
            raise ResultError(f'"{self.path}" is closed; read the data before closing it')
        return self._opened

    @property
    def content(self) -> ResultGroup:
        """The file itself, for those who know its layout."""
        return self._file

    @classmethod
    def open(cls, path: Path) -> Self:
        """Return the result file at ``path``; the errors are those of the class."""
        return cls(path)

    @classmethod
    def temporary(cls, path: Path) -> Self:
        """Return a result whose folder is removed as soon as nothing of it can be read."""
        return cls(path, folder=TemporaryFolder(path.parent))

    def __reduce__(self) -> tuple[Callable[..., "Trajectory"], tuple[object, ...]]:
        """Pickle a result as its path; a temporary one, which nobody else keeps, by content."""
        if self._folder is not None:
            return _received, (type(self), self.path.name, self.path.read_bytes())
        return type(self), (self.path.absolute(),)

    def close(self) -> None:
        """Close the file; what was not read yet can no longer be."""
        if self.is_open:
            self._opened.raw.file.close()

    @property
    def is_open(self) -> bool:
        """Return whether something can still be read."""
        return bool(self._opened.raw)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *failure: object) -> None:
        self.close()

    @cached_property
    def _frame_count(self) -> int:
        steps = access.group(self._file, "VTKHDF/Steps")
        count = access.attribute(steps, "NSteps", int)
        rows = len(access.dataset(steps, "Values"))
        if not 0 <= count <= rows:
            access.damaged(str(self.path), f"it declares {count} frames but has {rows}")
        return count

    @cached_property
    def times(self) -> Floats:
        """Times of the frames [s], shape (frame,)."""
        return access.array(self._file, "VTKHDF/Steps/Values")[: self._frame_count]

    @property
    def is_compressed(self) -> bool:
        """Whether frames are compressed."""
        points: Any = access.dataset(self._file, "VTKHDF/Points").raw
        return points.compression is not None

    @property
    def position(self) -> Frames:
        """Positions [m], shape (frame, node, 3)."""
        return self._at_points(POSITION)

    @property
    def tools(self) -> Frames | None:
        """Positions of the nodes of tools [m], shape (frame, node, 3); see `Network.tools`.

        None where no tool has a shape.
        """
        path = TOOL_FRAMES["position"].path
        if path not in self._file or not self.network.tools:
            return None
        nodes = sum(2 * len(tool.shapes) for tool in self.network.tools)
        rows = access.dataset(self._file, path)
        return Frames(rows, self._frame_count, nodes)

    @cached_property
    def sides(self) -> Sides:
        """The net just before and just after events, at most 64 of them."""
        counts = {one: self._places(one.at) for one in self.channels}
        return Sides(self._file, self.network, len(self.nodes), counts)

    @cached_property
    def holds(self) -> tuple[HoldInterval, ...]:
        """Who held which nodes since when, in order."""
        return read_holds(self._file)

    @property
    def velocity(self) -> Frames:
        """Velocities [m/s], shape (frame, node, 3)."""
        return self._at_points(VELOCITY)

    @property
    def force(self) -> OverFrames:
        """Sums of the spring forces on the nodes [N], shape (frame, node, 3)."""
        return self.fields["force"]

    def _at_points(self, channel: FieldChannel) -> Frames:
        data, first = access.dataset(self._file, column_of(channel).path), None
        if self.cut_cells is not None:
            first = self._starts[: self._frame_count]
        return Frames(data, self._frame_count, len(self.nodes), channel.row, first)

    @cached_property
    def _starts(self) -> Indices:
        """Where the points of each frame begin, shape (frame,)."""
        return access.array(self._file, "VTKHDF/Steps/PointOffsets")

    @cached_property
    def cut_cells(self) -> CutCells | None:
        """The parts of all elements that the run cut; None if it cut none.

        Corners of their tetrahedra and triangles are nodes of the network or riding points,
        which are weighted sums of nodes. ``position`` has the nodes; `points` has both.
        """
        return read_cut_cells(self._file, self.network)

    def points(self, frame: int) -> Numbers:
        """Return positions of recorded nodes and, behind them, of riding points [m].

        Shape (point, 3). Riding points are corners of parts of elements that were cut, as far
        as there are any in this frame; see `cut_cells`. The numbers of all cells of `cells`
        and `drawing` are rows of these positions.

        Args:
            frame: Its number, which may count from the end.
        """
        return self.at_points(POSITION, frame)

    @property
    def tension(self) -> OverFrames:
        """Tensions of the recorded springs [N], shape (frame, spring); NaN once one is gone.

        A spring that is pressed has a negative one.
        """
        return self.fields["tension"]

    @cached_property
    def channels(self) -> tuple[FieldChannel, ...]:
        """The fields that frames contain, besides positions and velocities."""
        return read_channels_of_frames(self._file)

    @cached_property
    def volume_cells(self) -> VolumeCells | None:
        """The cells of preserved volumes; None where no field is about them."""
        return read_volume_cells(self._file)

    @cached_property
    def fields(self) -> dict[str, OverFrames]:
        """Numbers of all fields by name, in their units.

        The shape is (frame, node) or (frame, node, 3), (frame, spring), (frame, triangle),
        (frame, cell) or (frame, element, 6), as rows of `nodes`, `springs`, `triangles`, the
        cells of `volume_cells` or the solid elements of `mesh`. They are NaN of springs,
        triangles and elements from the frame on in which these are gone.
        """
        return {one.name: self.frames_of(one) for one in self.channels}

    def frames_of(self, channel: FieldChannel) -> OverFrames:
        """Return the numbers of a channel over frames, as `fields` has them."""
        count = self._frame_count
        if channel.at == "node":
            return self._at_points(channel)
        if channel.at == "cell":
            data = access.dataset(self._file, CELLS["{field}"].of(field=channel.key).path)
            return Frames(data, count, self._places(channel.at), ())
        dataset, first = None, np.zeros(count, dtype=np.int64)
        if (path := column_of(channel).path) in self._file:
            dataset = access.dataset(self._file, path)
            offsets = f"VTKHDF/Steps/CellDataOffsets/{channel.stored}"
            first = access.array(self._file, offsets)[:count]
        return CellFrames(
            channel, self.position.dtype, dataset, first, self.parts,
            self._places(channel.at), partial(self._drawn, channel.at),
        )  # fmt: skip

    def at_points(self, channel: FieldChannel, frame: int) -> Numbers:
        """Return the numbers that VTK finds at points in a frame, shape (point, …).

        Points are recorded nodes and, behind them, riding points.

        Args:
            channel: Of a field of nodes, or of cells, of which nodes have the mean, or 0.
            frame: Number of the frame.
        """
        if self.cut_cells is None:
            return self._at_points(channel)[frame]
        data = access.dataset(self._file, column_of(channel).path)
        first = self._step("PointOffsets", frame)
        return data.finite(first, first + self._point_count(frame))

    def _point_count(self, frame: int) -> int:
        """Return how many nodes and riding points there are in a frame."""
        part = self._step("PartOffsets", frame)
        return int(access.dataset(self._file, "VTKHDF/NumberOfPoints")[part])

    def _drawn(self, at: Place, frame: int) -> Drawn:
        """Return where the numbers of springs, triangles or elements are in a frame."""
        grid = self.drawing(frame).grid
        return Drawn(len(grid), grid.rows[at], grid.items[at])

    def _places(self, at: Place) -> int:
        """Return how many nodes, springs, elements or others are recorded."""
        if at == "cell":
            return 0 if self.volume_cells is None else self.volume_cells.total
        if at in ("node", "spring"):
            return len(self.nodes if at == "node" else self.springs)
        return len(self.mesh.numbers(at))

    @cached_property
    def mesh(self) -> RecordedMesh:
        """All that frames may show of the network."""
        with_skin = any(channel.at == "triangle" for channel in self.channels)
        solids = read_solids(self._file)
        mesh = RecordedMesh.of(
            self.network, self.nodes, self.lines, solids, with_skin=with_skin
        )
        return mesh.with_cut_cells(self.cut_cells)

    @property
    def triangles(self) -> Indices:
        """Recorded triangles of the skin, numbered as in the frames, shape (triangle, 3)."""
        return self.mesh.triangles.astype(np.int64)

    def shown(self, name: str, frame: int) -> tuple[Numbers, Indices]:
        """Return the numbers of a field that a frame shows, in its unit, and whose they are.

        Args:
            name: Of a field of springs, triangles or elements.
            frame: Number of the frame; it may count from the end, as in NumPy.

        Returns:
            Numbers, and rows of `ends`, `triangles` or the elements of `mesh`, shape
            (shown, …) and (shown,). Parts of elements have one row for each tetrahedron.
        """
        field = self.fields[name]
        assert isinstance(field, CellFrames)
        return field.shown(frame)

    @cached_property
    def parts(self) -> Indices:
        """Number of the topology of each frame, shape (frame,); it only ascends."""
        return access.array(self._file, "VTKHDF/Steps/PartOffsets")[: self._frame_count]

    def cells(self, frame: int) -> Cells:
        """Return the cells that are drawn in frame number ``frame``."""
        return self.drawing(frame).cells

    def drawing(self, frame: int) -> DrawnMesh:
        """Return the cells of frame number ``frame``, also as VTK has them."""
        part = self._step("PartOffsets", frame)
        if self._drawing is None or self._drawing[0] != part:
            alive = alive_in(self._file, part, self.network)
            cells = self.mesh.cells(alive, self._point_count(frame))
            self._drawing = part, DrawnMesh(self.mesh, cells, alive)
        return self._drawing[1]

    def spring_force(self, frame: int) -> tuple[Numbers, Indices]:
        """Return the tensions [N] in a frame, and whose they are as rows of `ends`.

        `tension` has those of all springs, also of the ones that are gone. Both have shape
        (alive,). A frame number may count from the end, as in NumPy.
        """
        return self.shown("tension", frame)

    def _step(self, name: str, frame: int) -> int:
        count = self._frame_count
        if not -count <= frame < count:
            raise IndexError(f"frame {frame} of {count}")
        if name not in self._steps:
            self._steps[name] = access.array(self._file, f"VTKHDF/Steps/{name}")
        return int(self._steps[name][frame % count])

    @cached_property
    def nodes(self) -> Indices:
        """Network numbers of the recorded nodes, ascending, shape (node,)."""
        return access.array(self._file, RECORDING["nodes"].path)

    @cached_property
    def springs(self) -> Indices:
        """Network numbers of the recorded springs, ascending, shape (spring,)."""
        return self.lines[self.lines < self.network.spring_count]

    @cached_property
    def lines(self) -> Indices:
        """Numbers of the recorded springs and edges of elements, ascending, shape (line,)."""
        return access.array(self._file, RECORDING["lines"].path)

    @property
    def node_ids(self) -> Indices:
        """Ids of the recorded nodes, shape (node,)."""
        return self.network.node_ids[self.nodes]

    @property
    def spring_ids(self) -> Indices:
        """Ids of the recorded springs, shape (spring,)."""
        return self.network.springs.ids[self.springs]

    @cached_property
    def ends(self) -> Indices:
        """Node pairs of the recorded lines, numbered as in the frames, shape (line, 2).

        Those of springs come first.
        """
        return np.searchsorted(self.nodes, self.network.line_ends[self.lines]).reshape(-1, 2)

    @cached_property
    def bodies(self) -> dict[str, BodyPart]:
        """The bodies by name, with the slices of their nodes and springs in the network."""
        return {body.name: body for body in self.network.bodies}

    @cached_property
    def groups(self) -> tuple[NamedGroup, ...]:
        """All sets of the scene, tools with a shape, and regions of bodies."""
        return read_groups(self._file)

    @cached_property
    def sets(self) -> dict[str, NamedGroup]:
        """The sets of nodes and springs by name, in network numbers."""
        return {group.name: group for group in self.groups if not group.body}

    def nodes_of(self, name: str) -> Indices:
        """Return the nodes of a set or body as rows of the frames, shape (node,).

        ``trajectory.position[:, trajectory.nodes_of("waist")]`` is how they moved. A region is
        named with its body: "scar of liver".

        Raises:
            ValueError: There is none of that name, or the frames do not show all of it.
        """
        nodes = members(self.network, self.groups, name, "nodes")
        return self._rows(name, nodes, self.nodes, "nodes")

    def springs_of(self, name: str) -> Indices:
        """Return the springs of a set, body or joint as rows of `ends`, shape (spring,).

        Of nodes, those with both ends among them. Bodies of elements have edges instead.
        Springs that resist bending are in no frame.

        Raises:
            ValueError: There is none of that name, or the frames do not show all of it.
        """
        springs = members(self.network, self.groups, name, "springs")
        # Of springs between shown nodes, those that resist bending are left out of frames.
        within = np.isin(self.network.line_ends[springs], self.nodes).all(axis=1)
        shown = springs[~within | np.isin(springs, self.lines)]
        return self._rows(name, shown, self.lines, "springs")

    def _rows(self, name: str, wanted: Indices, shown: Indices, what: str) -> Indices:
        """Return where numbers stand among those that the frames show."""
        missing = int(np.isin(wanted, shown, invert=True).sum())
        if missing:
            raise ValueError(
                f'the frames of "{self.path}" do not contain {missing} of {len(wanted)} '
                f"{what} of "
                f'"{name}"; write in the scene: output {{ trajectory of [{name}] every … }}'
            )
        return np.searchsorted(shown, wanted)

    @cached_property
    def network(self) -> Network:
        """The whole network as it was before the run; its provenance is `provenance`."""
        return read_network(self._file, Source(self.path.name, self.text))

    @cached_property
    def sources(self) -> dict[str, Source]:
        """The texts that the run was made of, by name; the scene is the last one."""
        texts = {**self.manifest.get("sources", {}), self.scene: self.text}
        return {name: Source(name, text) for name, text in texts.items()}

    @cached_property
    def provenance(self) -> dict[str, Provenance]:
        """Which place of the text gave each number of an array of the network, by its name."""
        return read_origins(self._file, self.sources)

    @cached_property
    def logs(self) -> Logs:
        """All logs by name."""
        return Logs(self._file)

    @property
    def last_time(self) -> float:
        """The last time of which the result holds anything [s]; 0 if it holds nothing."""
        logs = [*self.logs.values(), *filter(None, [self.energies])]
        times = [self.times, *(log.time for log in logs)]
        return max((float(time[-1]) for time in times if len(time)), default=0.0)

    @cached_property
    def clock(self) -> AxisUnit:
        """The unit of times on axes, pages and in CSV."""
        return scale_of("s", [self.last_time])

    @cached_property
    def surfaces(self) -> Surfaces:
        """All smooth surfaces by the names of their bodies."""
        return Surfaces(self._file)

    @cached_property
    def energies(self) -> Log | None:
        """The energies over time [J]; None if they were not recorded."""
        return self._log(ENERGIES)

    @cached_property
    def errors(self) -> Log | None:
        """The errors of positions at the frames, as estimated by steps [m]; None without."""
        return self._log(ERRORS)

    @cached_property
    def promise(self) -> Promise:
        """Return whether positions are as accurate as the tolerance asks for."""
        return Promise.of(self.manifest)

    @cached_property
    def doubts(self) -> tuple[Doubt, ...]:
        """What makes numbers of the run doubtful; empty if nothing was found."""
        return doubts_of(self.manifest)

    @cached_property
    def without_effect(self) -> tuple[WithoutEffect, ...]:
        """Orders of the scene that changed nothing; empty of a run that is not done."""
        written = self.manifest.get("without_effect", ())
        return tuple(WithoutEffect(**one) for one in written)

    @property
    def companion(self) -> Log | None:
        """How far the run was from one with smaller steps until a time [m]; None without."""
        return self._log(COMPANION)

    def _log(self, group: GroupSpec) -> Log | None:
        return Log(self._file, group.path) if group.path in self._file else None

    @cached_property
    def events(self) -> tuple[Event, ...]:
        """Everything that happened, in order."""
        return read_events(self._file)

    @cached_property
    def manifest(self) -> dict[str, Any]:
        """Where the result comes from: versions, method, digest, outcome, …"""
        return read_manifest(self._file)

    @property
    def scene(self) -> str:
        """What the file of the scene was called when it was run."""
        return self.manifest.get("scene", self.path.name)

    @cached_property
    def expectations(self) -> tuple[ExpectationResult, ...]:
        """What became of each ``expect`` of the scene; nothing before the run has ended."""
        names = ExpectationResult.__struct_fields__
        rows = self.manifest.get("expectations", ())
        return tuple(ExpectationResult(*(row[name] for name in names)) for row in rows)

    @property
    def outcome(self) -> str:
        """How the run ended, as a sentence."""
        return self.manifest["outcome"]

    @property
    def finished(self) -> bool:
        """Whether the run went to its end."""
        return self.manifest["finished"]

    def checkpoint(self) -> Checkpoint | None:
        """Return the state to resume from; None if the run never kept one."""
        return read_checkpoint(self._file)

    @cached_property
    def text(self) -> str:
        """The scene as it was run."""
        return access.text(self._file, SCENE.path)

    def save(self, path: Path | str) -> Path:
        """Copy the file to another place, with the views of its surfaces, and return its path.

        Raises:
            PlaceError: It cannot stand there, or something else does.
        """
        from tissuec.results.paraview import copy_result

        return copy_result(self.path, Path(path), self.surfaces)


def _received(kind: type[Trajectory], name: str, content: bytes) -> Trajectory:
    """Return a temporary result that came from another process."""
    path = temporary_folder() / name
    path.write_bytes(content)
    return kind.temporary(path)
