"""Writing a result file while a scene runs, safe against kills, full disks and bad numbers."""

import time as clock
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from tissuec.core.source import Source
from tissuec.model.cut_cells import CutCells
from tissuec.model.network import Indices, Network
from tissuec.results import ResultError, access
from tissuec.results.arrays import (
    read_network,
    read_recording,
    read_solids,
    write_groups,
    write_network,
    write_recording,
)
from tissuec.results.checkpoint import (
    Checkpoint,
    Value,
    scene_digest,
    truncate,
    write_checkpoint,
)
from tissuec.results.cut_cells import CutCellTable
from tissuec.results.frames import FrameRecorder, SideTable
from tissuec.results.grid_frames import GridFrames
from tissuec.results.h5md import add_views, remove_views
from tissuec.results.layout import check_replaceable, mark_layout, open_result
from tissuec.results.manifest import (
    RUNNING,
    first_manifest,
    read_manifest,
    write_manifest,
    write_origins,
)
from tissuec.results.mesh import RecordedMesh, mesh_of
from tissuec.results.paraview import check_views, write_views
from tissuec.results.places import check_place, final_path, partial_path
from tissuec.results.recording import Event, EventSide, NamedGroup, Recording
from tissuec.results.schema import COMPANION, CUT_CELLS, ENERGIES, ERRORS, SCENE, SIDES
from tissuec.results.store import Store
from tissuec.results.surface_table import SurfaceTable
from tissuec.results.tables import DISTANCE, ENERGY, ERROR, EventTable, LogTable, log_tables
from tissuec.results.tools import HoldTable, ToolTable

_MOST_WAITING = 8 << 20  # [byte]
_LONGEST_WAIT = 2.0  # [s]: what a kill may cost at most


