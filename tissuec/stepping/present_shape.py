"""The net of a run at one time, to be drawn."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tissuec.results.fields import FIELDS, always_recorded
from tissuec.results.mesh import RecordedMesh
from tissuec.results.shapes import ExportedShape, net_shape
from tissuec.script.measures.snapshot import Snapshot


def present_shape(title: str, snapshot: Snapshot) -> ExportedShape:
    """Return everything that frames could show, at the time of a snapshot.

    Args:
        title: What is drawn.
        snapshot: At one time.
    """
    network = snapshot.state.network
    nodes = np.arange(network.body_nodes)
    ends = network.springs.ends[: network.first_mark]
    springs = np.flatnonzero((ends < len(nodes)).all(axis=1))
    cells = RecordedMesh.of(network, nodes, springs).cells(snapshot.state.alive)
    points: dict[str, NDArray[Any]] = {
        "position": snapshot.position[nodes],
        "velocity": snapshot.velocity[nodes],
    }
    own: dict[str, tuple[slice, NDArray[Any]]] = {}
    for channel in always_recorded():
        numbers = FIELDS[channel.name].sample(snapshot)
        if channel.at == "node":
            points[channel.stored] = numbers[nodes]
        elif channel.at == "spring":
            own[channel.stored] = cells.line_rows, numbers[cells.springs]
    points["node_id"] = network.node_ids[nodes]
    ids = network.springs.ids[cells.springs]
    return net_shape(title, float(snapshot.time), cells, points, own, ids)
