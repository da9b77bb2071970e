"""Phantom nodes and spare elements of solids that the script cuts; see ``model.phantoms``."""

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tissuec.compiler.bodies.arrays import BodyArrays
from tissuec.core.structs import replace
from tissuec.lang import syntax as s
from tissuec.model.blocks import EMBEDDING, FieldBlock
from tissuec.model.network import BodyPart, Network, Provenance, numbers_in
from tissuec.model.phantoms import NO_RESERVE, Phantoms, Reserve
from tissuec.scene.model import Scene

#: Cuts for which all parts around a node have nodes of their own where they cross. A blade
#: makes two parts there, or three where one side is in two pieces.
MOST = 3
_PARTS = 2  # of a cell that a blade divides


def cut_counts(scene: Scene) -> Counter[str]:
    """Return how many sentences of the script cut each body, by the key of its name."""
    script = scene.declarations.single.get("script")
    return Counter() if script is None else Counter(_cut_names(script.items))


def _cut_names(items: Iterable[s.Item]) -> Iterable[str]:
    """Yield the name, as a key, of what each cut of a script is of."""
    for item in items:
        if isinstance(item, s.Timed):
            yield from _cut_names(item.body)
        elif isinstance(item, s.Sentence):
            verb, _, name = item.name.key.partition(" ")
            if verb == "cut":
                yield from (one.key for one in item.name.listed) if item.name.listed else [name]


def reserve_of(body: BodyArrays, cuts: int) -> Reserve:
    """Return the reserve that a solid needs for a number of cuts, at least one.

    Quadratic hexahedra, and elements that can break, are removed where they are cut.
    """
    solids = body.elements
    if any(each.shape.functions > 1 or each.limits is not None for each in solids):
        return NO_RESERVE
    copies = 2 ** min(cuts, MOST)
    elements = sum(each.item_count for each in solids)
    return Reserve(copies * len(body.mesh.position), _PARTS * cuts * elements, cuts)


def with_phantoms(body: BodyArrays, cuts: int) -> BodyArrays:
    """Return a solid with its reserve for cuts.

    Args:
        cuts: How many sentences cut it, at least one.
    """
    reserve = reserve_of(body, cuts)
    if not reserve.nodes:
        return body
    parents = np.tile(np.arange(len(body.mesh.position)), 1 + reserve.nodes // len(body.mass))

    def copied(values: NDArray[Any]) -> NDArray[Any]:
        return values[parents]

    weight = body.provenance["mass"]
    return replace(
        body,
        mesh=replace(body.mesh, position=copied(body.mesh.position)),
        mass=copied(body.mass),
        velocity=copied(body.velocity),
        node_ids=copied(body.node_ids),
        weighing=None if body.weighing is None else copied(body.weighing),
        friction=replace(body.friction, nodes=copied(body.friction.nodes)),
        provenance={
            **body.provenance, "mass": Provenance(copied(weight.index), weight.origins),
        },
        breaking=body.breaking and _extended(body.breaking, reserve.elements),
        reserve=reserve,
    )  # fmt: skip


def _extended(known: Provenance, more: int) -> Provenance:
    """Return origins with those of more entries, which have none of their own."""
    none = np.zeros(more, dtype=known.index.dtype)
    return Provenance(np.append(known.index, none), known.origins)


def phantoms_of_bodies(bodies: Sequence[BodyPart]) -> tuple[Phantoms, ...]:
    """Return the phantoms of bodies with a reserve."""
    found: list[Phantoms] = []
    for body in (each for each in bodies if each.reserve.nodes):
        nodes, elements, cuts = body.reserve
        first = int(body.nodes.stop) - nodes
        drawn = np.arange(int(body.nodes.start), first)
        spare = slice(int(body.elements.stop) - elements, int(body.elements.stop))
        copies = nodes // len(drawn)
        found.append(
            Phantoms(
                body.name, slice(first, first + nodes), np.tile(drawn, copies), spare, cuts
            )
        )
    return tuple(found)


def parked(network: Network) -> FieldBlock:
    """Return the embedding of phantoms in their parents, beside glue."""
    from tissuec.forces.acting.embedding import EmbeddedNodes  # where there are phantoms

    nodes = np.concatenate([numbers_in(part.nodes) for part in network.phantoms])
    field = EmbeddedNodes.alone(nodes, network.parents[nodes])
    field = field if network.embedding is None else network.embedding.joined_with(field)
    return FieldBlock(EMBEDDING, EMBEDDING, field, None)
