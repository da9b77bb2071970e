"""From the arrays of the whole network to checked frames of the recorded part."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tissuec.model.network import Network
from tissuec.results.finite import check_finite, check_shape, check_times
from tissuec.results.mesh import RecordedMesh
from tissuec.results.polydata import PolyDataFrames
from tissuec.results.tools import ToolTable


class FrameRecorder:
    """Takes frames of the network and hands those of the recorded part to the file.

    Attributes:
        alive: Which springs are alive, shape (spring,); None until it was said.
        waiting: Frames that came since `flushed` was called.
    """

    def __init__(
        self, network: Network, mesh: RecordedMesh, file: PolyDataFrames, tools: ToolTable
    ):
        self._network = network
        self._tools = tools
        self._mesh = mesh
        self._file = file
        self._cells = file.parts.drawn
        # All of them need no look-up.
        whole = len(mesh.nodes) == network.node_count
        self._nodes = slice(None) if whole else mesh.nodes
        self._last_time = file.last_time()
        self.alive: NDArray[np.bool_] | None = None
        self.waiting = 0

    @property
    def is_due(self) -> bool:
        """Return whether enough frames wait for a batch."""
        return self.waiting >= self._file.batch

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

    def append(
        self,
        time: ArrayLike,
        position: ArrayLike,
        velocity: ArrayLike,
        force: ArrayLike,
        tension: ArrayLike,
    ) -> None:
        """Add frames, all or none of them; see `ResultWriter.frames`.

        Args:
            time: Times [s], shape (frame,).
            position: Of all nodes [m], shape (frame, node, 3).
            velocity: Of all nodes [m/s], shape (frame, node, 3).
            force: On all nodes [N], shape (frame, node, 3).
            tension: Of all springs [N], shape (frame, spring).

        Raises:
            ValueError: The topology is not set, a shape is wrong, or an entry is not finite.
        """
        if not len(self._mesh.nodes):
            return
        if self.alive is None or self._cells is None:
            raise ValueError("state the topology before the first frame")
        times = check_times(time, after=self._last_time)
        given = {"position": position, "velocity": velocity, "force": force}
        vectors = {name: self._at_nodes(data, len(times), name) for name, data in given.items()}
        tensions = self._at_lines(tension, len(times))
        for name, data in vectors.items():
            check_finite(data, name, times, self._network, self._mesh.nodes, "node")
        check_finite(tensions, "tension", times, self._network, self._cells.springs, "spring")
        shapes = self._tools.checked(np.asarray(position), times)
        if len(times):
            self._file.append(self._cells, times, vectors, tensions)
            self._tools.append(shapes)
            self._last_time = float(times[-1])
            self.waiting += len(times)

    def _at_nodes(self, data: ArrayLike, frames: int, name: str) -> NDArray[Any]:
        """Return the numbers at the recorded nodes, shape (frame, node, 3)."""
        data = np.asarray(data)
        check_shape(data, (frames, self._network.node_count, 3), name)
        # Frames that do not wait for others are written before anybody changes them.
        waits = self._file.batch > 1
        with np.errstate(over="ignore"):  # such a number is reported as not finite
            return data[:, self._nodes].astype(self._file.kind, copy=waits)

    def _at_lines(self, tension: ArrayLike, frames: int) -> NDArray[Any]:
        """Return the tensions of the lines, shape (frame, line)."""
        assert self._cells is not None
        data, springs = np.asarray(tension), self._cells.springs
        check_shape(data, (frames, self._network.spring_count), "tension")
        everything = slice(None) if len(springs) == data.shape[1] else springs
        with np.errstate(over="ignore"):
            return np.asarray(data[:, everything], dtype=self._file.kind)
