"""Points of contact on faces of bodies, and on axes of threads and of tools that are thin.

A face has points x_q with the areas A_q of a rule of quadrature, so that contact is a pressure
k δ [Pa], whatever the mesh. By default, k is c E*/h, with E* = E/(1 - ν²) of the
element behind the face, h its size and c = 12: a layer that is a twelfth as thick as an element
and that lets faces, which do not bend, follow a tool. Scenes whose forces are to balance have
c = 24, with which balls press as on smooth tissue; elsewhere it would shorten steps.
For walls of the thickness t, whose faces carry load by tension, k is c E* t/h².

Where two bodies touch, E* is the smaller one: points of the firmer body that touch a softer one
are points of their own, which touch nothing else.

Between the points of a face, a tool with a radius R below h/2 would slip through. Such a tool
has points along its axis instead, on which the whole surface presses. So do threads, so that
they cannot slip between nodes across an edge.
"""

from collections.abc import Sequence
from math import ceil
from typing import NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.compiler.bodies.threads import bonds
from tissuec.core.arrays import counted_up, cross, norm
from tissuec.core.errors import CompileError, Diagnostic
from tissuec.core.source import Span
from tissuec.core.units import AREAL_STIFFNESS, LENGTH, show
from tissuec.forces.contact.points import NO_FACE, ContactPoints
from tissuec.forces.contact.sides_kernel import CLOSED
from tissuec.forces.moduli import plane_modulus
from tissuec.geometry.edges import Edges, TriangleIndex
from tissuec.geometry.elements import TriangleRule, even, fourth_degree
from tissuec.geometry.inside import inside
from tissuec.geometry.nearest import or_one
from tissuec.geometry.neighbours import nearest_triangles
from tissuec.model.network import BodyPart, Floats, Indices, Network
from tissuec.scene.environment import Environment, EnvironmentEntries
from tissuec.scene.model import Tool
from tissuec.scene.reading.entry_hints import missing
from tissuec.scene.reading.findings import Findings

HARDNESS, AT_REST = 12.0, 24.0  # c in scenes that only move, and with equilibria
THIN = 0.5  # of the size of a face: a radius below has points along the axis
SMALL = 1.2  # the same: a radius below needs more points on faces
FEW, MANY = fourth_degree(), even(4)
_OF_RIDERS = 4.0  # points for each rider: two triangles, most of which have one point
MOST_ALONG = 1_000_000  # points of contact along a tool or a thread
ALONG = 0.25  # of the size of a face: distance of points along an axis
SOFT = 0.005  # of the size of a face: depth over which contact of faces begins
MEANT = (
    0.1  # of the size of a face: overlaps of solids that rounding of shapes does not explain
)
SKIN = 0.25  # of the size of a face: how far around surfaces without an inside others touch
ALIKE = 1e-6  # of E*: bodies that differ by less are equally firm


class DrawnOverlap(NamedTuple):
    """Two solids that are drawn into each other.

    Attributes:
        first, second: Numbers of the bodies.
        depth: Of the deepest point of one in the other [m].
        ignored: The part of it at which contact begins to press [m].
    """

    first: int
    second: int
    depth: float
    ignored: float


