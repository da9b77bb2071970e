"""Names of the nodes of a film, for read-outs of pages."""

from typing import Any

import numpy as np

from tissuec.model.network import Indices
from tissuec.view.player.drawn_nodes import DrawnNodes
from tissuec.view.player.packing import Pack
from tissuec.view.player.tints import written_tissue


def pack_node_facts(nodes: DrawnNodes, pack: Pack) -> dict[str, Any]:
    """Put ids and regions of nodes into a pack, and return the names of bodies and regions.

    Args:
        nodes: Of the film.
        pack: Takes the arrays.
    """
    trajectory, numbers = nodes.trajectory, nodes.film.numbers
    groups = [one for one in trajectory.groups if one.body and one.what == "nodes"]
    region: Indices = np.zeros(trajectory.network.node_count, dtype=np.int64)
    for number, group in enumerate(groups, start=1):
        region[group.indices] = number
    pack.add("ids", trajectory.network.node_ids[numbers][None])
    pack.add("region", region[numbers][None])
    return {
        "bodies": [
            {
                "name": body.name,
                "from": int(np.searchsorted(numbers, int(body.nodes.start))),
                "tissue": str(written_tissue(trajectory, body.name).get("name", "")),
            }
            for body in trajectory.network.bodies
        ],
        "regions": [
            {
                "name": one.name,
                "tissue": str(written_tissue(trajectory, one.body, one.name).get("name", "")),
            }
            for one in groups
        ],
    }
