"""Contact of tools and threads; nodes of tools come after those of the bodies."""

from collections.abc import Sequence
from math import pi, sqrt
from typing import TYPE_CHECKING, NamedTuple, NoReturn

import numpy as np
from msgspec import Struct

from tissuec.compiler.ambient_damping import skin_areas, thread_areas
from tissuec.compiler.bodies.threads import bonds
from tissuec.compiler.contact.friction import friction_of, has_friction
from tissuec.compiler.contact.points import (
    SKIN,
    SOFT,
    DrawnOverlap,
    FacePoints,
    SideTables,
    are_mirrored,
    face_points,
    refuse_nodes,
    spare_points,
    stiffness_of,
)
from tissuec.core.arrays import distinct
from tissuec.core.errors import Note, counted
from tissuec.core.structs import replace
from tissuec.core.units import LENGTH, STIFFNESS, show
from tissuec.geometry.edge_supports import SupportedEdges
from tissuec.geometry.inclusion import shared_elements
from tissuec.geometry.nearest import CAPSULE, PLANE, TRIANGLE
from tissuec.model.network import (
    FRICTION,
    Floats,
    Indices,
    Network,
    Origin,
    Provenance,
    ToolPart,
    ToolShape,
)
from tissuec.model.topology import pieces
from tissuec.scene.environment import Environment, EnvironmentEntries
from tissuec.scene.model import Tool
from tissuec.scene.reading.entry_hints import missing
from tissuec.scene.reading.findings import Findings

if TYPE_CHECKING:  # annotations only: scenes without it load faster
    from tissuec.forces.contact.contact import Contact
    from tissuec.forces.contact.pairs import ContactPairs

SOFTEST_LAYER = 0.1  # of the mean length of a spring
THINNEST = 0.5  # of the radius of the thinnest tool
STRIDE = 0.5  # the same, as the way that nodes may go in a step
ONE_GRAM = 1e-3  # mass of what no force moves [kg]
#: Of the extent of the network: overlaps within the rounding of coordinates.
TOUCHING = 1e-12


def with_tools(network: Network, tools: Sequence[Tool], environment: Environment) -> Network:
    """Return a network with the nodes that carry the shapes of tools, and bristles.

    Each node of a body and each point of contact has a bristle that stores the state of
    friction, where things can touch.
    """
    law = environment.contact
    shaped = [tool for tool in tools if tool.shapes]
    if law is None or not (has_friction(network, law) and _can_touch(network, shaped, law)):
        law = None  # nothing rubs
    if not shaped and law is None:
        return network
    points = [np.concatenate([shape.points for shape in tool.shapes]) for tool in shaped]
    none = np.zeros((0, 3))
    ends = network.node_count + np.cumsum([0, *map(len, points)])
    parts = tuple(
        ToolPart(
            tool.name,
            tool.kind,
            slice(int(start), int(stop)),
            tool.span,
            tuple(ToolShape(shape.kind, shape.radius) for shape in tool.shapes),
        )
        for tool, start, stop in zip(shaped, ends, ends[1:], strict=False)
    )
    of_tool = np.repeat(np.arange(len(shaped), dtype=np.int32), [len(p) for p in points])
    origins = Provenance(of_tool, tuple(Origin(tool.span, "tool") for tool in shaped))
    added = np.concatenate([none, *points])
    known = replace(network.with_nodes(added, ONE_GRAM, origins), tools=parts)
    if law is None:
        return known
    points = face_points(known, [tool for tool in tools if tool.may_touch], law)
    more = (
        0
        if points is None
        else len(points.position) + spare_points(points, network, twice=law.between_bodies)
    )
    return known.with_internal(FRICTION, network.node_count + more)


def _can_touch(network: Network, tools: Sequence[Tool], law: EnvironmentEntries) -> bool:
    """Return whether a scene has shapes that touch nodes."""
    if any(tool.may_touch for tool in tools):
        return True
    skins = _of_skins(network, law, None, threaded=bool(_sizes(network).any()))
    return bool(len(_of_threads(network).kind) or len(skins.kind))