class FacePoints(Struct, frozen=True, eq=False):
    """Points of contact of a network.

    Attributes:
        between: The points, as shares of nodes.
        position: As drawn [m], shape (point, 3).
        owner: Body of each, -1 on the axis of a tool, shape (point,).
        size: Radius of the axis that each is on [m], else 0, shape (point,).
        extent: Area [m²] of each point of a face, or length [m] on an axis, shape (point,).
        shape: The shape of a tool on whose axis each is, -1 of others, shape (point,).
        bodies: Numbers of the bodies whose faces have points, ascending.
        face_size: h of each of these bodies, the median of its faces [m], shape (body,).
        skin: Triangle of the network that each is on, -1 on an axis, shape (point,).
        thin: Which shapes of tools are thin compared with which bodies of the network, shape
            (shape, all bodies).
        couples: Bodies, and the softer ones that some of their points alone touch, shape
            (couple, 2).
        couple: Of each point, -1 of those that touch all others, shape (point,).
    """

    between: ContactPoints
    position: Floats
    owner: Indices
    size: Floats
    extent: Floats
    shape: Indices
    bodies: Indices
    face_size: Floats
    skin: Indices
    thin: NDArray[np.bool_]
    couples: Indices
    couple: Indices

    @property
    def is_on_thread(self) -> NDArray[np.bool_]:
        """Return which points are on threads, shape (point,)."""
        return (self.owner >= 0) & (self.between.face == NO_FACE)

    def group(self, bodies: int) -> Indices:
        """Return the group of each point: a row of the tables below, shape (point,).

        Groups are the nodes of each body, the points of each body, those of each shape of a
        tool, and those of each couple.

        Args:
            bodies: Number of all bodies.
        """
        own = np.where(self.owner < 0, 2 * bodies + self.shape, bodies + self.owner)
        return np.where(self.couple < 0, own, 2 * bodies + len(self.thin) + self.couple)

    def meetings(self, network: Network) -> NDArray[np.bool_]:
        """Return which groups of nodes may touch which groups of faces; see ``Meetings.meets``.

        Nodes of bodies with points touch nothing, and nodes of threads do not touch these
        bodies: their points do. Groups of faces are each shape of a tool, each thread, the skin
        of each body, and the faces in planes of symmetry, which nothing touches. Bodies that
        are glued together do not touch each other.
        """
        bodies, shapes = len(network.bodies), len(self.thin)
        groups = 2 * bodies + shapes + len(self.couples)
        meets = np.zeros((groups, shapes + 2 * bodies + 1), dtype=bool)
        of_tools, of_faced = slice(shapes), shapes + bodies + self.bodies
        threads = np.unique(self.owner[self.is_on_thread])
        meets[:bodies, :-1] = True
        meets[self.bodies] = False
        meets[np.ix_(threads, of_faced)] = False
        faced = bodies + self.bodies
        meets[faced, of_tools] = ~self.thin.T[self.bodies]
        meets[faced, shapes + bodies : -1] = True
        meets[np.ix_(bodies + threads, of_faced)] = True
        of_axes = slice(2 * bodies, 2 * bodies + shapes)
        meets[of_axes, shapes + bodies : -1] = self.thin
        for number, (body, softer) in enumerate(self.couples.tolist()):
            meets[bodies + body, shapes + bodies + softer] = False
            meets[2 * bodies + shapes + number, shapes + bodies + softer] = True
        owner = np.concatenate(
            [np.tile(np.arange(bodies), 2), np.full(shapes, -1), self.couples[:, 0]]
        )
        for pair in network.glued.tolist():
            for one, other in (pair, pair[::-1]):
                faces = [shapes + other, shapes + bodies + other]
                meets[np.ix_(owner == one, faces)] = False
        return meets

    def sides(
        self, network: Network, tools: Sequence[Tool], law: EnvironmentEntries
    ) -> "SideTables":
        """Return which groups of points are kept outside of which surfaces, and how far.

        Points of thin tools and of threads are kept outside of solids that no point of their
        tool or thread is in as drawn, unless a joint sews the thread to the body. Points and
        nodes of bodies are kept outside of all solids but those around the whole body, and
        those that a joint holds deep inside.

        Args:
            network: With the nodes of tools.
            tools: Those that may touch.
            law: As written.
        """
        bodies, shapes, meets = len(network.bodies), len(self.thin), self.meetings(network)
        sided, distances = np.zeros(meets.shape, np.int64), np.full(meets.shape, np.nan)
        overlaps: tuple[DrawnOverlap, ...] = ()
        tool = np.repeat(np.arange(len(tools)), [len(one.shapes) for one in tools])
        threads, lines = self.is_on_thread, np.flatnonzero(self.between.face == NO_FACE)
        solid = [int(n) for n in self.bodies if _is_solid(network, int(n))]
        for number in solid:
            body, column = network.bodies[number], shapes + bodies + number
            within = inside(self.position[lines], network.position, network.skin_of(body))
            entering = lines[within]
            of_tools = np.unique(tool[self.shape[entering[self.shape[entering] >= 0]]])
            kept = self.thin[:, number] & ~np.isin(tool, of_tools)
            sided[2 * bodies : 2 * bodies + shapes, column] = np.where(kept, CLOSED, 0)
            free = np.setdiff1d(self.owner[threads], self.owner[entering]).tolist()
            free = [n for n in free if not network.are_joined(network.bodies[n], body)]
            sided[bodies + np.array(free, dtype=np.int64), column] = CLOSED
        if law.between_bodies:
            overlaps = self._keep_apart(network, solid, law, meets, sided, distances)
        closed = {
            shapes + bodies + number: network.skin_of(network.bodies[number]).astype(np.int64)
            for number in solid
        }
        return SideTables(sided, distances, closed, overlaps)

    def distances_from_skins(self, network: Network, sides: "SideTables") -> list[Floats]:
        """Return how far from the skin of each body the groups of others touch it [m].

        Args:
            network: With the nodes of tools.
            sides: Of this network.

        Returns:
            For each body, NaN where its thickness counts, shape (group,).
        """
        bodies, shapes, meets = len(network.bodies), len(self.thin), self.meetings(network)
        owner = np.concatenate(
            [np.tile(np.arange(bodies), 2), np.full(shapes, -1), self.couples[:, 0]]
        )
        there = np.isin(np.arange(len(owner)), self.group(bodies))
        there[:bodies] = True
        return [
            sides.distances[
                meets[:, shapes + bodies + n] & there & (owner >= 0) & (owner != n),
                shapes + bodies + n,
            ]
            for n in range(bodies)
        ]

    def _keep_apart(
        self, network: Network, solid: Sequence[int], law: EnvironmentEntries,
        meets: NDArray[np.bool_], sided: Indices, distances: Floats,
    ) -> tuple[DrawnOverlap, ...]:  # fmt: skip
        """Fill in the tables of sides and distances for points and nodes of bodies.

        Surfaces of solids touch where they meet, or at the contact thickness that is written.
        Surfaces without an inside touch at the contact thickness. None begin to press as they
        are drawn: those that are drawn closer touch at that distance, as do those that overlap
        by no more than the thickness.

        Args:
            solid: Bodies with an inside.
            meets: Which groups may touch, changed in place like the others.

        Returns:
            Solids that are drawn into others by more than rounding.
        """
        deep: dict[tuple[int, int], float] = {}
        size = SKIN * float(self.face_size.min())
        thickness, written = law.contact_thickness or size, law.contact_thickness or 0.0
        bodies, first = len(network.bodies), len(self.thin) + len(network.bodies)
        groups, place = self.group(bodies), network.position
        for number, body in enumerate(network.bodies):
            rows = np.unique(groups[(self.owner == number) & (self.skin >= 0)])
            points = self.position[np.isin(groups, rows)]
            if body.thread is not None:
                continue
            if not len(rows):
                rows, points = np.array([number]), place[body.nodes]
            for other in solid:
                touched = rows[meets[rows, first + other]]
                if number == other or not len(touched):
                    continue
                around = network.bodies[other]
                gap, is_within = _gap(points, network, around, thickness)
                is_joined = network.are_joined(body, around)
                if is_within or (is_joined and gap < -thickness):
                    continue
                most = written if number in solid else thickness
                sided[touched, first + other] = CLOSED
                distances[touched, first + other] = min(max(gap, -thickness), most)
                if number in solid:
                    pair = min(number, other), max(number, other)
                    if not is_joined and -gap > min(MEANT * size / SKIN, thickness):
                        deep[pair] = max(deep.get(pair, 0.0), -gap)
                    continue
                back = np.unique(groups[(self.owner == other) & (self.skin >= 0)])
                ahead = self.position[np.isin(groups, back)]
                gap = abs(_gap(ahead, network, body, thickness)[0])
                if gap < thickness:
                    distances[back, first + number] = gap
        return tuple(
            DrawnOverlap(one, other, depth, min(depth, thickness))
            for (one, other), depth in deep.items()
        )


