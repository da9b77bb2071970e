"""Phantom nodes and spare elements of bodies that the script cuts; see ``model.phantoms``."""

from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import product
from math import ceil
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tissuec.compiler.bodies.arrays import BodyArrays
from tissuec.core.structs import replace
from tissuec.lang import syntax as s
from tissuec.model.blocks import EMBEDDING, FieldBlock
from tissuec.model.network import BodyPart, Floats, Network, Provenance
from tissuec.model.phantoms import NO_RESERVE, Phantoms, Reserve
from tissuec.scene.model import Scene

if TYPE_CHECKING:
    from tissuec.forces.point_fields import PointField

#: Cuts for which all parts around a node have nodes of their own where they cross. A blade
#: makes two parts there, or three where one side is in two pieces.
MOST = 3
_PARTS = 2  # of a cell that a blade divides
#: Riders for each element that the worst plane crosses; random blades need up to 8.3 in
#: hexahedra.
_RIDERS = {
    "hexahedron": 12.0, "quadratic hexahedron": 12.0, "wedge": 9.0, "tetrahedron": 4.0,
    "triangle": 4.0,
}  # fmt: skip
FEW = 60  # in addition: parts of small bodies share few points, and many cuts meet in each
#: Planes by which the largest section of a body is estimated: along faces, edges and corners
#: of a cube.
_NORMALS = np.array([n for n in product((-1, 0, 1), repeat=3) if n > (0, 0, 0)], dtype=float)


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
    """Return the reserve that a body needs for its interfaces and a number of cuts.

    Interfaces come first: each of the nodes that they make may be cut.

    Elements that can break other than by faces are removed where they are cut.
    """
    fields, tears = body.elements, body.body.tears_by_faces
    breaks = any(one.limits is not None for one in fields) and not tears
    if breaks:
        return NO_RESERVE
    of_each = 1 + 2 ** min(cuts, MOST) if cuts else 1
    copies = ((1 + body.parting.copies) * of_each - 1) * len(body.mesh.position)
    elements = sum(each.item_count for each in fields)
    riders = cuts * ceil(sum(_riders(each, body.mesh.position) for each in fields))
    spare = _PARTS * cuts * (elements + FEW) + body.parting.elements
    return Reserve(copies + riders, spare, cuts, riders)


def _riders(elements: "PointField", position: Floats) -> float:
    """Return how many riders the worst of some planes through elements needs."""
    most = max(_crossed((position @ normal)[elements.nodes]) for normal in _NORMALS)
    return _RIDERS[elements.cell_shape] * most + FEW


def _crossed(heights: Floats) -> int:
    """Return how many elements a plane of the worst height crosses.

    Args:
        heights: Of nodes [m], shape (element, node).
    """
    low, high = np.sort(heights.min(axis=1)), np.sort(heights.max(axis=1))
    return int((np.arange(1, len(low) + 1) - np.searchsorted(high, low, side="right")).max())


def with_phantoms(body: BodyArrays, cuts: int) -> BodyArrays:
    """Return a body with its reserve for interfaces and cuts.

    Args:
        cuts: How many sentences cut it.
    """
    reserve = reserve_of(body, cuts)
    if not reserve.nodes:
        return body
    drawn, copies = len(body.mass), reserve.nodes - reserve.riders
    parents = np.tile(np.arange(drawn), 1 + copies // drawn)
    parents = np.append(parents, np.zeros(reserve.riders, dtype=np.int64))

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
        nodes, elements, cuts, riders = body.reserve
        stop, copies = int(body.nodes.stop), nodes - riders
        first = stop - nodes
        drawn = np.arange(int(body.nodes.start), first)
        spare = slice(int(body.elements.stop) - elements, int(body.elements.stop))
        parents = np.tile(drawn, copies // len(drawn))
        own, riding = slice(first, first + copies), slice(first + copies, stop)
        found.append(Phantoms(body.name, own, parents, spare, cuts, riders=riding))
    return tuple(found)


def parked(network: Network) -> FieldBlock:
    """Return the embedding of phantoms in their parents, beside glue."""
    from tissuec.forces.acting.embedding import EmbeddedNodes  # where there are phantoms

    nodes = np.concatenate([part.reserved for part in network.phantoms])
    field = EmbeddedNodes.alone(nodes, network.parents[nodes])
    field = field if network.embedding is None else network.embedding.joined_with(field)
    return FieldBlock(EMBEDDING, EMBEDDING, field, None)
