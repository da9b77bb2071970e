"""Contact of solids that blades have divided: their parts, and faces of cuts, are touched.

After each cut, contact is derived anew from contact as drawn. Triangles of elements that exist
stay. Each part of a triangle has points of its own, with the pressure by depth, friction and
partners of the triangle; faces of cuts have points, too, with those of a triangle of their
body, and the stiffness E*/h of their own element, with h³ its volume. Points are as dense as on
whole triangles. Triangles of the outer surface, but not faces of cuts, press on points of
others.

Where a part is thin, its nodes have little mass for their area. So that they need no shorter
steps, the pressure by depth is multiplied by min(1, ``THIN`` f/g), where f is the share of the
part in the volume of its element, and g that of the triangle in the area of the whole one. What
touches a thin part sinks into it, until it touches the part behind it, too.
"""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tissuec.core.arrays import counted_up, cross, norm
from tissuec.core.structs import replace
from tissuec.forces.contact.contact import Contact
from tissuec.forces.contact.sides import Meetings
from tissuec.forces.moduli import plane_modulus
from tissuec.geometry.elements import TriangleRule, even, fourth_degree
from tissuec.geometry.inclusion import shared_elements
from tissuec.geometry.nearest import CAPSULE, TRIANGLE
from tissuec.model.cut_cells import PartTriangles
from tissuec.model.network import FRICTION, Floats, Indices, Network
from tissuec.model.phantoms import NotDivisible

if TYPE_CHECKING:
    from tissuec.mechanics.state import State

THIN = 3.0
_EDGES = TriangleRule(0.5 * np.eye(3) + 1.0 / 6.0, np.full(3, 1.0 / 3.0))
#: Rules by the share of the triangle in the area of a whole one, up to which each is taken.
_FEW = ((0.25, even(1)), (0.6, _EDGES), (np.inf, fourth_degree()))
_MANY = ((0.0625, even(1)), (0.25, even(2)), (0.5625, even(3)), (np.inf, even(4)))


def contact_on_parts(state: "State", parts: PartTriangles) -> Contact:
    """Return the contact of a state after cuts.

    Args:
        parts: Triangles that bound the parts of its solids.

    Raises:
        NotDivisible: There are more points than friction has room for.
    """
    drawn: Contact = state.network.contact
    present = state.contact
    made = _with_triangles(drawn, state, parts.chosen(parts.skin >= 0))
    if drawn.between is not None:
        made = _with_points(made, state, parts)
    return made if present is None else replace(made, exhaustive=present.exhaustive)


def _with_triangles(drawn: Contact, state: "State", outer: PartTriangles) -> Contact:
    """Return contact with parts of triangles behind all faces."""
    faces = len(drawn.radius)
    triangles = np.flatnonzero(drawn.kind[:faces] == TRIANGLE)
    if not len(triangles):
        return drawn
    of = np.concatenate([np.arange(faces), triangles[outer.skin]])
    columns = {name: getattr(drawn, name)[of] for name in ("kind", "radius", "bonds")}
    new, own = np.arange(len(of)) >= faces, drawn.parts[:faces, 3:]
    # Nodes in one place count as one: that of the element which their faces share.
    corners = np.where(own >= 0, drawn.points[own, 0], drawn.points[:faces])
    corners = np.concatenate([corners, outer.corners])
    points = np.concatenate([drawn.points[:faces], outer.corners])
    surface = drawn.surface[of]
    shared = shared_elements(corners, (own >= 0).sum(axis=1)[of], surface)
    shapes = np.concatenate([points, shared.points])
    rough = drawn.face_friction
    if len(rough):
        rough = _friction_of_nodes(drawn, state)[shapes]
    table = drawn.meetings
    return replace(
        drawn,
        kind=np.append(columns["kind"], np.full(len(shared.points), CAPSULE)),
        points=shapes,
        surface=np.append(surface, surface[shared.face]),
        parts=shared.parts,
        radius=columns["radius"],
        bonds=columns["bonds"],
        # Parts do not touch their own body: neighbours are not joined by edges.
        spared=np.where(new, drawn.owner[drawn.points[of, 0]], drawn.spared[of]),
        face_friction=rough,
        meetings=replace(table, of=table.of[of]),
        whole=np.ones(len(of), dtype=bool),
        bounds=outer.parts,
    )


