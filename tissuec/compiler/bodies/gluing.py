"""Glue: nodes of one body as fixed weighted sums of the nodes of another.

Each node gets the weights of the element that contains it, or of the nearest one within reach,
whose functions are continued to it. So nothing has to move, and the weights reproduce every
linear field. On walls and threads, nodes have to lie in a triangle or on a spring. Nodes of
faces that lie at faces get mean weights instead, which pass uniform stress on; see ``mortar``.
Masses are shared by the functions of corners.
"""

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, NamedTuple, NoReturn

import numpy as np

from tissuec.compiler.bodies.hosts import (
    CORNERS,
    ON,
    Hosts,
    candidates,
    hosts_at,
    placed,
    sizes,
)
from tissuec.compiler.bodies.mortar import SideFaces, faces_of, mortar_weights, outer
from tissuec.compiler.sets import Groups
from tissuec.core.arrays import norm
from tissuec.core.errors import counted
from tissuec.core.units import LENGTH, show
from tissuec.forces.acting.embedding import EmbeddedNodes
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
ROUNDING = 1e-12  # weights that are zero


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
    spread, owner = [csr_matrix((count, count))] * 2, np.full(count, -1)
    glues = scene.embeddings
    for number, glue in enumerate(glues):
        with findings.item():
            nodes, *weights = _glued(glue, network, groups, findings)
            if (again := nodes[owner[nodes] >= 0]).size:
                first = glues[int(owner[again[0]])]
                findings.reject(
                    "TIS309",
                    f"{first.name} glues {_node(network, int(again[0]))} already",
                    glue.span,
                    hint=f"leave it out in {glue.name}, by a set of the other nodes",
                )
            owner[nodes] = number
            spread = [csr_matrix(a + b) for a, b in zip(spread, weights, strict=True)]
    embedded = np.flatnonzero(owner >= 0)
    if not len(embedded):
        findings.stop()
    weights, shares = (_composed(one, owner, glues, findings)[embedded] for one in spread)
    every = csr_matrix(abs(weights) + abs(shares))
    every.sort_indices()
    at = np.repeat(np.arange(len(embedded)), np.diff(every.indptr)), every.indices
    field = EmbeddedNodes(
        first=every.indptr.astype(np.int64),
        hosts=every.indices.astype(np.int64),
        weights=np.asarray(weights[at]).ravel(),
        nodes=embedded,
        shares=np.asarray(shares[at]).ravel(),
    )
    shared = field.lumped(network.mass)
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
) -> "tuple[Indices, csr_matrix, csr_matrix]":
    """Return the nodes that a glue embeds, weights and shares of mass, shape (node, node)."""
    first, second = groups.both(glue.ends)
    hosts = hosts_at(network, second.indices)
    if not hosts:
        findings.reject(
            "TIS309",
            f"{second.name} has neither elements nor the springs of a thread that nodes could "
            "be glued to",
            glue.ends[1].span,
            hint="glue to a body of elements or to a thread, or join nodes by springs",
        )
    refuse_common(glue, first, second, hosts, findings)
    found = _weights(glue, network, first.indices, hosts)
    if len(found.far):
        _refuse_far(glue, network, first, second, found, findings)
    return first.indices, found.weights, found.shares


def refuse_common(
    glue: Glue, first: Group, second: Group, hosts: Sequence[Hosts], findings: Findings
) -> None:
    """Reject glue of nodes to what they belong to."""
    own = np.unique(np.concatenate([each.nodes.ravel() for each in hosts]))
    if common := int(np.isin(first.indices, own).sum()):
        findings.reject(
            "TIS309",
            f"{counted(common, 'node')} of {first.name} "
            f"{'belongs' if common == 1 else 'belong'} to what {second.name} is part of, and "
            "no node can be glued to itself",
            glue.ends[0].span.to(glue.ends[1].span),
            hint="choose nodes of another body",
        )