class SideTables(NamedTuple):
    """Which groups of points are kept outside of which surfaces.

    Attributes:
        sided, distances, closed: As of ``Meetings``.
        overlaps: Solids that are drawn into others.
    """

    sided: Indices
    distances: Floats
    closed: dict[int, Indices]
    overlaps: tuple[DrawnOverlap, ...]


def _gap(points: Floats, network: Network, body: BodyPart, margin: float) -> tuple[float, bool]:
    """Return the smallest distance of points from a body [m], and whether all are inside it.

    The distance is below zero if points are inside, infinite if none is within a margin.

    Args:
        points: As drawn [m], shape (point, 3).
        network: With the body.
        body: One with a surface.
        margin: [m].
    """
    skin = network.skin_of(body).astype(np.int64)
    faces = network.skin[_faces(network, body)].astype(np.int64)
    found = nearest_triangles(points, network.position, faces, margin, skin)
    least = np.full(len(points), np.inf)
    np.minimum.at(least, found.point, found.distance)
    near = np.flatnonzero(np.isfinite(least))
    within = inside(points[near], network.position, skin)
    away = np.where(within, -least[near], least[near])
    is_within = bool(within.sum() == len(points))
    return float(away.min(initial=np.inf)), is_within


def _is_solid(network: Network, number: int) -> bool:
    """Return whether a body has a closed surface around elements that fill it.

    Planes of symmetry close it.
    """
    body = network.bodies[number]
    skin = network.skin_of(body)
    if not Edges.among(skin).is_closed:
        return False
    index, filled = TriangleIndex(skin), np.zeros(len(skin), dtype=bool)
    for one in network.elements:
        if one.nodes.shape[1] > 3:
            place = index.find(one.faces.reshape(-1, 3))
            filled[place[place >= 0]] = True
    return bool(filled.all())


