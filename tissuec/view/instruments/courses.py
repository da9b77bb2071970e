"""Which instruments are seen, and where each is at every moment of a run."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tissuec.model.network import Floats, Indices
from tissuec.view.instruments import Course
from tissuec.view.instruments.shafts import free_shaft
from tissuec.view.player.moments import Moments

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
        """Return where nodes of the network stand in frames, as far as they are shown."""
        recorded = self.moments.trajectory.nodes
        return np.searchsorted(recorded, nodes[np.isin(nodes, recorded)])

    def unit(self, length: float) -> float:
        """Return the unit of an instrument that spans a length, both [m]."""
        return float(np.clip(length, _SMALLEST * self.size, _LARGEST * self.size))


def courses(moments: Moments) -> tuple[Course, ...]:
    """Return all instruments that are seen in a run."""
    from tissuec.view.instruments import cuts, grips

    scenery = Scenery.of(moments)
    if not len(scenery.shown):
        return ()
    return (
        *grips.grips(scenery), *cuts.cuts(scenery), *_handles(scenery), *_jets(scenery),
    )  # fmt: skip


def _tools(scenery: Scenery, kind: str) -> list[tuple[str, float, NDArray[np.float64]]]:
    """Return name, radius and points of the shapes of tools of a kind, (row, 2, 3) each."""
    network, points = scenery.moments.trajectory.network, scenery.moments.tools()
    found: list[tuple[str, float, NDArray[np.float64]]] = []
    for tool in network.tools:
        first = int(tool.nodes.start) - network.body_nodes
        for number, shape in enumerate(tool.shapes):
            own = points[:, first + 2 * number : first + 2 * number + 2]
            if tool.kind == kind and own.shape[1] == 2:
                found.append((tool.name, shape.radius, own))
    return found


def _handles(scenery: Scenery) -> list[Course]:
    """Return the rods that the balls of probes are carried by."""
    found: list[Course] = []
    always = (float(scenery.moments.times[0]), np.inf)
    for name, radius, points in _tools(scenery, "probe"):
        if np.array_equal(points[:, 0], points[:, 1]):
            shaft = free_shaft(points[0, 0], scenery.tissue(0))
            axes = np.broadcast_to(frame_along(shaft), (len(points), 3, 3))
            none = np.zeros(len(points))
            found.append(Course("handle", name, radius, always, points[:, 0], axes, none))
    return found


def _jets(scenery: Scenery) -> list[Course]:
    """Return the jets of nozzles while they flow."""
    found: list[Course] = []
    events = scenery.moments.trajectory.events
    for name, radius, points in _tools(scenery, "nozzle"):
        way = points[:, 1] - points[:, 0]
        way /= np.linalg.norm(way, axis=1, keepdims=True)
        axes = np.stack([frame_along(-one) for one in way])
        for event in events:
            if event.kind != "irrigate" or name not in event.cause:
                continue
            later = (one for one in events if one.time > event.time)
            ends = (one.time for one in later if (one.kind, one.place) == ("end", event.place))
            life = (event.time, next(ends, np.inf))
            reach = [_reach(scenery.tissue(row), points[row, 0], way[row], radius)
                     for row in range(len(points))]  # fmt: skip
            found.append(
                Course("jet", name, radius, life, points[:, 0], axes, np.array(reach) / radius)
            )
    return found


def _reach(tissue: Floats, tip: Floats, way: Floats, radius: float) -> float:
    """Return how far a jet goes until it meets tissue [m].

    Args:
        tissue: Nodes [m], shape (node, 3).
        tip: Where it begins [m], shape (3,).
        way: Unit vector, shape (3,).
        radius: Of the opening [m].
    """
    ahead = (tissue - tip) @ way
    aside = np.linalg.norm(tissue - tip - ahead[:, None] * way, axis=1)
    met = ahead[(ahead > radius) & (aside < 3.0 * radius + 0.1 * ahead)]
    return float(met.min()) if len(met) else 20.0 * radius


def frame_along(shaft: Floats) -> Floats:
    """Return unit vectors x, y and z, of which z is the given one, shape (3, 3)."""
    side = np.eye(3)[int(np.abs(shaft).argmin())]
    x = np.cross(side, shaft)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(shaft, x), shaft])
