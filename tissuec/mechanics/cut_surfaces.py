"""Surfaces of solids that blades have divided: riders at their corners, and what acts on them.

The surface of a part is drawn with riding points (``model.cut_cells``). For something to act
there, these points are nodes: *riders* from the reserve of the body, embedded in the nodes of
the part. Riders of parts that are divided again are free for others.
"""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tissuec.core.arrays import counted_up, cross, dot, norm
from tissuec.core.structs import replace
from tissuec.forces.acting.embedding import EmbeddedNodes
from tissuec.model.blocks import EMBEDDING, FieldBlock
from tissuec.model.cut_cells import CutCells, PartTriangles
from tissuec.model.network import Indices, MirrorPlane, Network, numbers_in
from tissuec.model.phantoms import NotDivisible, Phantoms

if TYPE_CHECKING:
    from tissuec.mechanics.state import State


#: Largest distance of the middle of a part from its triangle, over the size of the triangle:
#: faces of four corners are warped.
NEAR = 0.2


def riders_of(
    state: "State", phantoms: Phantoms, drawn: CutCells, alive: NDArray[np.bool_]
) -> Indices:
    """Return the node of each riding point that something can act on, else -1, shape (point,).

    Args:
        phantoms: The reserve of the body that is cut.
        drawn: The parts after a cut.
        alive: Entities that are there then, shape (entity,).

    Raises:
        NotDivisible: The riders of the body are exhausted.
    """
    acts = np.zeros(drawn.nodes + len(drawn.points), dtype=bool)
    acts[drawn.triangles[alive[drawn.borders]]] = True
    acts = acts[drawn.nodes :]
    known = np.zeros(0, dtype=np.int64) if state.riders is None else state.riders
    riders = np.append(known, np.full(len(acts) - len(known), -1))
    riders[~acts] = -1
    new = np.flatnonzero(acts & (riders < 0))
    free = np.setdiff1d(numbers_in(phantoms.riders), riders)
    if len(new) > len(free):
        raise NotDivisible(f"the surface of {phantoms.body} has been cut into too many pieces")
    riders[new] = free[: len(new)]
    return riders


def let_ride(state: "State", riders: Indices, copies: Indices) -> None:
    """Embed riders in the nodes of parts, and park those that are free again.

    Args:
        riders: Of the riding points of the state, see ``riders_of``, shape (point,).
        copies: Phantom nodes that are nodes of their own from now on, shape (n,).
    """
    drawn, embedding, network = state.cut_cells, state.embedding, state.network
    assert drawn is not None
    assert embedding is not None
    former = np.zeros(0, dtype=np.int64) if state.riders is None else state.riders
    begins = riders >= 0
    begins[: len(former)] &= former < 0
    freed = np.setdiff1d(former[former >= 0], riders)
    left = embedding.without(np.concatenate([copies, freed, riders[begins]]))
    left = left.joined_with(EmbeddedNodes.alone(freed, network.parents[freed]))
    sums = drawn.points.some(begins)
    left = left.joined_with(
        EmbeddedNodes(
            nodes=riders[begins], first=sums.first, hosts=sums.hosts, weights=sums.weights,
            shares=sums.weights,
        )
    )  # fmt: skip
    state.put(FieldBlock(EMBEDDING, EMBEDDING, left, None))
    state.riders = riders
    state.follow_hosts()


def part_triangles(state: "State") -> PartTriangles:
    """Return the triangles that bound parts now: of the outer surface, and cut faces."""
    drawn, riders = state.cut_cells, state.riders
    assert drawn is not None
    assert riders is not None
    there = np.flatnonzero(state.alive[drawn.borders])
    number = np.append(np.arange(drawn.nodes), riders)
    cuts = drawn.cuts[there]
    outer = cuts == 0
    skin = np.full(len(there), -1)
    skin[outer] = _triangles_of_skin(state.network, drawn, there[outer])
    planes = tuple(_with_riders(state, plane) for plane in state.network.mirrored)
    corners, parts = number[drawn.triangles[there]], drawn.borders[there]
    return PartTriangles(corners, skin, cuts, parts, planes)


def _with_riders(state: "State", plane: MirrorPlane) -> MirrorPlane:
    """Return a plane of symmetry with the copies of its nodes, and the riders on it."""
    on = np.isin(state.network.parents, plane.nodes)
    embedding = state.embedding
    assert embedding is not None
    on[embedding.nodes] = ~embedding.any_of(~on)
    return replace(plane, nodes=np.flatnonzero(on))


def _triangles_of_skin(network: Network, drawn: CutCells, chosen: Indices) -> Indices:
    """Return the triangle of the skin as drawn that each of some triangles lies in, shape (n,).

    Of those of the same element, it is the one that contains the middle; -1 if none does.

    Args:
        drawn: With the triangles.
        chosen: Of the outer surface, shape (n,).
    """
    elements = network.skin_elements
    assert elements is not None, "solids that are cut have them"
    place = drawn.points.beside(network.position)
    middle = place[drawn.triangles[chosen]].mean(axis=1)
    whole = drawn.wholes_of(drawn.borders[chosen])
    rows = np.argsort(elements, kind="stable")
    first = np.searchsorted(elements, whole, sorter=rows)
    count = np.searchsorted(elements, whole, side="right", sorter=rows) - first
    found = np.full(len(chosen), -1)
    of = np.repeat(np.arange(len(chosen)), count)
    row = rows[first[of] + counted_up(count)]
    a, b, c = place[network.skin[row]].swapaxes(0, 1)
    normal = np.asarray(cross(b - a, c - a))
    area = norm(normal)
    x = middle[of]
    inside = [dot(cross(q - p, x - p), normal) / area**2 for p, q in ((a, b), (b, c), (c, a))]
    away = np.abs(dot(x - a, normal)) / area**1.5
    score = np.minimum(np.min(inside, axis=0), 0.0) - away
    order = np.lexsort((score, of))
    order = order[score[order] > -NEAR]
    found[of[order]] = row[order]  # the last one, which is the best
    return found