class ResultWriter:
    """A result file that is being written; use it in a ``with`` statement.

    Everything goes to ``<stem>.partial.vtkhdf``, which opens at any moment and holds all that
    was flushed; `close` gives it its final name. Rows are flushed in batches, and at the latest
    two seconds after the former flush when more rows come.

    Args:
        path: The final name of the file.
        network: The compiled scene.
        recording: What is recorded.
        manifest: Facts about the run: "method", "plan", "overrides", "author", …
        scene_text: The scene as it was run.
        groups: Sets and regions.

    Attributes:
        views: Files that show the surfaces of the finished result, by the names of the bodies.

    Raises:
        ResultError: The file cannot be written there.
        ValueError: ``recording`` does not fit ``network``.
    """

    def __init__(
        self,
        path: Path,
        network: Network,
        recording: Recording,
        manifest: Mapping[str, object],
        scene_text: str,
        groups: Sequence[NamedGroup] = (),
    ):
        mesh = mesh_of(network, recording)
        _check_names(recording)
        check_place(Path(path))
        check_replaceable(Path(path))
        check_views(Path(path), [channel.body for channel in recording.surfaces])
        store = Store(partial_path(Path(path)), "create")
        try:
            mark_layout(store.file)
            store.array(SCENE[""], scene_text)
            write_network(store, network)
            write_origins(store, network.provenance)
            write_groups(store, groups)
            write_recording(store, recording)
            digest = scene_digest(scene_text, network)
            self._begin(store, network, recording, mesh, digest)
            self._manifest = first_manifest(manifest, scene_text)
            write_manifest(store, self._manifest)
            self.flush()
        except BaseException:
            store.abandon(remove=True)
            raise

    @classmethod
    def resume(cls, path: Path, checkpoint: Checkpoint) -> Self:
        """Return a writer that continues a partial file from its checkpoint.

        Whatever was written after the checkpoint is cut off, so that the file becomes the one
        that an uninterrupted run would have written.

        Args:
            path: The partial file, or the final name.
            checkpoint: What `Trajectory.checkpoint` returned for that file.

        Raises:
            ResultError: The file is missing, no result, or not the one of the checkpoint.
        """
        partial = partial_path(Path(path))
        open_result(partial).raw.file.close()
        check_replaceable(partial)
        store = Store(partial, "update")
        try:
            with access.reading(str(partial), "/"):
                truncate(store, checkpoint)
                writer = cls.__new__(cls)
                writer._take_up(store, checkpoint)
            writer.topology(checkpoint.alive)
            writer.flush()
        except BaseException:
            store.abandon()
            raise
        return writer

    def _take_up(self, store: Store, checkpoint: Checkpoint) -> None:
        """Set up all that a file holds; what a run that had ended said is left out."""
        if COMPANION.path in store.file:
            store.remove(COMPANION.path)
        remove_views(store.file)
        for late, first in ((SIDES, "time"), (CUT_CELLS, "parts")):
            if late.path in store.file and late[first].path not in checkpoint.rows:
                store.remove(late.path)
        source = Source(store.path.name, access.text(store.content, SCENE.path))
        network, recording = read_network(store.content, source), read_recording(store.content)
        mesh = mesh_of(network, recording, read_solids(store.content))
        check_views(store.path, [channel.body for channel in recording.surfaces])
        former = read_manifest(store.content)
        running = {"outcome": RUNNING, "finished": False}
        earlier = checkpoint.wall_time
        self._begin(store, network, recording, mesh, checkpoint.scene, earlier=earlier)
        self._manifest = former | dict.fromkeys(former.keys() & {"promise"}) | running
        write_manifest(store, self._manifest)

    def _begin(
        self,
        store: Store,
        network: Network,
        recording: Recording,
        mesh: RecordedMesh,
        scene: str,
        *,
        earlier: float = 0.0,
    ) -> None:
        """Set up all that the content of the file determines; it took ``earlier`` seconds.

        Args:
            scene: Digest of what is run.
        """
        self._store, self._scene = store, scene
        store.compresses = recording.compress
        self._cut_cells = CutCellTable(store, network)
        mesh = mesh.with_cut_cells(self._cut_cells.content)
        self._grids = GridFrames(store, network, recording, mesh)
        tools = ToolTable(store, network, self._grids.columns.kind)
        self._frames = FrameRecorder(network, recording, self._grids, tools)
        self._sides = SideTable(store, network, self._grids.columns)
        self._holds = HoldTable(store, network)
        self._logs = log_tables(store, recording.logs)
        self._energies = LogTable(store, ENERGIES, ENERGY) if recording.energies else None
        self._errors = LogTable(store, ERRORS, ERROR)
        self._events = EventTable(store)
        self._surfaces = {
            channel.body: SurfaceTable(
                store, network, channel, number=number, single=recording.single
            )
            for number, channel in enumerate(recording.surfaces)
        }
        self._fields = recording.fields
        self._identity = {
            "mass": network.mass[mesh.nodes],
            "ids": network.node_ids[mesh.nodes],
        }
        self.views: Mapping[str, Path] = {}
        self._manifest: dict[str, Any] = {}
        self._failure: ResultError | None = None
        self._closed = False
        self._flushed = clock.monotonic()
        self._started = self._flushed - earlier
        self._stopped: float | None = None

    @property
    def cut_cells(self) -> CutCells | None:
        """The parts of elements that were cut so far, also before a run that is resumed."""
        return self._cut_cells.content

    def topology(self, alive: ArrayLike, cut_cells: CutCells | None = None) -> None:
        """Set which entities exist in the frames to come, shape (entity,).

        To be called once before the first frame and after each cut and rupture; a new part of
        the file is made only when a frame follows that looks different.

        Args:
            cut_cells: The parts of elements that were cut: all of those given before, in the
                same order, and more. None if there are no others.

        Raises:
            ValueError: There are fewer parts than before.
        """
        self._check_open()
        grown = self._cut_cells.extend(cut_cells)
        self._frames.set_topology(alive, cut_cells if grown else None)
        for surface in self._surfaces.values():
            surface.set_topology(np.asarray(alive, dtype=bool))
        self._flush_if_due()

    def holds(self, time: float, holders: Mapping[str, Indices]) -> None:
        """Set which nodes are held from a time on [s]; indices by holder, shape (n,)."""
        self._check_open()
        self._holds.set(time, holders)

    def frames(
        self,
        time: ArrayLike,
        position: ArrayLike,
        velocity: ArrayLike,
        fields: Mapping[str, ArrayLike],
    ) -> None:
        """Add frames; all nodes and springs in the order of the network.

        Nothing is kept if the recording has no nodes.

        Args:
            time: [s], shape (frame,).
            position: [m], shape (frame, node, 3).
            velocity: [m/s], shape (frame, node, 3).
            fields: Numbers of the fields of the recording by name, as their members sample
                them; those of dead springs are ignored.

        Raises:
            ValueError: A field is missing, or a number is not finite or does not fit single
                precision; the message names node and time, and none of these frames is
                written.
            ResultError: There is no space on the disk.
        """
        self._check_open()
        self._frames.append(time, {**fields, "position": position, "velocity": velocity})
        self._flush_if_due()

    def awaits_sides(self, time: float, apart: float) -> bool:
        """Return whether the net is to be written on both sides of an event.

        Args:
            time: Of the event [s].
            apart: Least distance from the last event that was written [s].
        """
        return self._sides.awaits(time, apart)

    def sides(self, before: EventSide, after: EventSide) -> None:
        """Add the net just before and just after an event.

        Raises:
            ValueError: A number is not finite.
        """
        self._check_open()
        self._sides.append(before, after)
        self._flush_if_due()

    def surface(self, body: str, time: ArrayLike, position: ArrayLike) -> None:
        """Add frames of the smooth surface of a body.

        Args:
            time: [s], shape (frame,).
            position: Of all nodes in the order of the network [m], shape (frame, node, 3).

        Raises:
            ValueError: No such surface is recorded, or a number is not finite.
            ResultError: There is no space on the disk.
        """
        self._check_open()
        if body not in self._surfaces:
            raise ValueError(f'no surface of "{body}" is recorded')
        table, time, position = self._surfaces[body], np.atleast_1d(time), np.asarray(position)
        for rows in table.batches(len(time)):
            table.append(time[rows], position[rows])
            self._flush_if_due()

    def log(self, channel: str, time: ArrayLike, rows: ArrayLike) -> None:
        """Add rows of shape (moment, column) to a log at ``time`` [s], shape (moment,).

        Numbers need not be finite: the tension of a spring that was cut is none.

        Raises:
            ValueError: There is no such log.
        """
        self._log(channel).append(time, rows)
        self._flush_if_due()

    def log_jump(self, channel: str, time: float, before: ArrayLike, after: ArrayLike) -> None:
        """Add the rows of a log on both sides of an event, shape (column,) each.

        Raises:
            ValueError: There is no such log, or it is too wide for jumps.
        """
        self._log(channel).jump(time, before, after)
        self._flush_if_due()

    def _log(self, channel: str) -> LogTable:
        self._check_open()
        if channel not in self._logs:
            raise ValueError(f'no log is called "{channel}"')
        return self._logs[channel]

    def energies(self, time: ArrayLike, rows: ArrayLike) -> None:
        """Add rows of energies [J], shape (moment, 6), in the order of `ENERGIES`."""
        self._energy_table().append(time, rows)
        self._flush_if_due()

    def energy_jump(self, time: float, before: ArrayLike, after: ArrayLike) -> None:
        """Add the energies on both sides of an event that changed them [J], shape (6,) each."""
        self._energy_table().jump(time, before, after)
        self._flush_if_due()

    def _energy_table(self) -> LogTable:
        self._check_open()
        if self._energies is None:
            raise ValueError("no energies are recorded")
        return self._energies

    def errors(self, time: ArrayLike, rows: ArrayLike) -> None:
        """Add estimated errors of positions in frames [m], shape (moment, 1)."""
        self._check_open()
        self._errors.append(time, rows)
        self._flush_if_due()

    def companion(self, time: ArrayLike, rows: ArrayLike) -> None:
        """Add how far the companion run was from this one [m], if at all, shape (moment, 1)."""
        self._check_open()
        if np.size(time):
            LogTable(self._store, COMPANION, DISTANCE).append(time, rows)

    def event(
        self, time: float, kind: str, springs: Sequence[int], cause: str, place: str
    ) -> None:
        """Add one event; ``springs`` are network numbers."""
        self._check_open()
        self._events.append(Event(float(time), kind, tuple(map(int, springs)), cause, place))
        self._flush_if_due()

    def checkpoint(self, saved: Mapping[str, Value]) -> None:
        """Replace the checkpoint that a run can be resumed from.

        After a kill, the file contains either the previous checkpoint or this one, never a
        mixture.

        Raises:
            ValueError: The topology is not set.
        """
        self._check_open()
        if self._frames.alive is None:
            raise ValueError("state the topology before the first checkpoint")
        rows = self._store.row_counts()
        alive, wall_time = self._frames.alive, self._wall_time()
        write_checkpoint(self._store, Checkpoint(saved, rows, alive, wall_time, self._scene))
        self.flush()

    def flush(self) -> None:
        """Make all that was given so far readable, whatever happens next.

        Raises:
            ResultError: There is no space; the file holds what the last flush left, and nothing
                more can be written.
        """
        self._check_open()
        try:
            self._store.write()
            self._grids.show()
            for surface in self._surfaces.values():
                surface.show()
            self._store.commit()
        except BaseException as error:  # also an interruption in the middle of HDF5's work
            broken = f'writing "{self._store.path}" failed: {error!r}'
            self._failure = error if isinstance(error, ResultError) else ResultError(broken)
            raise
        self._frames.flushed()
        self._flushed = clock.monotonic()

    def close(
        self, outcome: str, finished: bool, facts: Mapping[str, object] | None = None
    ) -> Path:
        """End the file and return its path: the final name only if ``finished``.

        Args:
            outcome: How the run ended, as a sentence.
            finished: Whether it ran to its end; otherwise the file stays a partial one.
            facts: More entries for the manifest, such as "statistics".

        Raises:
            ResultError: The last rows could not be written. The partial file is readable.
        """
        if self._closed:
            raise ResultError(f'"{self._store.path}" is already closed')
        if self._failure is None:
            self._flush_or_end()
        else:
            self._store.rollback()  # what could not be written is given up
        finished = finished and self._failure is None
        end = {"wall_time": self._wall_time(), "outcome": outcome, "finished": finished}
        self._manifest = {**self._manifest, **(facts or {}), **end}
        self._closed = True
        try:
            self._end(final_path(self._store.path) if finished else None)
        except ResultError:
            self._store.abandon()
            if self._failure is None:  # otherwise that the disk is full is known already
                raise
        if not finished:
            return self._store.path
        final = final_path(self._store.path)
        paths = {name: table.path for name, table in self._surfaces.items()}
        self.views = write_views(final, paths)
        return final

    def _flush_or_end(self) -> None:
        """Flush; if that fails, end the file with what it holds, and raise the error."""
        try:
            self.flush()
        except ResultError as error:
            with suppress(ResultError):  # the first error says why
                self.close(f"stopped: {error}", finished=False)
            raise

    def _end(self, name: Path | None) -> None:
        """Write what comes last, and close the file; under another name, if there is one."""
        author = str(self._manifest.get("author", "not stated"))
        add_views(self._store.file, self._fields, author=author, **self._identity)
        write_manifest(self._store, self._manifest)
        try:
            self._store.close(name)
        except OSError as error:
            is_there = self._store.path.exists()
            kept = "the result is complete under the first name" if is_there else "it is lost"
            raise ResultError(
                f'cannot rename "{self._store.path}" to "{name}": {error.strerror}; {kept}'
            ) from error

    def stop_clock(self) -> float:
        """End the wall time of the run, and return it with that of a resumed part [s].

        What follows, such as the estimate of the error, is not counted.
        """
        self._stopped = clock.monotonic()
        return self._wall_time()

    def _wall_time(self) -> float:
        return (self._stopped or clock.monotonic()) - self._started

    def _flush_if_due(self) -> None:
        late = clock.monotonic() - self._flushed >= _LONGEST_WAIT
        if late or self._frames.is_due or self._store.waiting >= _MOST_WAITING:
            self.flush()

    def _check_open(self) -> None:
        if self._failure is not None:
            raise ResultError(str(self._failure))
        if self._closed:
            raise ResultError(f'"{self._store.path}" is already closed')

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._closed:
            return
        if error is None:
            self.close("the run ended without a recorded reason", finished=False)
            return
        interrupted = isinstance(error, KeyboardInterrupt)
        outcome = "interrupted" if interrupted else f"stopped: {error}"
        with suppress(ResultError):  # the error that ended the run says more
            self.close(outcome, finished=False)


def _check_names(recording: Recording) -> None:
    names = [channel.name for channel in recording.logs]
    if len(set(names)) < len(names) or "" in names:
        raise ValueError("every log needs a unique name")