class Faces(Struct, frozen=True, eq=False):
    """Shapes and the nodes that carry them; see ``Contact``.

    Attributes:
        kind, points, surface, radius, spared, bonds: As there.
        corners: The same as ``points``, but nodes in one place have one number.
    """

    kind: Indices
    points: Indices
    surface: Indices
    radius: Floats
    spared: Indices
    bonds: Indices
    corners: Indices


def contact_of(
    network: Network, tools: Sequence[Tool], environment: Environment, findings: Findings,
    *, balances: bool, settles: bool = False,
) -> "Contact | None":  # fmt: skip
    """Return the contact of a scene, None if there is none.

    Args:
        tools: Those that may touch.
        balances: Whether the scene has equilibria.
        settles: Whether the scene settles at 0 s, so that what overlaps comes to rest.
    """
    if (law := environment.contact) is None:
        return None
    points = face_points(network, tools, law)
    touchable = _touchable(network, points, findings)
    sides = None if points is None else points.sides(network, tools, law)
    skins = _of_skins(network, law, points, sides, threaded=bool(touchable.size.any()))
    parts = [_of_tools(network, tools), _of_threads(network), skins]
    columns = ([getattr(part, name) for part in parts] for name in Faces.__struct_fields__)
    faces = Faces(*map(np.concatenate, columns))
    if not len(faces.kind):
        _warn_of_nothing_to_touch(law, environment, findings)
        return None
    thin = faces.radius[faces.radius > 0.0]
    stiffness = _stiffness(network, law, environment, findings)
    shared = shared_elements(faces.corners, _sides(faces), faces.surface)
    from tissuec.forces.contact.contact import Contact  # where something touches
    from tissuec.forces.contact.sides import Meetings

    shapes = np.concatenate([faces.points, shared.points])
    contact = Contact(
        nodes=touchable.nodes,
        owner=touchable.owner,
        size=touchable.size,
        kind=np.concatenate([faces.kind, np.full(len(shared.points), CAPSULE)]),
        points=shapes,
        surface=np.concatenate([faces.surface, faces.surface[shared.face]]),
        parts=shared.parts,
        radius=faces.radius,
        spared=faces.spared,
        bonds=faces.bonds,
        edges=_edges(faces, network),
        joined=_joined(network, law),
        stride=STRIDE * float(thin.min()) if len(thin) else network.extent / 4.0,
        stiffness=stiffness,
        layer=law.contact_layer or _layer(network, faces.radius, environment, findings),
        damping=law.contact_damping or 0.0,
        **friction_of(network, law, shapes, points),
        memory=network.remembering(FRICTION)[: len(touchable.nodes)],
        rate=_pace(stiffness, network),
        span=environment.span,
        meetings=Meetings.of_all(len(touchable.nodes), len(faces.kind)),
        whole=np.ones(len(faces.kind), dtype=bool),
        there=np.ones(len(touchable.nodes), dtype=bool),
    )
    if points is not None and sides is not None:
        own = stiffness_of(points, network, environment, findings, balances=balances)
        contact = _with_points(contact, points, sides, network, parts, law, own)
    _warn_of_drawn_touches(contact, network, tools, sides, findings, settles=settles)
    return contact


def _edges(faces: Faces, network: Network) -> SupportedEdges:
    """Return the supports of the edges of those faces that are triangles."""
    triangles = faces.points[faces.kind == TRIANGLE]
    rings = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=-1)
    every = network.skin_elements
    own = None if every is None else every[: len(triangles)]
    return SupportedEdges.of(network.line_ends, rings, own)


def _pace(stiffness: Floats, network: Network) -> float:
    """Return the frequency of a node of mean mass on the mean stiffness of contact [1/s]."""
    hardness, mass = (
        float(values.mean()) if len(values) else 1.0
        for values in (stiffness, network.mass[: network.body_nodes])
    )
    return sqrt(hardness / mass)


