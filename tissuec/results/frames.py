"""From the arrays of the whole network to checked frames of the recorded part."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tissuec.model.network import Floats, Indices, Network
from tissuec.results.fields import FieldChannel, Place
from tissuec.results.finite import check_finite, check_shape, check_times
from tissuec.results.frame_columns import POSITION
from tissuec.results.mesh import Cells
from tissuec.results.polydata import PolyDataFrames
from tissuec.results.recording import Recording
from tissuec.results.tools import ToolTable


class FrameRecorder:
    """Takes frames of the network and hands those of the recorded part to the file.

    Attributes:
        alive: Which springs are alive, shape (spring,); None until it was said.
        waiting: Frames that came since `flushed` was called.
    """

    def __init__(
        self, network: Network, recording: Recording, file: PolyDataFrames, tools: ToolTable
    ):
        mesh = file.mesh
        self._network, self._tools = network, tools
        self._sizes: dict[Place, int] = {
            "node": network.node_count,
            "spring": network.spring_count,
            "triangle": len(network.skin),
            "cell": 0 if recording.cells is None else recording.cells.total,
        }
        self._mesh = mesh
        self._file = file
        self._cells = file.parts.drawn
        # All of them need no look-up.
        whole = len(mesh.nodes) == network.node_count
        self._nodes = slice(None) if whole else mesh.nodes
        self._drawn: tuple[Cells, Indices] | None = None  # numbers of the triangles
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

    def set_topology(self, alive: ArrayLike) -> None:
        """Set which springs exist from now on; ValueError if the shape is wrong.

        Args:
            alive: Booleans without a unit, shape (spring,).
        """
        alive = np.array(alive, dtype=bool)
        check_shape(alive, (self._network.spring_count,), "alive")
        self.alive = alive
        self._cells = self._mesh.cells(alive)
        if not self._file.parts.count:  # a file without any frame opens in viewers, too
            self._file.parts.draw(self._cells)

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
        if self.alive is None or self._cells is None:
            raise ValueError("state the topology before the first frame")
        times = check_times(time, after=self._last_time)
        found = {one: self._shown(one, numbers, times) for one in self._file.columns.channels}
        shapes = self._tools.checked(np.asarray(numbers[POSITION.name]), times)
        if len(times):
            self._file.append(self._cells, times, found)
            self._tools.append(shapes)
            self._last_time = float(times[-1])
            self.waiting += len(times)

    def _shown(
        self, channel: FieldChannel, given: Mapping[str, ArrayLike], times: Floats
    ) -> NDArray[Any]:
        """Return the checked numbers of a channel that frames show, shape (frame, shown, …).

        Args:
            channel: The channel.
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
        return found

    def _numbers(self, at: Place) -> NDArray[np.integer]:
        """Return the network numbers of the springs, triangles or cells that frames show."""
        assert self._cells is not None
        if at == "spring":
            return self._cells.springs
        if at == "cell":
            return np.arange(self._sizes["cell"])
        if self._drawn is None or self._drawn[0] is not self._cells:
            places = self._mesh.drawn_triangles(self._cells)
            self._drawn = self._cells, self._mesh.faces[places]
        return self._drawn[1]
