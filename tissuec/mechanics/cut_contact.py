"""Contact of solids that blades have divided: their parts, and faces of cuts, are touched.

After each cut, contact is derived anew from contact as drawn. Triangles of elements that exist
stay. Each part of a triangle has points of its own, with the pressure by depth, friction and
partners of the triangle; faces of cuts have points, too, with those of a triangle of their
body, and the stiffness E*/h of their own element, with h³ its volume. Points are as dense as on
whole triangles. Triangles of the outer surface, but not faces of cuts, press on points of
others.

Where a part is thin and at the surface of its body, its nodes have little mass for their area.
So that they need no shorter steps than an element that is alone, the pressure by depth is
multiplied by min(1, r), where r is the area of a triangle of such an element over the mass that
a force in its middle moves, divided by the same of all triangles of one face of the part. What
touches such a part sinks into it, until it touches the part behind it, too.
"""

from typing import TYPE_CHECKING, Self

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.arrays import counted_up, norm
from tissuec.core.structs import replace
from tissuec.forces.contact.contact import Contact
from tissuec.forces.contact.sides import Meetings
from tissuec.forces.contact.sides_kernel import TORN
from tissuec.forces.moduli import plane_modulus
from tissuec.geometry.elements import TriangleRule, even, fourth_degree
from tissuec.geometry.inclusion import shared_elements
from tissuec.geometry.nearest import CAPSULE, TRIANGLE, or_one
from tissuec.mechanics.cut_faces import face_normals, located
from tissuec.model.cut_cells import PartTriangles
from tissuec.model.network import FRICTION, Floats, Indices, Network
from tissuec.model.phantoms import NotDivisible

if TYPE_CHECKING:
    from tissuec.mechanics.state import State

_EDGES = TriangleRule(0.5 * np.eye(3) + 1.0 / 6.0, np.full(3, 1.0 / 3.0))
#: Rules by the share of the triangle in the area of a whole one, up to which each is taken.
_FEW = ((0.25, even(1)), (0.6, _EDGES), (np.inf, fourth_degree()))
_MANY = ((0.0625, even(1)), (0.25, even(2)), (0.5625, even(3)), (np.inf, even(4)))


class CutSides(Struct, frozen=True, eq=False):
    """Faces of cuts that touch their twins: those of the other side of the same cut.

    Attributes:
        faces: Triangles.
        side: On which each is, a number among ``bodies``, shape (triangle,).
        bodies, cuts: The body and the cut of each side, see ``PartTriangles``, shape (side,).
        depth: How far behind each side points are still kept outside [m], shape (side,).
    """

    faces: PartTriangles
    side: Indices
    bodies: Indices
    cuts: Indices
    depth: Floats

    @classmethod
    def of(cls, state: "State", parts: PartTriangles) -> Self:
        """Return those of the parts of all solids."""
        drawn: Contact = state.network.contact
        touch = drawn.twins_touch and drawn.between is not None
        faces = parts.chosen((parts.cuts != 0) & touch)
        key = np.stack([_bodies_of(state.network, faces), faces.cuts], axis=1)
        sides, side = np.unique(key, axis=0, return_inverse=True)
        side, depth = side.reshape(-1), np.zeros(len(sides))
        if len(sides):
            corners = state.drawn[faces.corners]
            np.maximum.at(depth, side, np.ptp(corners, axis=1).max(axis=1))
        return cls(faces, side, *sides.T, depth)

    def of_triangles(self, parts: PartTriangles) -> Indices:
        """Return the side of each of all triangles, -1 of the outer surface, shape (n,)."""
        found = np.full(len(parts.parts), -1)
        if len(self.side):
            found[parts.cuts != 0] = self.side
        return found

    def meetings(self, table: Meetings) -> Meetings:
        """Return tables with groups of points and surfaces behind the others, one of each side.

        Surfaces of cuts are open, as those of solids that have a hole.
        """
        rows, columns = table.meets.shape
        twins = (self.bodies[:, None] == self.bodies) & (self.cuts[:, None] == -self.cuts)
        shape = rows + len(twins), columns + len(twins)
        meets, sided = np.zeros(shape, dtype=bool), np.zeros(shape, dtype=np.int64)
        distances = np.full(shape, np.nan)
        for wide, own, ours in (
            (meets, table.meets, twins),
            (sided, table.sided, np.where(twins, TORN, 0)),
            (distances, table.distances, np.where(twins, 0.0, np.nan)),
        ):
            wide[:rows, :columns], wide[rows:, columns:] = own, ours
        depths = dict(enumerate(self.depth.tolist(), start=columns))
        return replace(table, meets=meets, sided=sided, distances=distances, depths=depths)