class _Touchable(NamedTuple):
    """Nodes of bodies, followed by points of contact; see ``Contact``."""

    nodes: Indices
    owner: Indices
    size: Floats


def _touchable(network: Network, points: FacePoints | None, findings: Findings) -> _Touchable:
    refuse_nodes(network, points, findings)
    nodes, size = np.arange(network.body_nodes), _sizes(network)
    owner = network.body_numbers(nodes)
    if points is None:
        return _Touchable(nodes, owner, size)
    behind = network.node_count + np.arange(len(points.owner))
    return _Touchable(
        np.append(nodes, behind), np.append(owner, points.owner), np.append(size, points.size)
    )


def _with_points(
    contact: "Contact", points: FacePoints, sides: SideTables, network: Network,
    parts: "list[Faces]", law: EnvironmentEntries, stiffness: Floats,
) -> "Contact":  # fmt: skip
    """Return contact with the stiffness of points and the pairs of groups that may touch.

    Args:
        sides: Which groups are kept outside of solids.
        parts: Faces of tools, of threads, and of skins.
        stiffness: Of points [N/m], shape (point,).
    """
    from tissuec.forces.contact.sides import Meetings  # where something touches

    of_tools, of_threads, of_skins = parts
    shapes, bodies = len(of_tools.kind), len(network.bodies)
    skins = shapes + bodies + network.body_numbers(of_skins.points[:, 0])
    skins[are_mirrored(network)[: len(skins)]] = shapes + 2 * bodies
    of = np.concatenate([np.arange(shapes), shapes + of_threads.spared, skins])
    group = np.append(network.body_numbers(np.arange(network.body_nodes)), points.group(bodies))
    return replace(
        contact,
        stiffness=np.append(contact.stiffness, stiffness),
        layer=law.contact_layer or SOFT * float(points.face_size.min()),
        between=points.between,
        twins_touch=law.between_bodies,
        meetings=Meetings(group, of, points.meetings(network), *sides[:3]),
    )


def _of_tools(network: Network, tools: Sequence[Tool]) -> Faces:
    shapes = [shape for tool in tools for shape in tool.shapes]
    start = network.tools[0].nodes.start if network.tools else 0
    points = start + np.arange(2 * len(shapes)).reshape(-1, 2)[:, [0, 1, 1]]
    corners = _places(network)[points]
    return Faces(
        kind=np.array(
            [PLANE if s.kind == "plane" else CAPSULE for s in shapes], dtype=np.int64
        ),
        points=points,
        # What has an end in common is one surface: shaft, bend and tip of a hook.
        surface=pieces(network.node_count, corners[:, :2])[corners[:, 0]].astype(np.int64),
        radius=np.array([shape.radius for shape in shapes], dtype=float),
        spared=np.full(len(shapes), -1),
        bonds=_unbound(len(shapes)),
        corners=corners,
    )


def _places(network: Network) -> Indices:
    """Return for each node the first node of the same tool in the same place, shape (node,)."""
    first = np.arange(network.node_count)
    for tool in network.tools:
        place = network.position[tool.nodes]
        _, where, of = np.unique(place, axis=0, return_index=True, return_inverse=True)
        first[tool.nodes] = tool.nodes.start + where[of.reshape(-1)]
    return first


def _of_threads(network: Network) -> Faces:
    """Return the pieces of threads, and of their knots."""
    found = [
        (network.springs.ends[spring], body.thread.radius, number, bond)
        for number, body in enumerate(network.bodies)
        if body.thread is not None
        for spring, bond in bonds(body.thread)
    ]
    points = np.array([row[0] for row in found], dtype=np.int64).reshape(-1, 2)[:, [0, 1, 1]]
    owner = np.array([row[2] for row in found], dtype=np.int64)
    return Faces(
        kind=np.full(len(found), CAPSULE),
        points=points,
        surface=network.node_count + owner,
        radius=np.array([row[1] for row in found], dtype=float),
        spared=owner,
        bonds=np.array([row[3] for row in found], dtype=np.int64).reshape(-1, 2),
        corners=points,
    )