def face_points(
    network: Network, tools: Sequence[Tool], law: EnvironmentEntries
) -> FacePoints | None:
    """Return the points of contact of a network; None if contact acts on nodes only.

    Args:
        network: With the nodes of tools.
        tools: Those that may touch.
        law: As written.
    """
    bodies = [n for n, body in enumerate(network.bodies) if _has_points(network, body, law)]
    if not bodies:
        return None
    radii = _radii(tools)
    rows = [_faces(network, network.bodies[n]) for n in bodies]
    areas = [_areas(network, row) for row in rows]
    size = np.array([np.median(np.sqrt(2.0 * area)) for area in areas])
    thin = np.zeros((len(radii), len(network.bodies)), dtype=bool)
    thin[:, bodies] = radii[:, None] < THIN * size
    thick = np.where(thin[:, bodies], np.inf, radii[:, None]).min(axis=0, initial=np.inf)
    rules = [MANY if radius < SMALL * h else FEW for radius, h in zip(thick, size, strict=True)]
    every = np.concatenate(rows)
    yields = _yielding(network, bodies, rows, areas, law)
    touch = _touch_others(network, tools, law, yields)
    own, couple = _in_couples(_on_faces(bodies, rows, areas, rules), yields, touch)
    axes = _axes(network, tools, thin[:, bodies], size)
    of_axis = np.repeat(np.flatnonzero(thin.any(axis=1)), [len(a.lengths) for a in axes])
    threads = [n for n, body in enumerate(network.bodies) if body.thread is not None]
    lines = [_along(network, network.bodies[n], ALONG * float(size.min())) for n in threads]
    of_thread = np.repeat(np.array(threads, dtype=np.int64), [len(a.lengths) for a in lines])
    both = [*axes, *lines]
    lengths = np.concatenate([np.zeros(0), *(a.lengths for a in both)])
    thickness = [np.full(len(a.lengths), a.radius) for a in lines]
    triangles = network.skin[every].astype(np.int64)
    on_lines, none = np.full(len(lengths), -1), np.full((len(own.face), 2), -1)
    between = ContactPoints(
        corners=np.concatenate([triangles[own.face], *(a.ends for a in both)]),
        shares=np.concatenate([own.shares, *(a.shares for a in both)]),
        areas=np.concatenate([own.areas, np.zeros(len(lengths))]),
        face=np.concatenate([own.face, np.full(len(lengths), NO_FACE)]),
        bonds=np.concatenate([none, *(a.bonds for a in both)]),
        triangles=triangles, drawn=np.concatenate(areas),
        elements=None if network.skin_elements is None else network.skin_elements[every],
        ends=network.line_ends, rows=every,
    )  # fmt: skip
    return FacePoints(
        between=between,
        position=between.behind(network.position)[network.node_count :],
        owner=np.concatenate([own.owner, 0 * of_axis - 1, of_thread]),
        size=np.concatenate([np.zeros(len(own.face)), radii[of_axis], *thickness]),
        extent=np.concatenate([own.areas, lengths]),
        shape=np.concatenate([np.full(len(own.face), -1), of_axis, 0 * of_thread - 1]),
        bodies=np.array(bodies),
        face_size=size,
        skin=np.append(every[own.face], on_lines),
        thin=thin,
        couples=np.argwhere(yields),
        couple=np.append(couple, on_lines),
    )


