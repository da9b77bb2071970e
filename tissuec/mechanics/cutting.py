"""Cuts through elements: blades divide those of a solid or a wall into parts.

An element that a blade crosses is replaced by its parts, each of which has all nodes of the
whole and integrates over its own matter (``geometry.cut_cells``). Nodes beyond the blade are
phantom nodes (``model.phantoms``), which take position and velocity of the nodes that they are
copies of, and part of their masses, so that mass and momentum stay the same.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.arrays import counted_up
from tissuec.core.structs import replace
from tissuec.geometry.cut_cells.cutting import DividedCells, cut, near_heights, parted
from tissuec.geometry.cut_cells.joining import free_faces, parting_levels
from tissuec.geometry.cut_cells.overlaps import offsets
from tissuec.geometry.cut_cells.parts import CellParts, PartPieces, PieceFaces, Sides
from tissuec.geometry.cut_cells.sections import CutFacets
from tissuec.geometry.elements import Measures
from tissuec.mechanics.cut_body import CutBody
from tissuec.mechanics.cut_effects import on_parts
from tissuec.mechanics.cut_fields import field_of, measures_of, put_bending, volumes_at_nodes
from tissuec.mechanics.cut_surfaces import let_ride, riders_of
from tissuec.mechanics.tying import TiedSections
from tissuec.model.cut_cells import CutCells, WeightedSums
from tissuec.model.edges import bare_edges
from tissuec.model.network import Floats, Indices, Network
from tissuec.model.phantoms import NotDivisible, Phantoms

if TYPE_CHECKING:
    from tissuec.forces.point_fields import PointField
    from tissuec.mechanics.cut_cavities import HeldVolumes
    from tissuec.mechanics.state import State

Bools = NDArray[np.bool_]
ROUNDING = 1e-12  # weights that are zero, and differences of those that are equal


class Division(Struct, frozen=True, eq=False):
    """What a cut makes of a body; nothing is changed yet.

    Attributes:
        phantoms: The reserve of the body.
        body: Its elements after the cut.
        moved: Places of internal variables that are copied, and of their copies, among the
            components of all velocities, shape (2, n).
        is_new: Which parts are new: of divided elements, with other nodes, or with a face that
            lies in the surface, shape (part,) each.
        lost: Entities that are divided, ascending.
        copies: New nodes, shape (n,).
        copied: The nodes that these are copies of, shape (n,).
        measured: Gradients and volumes of points of parts that are not whole.
        triangles: Of the surface of the cut, with numbers of parts over all shapes.
        tied: Sections of former cuts that are still tied, on the parts after the cut.
        drawn: All parts after the cut.
        riders: Of their riding points, see ``State``.
    """

    phantoms: Phantoms
    body: CutBody
    moved: Indices
    is_new: tuple[Bools, ...]
    lost: Indices
    copies: Indices
    copied: Indices
    measured: tuple[Measures, ...]
    triangles: CutFacets
    tied: TiedSections | None
    drawn: CutCells
    riders: Indices

    def alive_after(self, alive: Bools) -> Bools:
        """Return which entities are there after the cut, shape (entity,)."""
        alive = alive.copy()
        alive[self.lost] = False
        for entities, new in zip(self.body.entities, self.is_new, strict=True):
            alive[entities[new]] = True
        return alive


def divided(
    state: "State", name: str, heights: Floats, by: str,
    active: tuple[Bools, ...] | None = None,
) -> Division | None:  # fmt: skip
    """Return the division of a body by a surface; None if it divides nothing.

    Args:
        name: Of the body.
        heights: Of all nodes above the surface [m], shape (node,).
        by: Name of the cut; what is divided by one after the other is one cut.
        active: Of the elements in ``CutBody.of``, those that it may divide, shape (part,) each;
            all by default.

    Raises:
        NotDivisible: There is nothing left in reserve.
    """
    before = CutBody.of(state, name)
    near = near_heights(before.parts, state.position)
    found = cut(before.parts, heights, active, near)
    if not len(found.copied):
        return None
    return _division_of(state, name, before.with_level(by), found, heights)


def parted_along(state: "State", name: str, sides: Sequence[Sides], by: str) -> Division:
    """Return the division of a body along the faces between two kinds of elements.

    Args:
        name: Of the body.
        sides: 1 of the kind in front, -1 of the one behind, 0 of others, of the elements in
            ``CutBody.of``, shape (part,) each.
        by: Name of the cut.

    Raises:
        NotDivisible: There is nothing left in reserve.
    """
    before, count = CutBody.of(state, name), state.network.node_count
    found = parted(before.parts, sides, count)
    return _division_of(state, name, before.with_level(by), found, np.full(count, np.nan))


def _division_of(
    state: "State", name: str, before: CutBody, found: DividedCells, heights: Floats
) -> Division:
    """Return the division of a body whose cells are divided.

    Args:
        name: Of the body.
        before: Its elements, with the level by which they are divided.
        found: What becomes of them.
        heights: Of all nodes above the surface [m], NaN where none is divided, shape (node,).

    Raises:
        NotDivisible: There is nothing left in reserve.
    """
    phantoms = state.network.phantoms_of(name)
    assert phantoms is not None
    is_new = _are_new(before, found)
    copies = _allocated(state, phantoms, found.copied)
    number = np.append(np.arange(state.network.node_count), copies)
    parts = tuple(replace(each, nodes=number[each.nodes]) for each in found.groups)
    entities, used = list[Indices](), before.used
    for source, own, new in zip(found.source, before.entities, is_new, strict=True):
        each = own[source]
        count = int(new.sum())
        each[new] = phantoms.elements.start + used + np.arange(count)
        used += count
        entities.append(each)
    if used > phantoms.elements.stop - phantoms.elements.start:
        raise NotDivisible(f"{name} has been cut into too many parts")
    lost = [
        own[np.unique(source[new])]
        for own, source, new in zip(before.entities, found.source, is_new, strict=True)
    ]
    slots, stored, moved = list[Indices](), before.stored, [np.zeros((2, 0), dtype=np.int64)]
    fields = state.network.elements_of(name)
    for field, source, own in zip(fields, found.source, before.slots, strict=True):
        each, copied = _copied_slots(field, own, source, 3 * phantoms.rows.start + stored)
        stored += copied.shape[1]
        slots.append(each)
        moved.append(copied)
    tied: TiedSections | None = state.tied.get(name)
    if tied is not None:
        tied = tied.after(before, found.source, entities, heights).copied(copies, found.copied)
    own, place = [each.some(~each.are_whole) for each in parts], state.network.position
    measured = tuple(measures_of(*one, place) for one in zip(fields, own, strict=True))
    division = Division(
        phantoms,
        CutBody(parts, tuple(entities), tuple(slots), before.cuts, used, stored),
        np.concatenate(moved, axis=1), is_new, np.sort(np.concatenate(lost)),
        copies, found.copied, measured, found.cut, tied,
        CutCells.none(state.network.node_count), np.zeros(0, dtype=np.int64),
    )  # fmt: skip
    return _with_surface(state, division)


def _with_surface(state: "State", division: Division) -> Division:
    """Return a division whose new parts are drawn, and have riders."""
    drawn = state.cut_cells or division.drawn
    drawn = drawn.followed_by(drawn_parts(state.network, division))
    alive = division.alive_after(state.alive)
    return replace(
        division, drawn=drawn, riders=riders_of(state, division.phantoms, drawn, alive)
    )


def _copied_slots(
    field: "PointField", slots: Indices, source: Indices, first: int
) -> tuple[Indices, Indices]:
    """Return where parts keep their tensors, and which components are copied, shape (2, n).

    The first part of an element keeps its place.

    Args:
        slots: Of the elements before, shape (tensor, element).
        source: The element that each part was, ascending, shape (part,).
        first: The first component that is free.
    """
    found = slots[:, source]
    again = np.append(False, source[1:] == source[:-1])
    tensor, part = np.nonzero((found >= 0) & again)
    size = field.tensor_size
    new = first + size * np.arange(len(part))
    old = found[tensor, part]
    found[tensor, part] = new
    every = np.arange(size)
    return found, np.stack([(each[:, None] + every).ravel() for each in (old, new)])


def _are_new(before: CutBody, found: DividedCells) -> tuple[Bools, ...]:
    """Return which parts are new, see ``Division``, shape (part,) each."""
    first, former = offsets(found.groups), offsets(before.parts)
    source = [each + low for each, low in zip(found.source, former[:-1], strict=True)]
    pair = np.concatenate(source)[found.cut.parts]
    beside = np.zeros(first[-1], dtype=bool)
    beside[found.cut.parts[pair[:, 0] != pair[:, 1]]] = True
    columns = found.source, before.parts, found.groups, first[:-1], first[1:]
    return tuple(
        (np.bincount(of, minlength=1)[of] > 1)
        | (after.nodes != own.nodes[of]).any(axis=1)
        | beside[low:high]
        for of, own, after, low, high in zip(*columns, strict=True)
    )


def _allocated(state: "State", phantoms: Phantoms, copied: Indices) -> Indices:
    """Return phantom nodes for copies of nodes, shape (n,).

    Args:
        copied: Shape (n,).

    Raises:
        NotDivisible: A node has no more phantoms.
    """
    assert state.shares is not None
    free = np.flatnonzero(state.shares[phantoms.nodes] == 0.0)
    parents = phantoms.parents[free]
    order = np.argsort(parents, kind="stable")
    free, parents = free[order] + int(phantoms.nodes.start), parents[order]
    wanted = state.network.parents[copied]
    order = np.argsort(wanted, kind="stable")
    _, count = np.unique(wanted, return_counts=True)
    rank = np.empty(len(wanted), dtype=np.int64)
    rank[order] = counted_up(count)
    at = np.searchsorted(parents, wanted) + rank
    there = at < len(parents)
    there[there] = parents[at[there]] == wanted[there]
    if not there.all():
        node = int(state.network.node_ids[wanted[~there][0]])
        raise NotDivisible(
            f"more blades meet at node {node} of {phantoms.body} than its parts have nodes for"
        )
    return free[at]


def carry_out(state: "State", division: Division) -> None:
    """Divide the elements of a body; the state is changed in place."""
    phantoms, copies, copied = division.phantoms, division.copies, division.copied
    network, held = state.network, _held_volumes(state)
    state.position = state.position.copy()
    state.position[copies], state.velocity[copies] = (
        state.position[copied], state.velocity[copied],
    )  # fmt: skip
    _share_masses(state, division)
    state.velocity = np.ascontiguousarray(state.velocity)
    flat = state.velocity.reshape(-1)
    flat[division.moved[1]] = flat[division.moved[0]]
    state.alive = division.alive_after(state.alive)
    fields = network.elements_of(phantoms.body)
    body = division.body
    for each in zip(
        fields, body.parts, body.entities, body.slots, division.measured, strict=True
    ):
        _put_elements(state, *each)
        put_bending(state, phantoms.body, *each[1:3])
    state.cut_bodies = {**state.cut_bodies, phantoms.body: division.body}
    state.cut_cells = division.drawn
    let_ride(state, division.riders, copies)
    _extend_sets(state, copies, copied)
    # Fluids are put on parts as soon as it is known what is tied, see ``put_ties``.
    state.put(*on_parts(state, tuple(b for b in state.blocks.values() if b.kind != "fluid")))
    for each in held:
        each.keep_pressures(state)


def _held_volumes(state: "State") -> "list[HeldVolumes]":
    """Return the volumes of cavities before a cut."""
    if not (fluids := state.of_kind("fluid")):
        return []
    from tissuec.mechanics.cut_cavities import HeldVolumes  # where there are any

    return [HeldVolumes.of(state, each) for each in fluids]


def carry_out_tied(
    state: "State", division: Division, heights: Floats
) -> tuple[TiedSections, TiedSections, Indices]:
    """Divide the elements of a body; the state is changed in place, but for its ties.

    Args:
        heights: Of all nodes above the surface [m], shape (node,).

    Returns:
        What is tied of former cuts, all sections of this one, and edges that are lost, shape
        (n,).
    """
    heights = heights.copy()
    heights[division.copies] = heights[division.copied]
    carry_out(state, division)
    edges = part_edges(state, division.lost, heights)
    body = division.body, division.triangles
    new = TiedSections.of(state.network, division.phantoms.body, *body, heights)
    old = division.tied
    if old is None:
        old = TiedSections.none(len(heights), new.roots.shape[2])
    return old, new, edges


def part_edges(state: "State", lost: Indices, heights: Floats) -> Indices:
    """Remove edges that a surface crosses and no element has any more; return them.

    Args:
        lost: Elements that it has divided, entities, shape (n,).
        heights: Of all nodes above it [m], shape (node,).

    Returns:
        Entities, shape (m,).
    """
    network = state.network
    edges = bare_edges(network, state.alive, lost)
    ahead = heights[network.line_ends[edges]] >= 0.0
    edges = edges[ahead.any(axis=1) & ~ahead.all(axis=1)]
    state.alive[edges] = False
    return edges


def _put_elements(
    state: "State",
    field: "PointField",
    parts: CellParts,
    entities: Indices,
    slots: Indices,
    measured: Measures,
) -> None:
    """Put the elements of a shape, after a cut, beside those of the drawn body."""
    whole = parts.are_whole
    cell = parts.cell[whole]
    moved = entities[whole] != field.walls[cell]
    if moved.any():
        item, every = cell[moved], np.arange(np.count_nonzero(moved))
        made = replace(
            field.only(item), nodes=parts.nodes[whole][moved], walls=entities[whole][moved],
            walled=every,
        ).with_slots(slots[:, whole][:, moved])  # fmt: skip
        block = field.block
        state.put(replace(block, name=f"{block.name} beside cuts", field=made))
    own = parts.some(~whole)
    if not len(own):
        return
    made = field_of(field, own, measured, entities[~whole])
    state.put(made.with_slots(slots[:, ~whole]).block)


def _share_masses(state: "State", division: Division) -> None:
    """Share masses and drag of copied nodes among their copies, by the matter around them."""
    assert state.shares is not None
    matter = np.zeros(len(state.shares))
    fields = state.network.elements_of(division.phantoms.body)
    drawn = state.network.body_named(division.phantoms.body)
    for field, parts, measured in zip(
        fields, division.body.parts, division.measured, strict=True
    ):
        own, are_whole = parts.some(~parts.are_whole), parts.are_whole
        volumes = volumes_at_nodes(field, own, measured, state.network.position)
        cell = parts.cell[are_whole]
        each = [
            (parts.nodes[are_whole], field.node_volumes[cell], cell),
            (own.nodes, volumes, own.cell),
        ]
        for nodes, sizes, of in each:
            if drawn.density is not None:
                dense = drawn.density[field.walls[of] - int(drawn.elements.start)]
                sizes = sizes * dense[:, None]
            matter += np.bincount(nodes.ravel(), sizes.ravel(), len(matter))
    copied, place = np.unique(division.copied, return_inverse=True)
    every = np.concatenate([copied, division.copies])
    lineage = np.concatenate([np.arange(len(copied)), place])
    share = matter[every] / np.bincount(lineage, matter[every])[lineage]
    before = copied[lineage]
    mass, shares = state.mass.copy(), state.shares.copy()
    mass[every] = state.mass[before] * share
    shares[every] = state.shares[before] * share
    state.mass, state.shares = mass, shares


def _extend_sets(state: "State", copies: Indices, copied: Indices) -> None:
    """Let copies be held, driven and pushed as the nodes are that they are copies of."""
    is_copy = np.zeros(state.network.node_count, dtype=bool)
    is_copy[copies] = True
    of = np.arange(len(is_copy))
    of[copies] = copied
    for name, nodes in state.holders.items():
        found = state.with_copies(nodes)
        more = found[is_copy[found]]
        if len(more):
            state.holders[name] = np.union1d(nodes, more)
    for name, motion in state.motions.items():
        found = state.with_copies(np.unique(motion.nodes))
        more = found[is_copy[found]]
        if len(more):
            row = np.full(len(of), -1)
            row[motion.nodes] = np.arange(len(motion.nodes))
            state.motions[name] = motion.some(
                np.concatenate([motion.nodes, more]),
                np.concatenate([np.arange(len(motion.nodes)), row[of[more]]]),
            )
    state.directed = {
        name: replace(hold, nodes=state.with_copies(hold.nodes))
        for name, hold in state.directed.items()
    }
    state.guide()
    for name, load in state.loads.items():
        state.loads[name] = _shared_load(state, load, is_copy, of)


def _shared_load(state: "State", load, is_copy: Bools, of: Indices):
    """Return a load that copies share with the nodes that they are copies of."""
    found = state.with_copies(np.unique(load.nodes))
    more = found[is_copy[found]]
    if not len(more):
        return load
    assert state.shares is not None
    total = np.zeros(len(of))
    members = np.concatenate([np.unique(of[more]), more])
    np.add.at(total, of[members], state.shares[members])
    factors, nodes = load.factors, load.nodes
    part = np.ones(len(of))
    part[members] = state.shares[members] / total[of[members]]
    entry = np.concatenate([np.flatnonzero(nodes == of[node]) for node in more])
    copies = np.concatenate([np.full((nodes == of[node]).sum(), node) for node in more])
    return replace(
        load,
        nodes=np.concatenate([nodes, copies]),
        shares=np.concatenate([factors * part[nodes], factors[entry] * part[copies]]),
    )


def drawn_parts(network: Network, division: Division) -> CutCells:
    """Return the drawing of new parts: their matter, outer surface, and cut faces."""
    found = CutCells.none(network.node_count)
    fields = network.elements_of(division.phantoms.body)
    body = division.body
    both = free_faces(body.parts), parting_levels(body.parts)
    number = _numbers(body.cuts)
    columns = fields, body.parts, body.entities, division.is_new, *both
    for field, parts, entities, new, free, parting in zip(*columns, strict=True):
        own = parts.some(new)
        pieces = own.with_roots(np.ones(len(own), dtype=bool))
        if parts.division.dimension == 2:
            wall = _drawn_wall(network, own, pieces, entities[new], field.walls[own.cell])
            found = found.followed_by(wall)
            continue
        faces = PieceFaces.of(parts.shape, pieces)
        at = pieces.part[faces.piece], faces.face
        kept = np.flatnonzero((faces.face >= 0) & free[new][at] | (faces.level >= 0))
        corners = own.weights(pieces)
        piece = faces.piece[kept]
        surface = corners[piece[:, None], faces.corners[kept]]
        triangle_part = pieces.part[piece]
        # Cuts between elements leave free faces that have a neighbour as drawn.
        level = np.where(faces.level >= 0, faces.level, parting[new][at])[kept]
        cuts = np.where(level >= 0, number[level] * own.sides[triangle_part, level], 0)
        every = np.concatenate(
            [
                corners.reshape(-1, corners.shape[2]),
                surface.reshape(-1, corners.shape[2]),
            ]
        )
        host = np.concatenate([np.repeat(pieces.part, 4), np.repeat(triangle_part, 3)])
        numbers, points = _riding(own.nodes[host], every, network.node_count)
        split = 4 * len(pieces)
        found = found.followed_by(
            CutCells(
                nodes=network.node_count, points=points, parts=entities[new],
                wholes=field.walls[own.cell],
                corners=_turned(numbers[:split].reshape(-1, 4), pieces),
                owners=entities[new][pieces.part],
                triangles=numbers[split:].reshape(-1, 3), borders=entities[new][triangle_part],
                cuts=cuts,
            )
        )  # fmt: skip
    return found


def _numbers(cuts: tuple[str, ...]) -> Indices:
    """Return the number of the cut of each level, from 1 on, shape (level,)."""
    order = list(dict.fromkeys(cuts))
    return np.array([1 + order.index(each) for each in cuts])


def _drawn_wall(
    network: Network, own: CellParts, pieces: PartPieces, entities: Indices, wholes: Indices
) -> CutCells:
    """Return the drawing of parts of triangles of a wall: pieces that face as it does."""
    weights = own.weights(pieces)
    flat = weights.reshape(-1, weights.shape[2])
    numbers, points = _riding(own.nodes[np.repeat(pieces.part, 3)], flat, network.node_count)
    left = pieces.inside.sign < 0
    triangles = numbers.reshape(-1, 3)
    none = CutCells.none(network.node_count)
    return replace(
        none, points=points, parts=entities, wholes=wholes,
        triangles=np.where(left[:, None], triangles[:, [0, 2, 1]], triangles),
        borders=entities[pieces.part], cuts=np.zeros(len(pieces), dtype=np.int64),
    )  # fmt: skip


def _turned(corners: Indices, pieces: PartPieces) -> Indices:
    """Return corners of pieces in an order with positive volume, shape (piece, 4)."""
    return np.where((pieces.inside.sign < 0)[:, None], corners[:, [0, 2, 1, 3]], corners)


def _riding(nodes: Indices, weights: Floats, count: int) -> tuple[Indices, WeightedSums]:
    """Return numbers of points, and the sums that those from ``count`` on are.

    Points with the same weights of the same nodes have one number, and those with one node
    that of the node.

    Args:
        nodes: Hosts of each, shape (point, node).
        weights: Dimensionless, shape (point, node).
        count: Of all nodes.
    """
    is_host = np.abs(weights) > ROUNDING
    hosts = np.where(is_host, nodes, -1)
    order = np.argsort(hosts, axis=1, kind="stable")
    hosts = np.take_along_axis(hosts, order, axis=1)
    parts = np.take_along_axis(np.where(is_host, weights, 0.0), order, axis=1)
    key = np.concatenate([hosts, np.round(parts / ROUNDING).astype(np.int64)], axis=1)
    _, first, place = np.unique(key, axis=0, return_index=True, return_inverse=True)
    hosts, parts = hosts[first], parts[first]
    own = hosts >= 0
    is_node = own.sum(axis=1) == 1
    number = np.where(is_node, hosts.max(axis=1), count + np.cumsum(~is_node) - 1)
    hosts, parts, own = hosts[~is_node], parts[~is_node], own[~is_node]
    sums = WeightedSums.of(own.sum(axis=1), hosts[own], parts[own])
    return number[place.reshape(-1)], sums