def _unbound(count: int) -> Indices:
    """Return the bonds of shapes that need no springs."""
    return np.full((count, 2), -1)


def default_thickness(network: Network, points: FacePoints | None) -> float:
    """Return a quarter of the size of the smallest faces that have points [m].

    Where none have, it is a quarter of the mean length of a spring, or 0 without any.
    """
    size = _mean_length(network) if points is None else float(points.face_size.min())
    return SKIN * size if size > 0.0 else 0.0


def _of_skins(
    network: Network,
    law: EnvironmentEntries,
    points: FacePoints | None,
    sides: SideTables | None = None,
    *,
    threaded: bool,
) -> Faces:
    """Return the triangles of the surfaces of all bodies, if anything can touch them.

    Threads and thin tools always touch surfaces, at their own radius; surfaces then have none.

    Args:
        points: Of contact of faces.
        sides: Which of them are kept outside of solids.
        threaded: Whether there are any of those.
    """
    skin, thickness = network.skin.astype(np.int64), np.zeros(len(network.bodies))
    if law.between_bodies:
        usual = default_thickness(network, points)
        thickness[:] = law.contact_thickness or usual
        if points is not None and sides is not None and not law.within_bodies:
            # Where everything is kept outside, the thickness only says what is listed as near.
            for number, apart in enumerate(points.distances_from_skins(network, sides)):
                if len(apart) and not np.isnan(apart).any():
                    thickness[number] = max(usual, float(apart.max()))
    elif not threaded:
        skin = skin[:0]
    owner = network.body_numbers(skin[:, 0])
    return Faces(
        kind=np.full(len(skin), TRIANGLE),
        points=skin,
        surface=network.node_count + len(network.bodies) + owner,
        radius=thickness[owner],
        spared=np.full(len(skin), -1) if law.within_bodies else owner,
        bonds=_unbound(len(skin)),
        corners=skin,
    )


def _sides(faces: Faces) -> Indices:
    """Return how many corners each face may share with others, shape (face,)."""
    apart = faces.corners[:, 0] != faces.corners[:, 1]
    return np.select([faces.kind == TRIANGLE, (faces.kind == CAPSULE) & apart], [3, 2], 0)


def _sizes(network: Network) -> Floats:
    """Return the radius of the thread that each node of a body belongs to, else 0 [m]."""
    radii = [0.0 if body.thread is None else body.thread.radius for body in network.bodies]
    return np.array(radii, dtype=float)[network.body_numbers(np.arange(network.body_nodes))]


def _joined(network: Network, law: EnvironmentEntries) -> Indices:
    """Return pairs of nodes that do not touch, because springs join them; see ``Contact``.

    Those of a body that touches itself, and stitches of threads, which go into the tissue.
    """
    stitches = network.joined_ends.astype(np.int64)
    stitches = stitches[(_sizes(network)[stitches] > 0.0).any(axis=1)]
    own = network.line_ends[network.of_bodies & law.within_bodies]
    low, high = np.sort(np.concatenate([own.astype(np.int64), stitches]), axis=1).T
    return distinct(low * network.node_count + high)


def _warn_of_overlaps(
    overlaps: Sequence[DrawnOverlap], network: Network, findings: Findings, *, settles: bool
) -> None:
    """Warn of solids that are drawn into each other, as a part of the depth has no force."""
    for one in overlaps:
        first, second = network.bodies[one.first], network.bodies[one.second]
        depth, ignored = show(one.depth, LENGTH), show(one.ignored, LENGTH)
        rest = "" if settles else ", and pushes them apart by the rest at once"
        message = (
            f"{second.name} is drawn {depth} into {first.name}: contact begins to press "
            f"{ignored} below the surface{rest}"
            if one.depth - one.ignored > TOUCHING * network.extent
            else f"{second.name} is drawn {depth} into {first.name}, where contact begins to "
            "press: this depth has no force"
        )
        findings.add(
            "W406",
            message,
            second.span,
            hint=f"draw them {depth} further apart; to press them together, move one of them",
            notes=(Note("the other body", first.span),),
        )