def _friction_of_nodes(drawn: Contact, state: "State") -> Floats:
    """Return the coefficient of each node that carries shapes, shape (node,)."""
    found = np.zeros(state.network.node_count)
    found[drawn.points] = drawn.face_friction
    found = found[state.network.parents]
    if (embedding := state.embedding) is not None:
        found[embedding.nodes] = embedding.weighted(found)
    return found


def _with_points(drawn: Contact, state: "State", parts: PartTriangles) -> Contact:
    """Return contact with points on parts of triangles and on faces of cuts."""
    between, network = drawn.between, state.network
    assert between is not None
    face = np.full(len(network.skin), -1)
    face[between.rows] = np.arange(len(between.rows))
    is_cut = parts.skin < 0
    like = np.where(is_cut, _faces_of_bodies(network, between.rows, parts), face[parts.skin])
    chosen = like >= 0
    parts, like, is_cut = parts.chosen(chosen), like[chosen], is_cut[chosen]
    a, b, c = state.drawn[parts.corners].swapaxes(0, 1)
    area = 0.5 * np.asarray(norm(cross(b - a, c - a)))
    hard = _hardness(state, drawn, parts, like, is_cut, area)
    first = len(drawn.nodes) - len(between.corners)
    part, point, shares, areas = _points(drawn, like, area, between.drawn[like])
    source = first + point
    stiffness = drawn.stiffness[source] / between.areas[point] * areas * hard[part]
    count = len(part)
    columns = {
        name: np.append(getattr(drawn, name), getattr(drawn, name)[source])
        for name in ("owner", "size", "there")
    }
    if len(drawn.node_friction):
        columns["node_friction"] = np.append(drawn.node_friction, drawn.node_friction[source])
    made = replace(
        between,
        corners=np.concatenate([between.corners, parts.corners[part]]),
        shares=np.concatenate([between.shares, shares]),
        areas=np.append(between.areas, areas),
        face=np.append(between.face, len(between.triangles) + part),
        bonds=np.concatenate([between.bonds, np.full((count, 2), -1)]),
        triangles=np.concatenate([between.triangles, parts.corners]),
        drawn=np.append(between.drawn, area),
        bounds=parts.parts,
    )
    behind = network.node_count + len(between.corners) + np.arange(count)
    table = drawn.meetings
    return replace(
        drawn,
        **columns,
        nodes=np.append(drawn.nodes, behind),
        stiffness=np.append(drawn.stiffness, stiffness),
        memory=_bristles(drawn, network, count),
        meetings=_apart(drawn, table.group[source], columns["owner"][len(drawn.owner) :]),
        between=made,
    )


def _points(
    drawn: Contact, like: Indices, area: Floats, whole: Floats
) -> tuple[Indices, Indices, Floats, Floats]:
    """Return points on parts: the part and a point as drawn like each, shares, and areas [m²].

    Args:
        like: The triangle as drawn that each part is like, shape (part,).
        area: Of each [m²], shape (part,).
        whole: Of the triangles that they are like [m²], shape (part,).
    """
    between = drawn.between
    assert between is not None
    group = drawn.meetings.group[len(drawn.nodes) - len(between.corners) :]
    own = np.flatnonzero(between.face >= 0)
    key = np.stack([between.face[own], group[own]], axis=1)
    kinds, first, count = np.unique(key, axis=0, return_index=True, return_counts=True)
    order = np.argsort(like, kind="stable")
    low = np.searchsorted(like, kinds[:, 0], sorter=order)
    high = np.searchsorted(like, kinds[:, 0], side="right", sorter=order)
    kind = np.repeat(np.arange(len(kinds)), high - low)
    part = order[np.repeat(low, high - low) + counted_up(high - low)]
    share, is_many = area[part] / whole[part], count[kind] > len(fourth_degree().weights)
    found: list[tuple[Indices, Indices, Floats, Floats]] = []
    for many, rules in ((False, _FEW), (True, _MANY)):
        least = -np.inf
        for most, rule in rules:
            row = np.flatnonzero((is_many == many) & (least < share) & (share <= most))
            least, size = most, len(rule.weights)
            of = np.repeat(row, size)
            found.append(
                (part[of], own[first[kind[of]]], np.tile(rule.points, (len(row), 1)),
                 np.outer(area[part[row]], rule.weights).ravel())
            )  # fmt: skip
    columns = [np.concatenate(column) for column in zip(*found, strict=True)]
    order = np.argsort(columns[0], kind="stable")
    part, point, shares, areas = (column[order] for column in columns)
    return part, point, shares, areas


