"""Checks of what holds bodies: those that fall, or are pushed away, for want of support."""

from collections.abc import Iterator, Sequence

import numpy as np
from msgspec import Struct

from tissuec.compiler.checks import check
from tissuec.compiler.compile import Compiled
from tissuec.compiler.measures.observed import CompiledCondition
from tissuec.core.arrays import norm
from tissuec.core.errors import Diagnostic
from tissuec.core.units import FORCE, LENGTH, TIME, show
from tissuec.forces.acting.load import Load
from tissuec.model.network import BodyPart, Floats, Indices, Network, numbers_in
from tissuec.model.topology import pieces
from tissuec.script.measures import MEASURES
from tissuec.script.plan import Plan, ScheduledAction
from tissuec.script.verbs import Action, Shifting, follows
from tissuec.script.verbs.holding import Driven, Holding, nodes_held_by
from tissuec.script.verbs.push import Push

#: Of its size: how far a body may fall before something holds it.
FAR = 0.25
BALANCED = 1e-9  # of the sum of pushes, for their resultant
_OF_MOTION = ("position", "speed")  # measures of expectations about a fall


class Loose(Struct, eq=False):
    """Bodies in one piece that nothing holds, at first.

    Attributes:
        nodes: Of all of them, ascending, shape (n,).
        until: When something holds them [s]; infinite if nothing does.
    """

    bodies: list[BodyPart]
    nodes: Indices
    until: float

    @property
    def name(self) -> str:
        """Return the names of the bodies, as in a sentence."""
        return " and ".join(body.name for body in self.bodies)


@check
def unheld(compiled: Compiled) -> Iterator[Diagnostic]:
    """W310: bodies with springs that nothing holds, where weight or pushes move them.

    Left out are bodies that are thrown, whose motion is expected, or that contact can catch;
    what planes of symmetry bear; and scenes with force blocks, which may hold anything.
    """
    plan = compiled.plan
    events = plan.every_event
    pushes = [event.action for event in events if isinstance(event.action, Push)]
    if compiled.scene.forces or not (pushes or np.any(plan.gravity)):
        return
    loose, held = loose_bodies(compiled.network, plan)
    loads = [push.load(compiled.network, push.profile) for push in pushes] if loose else []
    moved = [(one, _direction(one, compiled, loads)) for one in loose]
    waiting = [(one, along) for one, along in moved if along.any() and not _expected(one, plan)]
    catching = held + [body for one, along in moved if not along.any() for body in one.bodies]
    while caught := [pair for pair in waiting if _is_caught(compiled, *pair, catching, events)]:
        waiting = [pair for pair in waiting if pair not in caught]
        catching += [body for one, _ in caught for body in one.bodies]
    for one, _ in waiting:
        yield from _told(one, compiled, loads)


def loose_bodies(network: Network, plan: Plan) -> tuple[list[Loose], list[BodyPart]]:
    """Return the bodies that are free at 0 s, in pieces, and those that are held."""
    triggered = (e.action for trigger in plan.triggers for e in trigger.events)
    orders = [(event.time, event.action) for event in plan.events]
    orders += [(0.0, action) for action in triggered]  # nobody knows when
    until = np.full(network.node_count, np.inf)
    for time, action in orders:
        nodes = nodes_held_by(action)
        until[nodes] = np.minimum(until[nodes], time)
    piece = None
    loose: dict[int, Loose] = {}
    held: list[BodyPart] = []
    for body in network.bodies:
        is_net = body.lines.start < body.lines.stop
        if not is_net or network.velocity[body.nodes].any() or not until[body.nodes].all():
            held.append(body)
            continue
        if piece is None:  # most scenes do without
            ends = np.concatenate([network.line_ends, network.glued_ends])
            piece = pieces(network.node_count, ends)
            first = np.full(network.node_count, np.inf)
            np.minimum.at(first, piece, until)
            until = first[piece]
        since = float(until[body.nodes].min())
        if since == 0.0:
            held.append(body)
            continue
        nodes = numbers_in(body.nodes)
        one = loose.setdefault(int(piece[nodes[0]]), Loose([], nodes[:0], since))
        one.bodies.append(body)
        one.nodes, one.until = np.append(one.nodes, nodes), min(one.until, since)
    return list(loose.values()), held


def _direction(one: Loose, compiled: Compiled, loads: Sequence[Load]) -> Floats:
    """Return where weight, or else pushes, drive some bodies; 0 where they balance, (3,)."""
    acting, gravity = _acting(one, loads), compiled.plan.gravity
    total = _resultant(one, acting, compiled.network)
    if np.any(gravity):
        # What is pushed up may float.
        return np.zeros(3) if total @ gravity < 0.0 else gravity / norm(gravity)
    size = float(norm(total))
    is_balanced = size <= BALANCED * float(norm(acting).sum())
    return np.zeros(3) if is_balanced else total / size


def _acting(one: Loose, loads: Sequence[Load]) -> Floats:
    """Return the forces of all pushes on some bodies [N], shape (push, 3)."""
    own = [load.factors[np.isin(load.nodes, one.nodes)].sum() for load in loads]
    forces = [load.terms[0].vector * each for load, each in zip(loads, own, strict=True)]
    return np.array(forces, dtype=float).reshape(-1, 3)


