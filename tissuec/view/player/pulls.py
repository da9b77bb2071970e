"""Resultant forces: what instruments and holds exert on tissue, and where."""

from collections.abc import Iterator

import numpy as np
from msgspec import Struct

from tissuec.model import topology
from tissuec.model.network import Floats, Indices
from tissuec.results.tools import HoldInterval
from tissuec.results.trajectory import Trajectory
from tissuec.view.player.moments import Moments

_FIX = "fix"


class HoldingForce(Struct, frozen=True, eq=False):
    """A force on tissue, at one place.

    Attributes:
        name: Of the tool or set; "fix" for fixed nodes.
        life: When it acts [s].
        place: Where [m], shape (row, 3).
        force: On the tissue [N], shape (row, 3).
    """

    name: str
    life: tuple[float, float]
    place: Floats
    force: Floats


def read_pulls(moments: Moments) -> list[HoldingForce]:
    """Return the forces of all that holds nodes, and of tools whose force is logged."""
    return [*_holds(moments), *_contacts(moments)]


def _holds(moments: Moments) -> Iterator[HoldingForce]:
    """Yield minus the sum of spring forces on held nodes, where all of them are recorded."""
    trajectory = moments.trajectory
    for hold, stop in _intervals(trajectory):
        for nodes in (
            _connected(trajectory, hold.nodes) if hold.holder == _FIX else [hold.nodes]
        ):
            if not np.isin(nodes, trajectory.nodes).all():
                continue
            rows = np.searchsorted(trajectory.nodes, nodes)
            place = moments.vectors("position", rows, np.float64).mean(axis=1)
            force = 0.0 - moments.vectors("force", rows, np.float64).sum(axis=1)
            yield HoldingForce(hold.holder, (hold.time, stop), place, force)


def _intervals(trajectory: Trajectory) -> Iterator[tuple[HoldInterval, float]]:
    """Yield what holds nodes, and until when."""
    for number, hold in enumerate(trajectory.holds):
        if len(hold.nodes) and hold.time < trajectory.times[-1]:
            later = trajectory.holds[number + 1 :]
            yield hold, next((one.time for one in later if one.holder == hold.holder), np.inf)


def _connected(trajectory: Trajectory, nodes: Indices) -> list[Indices]:
    """Return nodes in groups that springs join, such as both ends of a tube."""
    network = trajectory.network
    place = np.full(network.node_count, -1)
    place[nodes] = np.arange(len(nodes))
    ends = place[network.ends]
    inner = ends[(ends >= 0).all(axis=1)]
    labels = np.asarray(topology.pieces(len(nodes), inner.astype(np.int32)))
    return [nodes[labels == label] for label in np.unique(labels)]


def _contacts(moments: Moments) -> Iterator[HoldingForce]:
    """Yield the forces of tools with shapes, as far as they are logged."""
    trajectory, tools = moments.trajectory, moments.tools()
    network = trajectory.network
    for tool in network.tools:
        log = trajectory.logs.get(f"force of {tool.name}")
        if log is None or log.columns != ("x", "y", "z") or not len(log.time):
            continue
        first = int(tool.nodes.start) - network.body_nodes
        time, value = log.with_jumps()
        axes = [np.interp(moments.times, time, value[:, axis]) for axis in range(3)]
        force = np.stack(axes, axis=1)
        yield HoldingForce(tool.name, (float(log.time[0]), np.inf), tools[:, first], force)
