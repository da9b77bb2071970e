"""The recorded part of the network in frames, and just before and after events.

Between two frames, a reader may interpolate the motion, but not across a cut. So the net is
written twice at the time of an event, in a separate table: frames keep the times that the scene
requests.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tissuec.model.cut_cells import CutCells
from tissuec.model.network import Floats, Network
from tissuec.results import access
from tissuec.results.access import ResultGroup
from tissuec.results.alive import read_alive, row_bytes
from tissuec.results.datasets import DatasetSpec
from tissuec.results.fields import FieldChannel, Place
from tissuec.results.finite import check_finite, check_shape, check_times
from tissuec.results.frame_columns import (
    FRAME_ROWS,
    MOTION,
    POSITION,
    FrameColumns,
    Frames,
    side_of,
)
from tissuec.results.grid_frames import GridFrames
from tissuec.results.mesh import DrawnMesh
from tissuec.results.recording import EventSide, Recording
from tissuec.results.schema import SIDES
from tissuec.results.store import ColumnTable, Store
from tissuec.results.tools import ToolTable


class FrameRecorder:
    """Takes frames of the network and hands those of the recorded part to the file.

    Attributes:
        alive: Which entities are alive, shape (entity,); None until it was said.
        waiting: Frames added since `flushed` was called.
    """

    def __init__(
        self, network: Network, recording: Recording, file: GridFrames, tools: ToolTable
    ):
        mesh = file.mesh
        self._network, self._tools = network, tools
        self._sizes: dict[Place, int] = {
            "node": network.node_count,
            "spring": network.spring_count,
            "triangle": len(network.skin),
            "cell": 0 if recording.cells is None else recording.cells.total,
            "element": len(mesh.solid_entities),
        }
        self._mesh = mesh
        self._file = file
        self._shows: DrawnMesh | None = file.parts.drawn
        # All of them need no look-up.
        whole = len(mesh.nodes) == network.node_count
        self._nodes = slice(network.node_count) if whole else mesh.nodes
        self._last_time = file.last_time()
        self.alive: NDArray[np.bool_] | None = None
        self.waiting = 0

    @property
    def is_due(self) -> bool:
        """Return whether enough frames wait for a batch."""
        return self.waiting >= self._file.columns.batch

    def flushed(self) -> None:
        """Reset the number of waiting frames."""
        self.waiting = 0

    def set_topology(self, alive: ArrayLike, cut_cells: CutCells | None = None) -> None:
        """Set which entities exist from now on; ValueError if the shape is wrong.

        Args:
            alive: Booleans without a unit, shape (entity,).
            cut_cells: Parts of elements that were cut; None if that table has not grown.
        """
        alive = np.array(alive, dtype=bool)
        check_shape(alive, (self._network.entity_count,), "alive")
        self.alive = alive
        self._mesh = self._mesh.with_cut_cells(cut_cells)
        self._shows = DrawnMesh(self._mesh, self._mesh.cells(alive), alive)
        if not self._file.parts.count:  # a file without any frame opens in viewers, too
            self._file.parts.draw(self._shows)

    def append(self, time: ArrayLike, numbers: Mapping[str, ArrayLike]) -> None:
        """Add frames, all or none of them; see `ResultWriter.frames`.

        Args:
            time: Times [s], shape (frame,).
            numbers: Of all channels by name, in their units, shape (frame, node, …) or alike.

        Raises:
            ValueError: The topology is not set, a channel is missing, a shape is wrong, or an
                entry is not finite.
        """
        if not len(self._mesh.nodes):
            return
        if self.alive is None or self._shows is None:
            raise ValueError("state the topology before the first frame")
        times = check_times(time, after=self._last_time)
        found = {one: self._shown(one, numbers, times) for one in self._file.columns.channels}
        shapes = self._tools.checked(np.asarray(numbers[POSITION.name]), times)
        if len(times):
            self._file.append(self._shows, times, found)
            self._tools.append(shapes)
            self._last_time = float(times[-1])
            self.waiting += len(times)

    def _shown(
        self, channel: FieldChannel, given: Mapping[str, ArrayLike], times: Floats
    ) -> NDArray[Any]:
        """Return the checked numbers of a channel that frames show, shape (frame, shown, …).

        Args:
            given: Numbers of the whole network by the names of channels.
            times: Of the frames [s].
        """
        name, at = channel.name, channel.at
        if name not in given:
            raise ValueError(f"frames need the {name} of each {at}")
        data = np.asarray(given[name])
        check_shape(data, (len(times), self._sizes[at], *channel.row), name)
        if at == "node":
            chosen, numbers = self._nodes, self._mesh.nodes
        else:
            numbers = self._numbers(at)
            chosen = slice(None) if len(numbers) == data.shape[1] else numbers
        # Frames that do not wait for others are written before anybody changes them.
        waits = self._file.columns.batch > 1
        with np.errstate(over="ignore"):  # such a number is reported as not finite
            found = data[:, chosen].astype(self._file.columns.kind, copy=waits)
        check_finite(found, name, times, self._network, numbers, at)
        if at == "node" and self._mesh.cut is not None:
            every = self._mesh.cut.beside(data[:, chosen], channel)
            return every.astype(self._file.columns.kind)
        return found

    def _numbers(self, at: Place) -> NDArray[np.integer]:
        """Return the network numbers of what frames show, other than nodes."""
        assert self._shows is not None
        if at == "cell":
            return np.arange(self._sizes["cell"])
        return self._mesh.numbers(at)[self._shows.grid.items[at]]


MOST_EVENTS = 64
"""Events at which the net is written; further ones are shown by frames alone."""


class SideTable:
    """Two rows for each event, before and after it, of what frames show.

    The datasets are made with the first event: most scenes of the smallest kind have none.

    Args:
        store: The file.
        network: The compiled scene.
        columns: Of the frames.
    """

    def __init__(self, store: Store, network: Network, columns: FrameColumns):
        self._store, self._network, self._frames = store, network, columns
        self._sides = SideColumns(network, columns)
        self._table: ColumnTable | None = None
        self._last = -np.inf
        if SIDES.path in store.file:
            self._last = self._made().last("time")

    def _made(self) -> ColumnTable:
        if self._table is None:
            self._table = ColumnTable(self._store, self._sides.datasets)
        return self._table

    def awaits(self, time: float, apart: float) -> bool:
        """Return whether the sides of an event are still to be written.

        Args:
            time: Of the event [s].
            apart: Least distance from the last event that was written [s].
        """
        count = 0 if self._table is None else self._table["time"].rows // 2
        is_shown = self._frames.places("node").size > 0
        return is_shown and count < MOST_EVENTS and time >= self._last + apart

    def append(self, before: EventSide, after: EventSide) -> None:
        """Add the net on both sides of an event.

        Raises:
            ValueError: A number is not finite.
        """
        times = np.array([before.time, after.time])
        rows = {
            one.key: self._of(one, [self._there(one, side) for side in (before, after)], times)
            for one in self._frames.numbers
        }
        rows["time"] = times
        rows["alive"] = np.concatenate([np.packbits(side.alive) for side in (before, after)])
        self._made().append(rows)
        self._last = after.time

    def _of(
        self, channel: FieldChannel, sides: Sequence[Floats], times: Floats
    ) -> NDArray[Any]:
        """Return the checked numbers of what is recorded at both sides, row after row."""
        data, recorded = np.stack(sides), self._sides.places(channel.at)
        with np.errstate(over="ignore"):  # such a number is reported as not finite
            numbers = data[:, recorded].astype(self._frames.kind)
        check_finite(numbers, channel.name, times, self._network, recorded, channel.at)
        return numbers.reshape(-1, *channel.row)

    def _there(self, channel: FieldChannel, side: EventSide) -> Floats:
        """Return the numbers of a channel, 0 of what is gone."""
        if channel in MOTION:
            return getattr(side, channel.name)
        data = side.fields[channel.name]
        if channel.at == "spring":
            return np.where(side.alive[: self._network.spring_count], data, 0.0)
        if channel.at not in ("triangle", "element"):
            return data
        found, mesh = np.zeros_like(data), self._frames.mesh
        drawn = np.flatnonzero(side.alive[mesh.solid_entities])
        if channel.at == "triangle":
            drawn = mesh.numbers("triangle")[mesh.cells(side.alive).faces]
        found[drawn] = data[drawn]
        return found


class SideColumns:
    """The columns of both sides of events, with the rows that are allocated at once.

    Attributes:
        datasets: By name.
    """

    def __init__(self, network: Network, frames: FrameColumns):
        tools = np.arange(network.body_nodes, network.node_count)
        self._nodes = np.concatenate([frames.places("node"), tools])
        self._frames, self._bytes = frames, row_bytes(network)
        self.datasets = {
            "time": SIDES["time"],
            "alive": SIDES["alive"].of(chunk=_rows_of_a_chunk(self._bytes)),
        }
        for one in frames.numbers:
            chunk = _rows_of_a_chunk(self.places(one.at).size)
            self.datasets[one.key] = side_of(one).of(kind=frames.kind, chunk=chunk)

    def places(self, at: Place) -> NDArray[np.integer]:
        """Return the network numbers of what is recorded, shape (place,)."""
        return self._nodes if at == "node" else self._frames.places(at)

    def rows(self) -> Iterator[tuple[DatasetSpec, int]]:
        """Yield the columns with the rows of each side."""
        yield self.datasets["time"], 1
        yield self.datasets["alive"], self._bytes
        for one in self._frames.numbers:
            yield self.datasets[one.key], self.places(one.at).size


def _rows_of_a_chunk(rows: int) -> int:
    """Return the rows that are allocated at once for items of which a side has ``rows``."""
    return max(1, min(2 * rows, FRAME_ROWS))


class Sides:
    """The net on both sides of events, read on request.

    The rows of all arrays are in turn before and after an event.

    Attributes:
        times: Of the sides [s], shape (side,).
        position, velocity: Of the recorded nodes, and behind them of the nodes of tools [m],
            [m/s], shape (side, node, 3).
        fields: Of fields by name, in their units, shape (side, node, …) likewise, or (side,
            item) of all recorded springs, triangles and cells, 0 where these are gone.

    Args:
        file: The file.
        network: Its network.
        nodes: Number of recorded nodes.
        channels: The fields that frames contain, with the number of recorded springs,
            triangles or cells that have one.
    """

    def __init__(
        self, file: ResultGroup, network: Network, nodes: int,
        channels: Mapping[FieldChannel, int],
    ):  # fmt: skip
        self._file, self._network = file, network
        self.times: Floats = np.zeros(0)
        if SIDES.path in file:
            self.times = access.array(file, SIDES["time"].path)
        points = nodes + network.node_count - network.body_nodes
        self.position, self.velocity = (self._frames(one, points) for one in MOTION)
        self.fields = {
            one.name: self._frames(one, points if one.at == "node" else count)
            for one, count in channels.items()
        }

    def _frames(self, channel: FieldChannel, rows: int) -> Frames | Floats:
        if side_of(channel).path not in self._file:
            return np.zeros((len(self), rows, *channel.row))
        data = access.dataset(self._file, side_of(channel).path)
        return Frames(data, len(self), rows, channel.row)

    def __len__(self) -> int:
        return len(self.times)

    def alive(self, side: int) -> NDArray[np.bool_]:
        """Return which entities of the network exist, shape (entity,)."""
        return read_alive(self._file, SIDES["alive"], side, self._network)