def _resultant(one: Loose, acting: Floats, network: Network) -> Floats:
    """Return the sum of some forces without what planes of symmetry bear [N], shape (3,)."""
    total = acting.sum(axis=0)
    for plane in network.mirrored:  # which are parallel or perpendicular
        if np.isin(plane.nodes, one.nodes).any():
            total = total - (total @ plane.normal) * plane.normal
    return total


def _expected(one: Loose, plan: Plan) -> bool:
    """Return whether the scene expects something of the motion of some bodies."""
    measures = {MEASURES[name] for name in _OF_MOTION}
    return any(
        reading.measure in measures and np.isin(subject.nodes, one.nodes).any()
        for expectation in plan.expectations
        if isinstance(expectation.condition, CompiledCondition)
        for reading in expectation.condition.readings.values()
        for subject in reading.subjects
        if subject.nodes is not None
    )


def _is_caught(
    compiled: Compiled,
    one: Loose,
    along: Floats,
    others: Sequence[BodyPart],
    events: Sequence[ScheduledAction],
) -> bool:
    """Return whether something is where bodies go that they can touch.

    They and the others are taken for balls, seen along the way.
    """
    network, law = compiled.network, compiled.scene.environment.contact
    if law is None or compiled.network.contact is None:
        return False
    has_thread = any(body.thread is not None for body in one.bodies)
    for tool in filter(lambda tool: tool.touches, network.tools):
        reach = max(shape.radius for shape in tool.shapes) + _way(events, tool.name)
        is_plane = any(shape.kind == "plane" for shape in tool.shapes)
        if is_plane or _is_ahead(network, one.nodes, numbers_in(tool.nodes), along, reach):
            return True
    for body in others:
        if law.between_bodies or has_thread or body.thread is not None:
            reach = _way(events) + (body.thread.radius if body.thread is not None else 0.0)
            if _is_ahead(network, one.nodes, numbers_in(body.nodes), along, reach):
                return True
    return False


def _way(events: Sequence[ScheduledAction], tool: str = "") -> float:
    """Return how far a script moves a tool at most, or all that it moves [m]."""
    return sum(
        event.action.shift
        for event in events
        if (not tool or driven_by(event.action) == tool) and follows(event.action, Shifting)
    )


def driven_by(action: Action) -> str:
    """Return the name of what an action drives; empty if it drives nothing."""
    change = action.holding() if follows(action, Holding) else None
    return change.mover.name if isinstance(change, Driven) else ""


def _is_ahead(
    network: Network, nodes: Indices, others: Indices, along: Floats, reach: float
) -> bool:
    """Return whether nodes that go along a direction may meet others within a reach [m]."""
    own, theirs = network.position[nodes], network.position[others]
    if (theirs @ along).max() + reach < (own @ along).min():
        return False
    flat, far = (place - np.outer(place @ along, along) for place in (own, theirs))
    centre, other = flat.mean(axis=0), far.mean(axis=0)
    radii = float(norm(flat - centre).max() + norm(far - other).max())
    return bool(norm(other - centre) <= radii + reach)


def _told(one: Loose, compiled: Compiled, loads: Sequence[Load]) -> Iterator[Diagnostic]:
    """Yield the findings about bodies that nothing holds, unless they are held soon enough."""
    plan, network = compiled.plan, compiled.network
    hint = 'hold it, for example with "at 0 s: fix SET", or place something that it can touch'
    if not np.any(plan.gravity):
        if np.isfinite(one.until):
            return
        left = _resultant(one, _acting(one, loads), network)
        total = show(float(norm(left)), FORCE)
        text = f"nothing holds {one.name}: pushes of {total} in all drive it away"
        hint += "; forces that balance need no support"
    elif plan.simulation.is_static:
        text = f"nothing holds {one.name} against gravity, so that it has no equilibrium"
        hint += "; without weight, write gravity = (0, 0, 0) m/s^2"
    else:
        size = float(norm(np.ptp(network.position[one.nodes], axis=0)))
        way = _fall(one, compiled, min(one.until, plan.simulation.duration))
        if np.isfinite(one.until) and way <= FAR * size:
            return
        before = f" before {show(one.until, TIME)}" if np.isfinite(one.until) else ""
        text = f"nothing holds {one.name}{before}: it falls by {show(way, LENGTH)}"
        hint += "; without weight, write gravity = (0, 0, 0) m/s^2"
    yield Diagnostic("W310", text, one.bodies[0].span, hint)


def _fall(one: Loose, compiled: Compiled, time: float) -> float:
    """Return how far bodies fall from rest until a time [s], under ambient damping [m].

    With the damping c and the mass m it is g/k² (kt - 1 + exp(-kt)), k = c/m.
    """
    plan, network = compiled.plan, compiled.network
    own = np.zeros(network.node_count) if network.drag is None else network.drag
    drag = plan.drag * len(one.nodes) + own[one.nodes].sum()
    slowed = time * float(drag / network.mass[one.nodes].sum())
    share = 0.5 if slowed < 1e-4 else (slowed + np.expm1(-slowed)) / slowed**2
    return float(norm(plan.gravity)) * time**2 * float(share)
