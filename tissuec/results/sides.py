"""The net just before and just after events, which frames at even distances in time miss.

Between two frames, a reader may interpolate the motion; across a cut it must not. So the net is
written twice at the time of an event, in a table of its own: frames keep the times that the
scene asks for.
"""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tissuec.model.network import Floats, Network
from tissuec.results import access
from tissuec.results.access import ResultGroup
from tissuec.results.fields import FieldChannel, Place
from tissuec.results.finite import check_finite
from tissuec.results.frame_arrays import Frames
from tissuec.results.mesh import RecordedMesh
from tissuec.results.polydata import FRAME_ROWS
from tissuec.results.recording import EventSide, Recording
from tissuec.results.store import FEW, Store

SIDES = "/tissuec/sides"
MOST_EVENTS = 64
"""Events at which the net is written; further ones are shown by frames alone."""
_VECTORS = {"position": "m", "velocity": "m/s"}
_GONE = {"spring": ", 0 once it is gone", "triangle": ", 0 once it is gone"}


class SideTable:
    """Two rows for each event, before and after it, of what frames show.

    The datasets are made with the first event: most scenes of the smallest kind have none.

    Args:
        store: The file.
        network: The compiled scene.
        recording: What frames contain.
        mesh: The part that frames show.
        kind: Type of the numbers of frames.
    """

    def __init__(
        self, store: Store, network: Network, recording: Recording, mesh: RecordedMesh,
        kind: np.dtype,
    ):  # fmt: skip
        self._store, self._network, self._mesh, self._kind = store, network, mesh, kind
        self._channels, self._volumes = recording.fields, recording.cells
        tools = np.arange(network.body_nodes, network.shown_nodes)
        self._nodes = np.concatenate([mesh.nodes, tools])
        self._columns: dict[str, Any] = {}
        self._last = -np.inf
        if SIDES in store.file:
            self._make()
            times = self._columns["time"].dataset
            self._last = float(times[-1]) if len(times) else -np.inf

    def awaits(self, time: float, apart: float) -> bool:
        """Return whether the sides of an event are still to be written.

        Args:
            time: Of the event [s].
            apart: Least distance from the last event that was written [s].
        """
        count = self._columns["time"].rows // 2 if self._columns else 0
        return len(self._mesh.nodes) > 0 and count < MOST_EVENTS and time >= self._last + apart

    def append(self, before: EventSide, after: EventSide) -> None:
        """Add the net on both sides of an event.

        Raises:
            ValueError: A number is not finite.
        """
        if not self._columns:
            self._make()
        times = np.array([before.time, after.time])
        rows: dict[str, NDArray[Any]] = {"time": times}
        for name in _VECTORS:
            rows[name] = self._of(
                [getattr(side, name) for side in (before, after)], name, times
            )
        for channel in self._channels:
            found = [self._there(channel, side) for side in (before, after)]
            rows[channel.key] = self._of(found, channel.name, times, channel.at)
        alive = [np.packbits(side.alive) for side in (before, after)]
        rows["alive"] = np.concatenate(alive)
        self._store.append({self._columns[name]: data for name, data in rows.items()})
        self._last = after.time

    def _of(
        self, sides: Sequence[Floats], name: str, times: Floats, at: Place = "node"
    ) -> NDArray[Any]:
        """Return the checked numbers of what is recorded at both sides, row after row."""
        data, recorded = np.stack(sides), self._recorded(at)
        with np.errstate(over="ignore"):  # such a number is reported as not finite
            numbers = data[:, recorded].astype(self._kind)
        check_finite(numbers, name, times, self._network, recorded, at)
        return numbers.reshape(-1, *data.shape[2:])

    def _recorded(self, at: Place) -> NDArray[np.integer]:
        """Return the network numbers of what is recorded."""
        if at == "node":
            return self._nodes
        if at == "cell":
            return np.arange(0 if self._volumes is None else self._volumes.total)
        return self._mesh.springs if at == "spring" else self._mesh.faces

    def _there(self, channel: FieldChannel, side: EventSide) -> Floats:
        """Return the numbers of a field, 0 of springs and triangles that are gone."""
        data = side.fields[channel.name]
        if channel.at == "spring":
            return np.where(side.alive, data, 0.0)
        if channel.at != "triangle":
            return data
        found = np.zeros_like(data)
        drawn = self._mesh.faces[self._mesh.drawn_triangles(self._mesh.cells(side.alive))]
        found[drawn] = data[drawn]
        return found

    def _make(self) -> None:
        column = partial(self._store.column, in_parts=True)
        text = "just before and just after each event, in turn"
        bits = side_rows_of_a_chunk(self._network.spring_count // 8 + 1)
        vectors = side_rows_of_a_chunk(len(self._nodes))
        self._columns = {
            "time": self._store.column(
                f"{SIDES}/time", "f8", f"times {text}", unit="s", chunk=FEW
            ),
            "alive": column(
                f"{SIDES}/alive",
                "u1",
                f"which springs of the network exist, eight in a byte; {text}",
                chunk=bits,
            ),
        }
        for name, unit in _VECTORS.items():
            self._columns[name] = column(
                f"{SIDES}/{name}",
                self._kind,
                f"{name} of each recorded node, then of the nodes of tools; {text}",
                unit=unit,
                row=(3,),
                chunk=vectors,
            )
        for one in self._channels:
            more = ", then of the nodes of tools" if one.at == "node" else _GONE.get(one.at, "")
            self._columns[one.key] = column(
                f"{SIDES}/{one.key}",
                self._kind,
                f"{one.name} of each recorded {one.at}{more}; {text}",
                unit=one.unit,
                row=one.row,
                chunk=side_rows_of_a_chunk(len(self._recorded(one.at))),
            )


def side_rows_of_a_chunk(rows: int) -> int:
    """Return the rows that are allocated at once for items of which a side has ``rows``."""
    return max(1, min(2 * rows, FRAME_ROWS))


class Sides:
    """The net on both sides of events, read when it is asked for.

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
        if SIDES in file:
            self.times = access.array(file, f"{SIDES}/time")
        points = nodes + network.shown_nodes - network.body_nodes
        self.position, self.velocity = (self._frames(name, points, (3,)) for name in _VECTORS)
        self.fields = {
            one.name: self._frames(one.key, points if one.at == "node" else count, one.row)
            for one, count in channels.items()
        }

    def _frames(self, name: str, rows: int, row: tuple[int, ...]) -> Frames | Floats:
        if not len(self):
            return np.zeros((0, rows, *row))
        return Frames(access.dataset(self._file, f"{SIDES}/{name}"), len(self), rows, row)

    def __len__(self) -> int:
        return len(self.times)

    def alive(self, side: int) -> NDArray[np.bool_]:
        """Return which springs of the network exist, shape (spring,)."""
        count = self._network.spring_count
        size = -(-count // 8)
        rows = access.dataset(self._file, f"{SIDES}/alive")[side * size : (side + 1) * size]
        if len(rows) < size:
            access.damaged(self._file.file, f'"{SIDES}/alive" is incomplete')
        return np.unpackbits(rows, count=count).astype(bool)
