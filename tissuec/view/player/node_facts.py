"""Names of the nodes of a film, for read-outs of pages."""

from typing import Any

import numpy as np

from tissuec.model.network import Indices
from tissuec.view.player.drawn_nodes import DrawnNodes
from tissuec.view.player.packing import Pack


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
                "tissue": _tissue(nodes, body.name, ""),
            }
            for body in trajectory.network.bodies
        ],
        "regions": [
            {"name": group.name, "tissue": _tissue(nodes, group.body, group.name)}
            for group in groups
        ],
    }


def _tissue(nodes: DrawnNodes, body: str, region: str) -> str:
    parts: dict[str, Any] = nodes.trajectory.manifest.get("tissues", {}).get(body, {})
    found: dict[str, Any] = parts.get(region) or parts.get("") or {}
    return str(found.get("name", ""))
