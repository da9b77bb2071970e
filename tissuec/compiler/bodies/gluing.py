"""Glue: nodes of one body as fixed weighted sums of the nodes of another.

Each node gets the weights of the element that contains it, or of the nearest one within reach,
whose functions are continued to it. So nothing has to move, the weights reproduce every linear
field, and faces that lie in one another follow each other exactly. On walls and threads, nodes
have to lie in a triangle or on a spring.
"""

from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple, NoReturn

import numpy as np
from numpy.typing import NDArray

from tissuec.compiler.sets import Groups
from tissuec.core.arrays import norm
from tissuec.core.errors import counted
from tissuec.core.units import LENGTH, show
from tissuec.forces.acting.embedding import EmbeddedNodes
from tissuec.geometry.natural_coordinates import places_in
from tissuec.geometry.nearest import TRIANGLE, places
from tissuec.model.blocks import EMBEDDING, FieldBlock
from tissuec.model.network import Floats, Indices, Network
from tissuec.scene.model import Glue, Scene
from tissuec.scene.reading.findings import Findings
from tissuec.script.verbs import Action, Group
from tissuec.script.verbs.holding import nodes_held_by

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

#: Of the length of the edges of what nodes are glued to: how far they may be from it.
REACH = 0.05
#: The same from walls and threads, which cannot be continued to beside them.
ON = 1e-9
ROUNDING = 1e-12  # weights that are zero


class Hosts(NamedTuple):
    """What nodes can be glued to: elements of one shape, triangles or springs.

    Attributes:
        shape: Name of the shape of elements; "triangle" or "spring".
        nodes: Shape (element, node).
    """

    shape: str
    nodes: Indices

    @property
    def is_solid(self) -> bool:
        """Return whether weights can be continued beside the element."""
        return self.shape not in ("triangle", "spring")


def embedding_block(
    scene: Scene, network: Network, groups: Groups, findings: Findings
) -> FieldBlock:
    """Return the nodes that the glue of a scene embeds in others.

    Args:
        network: With the elements of all bodies.
        groups: Sets and bodies.
    """
    from scipy.sparse import csr_matrix

    count = network.node_count
    spread, owner = csr_matrix((count, count)), np.full(count, -1)
    glues = list(scene.glues.values())
    for number, glue in enumerate(glues):
        with findings.item():
            nodes, weights = _glued(glue, network, groups, findings)
            if (again := nodes[owner[nodes] >= 0]).size:
                first = glues[int(owner[again[0]])]
                findings.reject(
                    "TIS309",
                    f"{first.name} glues {_node(network, int(again[0]))} already",
                    glue.span,
                    hint=f"leave it out in {glue.name}, by a set of the other nodes",
                )
            owner[nodes] = number
            spread = csr_matrix(spread + weights)
    embedded = np.flatnonzero(owner >= 0)
    if not len(embedded):
        findings.stop()
    whole = _composed(spread, owner, glues, findings)
    rows = whole[embedded]
    field = EmbeddedNodes(
        embedded,
        rows.indptr.astype(np.int64),
        rows.indices.astype(np.int64),
        np.ascontiguousarray(rows.data),
    )
    shared = field.shared(network.mass)
    if (shared[field.hosts] <= 0.0).any():
        worst = int(field.hosts[np.argmin(shared[field.hosts])])
        findings.reject(
            "TIS309",
            f"{_node(network, worst)} would have a mass of {shared[worst] * 1e6:.3g} mg: "
            "what is glued beside it is too heavy and too far from it",
            glues[0].span,
            hint="reduce reach, glue the other way round, or move the bodies together",
        )
    return FieldBlock(EMBEDDING, EMBEDDING, field, glues[0].span)


def _composed(
    spread: "csr_matrix", owner: Indices, glues: list[Glue], findings: Findings
) -> "csr_matrix":
    """Return weights of nodes that are not embedded themselves, shape (node, node).

    Args:
        spread: Weights of all hosts of embedded nodes, shape (node, node).
        owner: Glue of each embedded node, -1 of others, shape (node,).
    """
    from scipy.sparse import diags

    on, off = diags((owner >= 0).astype(float)), diags((owner < 0).astype(float))
    whole = spread
    for _ in range(len(glues)):
        inner = (whole @ on).tocsr()
        inner.eliminate_zeros()
        if not inner.nnz:
            whole = whole.tocsr()
            whole.eliminate_zeros()
            whole.sort_indices()
            return whole
        whole = whole @ off + inner @ spread
    names = " and ".join(glue.name for glue in glues)
    findings.reject(
        "TIS309", f"{names} glue nodes to each other in a circle", glues[0].span,
        hint="glue the finer side to the coarser one only",
    )  # fmt: skip


