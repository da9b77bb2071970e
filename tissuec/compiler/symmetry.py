"""Planes of symmetry of a scene: the nodes on them, and features that contradict them."""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from msgspec import Struct

from tissuec.core.errors import Note
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.core.units import LENGTH, show
from tissuec.forces.contact.contact import Contact
from tissuec.model.guides import Guides, free_directions
from tissuec.model.network import BodyPart, Floats, Indices, MirrorPlane, Network
from tissuec.scene.environment import EnvironmentEntries
from tissuec.scene.model import Scene
from tissuec.scene.reading.findings import Findings
from tissuec.script.plan import Plan, ScheduledAction
from tissuec.script.verbs.change import ChangeMotion, ChangeSurroundings
from tissuec.script.verbs.cut_surface import Blade
from tissuec.script.verbs.holding import Driven, Holding, Taken
from tissuec.script.verbs.move import Move, Turn
from tissuec.script.verbs.push import Push

ON_PLANE = 1e-6  # of the size of the scene: as far from a plane, a node is on it
GRAVITY = "gravity"  # in messages
ASLANT = 1e-9  # component across a plane, relative to the size of a vector, that is none


class WrittenPlane(Struct, frozen=True, eq=False):
    """A plane of symmetry and the nodes on it, ascending, shape (n,)."""

    plane: Blade
    nodes: Indices
    span: Span

    @property
    def mirror(self) -> MirrorPlane:
        """Return the plane without the span of its sentence."""
        return MirrorPlane(self.plane.origin, self.plane.normal, self.nodes)


def read_planes(scene: Scene, network: Network, findings: Findings) -> tuple[WrittenPlane, ...]:
    """Return the planes of symmetry of a scene; wrong ones are reported and left out.

    Args:
        network: All bodies and joints.
    """
    planes: list[WrittenPlane] = []
    if not network.body_nodes:  # a body that could not be drawn is reported elsewhere
        return ()
    for said in scene.environment.planes:
        with findings.item():
            _refuse_angles(said.plane, planes, findings, said.span)
            planes.append(_placed(said.plane, network, findings, said.span))
    return tuple(planes)


def guides_of_planes(
    planes: Sequence[WrittenPlane], network: Network, plan: Plan, findings: Findings
) -> Guides:
    """Return how planes of symmetry guide the nodes on them; report what contradicts them.

    Args:
        planes: At least one.
        plan: What the script does to nodes on planes, and gravity.
    """
    for one in planes:
        _refuse_aslant(one, plan.gravity, GRAVITY, one.span, findings)
        _refuse_motion(one, network, findings)
        for span, vectors, what in _acting(one, plan):
            for vector in vectors:
                _refuse_aslant(one, vector, what, span, findings)
    nodes = np.unique(np.concatenate([one.nodes for one in planes]))
    within = np.array([_projection(int(node), planes) for node in nodes]).reshape(-1, 3, 3)
    share = 0.5 ** np.rint(3.0 - np.trace(within, axis1=1, axis2=2))
    return Guides(nodes, within, share, planes[0].span)


def shared_contact(contact: Contact, guides: Guides, law: EnvironmentEntries) -> Contact:
    """Return contact in which nodes on planes have the share of the drawn half.

    Args:
        contact: Where each node represents all that is around it.
        guides: The nodes on planes.
        law: By surface, nodes have the part of the surface that is drawn already.
    """
    if law.contact_surface_stiffness is not None:
        return contact
    stiffness = contact.stiffness.copy()
    stiffness[guides.nodes] *= guides.share
    return replace(contact, stiffness=stiffness)


def _refuse_angles(
    plane: Blade, others: Iterable[WrittenPlane], findings: Findings, span: Span
) -> None:
    """Reject a plane that is neither parallel nor perpendicular to others."""
    for other in others:
        cosine = abs(float(plane.normal @ other.plane.normal))
        if ASLANT < cosine < 1.0 - ASLANT:
            across = plane.normal - (plane.normal @ other.plane.normal) * other.plane.normal
            findings.reject(
                "TIS306",
                f"planes of symmetry must be perpendicular, or parallel, not at an angle of "
                f"{np.degrees(np.arccos(cosine)):.3g} degrees",
                span,
                hint=f"write facing {_direction(across)}, or draw a half or a quarter of the "
                "body instead of a sector",
                notes=(Note("another plane", other.span),),
            )


def _direction(vector: Floats) -> str:
    """Return a direction as text, with a largest component of 1."""
    largest = float(np.abs(vector).max())
    parts = [round(float(part) / largest, 6) + 0.0 for part in vector]
    return f"({', '.join(f'{part:.3g}' for part in parts)})"


def _placed(plane: Blade, network: Network, findings: Findings, span: Span) -> WrittenPlane:
    """Return a plane with the nodes on it, or reject it."""
    bodies = slice(network.body_nodes)
    away = (network.position[bodies] - plane.origin) @ plane.normal
    limit = ON_PLANE * network.extent
    if not (np.abs(away) <= limit).any():
        nearest = show(float(np.abs(away).min(initial=np.inf)), LENGTH)
        findings.reject(
            "TIS309",
            f"no node lies on this plane; the nearest is {nearest} away",
            span,
            hint="move the plane to the nodes of a face, or draw bodies up to it",
        )
    sides = {
        name: next((b.name for b in network.bodies if is_there[b.nodes].any()), None)
        for name, is_there in (("front", away > limit), ("back", away < -limit))
    }
    if all(sides.values()):
        findings.reject(
            "TIS309",
            f"{sides['front']} lies on both sides of this plane"
            if sides["front"] == sides["back"]
            else f"{sides['front']} and {sides['back']} lie on different sides of this plane",
            span,
            hint="draw the half on one side only: the other is its mirror image",
        )
    found = WrittenPlane(plane, np.flatnonzero(np.abs(away) <= limit), span)
    _refuse_springs(found, network, findings)
    return found