def contact_on_parts(state: "State", parts: PartTriangles) -> Contact:
    """Return the contact of a state after cuts.

    Args:
        parts: Triangles that bound the parts of its solids.

    Raises:
        NotDivisible: There are more points than friction has room for.
    """
    drawn: Contact = state.network.contact
    present, sides = state.contact, CutSides.of(state, parts)
    made = _with_triangles(drawn, state, parts.chosen(parts.skin >= 0), sides)
    if drawn.between is not None:
        made = _with_points(made, state, parts, sides)
    return made if present is None else replace(made, exhaustive=present.exhaustive)


def _with_triangles(
    drawn: Contact, state: "State", outer: PartTriangles, sides: CutSides
) -> Contact:
    """Return contact with parts of triangles, and faces of cuts, behind all faces."""
    faces, cut = len(drawn.radius), sides.faces
    triangles = np.flatnonzero(drawn.kind[:faces] == TRIANGLE)
    if not len(triangles):
        return drawn
    of = np.concatenate([np.arange(faces), triangles[outer.skin]])
    columns = {
        name: np.append(getattr(drawn, name)[of], np.full(len(cut.parts), value))
        for name, value in (("kind", TRIANGLE), ("radius", 0.0), ("spared", -1))
    }
    new, own = np.arange(len(of)) >= faces, drawn.parts[:faces, 3:]
    # Parts do not touch the surface of their own body: neighbours are not joined by edges.
    owner = drawn.owner[drawn.points[of, 0]]
    columns["spared"][: len(of)] = np.where(new, owner, drawn.spared[of])
    # Nodes in one place count as one: that of the element which their faces share.
    corners = np.where(own >= 0, drawn.points[own, 0], drawn.points[:faces])
    corners = np.concatenate([corners, outer.corners, cut.corners])
    points = np.concatenate([drawn.points[:faces], outer.corners, cut.corners])
    surface = np.append(drawn.surface[of], 1 + drawn.surface.max() + sides.side)
    counts = np.append((own >= 0).sum(axis=1)[of], np.zeros_like(sides.side))
    shared = shared_elements(corners, counts, surface)
    shapes = np.concatenate([points, shared.points])
    rough = drawn.face_friction
    if len(rough):
        rough = _friction_of_nodes(drawn, state)[shapes]
    table = drawn.meetings
    count = int(table.meets.shape[1])
    return replace(
        drawn,
        kind=np.append(columns["kind"], np.full(len(shared.points), CAPSULE)),
        points=shapes,
        surface=np.append(surface, surface[shared.face]),
        parts=shared.parts,
        radius=columns["radius"],
        bonds=np.concatenate([drawn.bonds[of], np.full((len(cut.parts), 2), -1)]),
        spared=columns["spared"],
        face_friction=rough,
        meetings=replace(table, of=np.append(table.of[of], count + sides.side)),
        whole=np.ones(len(columns["radius"]), dtype=bool),
        bounds=np.append(outer.parts, cut.parts),
    )


def _friction_of_nodes(drawn: Contact, state: "State") -> Floats:
    """Return the coefficient of each node that carries shapes, shape (node,)."""
    found = np.zeros(state.network.node_count)
    found[drawn.points] = drawn.face_friction
    found = found[state.network.parents]
    if (embedding := state.embedding) is not None:
        found[embedding.nodes] = embedding.weighted(found)
    return found


def _with_points(
    drawn: Contact, state: "State", parts: PartTriangles, sides: CutSides
) -> Contact:
    """Return contact with points on parts of triangles and on faces of cuts."""
    between, network = drawn.between, state.network
    assert between is not None
    face = np.full(len(network.skin), -1)
    face[between.rows] = np.arange(len(between.rows))
    is_cut = parts.skin < 0
    like = np.where(is_cut, _faces_of_bodies(network, between.rows, parts), face[parts.skin])
    chosen = like >= 0
    side = sides.of_triangles(parts)[chosen]
    parts, like, is_cut = parts.chosen(chosen), like[chosen], is_cut[chosen]
    corners = state.drawn[parts.corners]
    area = 0.5 * np.asarray(norm(face_normals(corners)))
    hard = _hardness(state, drawn, parts, like, is_cut, area)
    first = len(drawn.nodes) - len(between.corners)
    part, point, shares, areas = _points(drawn, like, area, between.drawn[like])
    group = drawn.meetings.group[first + point]
    table = _apart(drawn, group, drawn.owner[first + point])
    each = hard[part]
    if len(sides.side):
        own, rows = _other_points(side[part], group, drawn.owner[first + point])
        both = _hardness_of_both(corners, hard, parts.cuts != 0)
        each = np.append(each, both[part[own]])
        table = replace(
            sides.meetings(table), group=np.append(table.group, len(table.meets) + rows)
        )
        every = np.append(np.arange(len(part)), own)
        part, point, shares, areas = part[every], point[every], shares[every], areas[every]
    source = first + point
    stiffness = drawn.stiffness[source] / between.areas[point] * areas * each
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
    return replace(
        drawn,
        **columns,
        nodes=np.append(drawn.nodes, behind),
        stiffness=np.append(drawn.stiffness, stiffness),
        memory=_bristles(drawn, network, count),
        meetings=table,
        between=made,
    )