def _glued(
    glue: Glue, network: Network, groups: Groups, findings: Findings
) -> "tuple[Indices, csr_matrix]":
    """Return the nodes that a glue embeds, and their weights, shape (node, node)."""
    where = glue.ends[0].span.to(glue.ends[1].span)
    first, second = groups.both(glue.ends)
    hosts = _hosts(network, second.indices, whole=glue.ends[1].key in groups.bodies)
    if not hosts:
        findings.reject(
            "TIS309",
            f"{second.name} has neither elements nor the springs of a thread that nodes could "
            "be glued to",
            glue.ends[1].span,
            hint="glue to a body of elements or to a thread, or join nodes by springs",
        )
    own = np.unique(np.concatenate([each.nodes.ravel() for each in hosts]))
    if common := int(np.isin(first.indices, own).sum()):
        findings.reject(
            "TIS309",
            f"{counted(common, 'node')} of {first.name} "
            f"{'belongs' if common == 1 else 'belong'} to what {second.name} is part of, and "
            "no node can be glued to itself",
            where,
            hint="choose nodes of another body",
        )
    found = _weights(glue, network.position, first.indices, hosts)
    if len(found.far):
        _refuse_far(glue, network, first, second, found, findings)
    return first.indices, found.weights


class NodeWeights(NamedTuple):
    """The weights that were found.

    Attributes:
        weights: Shape (node, node); those of nodes that are too far are 0.
        far: Nodes that are too far, shape (n,).
        distance: Of these [m], shape (n,); infinite if there is nothing near.
        reach: What it has to be at most [m].
        is_solid: Whether weights are continued beside what nodes are glued to.
    """

    weights: "csr_matrix"
    far: Indices
    distance: Floats
    reach: float
    is_solid: bool


def _hosts(network: Network, nodes: Indices, *, whole: bool) -> list[Hosts]:
    """Return the elements at some nodes, or else pieces of threads, as hosts.

    Args:
        nodes: Of a set or body, shape (n,).
        whole: Whether they are those of a body.
    """
    inside = np.zeros(network.node_count, dtype=bool)
    inside[nodes] = True
    found: list[Hosts] = []
    for each in network.elements:
        at = inside[each.nodes].any(axis=1)
        if at.any():
            shape = getattr(each, "shape", None)
            name = "triangle" if shape is None else shape.name
            found.append(Hosts(name, each.nodes[at].astype(np.int64)))
    solid = [each for each in found if each.is_solid]
    if found:
        return solid or found
    for thread in network.threads.values():
        pieces = network.springs.ends[thread.pieces].astype(np.int64)
        at = inside[pieces].all(axis=1)
        if at.any():
            found.append(Hosts("spring", pieces[at]))
    return found


def _weights(glue: Glue, position: Floats, nodes: Indices, hosts: list[Hosts]) -> NodeWeights:
    """Return the weights of nodes in the nearest of what they can be glued to."""
    from scipy.sparse import coo_matrix

    edge = max(float(_sizes(position[each.nodes]).mean()) for each in hosts)
    is_solid = all(each.is_solid for each in hosts)
    reach = REACH * edge if glue.reach is None else glue.reach
    points, count = position[nodes], len(position)
    least, entries = np.full(len(nodes), np.inf), dict[int, tuple[Indices, Floats]]()
    for each in hosts:
        point, element = _candidates(points, position[each.nodes], reach)
        weights, beside = _placed(each, points[point], position[each.nodes[element]])
        # The nearest one, and of those alike the first one.
        order = np.lexsort((element, np.round(beside / edge, 9), point))
        point, first = np.unique(point[order], return_index=True)
        for k, pair in zip(point, order[first], strict=True):
            if beside[pair] < least[k] - ON * edge:
                least[k] = beside[pair]
                entries[int(k)] = each.nodes[element[pair]], weights[pair]
    near = least <= (reach if is_solid else min(reach, 1e3 * ON * edge)) * (1.0 + ON)
    rows, columns, values = [], [], []
    for k in np.flatnonzero(near):
        own, weight = entries[int(k)]
        kept = np.abs(weight) > ROUNDING
        rows.append(np.full(int(kept.sum()), nodes[k]))
        columns.append(own[kept])
        values.append(weight[kept] / weight[kept].sum())
    none = [np.zeros(0, dtype=np.int64)]
    at = np.concatenate([*none, *rows]), np.concatenate([*none, *columns])
    found = coo_matrix((np.concatenate([np.zeros(0), *values]), at), shape=(count, count))
    limit = reach if is_solid else 1e3 * ON * edge
    return NodeWeights(found.tocsr(), nodes[~near], least[~near], limit, is_solid)