def _radii(tools: Sequence[Tool]) -> Floats:
    """Return the radii of all shapes of tools, inf of planes [m], shape (shape,)."""
    shapes = [shape for tool in tools for shape in tool.shapes]
    return np.array([one.radius if one.kind == "capsule" else np.inf for one in shapes])


def _yielding(
    network: Network, bodies: Sequence[int], rows: Sequence[Indices],
    areas: Sequence[Floats], law: EnvironmentEntries,
) -> NDArray[np.bool_]:  # fmt: skip
    """Return which bodies are firmer than which others, shape (body, body).

    None are if bodies do not touch one another, or where a pressure per depth is written.
    """
    found = np.zeros((len(network.bodies), len(network.bodies)), dtype=bool)
    if not law.between_bodies or law.contact_surface_stiffness is not None or len(bodies) < 2:
        return found
    firm = [_of_elements(network.skin[row].astype(np.int64), network)[0] for row in rows]
    most = np.array([one.max() for one in firm])
    mean = np.array([one @ area / area.sum() for one, area in zip(firm, areas, strict=True)])
    found[np.ix_(bodies, bodies)] = (most[:, None] > (1.0 + ALIKE) * mean) & (mean > 0.0)
    np.fill_diagonal(found, val=False)
    return found


def _touch_others(
    network: Network, tools: Sequence[Tool], law: EnvironmentEntries, yields: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Return which bodies may touch more than softer ones, shape (body,)."""
    count = len(network.bodies)
    if law.within_bodies or any(tool.shapes for tool in tools):
        return np.ones(count, dtype=bool)
    has_skin = np.array([len(network.skin_of(body)) > 0 for body in network.bodies])
    others = has_skin & ~np.eye(count, dtype=bool) & ~yields
    return np.asarray(others.any(axis=1) | ~yields.any(axis=1))


def _in_couples(
    own: "_OnFaces", yields: NDArray[np.bool_], touch: NDArray[np.bool_]
) -> tuple["_OnFaces", Indices]:
    """Return the points of faces, once more for each softer body, and their couples.

    Args:
        own: Points of faces, body by body.
        yields: Which bodies are firmer than which others, shape (body, body).
        touch: Which bodies may touch more than softer ones, shape (body,).
    """
    couples = np.argwhere(yields)
    chosen = [np.flatnonzero(touch[own.owner])]
    chosen += [np.flatnonzero(own.owner == body) for body in couples[:, 0]]
    point = np.concatenate(chosen)
    couple = np.repeat(np.arange(-1, len(couples)), [len(each) for each in chosen])
    return own.some(point), couple


class _OnFaces(NamedTuple):
    """Points of faces, body by body.

    Attributes:
        face: Number of the triangle of each, shape (point,).
        shares: N_a, shape (point, 3).
        areas: [m²], shape (point,).
        owner: Body of each, shape (point,).
    """

    face: Indices
    shares: Floats
    areas: Floats
    owner: Indices

    def some(self, which: Indices) -> "_OnFaces":
        """Return a selection of points, by indices of shape (n,)."""
        return _OnFaces(
            self.face[which], self.shares[which], self.areas[which], self.owner[which]
        )


def _on_faces(
    bodies: Sequence[int],
    rows: Sequence[Indices],
    areas: Sequence[Floats],
    rules: Sequence[TriangleRule],
) -> _OnFaces:
    """Return the points of the faces of bodies, by their triangles, areas and rules."""
    first = np.cumsum([0, *map(len, rows)])
    faces = [
        np.repeat(start + np.arange(len(row)), len(rule.weights))
        for row, rule, start in zip(rows, rules, first, strict=False)
    ]
    shares = [np.tile(one.points, (len(row), 1)) for one, row in zip(rules, rows, strict=True)]
    every = [np.outer(a, one.weights).ravel() for one, a in zip(rules, areas, strict=True)]
    return _OnFaces(
        np.concatenate(faces),
        np.concatenate(shares),
        np.concatenate(every),
        np.repeat(bodies, [len(face) for face in faces]),
    )


def _has_points(network: Network, body: BodyPart, law: EnvironmentEntries) -> bool:
    """Return whether contact acts on the faces of a body."""
    if body.thread is not None or law.contact_places == "nodes":
        return False
    by_word = law.contact_places == "faces"
    by_default = body.is_made_of_elements and law.contact_stiffness is None
    return (by_word or by_default) and len(_faces(network, body)) > 0


def _faces(network: Network, body: BodyPart) -> Indices:
    """Return the surface triangles of a body that are not in a plane of symmetry."""
    own = (network.skin >= body.nodes.start) & (network.skin < body.nodes.stop)
    return np.flatnonzero(own.all(axis=1) & ~are_mirrored(network))


def are_mirrored(network: Network) -> NDArray[np.bool_]:
    """Return which surface triangles are in a plane of symmetry, shape (triangle,)."""
    mirrored = np.zeros(len(network.skin), dtype=bool)
    for plane in network.mirrored:
        mirrored |= np.isin(network.skin, plane.nodes).all(axis=1)
    return mirrored


def _areas(network: Network, rows: Indices) -> Floats:
    a, b, c = network.position[network.skin[rows].T]
    return 0.5 * norm(cross(b - a, c - a))


class _Axis(Struct, frozen=True, eq=False):
    """Points on the axis of a capsule, or along a thread.

    Attributes:
        ends: Nodes at the ends of the line of each, the second one twice, shape (point, 3).
        shares: N_a, shape (point, 3).
        lengths: Length of axis that each represents [m], shape (point,).
        bonds: Springs of which one must be there for a point, -1 for none, shape (point, 2).
        radius: [m].
    """

    ends: Indices
    shares: Floats
    lengths: Floats
    bonds: Indices
    radius: float


def _axes(
    network: Network, tools: Sequence[Tool], thin: NDArray[np.bool_], size: Floats
) -> list[_Axis]:
    """Return the points of the shapes of tools that are thin compared with a body.

    Args:
        thin: Which shapes are thin for which bodies, shape (shape, body).
        size: Of the faces of each body [m], shape (body,).
    """
    shapes = [(tool, shape.radius) for tool in tools for shape in tool.shapes]
    return [
        _axis(network, 2 * number, tool, radius, ALONG * float(size[beside].min()))
        for number, ((tool, radius), beside) in enumerate(zip(shapes, thin, strict=True))
        if beside.any()
    ]


def _axis(network: Network, place: int, tool: Tool, radius: float, apart: float) -> _Axis:
    """Return points along a capsule of a tool, and at those of its ends that are free.

    A rounded end, which is as wide as the tool, counts as half a radius.

    Args:
        place: Of its first node among those of tools.
        apart: Largest distance of points [m].
    """
    first = network.tools[0].nodes.start + place
    a, b = network.position[first], network.position[first + 1]
    others = np.concatenate([shape.points for shape in tool.shapes])
    length = float(np.linalg.norm(b - a))
    count = int(np.ceil(length / apart)) if length > 0.0 else 0
    _refuse_long(tool.name, length, apart, tool.span)
    way = (np.arange(count) + 0.5) / max(count, 1)
    lengths = np.full(count, length / max(count, 1))
    ends = [0.0] if length == 0.0 else [0.0, 1.0]
    free = [s for s in ends if (others == (a, b)[round(s)]).all(axis=1).sum() == 3 - len(ends)]
    way, lengths = np.append(way, free), np.append(lengths, np.full(len(free), 0.5 * radius))
    return _Axis(
        np.tile([first, first + 1, first + 1], (len(way), 1)),
        np.stack([1.0 - way, way, np.zeros_like(way)], axis=1),
        lengths,
        np.full((len(way), 2), -1),
        radius,
    )


def _refuse_long(name: str, length: float, apart: float, span: Span) -> None:
    """Reject what is too long for points some way apart along it [m]."""
    if length <= MOST_ALONG * apart:
        return
    message = (
        f"{name} is {show(length, LENGTH)} long and touches faces of "
        f"{show(apart / ALONG, LENGTH)}, which takes {length / apart:.2g} points of contact"
    )
    hint = f"at most {MOST_ALONG} are possible: check the places of its ends"
    raise CompileError([Diagnostic("TIS310", message, span, hint)])


def _along(network: Network, body: BodyPart, apart: float) -> _Axis:
    """Return points along the pieces of a thread, at most some way apart [m].

    They are in the middles of equal parts of a piece.
    """
    assert body.thread is not None
    pieces = bonds(body.thread)
    ends = network.line_ends[[spring for spring, _ in pieces]].astype(np.int64)
    length = norm(network.position[ends[:, 1]] - network.position[ends[:, 0]])
    _refuse_long(body.name, float(length.sum()), apart, body.span)
    count = np.maximum(np.ceil(length / apart), 1.0).astype(np.int64)
    of = np.repeat(np.arange(len(ends)), count)
    way = (counted_up(count) + 0.5) / count[of]
    return _Axis(
        ends[of][:, [0, 1, 1]],
        np.stack([1.0 - way, way, np.zeros_like(way)], axis=1),
        length[of] / count[of],
        np.array([bond for _, bond in pieces], dtype=np.int64)[of],
        body.thread.radius,
    )


def spare_points(points: FacePoints, network: Network, *, twice: bool) -> int:
    """Return how many points on parts of solids there may be after cuts.

    Those of the outer surface may all be replaced; behind these are those of faces of cuts.

    Args:
        twice: Whether faces of cuts have other points for each other.
    """
    found = 0
    for part in network.phantoms:
        number = next(n for n, b in enumerate(network.bodies) if b.name == part.body)
        own = points.between.face[(points.owner == number) & (points.skin >= 0)]
        riders = int(part.riders.stop - part.riders.start)
        most = np.bincount(own).max(initial=0) / len(FEW.weights)
        found += len(own) + ceil((1 + twice) * _OF_RIDERS * most * riders)
    return found


def refuse_nodes(network: Network, points: FacePoints | None, findings: Findings) -> None:
    """Reject solids that the script cuts, but whose nodes touch instead of their faces."""
    faced = [] if points is None else [network.bodies[n].name for n in points.bodies.tolist()]
    for part in network.phantoms:
        body = network.body_named(part.body)
        if part.body not in faced and len(network.skin_of(body)):
            findings.reject(
                "TIS306",
                f"{part.body} is cut, but its nodes are touched, of which cuts make copies",
                body.span,
                hint="write contact places is faces, without a contact stiffness",
            )


def stiffness_of(
    points: FacePoints, network: Network, environment: Environment, findings: Findings,
    *, balances: bool,
) -> Floats:  # fmt: skip
    """Return the stiffness of each point of contact [N/m], shape (point,).

    Args:
        points: Of the network.
        network: With its elements.
        environment: The environment, which may set the pressure per depth.
        balances: Whether the scene has equilibria.
    """
    assert environment.contact is not None, "otherwise there are no points"
    axis, threaded = points.owner < 0, points.is_on_thread
    if (written := environment.contact.contact_surface_stiffness) is not None:
        return written * points.extent * np.where(axis | threaded, points.size, 1.0)
    touched = [network.bodies[int(n)] for n in points.bodies]
    nets = [body for body in touched if not body.is_made_of_elements]
    if nets:
        example = f"contact surface stiffness = {show(1e6, AREAL_STIFFNESS)}"
        findings.reject(
            "TIS304",
            f'environment needs "contact surface stiffness": {nets[0].name} is made of '
            "springs, which do not say how hard its faces are",
            environment.span,
            hint=missing(example, environment.span),
        )
    firm, hard = _of_elements(points.between.triangles, network)
    found = np.zeros(len(points.extent))
    faced = points.between.face != NO_FACE
    hard *= AT_REST if balances else HARDNESS
    found[faced] = hard[points.between.face[faced]] * points.extent[faced]
    owner = np.searchsorted(points.bodies, points.owner[faced])
    area = np.bincount(owner, points.extent[faced])
    mean = np.zeros(len(network.bodies))
    firm_of = firm[points.between.face[faced]] * points.extent[faced]
    mean[points.bodies] = np.bincount(owner, firm_of) / area
    yields = np.flatnonzero(points.couple >= 0)
    softer = mean[points.couples[points.couple[yields], 1]]
    found[yields] *= np.minimum(softer / or_one(firm[points.between.face[yields]]), 1.0)
    beside = points.thin[points.shape[axis]]
    # A strip as wide as R, of the pressure c E*/R by depth.
    found[axis] = HARDNESS * points.extent[axis] * (beside @ mean) / beside.sum(axis=1)
    # At a corner of a cell, a single point bears what dents the cell by half.
    firmest, size = mean[points.bodies].max(), float(points.face_size.max())
    hard_of = np.maximum(HARDNESS, 2.0 * size / or_one(points.size[threaded]))
    found[threaded] = hard_of * points.extent[threaded] * firmest
    return found


def _of_elements(triangles: Indices, network: Network) -> tuple[Floats, Floats]:
    """Return E* [Pa] of the element behind each triangle, and k/c [Pa/m].

    Args:
        triangles: Corners, shape (triangle, 3).
    """
    firm, hard = np.zeros((2, len(triangles)))
    a, b, c = network.position[triangles.T]
    area = 0.5 * norm(cross(b - a, c - a))
    index = TriangleIndex(triangles)
    for one in network.elements:
        is_wall, faces = one.nodes.shape[1] == 3, one.faces
        place = index.find(faces.reshape(-1, 3))
        element = np.repeat(np.arange(len(one.nodes)), faces.shape[1])
        place, element = place[place >= 0], element[place >= 0]
        firm[place] = plane_modulus(one.shear[element], one.bulk_modulus[element])
        size = np.sqrt(2.0 * area[place])
        thick = one.weight[element] / area[place] if is_wall else size
        hard[place] = firm[place] * thick / size**2
    return firm, hard