def _warn_of_drawn_touches(
    contact: "Contact", network: Network, tools: Sequence[Tool], sides: SideTables | None,
    findings: Findings, *, settles: bool,
) -> None:  # fmt: skip
    """Warn of what touches before anything moves: it is pushed apart at once.

    Args:
        sides: With the solids that are drawn into each other.
        settles: Whether the scene settles at 0 s.
    """
    overlaps = () if sides is None else sides.overlaps
    _warn_of_overlaps(overlaps, network, findings, settles=settles)
    if settles:
        return
    contact = contact.intact(network.present)
    pairs = contact.near(network.position, 0.0)
    depth = contact.places(network.position, pairs).depth
    # Skins have numbers behind nodes and threads.
    skin = contact.surface[pairs.shape] - network.node_count - len(network.bodies)
    owner, touches = contact.owner[pairs.node], depth > TOUCHING * network.extent
    for one in overlaps:
        touches &= ~np.isin(owner, one[:2]) | ~np.isin(skin, one[:2]) | (owner == skin)
    pairs = pairs.some(touches)
    if len(pairs.node):
        deepest = show(float(depth[touches].max()), LENGTH)
        findings.add(
            "W406",
            "bodies or tools overlap at the start at "
            f"{counted(len(distinct(pairs.node)), 'point' if contact.between else 'node')} "
            f"by up to {deepest} and are pushed apart at once",
            contact.span,
            hint=_turned_planes(network, tools)
            or f"draw {_further_apart(contact, network, pairs)}, or let the net settle "
            '("at 0 s: settle")',
        )


def _turned_planes(network: Network, tools: Sequence[Tool]) -> str:
    """Return that a body lies behind a plane, whose normal may be meant otherwise; or ""."""
    first = network.tools[0].nodes.start if network.tools else 0
    shapes = [(tool.name, shape) for tool in tools for shape in tool.shapes]
    for number, (name, shape) in enumerate(shapes):
        if shape.kind != "plane":
            continue
        point, ahead = network.position[first + 2 * number : first + 2 * number + 2]
        for body in network.bodies:
            if ((network.position[body.nodes] - point) @ (ahead - point) < 0.0).all():
                return (
                    f"{body.name} lies behind {name}, on the side that its normal points away "
                    "from: reverse the normal"
                )
    return ""


def _further_apart(contact: "Contact", network: Network, pairs: "ContactPairs") -> str:
    """Return a remedy: what to draw further apart, or which thickness to reduce."""
    surface, thread = contact.surface[pairs.shape], contact.size[pairs.node]
    of_tool = (surface < network.node_count) | (contact.owner[pairs.node] < 0)
    # A thread touches at its own radius, unless surfaces of bodies are thicker.
    of_skin = (surface >= network.node_count + len(network.bodies)) & (pairs.radius > thread)
    what = "bodies and tools further apart" if of_tool.any() else "bodies further apart"
    is_thread = (thread > 0.0) | (
        (surface >= network.node_count) & (surface < network.node_count + len(network.bodies))
    )
    if of_skin.all():
        return f"{what}, or write a smaller contact thickness"
    if is_thread.any() and not (of_tool | of_skin).any():
        return f"{what}, or write a smaller thickness of the thread"
    return what


def _mean_length(network: Network) -> float:
    """Return the mean length of the lines of bodies as drawn [m]; NaN without any."""
    ends = network.position[network.line_ends[network.of_bodies]]
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    return float(lengths.mean()) if len(lengths) else float("nan")


