"""Resultant forces: what instruments and holds exert on tissue, and where."""

from collections.abc import Iterator

import numpy as np
from msgspec import Struct

from tissuec.model import topology
from tissuec.model.network import Floats, Indices
from tissuec.results.moments import Moments
from tissuec.results.recording import AXES
from tissuec.results.tools import FIX, with_ends
from tissuec.results.trajectory import Trajectory


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
    for hold, stop in with_ends(trajectory.holds):
        is_fixed, begins = hold.holder == FIX, hold.time < moments.times[-1]
        for nodes in _connected(trajectory, hold.nodes) if is_fixed else [hold.nodes]:
            if begins and np.isin(nodes, trajectory.nodes).all():
                rows = np.searchsorted(trajectory.nodes, nodes)
                place = moments.of_held("position", rows).mean(axis=1)
                force = 0.0 - moments.of_held("force", rows).sum(axis=1)
                yield HoldingForce(hold.holder, (hold.time, stop), place, force)


def _connected(trajectory: Trajectory, nodes: Indices) -> list[Indices]:
    """Return nodes in groups that springs join, such as both ends of a tube."""
    network = trajectory.network
    place = np.full(network.node_count, -1)
    place[nodes] = np.arange(len(nodes))
    ends = place[network.springs.ends]
    inner = ends[(ends >= 0).all(axis=1)]
    labels = np.asarray(topology.pieces(len(nodes), inner.astype(np.int32)))
    return [nodes[labels == label] for label in np.unique(labels)]


def _contacts(moments: Moments) -> Iterator[HoldingForce]:
    """Yield the forces of tools with shapes, as far as they are logged."""
    trajectory, tools = moments.trajectory, moments.tools()
    network = trajectory.network
    for tool in network.tools:
        log = trajectory.logs.get(f"force of {tool.name}")
        if log is None or log.columns != AXES or not len(log.time):
            continue
        first = int(tool.nodes.start) - network.body_nodes
        time, value = log.with_jumps()
        axes = [np.interp(moments.times, time, value[:, axis]) for axis in range(3)]
        force = np.stack(axes, axis=1)
        yield HoldingForce(tool.name, (float(log.time[0]), np.inf), tools[:, first], force)