def _sizes(corners: Floats) -> Floats:
    """Return a length of edges of each element [m], shape (element,).

    Args:
        corners: Of elements [m], shape (element, node, 3).
    """
    return norm(corners - corners[:, :1])[:, 1:].min(axis=1)


def _candidates(points: Floats, corners: Floats, reach: float) -> tuple[Indices, Indices]:
    """Return pairs of points and elements in whose boxes, widened by the reach, they are.

    Args:
        points: [m], shape (point, 3).
        corners: Of elements [m], shape (element, node, 3).
    """
    from scipy.spatial import KDTree

    low, high = corners.min(axis=1), corners.max(axis=1)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    radius = norm(half) + reach
    near = KDTree(points).query_ball_point(middle, radius * (1.0 + ON), return_sorted=True)
    point = np.concatenate([np.zeros(0, dtype=np.int64), *map(_as_indices, near)])
    element = np.repeat(np.arange(len(corners)), [len(each) for each in near])
    inside = np.abs(points[point] - middle[element]) <= (half[element] + reach) * (1.0 + ON)
    inside = inside.all(axis=1)
    return point[inside], element[inside]


def _as_indices(values: list[int]) -> NDArray[np.int64]:
    return np.asarray(values, dtype=np.int64)


def _placed(hosts: Hosts, points: Floats, corners: Floats) -> tuple[Floats, Floats]:
    """Return weights of points, shape (pair, node), and how far they are beside [m]."""
    if hosts.is_solid:
        return places_in(hosts.shape, points, corners)
    if hosts.shape == "spring":
        corners = np.concatenate([corners, corners[:, 1:]], axis=1)
        ends = _nearest(points, corners)
        weights = np.stack([ends[:, 0], ends[:, 1] + ends[:, 2]], axis=1)
    else:
        ends = weights = _nearest(points, corners)
    return weights, norm(points - np.einsum("pa,pak->pk", ends, corners))


def _nearest(points: Floats, corners: Floats) -> Floats:
    """Return the weights of corners of triangles in the points nearest to others."""
    kind = np.full(len(points), TRIANGLE)
    return places(points, kind, corners, np.zeros(len(points))).weights


def _node(network: Network, node: int) -> str:
    """Return the name of a node for messages."""
    body = network.body_at(node)
    return f"node {network.node_ids[node]} of {body.name}"


def _refuse_far(
    glue: Glue,
    network: Network,
    first: Group,
    second: Group,
    found: NodeWeights,
    findings: Findings,
) -> NoReturn:
    """Reject nodes that are too far from what they are glued to."""
    node, distance = int(found.far[0]), float(found.distance[0])
    x, y, z = (f"{1e3 * place:.4g}" for place in network.position[node])
    many = len(found.far)
    nearest = norm(network.position[second.indices] - network.position[node]).min()
    away = (
        f"is further than {show(found.reach, LENGTH)} from it, and {show(nearest, LENGTH)} "
        "from its nearest node"
    )
    hint = "write a larger reach, move the bodies together, or glue a set of near nodes only"
    if np.isfinite(distance) and not found.is_solid:
        away = f"is {show(distance, LENGTH)} beside it"
        hint = "nodes glued to a wall or a thread must lie on it: move them there"
    findings.reject(
        "TIS302",
        f"{counted(many, 'node')} of {first.name} {'is' if many == 1 else 'are'} not at "
        f"{second.name}: {_node(network, node)} at ({x}, {y}, {z}) mm {away}",
        glue.ends[0].span.to(glue.ends[1].span),
        hint=hint,
    )


def refuse_held(
    embedding: EmbeddedNodes, actions: Iterable[Action], network: Network, findings: Findings
) -> None:
    """Reject orders that hold or move glued nodes without all nodes that they follow.

    Args:
        actions: Of the script.
    """
    for action in actions:
        inside = np.zeros(network.node_count, dtype=bool)
        inside[nodes_held_by(action)] = True
        alone = embedding.nodes[inside[embedding.nodes] & embedding.any_of(~inside)]
        if len(alone):
            first = int(np.searchsorted(embedding.nodes, alone[0]))
            host = network.body_at(int(embedding.hosts[embedding.first[first]]))
            findings.add(
                "TIS309",
                f"{counted(len(alone), 'node')} of {network.body_at(int(alone[0])).name} "
                f"{'follows' if len(alone) == 1 else 'follow'} {host.name} by glue and cannot "
                "be held or moved alone",
                action.span,
                hint=f"name the nodes of {host.name} there instead, or as well",
            )