def _warn_of_nothing_to_touch(
    law: EnvironmentEntries, environment: Environment, findings: Findings
) -> None:
    if findings.errors:  # a tool may be what is wrong
        return
    text = "contact has no effect: no tool has a shape"
    example = "tool probe { kind is probe; radius = 3 mm; centre = (0, 0, 10) mm }"
    hint = f"for example: {example}"
    if law.between_bodies:
        text += ", and no body has a surface"
        hint = f"use a mesh with a surface, such as a sheet, or give a tool a shape, {hint}"
    findings.add("W407", text, environment.span, hint=hint)


def _stiffness(
    network: Network, law: EnvironmentEntries, environment: Environment, findings: Findings
) -> Floats:
    """Return by how much each node of a body resists what touches it [N/m], shape (node,)."""
    if law.contact_surface_stiffness is not None:
        return law.contact_surface_stiffness * _faced_areas(network, environment, findings)
    alike = law.contact_stiffness or _stiffness_of_springs(network, environment, findings)
    return np.full(network.body_nodes, alike)


def _faced_areas(network: Network, environment: Environment, findings: Findings) -> Floats:
    """Return the area that each node of a body shows to what touches it [m²], shape (node,).

    Of a thread its thickness times its length; nodes inside of a skin have the mean of others,
    and those of a net without a skin the mean of all other nodes that have one.
    """
    area = skin_areas(network) + thread_areas(network) / pi
    if not area.any():
        body = network.bodies[0]
        findings.reject(
            "TIS306",
            f"contact surface stiffness needs a surface, which {body.name} does not have",
            environment.span,
            hint="write a contact stiffness, of each node",
            notes=(Note("the body", body.span),),
        )
    usual = float(area[area > 0.0].mean())
    for body in network.bodies:
        own = area[body.nodes]
        mean = float(own[own > 0.0].mean()) if own.any() else usual
        area[body.nodes] = np.where(own > 0.0, own, mean)
    return area[: network.body_nodes]


def _stiffness_of_springs(
    network: Network, environment: Environment, findings: Findings
) -> float:
    """Return the mean over the nodes of what their springs and elements resist with [N/m]."""
    own = slice(network.body_springs)  # and not those of joints, which may be few and stiff
    steep = network.springs.behaviour.steepness(np.zeros(network.spring_count))[own]
    ends, both = network.springs.ends[own].ravel(), np.repeat(steep, 2)
    each = np.bincount(ends, both, network.body_nodes).astype(float)  # also of no springs
    nodes = np.arange(network.node_count)
    for solid in network.elements:
        # The trace of a node's stiffness, as the sum of springs. Unstrained, all are positive.
        is_unstrained = not solid.is_prestressed
        matrix = solid.matrix(0.0, network.position, nodes, len(nodes), exact=is_unstrained)
        each += matrix.tocsr().diagonal().reshape(-1, 3).sum(axis=1)[: network.body_nodes]
    if each.any():
        return float(each[each > 0.0].mean())
    _unknown("contact stiffness", show(1e3, STIFFNESS), environment, findings)


def _layer(
    network: Network, radius: Floats, environment: Environment, findings: Findings
) -> float:
    """Return a tenth of the mean length of a spring, and no more than thin tools allow [m]."""
    thin = THINNEST * radius[radius > 0.0]
    if network.of_bodies.any():
        return min(SOFTEST_LAYER * _mean_length(network), float(thin.min(initial=np.inf)))
    if len(thin):
        return SOFTEST_LAYER * float(thin.min())
    _unknown("contact layer", show(1e-3, LENGTH), environment, findings)


def _unknown(name: str, example: str, environment: Environment, findings: Findings) -> NoReturn:
    findings.raise_errors()  # a mesh that is wrong has no springs either
    findings.reject(
        "TIS304",
        f'environment needs "{name}", because no spring determines it',
        environment.span,
        hint=missing(f"{name} = {example}", environment.span),
    )