def _other_points(side: Indices, group: Indices, owner: Indices) -> tuple[Indices, Indices]:
    """Return points of which there are others that touch the other side of their cut alone.

    They are those of one group of each body.

    Args:
        side: Of the cut on which each point is, -1 of others, shape (point,).
        group: Of each in the tables of contact, shape (point,).
        owner: The body of each, shape (point,).

    Returns:
        Numbers of points, and their sides, shape (n,) each.
    """
    lowest = np.full(owner.max(initial=0) + 1, group.max(initial=0))
    np.minimum.at(lowest, owner, group)
    own = np.flatnonzero((side >= 0) & (group == lowest[owner]))
    return own, side[own]


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
    found = np.full(len(network.bodies), -1)
    found[network.body_numbers(network.skin[rows, 0])[::-1]] = np.arange(len(rows))[::-1]
    return found[_bodies_of(network, parts)]


def _bodies_of(network: Network, parts: PartTriangles) -> Indices:
    """Return the number of the body of each part, shape (part,)."""
    filled = np.array([body.is_made_of_elements for body in network.bodies])
    ends = np.array([int(body.elements.stop) for body in network.bodies])
    numbers = np.flatnonzero(filled)
    return numbers[np.searchsorted(ends[numbers], parts.parts, side="right")]


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
    size, firm, ease = np.zeros((3, network.entity_count))
    matter = np.zeros(network.node_count)
    for one in network.elements:
        matter += np.bincount(one.nodes.ravel(), one.node_volumes.ravel(), len(matter))
    for one in network.elements:
        size[one.walls] = np.cbrt(one.weights.sum(axis=1))
        firm[one.walls] = plane_modulus(one.shear, one.bulk_modulus)
        masses = one.node_volumes * (network.mass / or_one(matter))[one.nodes]
        ease[one.walls] = (1.0 / masses).mean(axis=1) / 3.0
    whole, row = cut.wholes_of(parts.parts), between.elements[like]
    ratio = (firm[whole] / size[whole]) / (firm[row] / size[row])
    first = len(drawn.nodes) - len(between.corners)
    faced = between.face >= 0
    each = drawn.stiffness[first:][faced] / between.areas[faced]
    if np.ptp(each) <= 1e-9 * each.max():  # one that is written
        ratio = np.ones_like(ratio)
    # Of each part, what lies in one triangle, or on its faces of one cut.
    key = np.stack([parts.parts, np.where(is_cut, -np.abs(parts.cuts), like)], axis=1)
    _, of = np.unique(key, axis=0, return_inverse=True)
    of = of.reshape(-1)
    light = np.bincount(of, area * _eases(state, parts.corners))[of]
    usual = np.where(is_cut, size[whole] ** 2, between.drawn[like]) * ease[whole]
    return np.where(is_cut, ratio, 1.0) * np.minimum(1.0, usual / light)


def _eases(state: "State", triangles: Indices) -> Floats:
    """Return the inverse of the mass that a force on the middle of triangles moves [1/kg].

    Args:
        triangles: Their corners, riders among them, shape (triangle, 3).
    """
    from scipy.sparse import csr_matrix

    count, embedding = state.network.node_count, state.embedding
    assert embedding is not None
    own = np.setdiff1d(np.arange(count), embedding.nodes)
    rows = np.append(own, embedding.nodes[embedding.owners])
    each = np.append(np.ones(len(own)), embedding.weights)
    rides = csr_matrix((each, (rows, np.append(own, embedding.hosts))), (count, count))
    thirds = np.full(triangles.size, 1.0 / 3.0)
    at = np.repeat(np.arange(len(triangles)), 3), triangles.ravel()
    shares = csr_matrix((thirds, at), (len(triangles), count)) @ rides
    return np.asarray(shares.multiply(shares) @ (1.0 / state.divisor))


def _hardness_of_both(corners: Floats, hard: Floats, own: NDArray[np.bool_]) -> Floats:
    """Return the smaller hardness of triangles on faces of cuts and of their twins, (part,).

    Args:
        corners: Of all triangles as drawn [m], shape (part, 3, 3).
        hard: As ``_hardness`` returns it, shape (part,).
        own: Which are on faces of cuts, shape (part,).
    """
    twin = located(corners[own].mean(axis=1), face_normals(corners[own]), corners[own])
    found = hard.copy()
    found[own] = np.minimum(hard[own], np.where(twin >= 0, hard[own][twin], np.inf))
    return found


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
    is_own = table.of < table.meets.shape[1]  # those behind are faces of cuts
    triangles = np.flatnonzero((drawn.kind[: len(drawn.radius)] == TRIANGLE) & is_own)
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
