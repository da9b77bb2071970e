"""The net of a run at one time, to be drawn."""

import numpy as np

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
    springs = np.flatnonzero((network.springs.ends < len(nodes)).all(axis=1))
    cells = RecordedMesh.of(network, nodes, springs).cells(snapshot.state.alive)
    points = {
        "position": snapshot.position[nodes],
        "velocity": snapshot.velocity[nodes],
        "force": snapshot.node_force[nodes],
        "node_id": network.node_ids[nodes],
    }
    tension, ids = snapshot.tension[cells.springs], network.springs.ids[cells.springs]
    return net_shape(title, float(snapshot.time), cells, points, tension, ids)