def _refuse_springs(one: WrittenPlane, network: Network, findings: Findings) -> None:
    """Reject parts within a plane, half of which belong to the mirror image; and bending."""
    springs = network.springs
    acts = (springs.stiffness > 0.0) | (springs.law > 0)
    within = np.flatnonzero(acts & np.isin(springs.ends, one.nodes).all(axis=1))
    if len(within):
        owner = network.owner(int(within[0]))
        findings.reject(
            "TIS309",
            f"springs of {owner.name} lie within this plane and would count for both halves",
            one.span,
            hint="draw the whole body, or give its tissue a Young's modulus: a plane can cross "
            "elements"
            if isinstance(owner, BodyPart)
            else f"leave nodes on the plane out of one of the sets that {owner.name} joins; "
            "springs can end on the plane",
        )
    for wall in network.of_kind("membranes"):
        if np.isin(wall.nodes, one.nodes).all(axis=1).any():
            findings.reject(
                "TIS309",
                f"triangles of {wall.name} lie within this plane and would count for both "
                "halves",
                one.span,
                hint="let the plane cross the wall",
            )
    for bent in network.of_kind("plates"):
        if len(there := np.intersect1d(bent.nodes, one.nodes)):
            name = network.body_at(int(there[0])).name
            findings.reject(
                "TIS306",
                f"{name} resists bending, but not against its mirror image behind this plane",
                one.span,
                hint="draw the whole wall, or write bending is none in the body",
            )


def _projection(node: int, planes: Iterable[WrittenPlane]) -> Floats:
    """Return the projection into all planes that a node is on, shape (3, 3)."""
    normals = [one.plane.normal for one in planes if node in one.nodes]
    return free_directions(np.array(normals), ON_PLANE)


def _refuse_aslant(
    one: WrittenPlane, vector: Floats, what: str, span: Span, findings: Findings
) -> None:
    """Report a vector that is not parallel to a plane."""
    across = abs(float(vector @ one.plane.normal))
    if across > ASLANT * float(np.linalg.norm(vector)):
        rest = _floor(one.plane) if what == GRAVITY else f": {one.span.one_line}"
        with findings.item():
            findings.reject(
                "TIS306",
                f"{what} is not parallel to a plane of symmetry",
                span,
                hint=f"the mirror image would need the opposite{rest}",
            )


def _floor(plane: Blade) -> str:
    """Return how the floor is written that a plane across gravity is meant to be."""
    point, normal = (
        ", ".join(f"{part:.6g}" for part in vector + 0.0)
        for vector in (1e3 * plane.origin, plane.normal)
    )
    return (
        "; for a smooth floor instead of the plane, write tool floor { kind is plane; "
        f"point = ({point}) mm; normal = ({normal}) }} and, in environment, "
        "contact is tools only"
    )


def _refuse_motion(one: WrittenPlane, network: Network, findings: Findings) -> None:
    """Report nodes on a plane that begin by leaving it."""
    for velocity in np.unique(network.velocity[one.nodes], axis=0):
        _refuse_aslant(one, velocity, "a velocity at the start", one.span, findings)


def _acting(one: WrittenPlane, plan: Plan) -> Iterator[tuple[Span, Sequence[Floats], str]]:
    """Yield the actions of the script on nodes of a plane, which must be parallel to it."""
    events = plan.every_event
    for event in events:
        match event.action:
            case ChangeSurroundings(gravity=gravity, span=span) if gravity is not None:
                yield span, [gravity], GRAVITY
            case Push(group=group, force=force, span=span) if _any(one, group.indices):
                yield span, [force], "a force on nodes of this plane"
            case Move(vectors=vectors, span=span) if _any(one, _moved(event, events)):
                yield span, vectors, "a motion of nodes of this plane"
            case Turn(axis=axis, span=span) if _any(one, _moved(event, events)):
                yield span, _turned(one, axis), "a turn of nodes of this plane"
            case ChangeMotion(group=group, vector=vector, is_spin=is_spin, span=span) if _any(
                one, group.indices
            ):
                vectors = _turned(one, vector) if is_spin else [vector]
                yield span, vectors, "a velocity of nodes of this plane"
            case _:
                pass


def _turned(one: WrittenPlane, axis: Floats) -> list[Floats]:
    """Return where a turn about an axis moves nodes to that are beside it in the plane."""
    within = np.asarray(np.linalg.svd(one.plane.normal[None]).Vh[1:], dtype=np.float64)
    return list(np.cross(axis, within))


def _any(one: WrittenPlane, nodes: Indices) -> bool:
    return bool(np.isin(nodes, one.nodes).any())


def _moved(event: ScheduledAction, events: Iterable[ScheduledAction]) -> Indices:
    """Return the nodes that a motion may move: of a tool, all that it ever takes."""
    action = event.action
    change = action.holding() if isinstance(action, Holding) else None
    assert isinstance(change, Driven)
    if change.mover.nodes is not None:
        return change.mover.nodes
    taken = [np.zeros(0, dtype=np.int64)]
    for other in events:
        held = other.action.holding() if isinstance(other.action, Holding) else None
        if isinstance(held, Taken) and held.holder == change.mover.name:
            taken.append(held.nodes)
    return np.concatenate(taken)