def _faces_of_bodies(network: Network, rows: Indices, parts: PartTriangles) -> Indices:
    """Return a triangle with points of the body of each part, -1 without any, (part,)."""
    ends = np.array([int(body.elements.stop) for body in network.bodies])
    nodes = np.array([int(body.nodes.stop) for body in network.bodies])
    owner = np.searchsorted(nodes, network.skin[rows, 0], side="right")
    found = np.full(len(ends), -1)
    found[owner[::-1]] = np.arange(len(rows))[::-1]
    filled = np.array([body.is_made_of_elements for body in network.bodies])
    numbers = np.flatnonzero(filled)
    return found[numbers[np.searchsorted(ends[numbers], parts.parts, side="right")]]


def _hardness(
    state: "State", drawn: Contact, parts: PartTriangles, like: Indices,
    is_cut: NDArray[np.bool_], area: Floats,
) -> Floats:  # fmt: skip
    """Return the pressure by depth over that of the triangle that each is like, shape (part,).

    Args:
        like: The triangle as drawn that each is like, shape (part,).
        is_cut: Which of them are faces of cuts, shape (part,).
        area: As drawn [m²], shape (part,).
    """
    between, network, cut = drawn.between, state.network, state.cut_cells
    assert between is not None
    assert between.elements is not None
    assert cut is not None
    volume, firm = np.zeros((2, network.entity_count))
    for one in (*network.elements, *state.cut_elements):
        volume[one.walls] = one.weights.sum(axis=1)
        firm[one.walls] = plane_modulus(one.shear, one.bulk_modulus)
    whole, row = cut.wholes_of(parts.parts), between.elements[like]
    size = np.cbrt(volume)
    ratio = (firm[whole] / size[whole]) / (firm[row] / size[row])
    first = len(drawn.nodes) - len(between.corners)
    faced = between.face >= 0
    each = drawn.stiffness[first:][faced] / between.areas[faced]
    if np.ptp(each) <= 1e-9 * each.max():  # one that is written
        ratio = np.ones_like(ratio)
    # Of each part, what lies in one triangle, or on all its faces of cuts.
    key = np.stack([parts.parts, np.where(is_cut, -1, like)], axis=1)
    _, of = np.unique(key, axis=0, return_inverse=True)
    together = np.bincount(of.reshape(-1), area)[of.reshape(-1)]
    share = together / np.where(is_cut, size[whole] ** 2, between.drawn[like])
    thin = np.minimum(1.0, THIN * volume[parts.parts] / (volume[whole] * share))
    return np.where(is_cut, ratio, 1.0) * thin


def _bristles(drawn: Contact, network: Network, count: int) -> Indices:
    """Return rows of bristles, with those of new points behind.

    Raises:
        NotDivisible: There are not enough.
    """
    if not len(drawn.memory):
        return drawn.memory
    rows = network.remembering(FRICTION)
    if len(drawn.memory) + count > len(rows):
        raise NotDivisible("cuts have made more points of contact than friction has room for")
    return rows[: len(drawn.memory) + count]


def _apart(drawn: Contact, group: Indices, owner: Indices) -> Meetings:
    """Return which groups meet, with those of points on parts, which spare their own body.

    Args:
        group: Of the points that those on parts are like, shape (n,).
        owner: The body of each, shape (n,).
    """
    table = drawn.meetings
    triangles = np.flatnonzero(drawn.kind[: len(drawn.radius)] == TRIANGLE)
    if (drawn.spared[triangles] >= 0).all():
        return replace(table, group=np.append(table.group, group))
    new, first, made = np.unique(group, return_index=True, return_inverse=True)
    meets, of = table.meets[new], drawn.owner[drawn.points[triangles, 0]]
    for row, body in enumerate(owner[first].tolist()):
        meets[row, table.of[triangles[of == body]]] = False
    return replace(
        table,
        group=np.append(table.group, len(table.meets) + made.reshape(-1)),
        meets=np.concatenate([table.meets, meets]),
        sided=np.concatenate([table.sided, table.sided[new]]),
        distances=np.concatenate([table.distances, table.distances[new]]),
    )
