"""Where a surface is open, in words."""

from tissuec.core.errors import counted
from tissuec.model.network import Indices, Network

_MOST_NODES = 4  # that are named of one ring
_MOST_RINGS = 3


def where_open(network: Network, edges: Indices) -> str:
    """Return where the free edges of a surface are, by the nodes of the rings that they form.

    Args:
        network: The network.
        edges: Node pairs, each in the direction of its triangle, shape (edge, 2).
    """
    rings = _rings(edges)
    named = [
        ", ".join(str(network.node_ids[node]) for node in ring[:_MOST_NODES])
        + (", …" if len(ring) > _MOST_NODES else "")
        for ring in rings[:_MOST_RINGS]
    ]
    more = " and others" if len(rings) > _MOST_RINGS else ""
    where = "along" if len(rings) == 1 else f"in {counted(len(rings), 'ring')} along"
    return f"{len(edges)} edges are free, {where} the nodes {' and '.join(named)}{more}"


def _rings(edges: Indices) -> list[list[int]]:
    """Return the nodes along free edges, ring by ring, each as far as it leads."""
    after: dict[int, list[int]] = {}
    for first, second in edges.tolist():
        after.setdefault(first, []).append(second)
    rings: list[list[int]] = []
    while after:
        node = next(iter(after))
        ring: list[int] = []
        while after.get(node):
            ring.append(node)
            following = after[node].pop()
            if not after[node]:
                del after[node]
            node = following
        rings.append(ring)
    return rings