class NodeWeights(NamedTuple):
    """The weights that were found.

    Attributes:
        weights: Shape (node, node); those of nodes that are too far are 0.
        shares: Of masses, likewise.
        far: Nodes that are too far, shape (n,).
        distance: Of these [m], shape (n,); infinite if there is nothing near.
        reach: What it has to be at most [m].
        is_solid: Whether weights are continued beside what nodes are glued to.
    """

    weights: "csr_matrix"
    shares: "csr_matrix"
    far: Indices
    distance: Floats
    reach: float
    is_solid: bool


def _weights(glue: Glue, network: Network, nodes: Indices, hosts: list[Hosts]) -> NodeWeights:
    """Return the weights of nodes in the nearest of what they can be glued to."""
    from scipy.sparse import csr_matrix, diags

    position = network.position
    edge, reach = edge_and_reach(glue, position, hosts)
    is_solid = all(each.is_solid for each in hosts)
    limit = reach if is_solid else min(reach, 1e3 * ON * edge)
    points = position[nodes]
    least, entries = np.full(len(nodes), np.inf), dict[int, tuple[str, Indices, Floats]]()
    for each in hosts:
        point, element = candidates(points, position[each.nodes], reach)
        weights, beside = placed(each.shape, points[point], position[each.nodes[element]])
        # The nearest one, and of those alike the first one.
        order = np.lexsort((element, np.round(beside / edge, 9), point))
        point, first = np.unique(point[order], return_index=True)
        for k, pair in zip(point, order[first], strict=True):
            if beside[pair] < least[k] - ON * edge:
                least[k] = beside[pair]
                entries[int(k)] = each.shape, each.nodes[element[pair]], weights[pair]
    near = least <= limit * (1.0 + ON)
    found, shares = [], []
    for k in np.flatnonzero(near):
        shape, own, weight = entries[int(k)]
        found.append((nodes[k], own, weight))
        shares.append((nodes[k], own, weight @ CORNERS[shape] if shape in CORNERS else weight))
    weights, lumping = (_matrix(each, len(position)) for each in (found, shares))
    if near.all() and (faces := _faces(network, nodes)) and hosts[0].shape != "spring":
        beside = outer([one for each in hosts for one in faces_of(each)])
        passing, mean = mortar_weights(position, faces, beside, limit)
        points = np.ones(len(position))
        points[passing] = 0.0
        weights = csr_matrix(diags(points) @ weights + mean)
    return NodeWeights(weights, lumping, nodes[~near], least[~near], limit, is_solid)


def edge_and_reach(glue: Glue, position: Floats, hosts: Sequence[Hosts]) -> tuple[float, float]:
    """Return the length of edges of hosts, and how far what is glued may be from them [m].

    Args:
        position: Of all nodes [m], shape (node, 3).
    """
    edge = max(float(sizes(position[each.nodes]).mean()) for each in hosts)
    return edge, REACH * edge if glue.reach is None else glue.reach


def _faces(network: Network, nodes: Indices) -> list[SideFaces]:
    """Return the faces of solid elements that have glued nodes, of elements with others, too.

    Args:
        nodes: That are glued, shape (n,).
    """
    glued = np.zeros(network.node_count, dtype=bool)
    glued[nodes] = True
    found: list[SideFaces] = []
    for each in network.of_kind("elements"):
        at = glued[each.nodes]
        some = each.nodes[at.any(axis=1) & ~at.all(axis=1)].astype(np.int64)
        for faces in faces_of(Hosts(each.shape.name, some)):
            chosen = glued[faces.nodes].all(axis=1)
            if chosen.any():
                found.append(faces.some(chosen))
    return found


def _matrix(rows: list[tuple[int, Indices, Floats]], count: int) -> "csr_matrix":
    """Return weights of nodes, each with its hosts, as a matrix of shape (count, count)."""
    from scipy.sparse import coo_matrix

    nodes, hosts, weights = [], [np.zeros(0, dtype=np.int64)], [np.zeros(0)]
    for node, own, weight in rows:
        kept = np.abs(weight) > ROUNDING
        nodes += [node] * int(kept.sum())
        hosts.append(own[kept])
        weights.append(weight[kept] / weight[kept].sum())
    at = np.array(nodes, dtype=np.int64), np.concatenate(hosts)
    return coo_matrix((np.concatenate(weights), at), shape=(count, count)).tocsr()


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
