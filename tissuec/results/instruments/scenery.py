"""What instruments are placed in: the net at every moment, and its size."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from tissuec.core.names import key_of
from tissuec.model.network import Floats, Indices
from tissuec.results.moments import Moments

_SHARE = 1.0 / 15.0  # of the run, that an instrument takes to come or to go
_SMALLEST, _LARGEST = 0.03, 0.1  # units of instruments, beside the size of the bodies
_NEAR = 1e-9  # of the duration


class Scenery(NamedTuple):
    """What instruments are placed in.

    Attributes:
        moments: Of the run.
        shown: Rows in frames of the nodes of bodies, shape (node,).
        size: Diagonal of the box around the bodies at first [m].
        pause: Time in which an instrument comes or goes [s].
    """

    moments: Moments
    shown: Indices
    size: float
    pause: float

    @classmethod
    def of(cls, moments: Moments) -> "Scenery":
        """Return that of a run."""
        trajectory = moments.trajectory
        bodies = trajectory.network.body_nodes or trajectory.network.node_count
        shown = np.flatnonzero(trajectory.nodes < bodies)
        first = trajectory.position[0][shown]
        size = float(np.linalg.norm(np.ptp(first, axis=0))) if len(shown) else 0.0
        pause = _SHARE * float(moments.times[-1] - moments.times[0])
        return cls(moments, shown, size or 1.0, pause or 1.0)

    def kind(self, tool: str) -> str:
        """Return the kind of a tool; "" where the scene is not known to say it."""
        return str(self._entries(tool).get("kind", ""))

    def shaft(self, tool: str) -> Floats | None:
        """Return the unit vector that the scene gives the shaft of a tool, shape (3,)."""
        found = self._entries(tool).get("shaft")
        return None if found is None else np.array(found) / np.linalg.norm(found)

    def _entries(self, tool: str) -> Mapping[str, Any]:
        tools: Mapping[str, Any] = self.moments.trajectory.manifest.get("tools", {})
        key = key_of(tool)
        for name, entries in tools.items():
            if key_of(name) == key:
                return entries
        return {}

    def row(self, time: float) -> int:
        """Return the first row at or after a time [s]: at an event, the net before it."""
        times = self.moments.times
        found = np.searchsorted(times, time - _NEAR * float(times[-1]))
        return int(min(found, len(times) - 1))

    def last_row(self, time: float) -> int:
        """Return the last row at or before a time [s]; of the sides of an event, the first."""
        row = self.row(time)
        later = self.moments.times[row] > time + _NEAR * float(self.moments.times[-1])
        return max(0, row - bool(later))

    def tissue(self, row: int) -> Floats:
        """Return the nodes of bodies in a row [m], shape (node, 3)."""
        return self.moments.vectors_in("position", row)[self.shown]

    def rows_of(self, nodes: Indices) -> Indices:
        """Return the rows in frames of nodes of the network that are shown, shape (shown,)."""
        recorded = self.moments.trajectory.nodes
        return np.searchsorted(recorded, nodes[np.isin(nodes, recorded)])

    def unit(self, length: float, tool: str) -> float:
        """Return the unit of an instrument [m].

        Args:
            length: That it spans [m].
            tool: Its name; the scene may give its size.
        """
        if (size := self._entries(tool).get("size")) is not None:
            return float(size)
        return float(np.clip(length, _SMALLEST * self.size, _LARGEST * self.size))
