"""Events at one time of a run: ruptures, actions and triggers, with their energy."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from tissuec.core.errors import counted
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.core.units import ENERGY, LENGTH, TIME, show, show_in
from tissuec.engine.execution.failure_messages import explain_action, of_body
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run_state import RunState
from tissuec.mechanics import observables
from tissuec.mechanics.rest import is_stable, rests_pressed
from tissuec.mechanics.state import State
from tissuec.model.network import Floats, Indices, Network
from tissuec.model.torn import Peeled, Torn
from tissuec.script.breaking import break_apart
from tissuec.script.measures.snapshot import EnergyBalance, Snapshot
from tissuec.script.plan import Plan
from tissuec.script.verbs import CHANGED, ActionFailed, LoggedEvent, after_cuts
from tissuec.script.verbs.tie import seized, slipped

if TYPE_CHECKING:
    from tissuec.forces.enclosed.kept_volumes import KeptVolumes

#: How springs break by themselves: the array of the limit, and the cause in words.
_BROKEN = {
    "rupture": ("strength", "the tension exceeded the breaking force"),
    "crush": ("crush", "the compression exceeded the crushing force"),
}


class EventHandler:
    """Carries out events on a run state and informs the recorder.

    Args:
        run_state: Changed in place.

    Attributes:
        failure: Why the run cannot continue, as a sentence; empty if it can.
    """

    failure = ""
    _changed = False  # whether actions have changed the state without an entry in the log

    def __init__(self, network: Network, plan: Plan, recorder: Recorder, run_state: RunState):
        self.network, self.plan = network, plan
        self.recorder, self.run_state = recorder, run_state

    def begin(self) -> None:
        """Carry out the events of 0 s; the energy after them is the initial one."""
        self._happen()
        if self.plan.needs_ledger:
            self.run_state.initial = self._energy()

    def handle(self, *, ruptured: Indices | None = None, true: list[int] | None = None) -> bool:
        """Carry out what is due at the present time; return whether anything happened.

        Args:
            ruptured: Springs that break now, shape (n,).
            true: Triggers that are known to be true now, by their places in the plan.
        """
        before, self._changed = len(self.run_state.logged_events), False
        if self.plan.needs_ledger and self._may_happen(ruptured):
            energy = self._energy()
            self._happen(ruptured, true)
            # What events put in or take out.
            self.run_state.switched += self._energy() - energy
        else:
            self._happen(ruptured, true)
        has_torn = ruptured is not None and len(ruptured) > 0
        return self._changed or has_torn or len(self.run_state.logged_events) > before

    def _may_happen(self, ruptured: Indices | None) -> bool:
        """Return whether the present time may be that of an event; ``ruptured`` as above."""
        state, queue = self.run_state.state, self.run_state.queue
        return bool(
            (ruptured is not None and len(ruptured))
            or queue.next <= state.time + queue.near
            or self.run_state.waiting
            or state.knots
            or state.motions
        )

    def _happen(self, ruptured: Indices | None = None, true: list[int] | None = None) -> None:
        """Carry out what is due; arguments as of ``handle``."""
        if ruptured is not None and len(ruptured):
            self._rupture(ruptured)
        for name in self.run_state.state.seize():
            self._log(seized(name, self.run_state.state.knots[name]))
        self._carry_out()
        fired = true or self.true_triggers(self.snapshot())
        while fired:
            self._fire(fired)
            self._carry_out()
            fired = self.true_triggers(self.snapshot())

    def enter(self) -> None:
        """Pass the present state to the recorder."""
        run_state = self.run_state
        ledger = EnergyBalance(run_state.initial, switched=run_state.switched)
        self.recorder.enter(run_state.state, run_state.ruptured, ledger)

    def leave(self, work: float, dissipated: float) -> None:
        """Let the recorder evaluate expectations that end now, before any event.

        Args:
            work, dissipated: Of the energy ledger until now [J].
        """
        self.recorder.leave(self.with_ledger(self.snapshot(), work, dissipated))

    def end(self, work: float, dissipated: float) -> None:
        """Let the recorder evaluate what would last longer; arguments as of `leave`."""
        self.recorder.end(self.with_ledger(self.snapshot(), work, dissipated))

    def record_jumps(self, work: float, dissipated: float) -> None:
        """Pass changes by events to the recorder, just after them; arguments as of `leave`."""
        self.recorder.record_jumps(self.with_ledger(self.snapshot(), work, dissipated))

    def with_ledger(self, snapshot: Snapshot, work: float, dissipated: float) -> Snapshot:
        """Return a snapshot before the next event, with a ledger if one is kept.

        Args:
            snapshot: Of the run, at one time.
            work, dissipated: Of the energy ledger until then [J].
        """
        run_state = self.run_state
        if not self.plan.needs_ledger:
            return snapshot
        ledger = EnergyBalance(run_state.initial, work, dissipated, run_state.switched)
        return snapshot.with_ledger(ledger)

    def look_at_rest(self) -> None:
        """Note it if the net rests at an unstable equilibrium, before anything happens."""
        found = unstable_rest(self.run_state, self.plan.simulation.span)
        if found is not None:
            self._log(found)

    def look_for_doubts(self, *, always: bool = False) -> None:
        """Look for what makes numbers doubtful, and enter what is new into the event log.

        Args:
            always: Whether to look even if that was done a moment ago.
        """
        state, doubts = self.run_state.state, self.recorder.memory.doubts
        self.recorder.look(state, state.time, state.position, always=always)
        self.recorder.follow(state.time, state.position, state, always=always)
        for doubt, span in doubts.fresh:
            self._log(LoggedEvent("note", (), doubt.what, span), doubt.time)
        doubts.fresh.clear()

    def snapshot(self) -> Snapshot:
        """Return the present snapshot, without a ledger."""
        return replace(Snapshot.of(self.run_state.state), ruptured=self.run_state.ruptured)

    def snapshot_at(self, time: Floats | float, position: Floats, velocity: Floats) -> Snapshot:
        """Return a snapshot before the next event, or a batch of snapshots.

        Args:
            time: Time [s], shape (…).
            position: Of all nodes [m], shape (…, node, 3).
            velocity: Of all nodes [m/s], shape (…, node, 3).
        """
        return replace(self.snapshot(), time=time, position=position, velocity=velocity)

    def true_triggers(self, snapshot: Snapshot) -> list[int]:
        """Return the waiting triggers whose conditions hold, in written order."""
        triggers = self.plan.triggers
        return [
            number for number in self.run_state.waiting if triggers[number].condition(snapshot)
        ]

    def may_be_true(self, snapshots: Snapshot) -> bool:
        """Return whether the condition of a waiting trigger holds in a batch of snapshots."""
        conditions = (self.plan.triggers[number].condition for number in self.run_state.waiting)
        return any(condition.holds(snapshots).any() for condition in conditions)

    def _carry_out(self) -> None:
        state, queue = self.run_state.state, self.run_state.queue
        log = self.run_state.logged_events
        try:
            for action in queue.due(state.time):
                for logged_event in after_cuts(action, state).apply(state, queue):
                    if logged_event.kind == CHANGED:
                        self._changed = True
                    else:
                        self._log(logged_event)
        except ActionFailed as failure:
            self.failure = explain_action(
                failure, state, torn_by(failure.springs, state.time, log)
            )
        state.place_held()
        for enclosure, cells in state.let_leak():
            cause = leaking(enclosure, cells, state, log)
            self._log(LoggedEvent("leak", (), cause, enclosure.span))

    def _rupture(self, springs: Indices) -> None:
        state = self.run_state.state
        for name in state.give_way(springs):
            knot = state.knots[name]
            springs = springs[springs != knot.hold]
            self._log(slipped(name, knot))
        motion = state.position, state.velocity
        is_element = springs >= self.network.line_count
        broken, springs, elements = springs, springs[~is_element], springs[is_element]
        is_pressed = observables.tension(state, *motion, springs) < 0.0
        try:
            parted, edges, torn, peeled = break_apart(state, broken)
        except ActionFailed as failure:
            self.failure = explain_action(failure, state, "")
            return
        self.run_state.ruptured[parted] = self.run_state.ruptured[edges] = True
        elements = elements[np.isin(elements, parted)]  # without glued sections
        for each in torn.values():
            elements = np.setdiff1d(elements, each.every_element)
        self._log_broken("rupture", springs[~is_pressed])
        self._log_broken("crush", springs[is_pressed])
        for event in broken_elements(self.network, motion[0], elements, edges):
            self._log(event)
        for each in torn.values():
            for event in _torn_faces(self.network, motion[0], each):
                self._log(event)
        for one in peeled:
            self._log(_opened(self.network, one))

    def _log_broken(self, kind: str, springs: Indices) -> None:
        """Enter springs that broke, by the places that their limits come from."""
        array, cause = _BROKEN[kind]
        origins = self.network.provenance.get(array)
        by_origin: dict[Any, list[int]] = {}
        for spring in springs.tolist():
            span = self.plan.simulation.span if origins is None else origins[spring].span
            by_origin.setdefault(span, []).append(spring)
        for span, found in by_origin.items():
            self._log(LoggedEvent(kind, tuple(found), cause, span))

    def _fire(self, triggers: list[int]) -> None:
        for number in triggers:
            trigger = self.plan.triggers[number]
            self.run_state.waiting.remove(number)
            cause = " ".join(trigger.span.text.split())
            self._log(LoggedEvent("trigger", (), cause, trigger.span))
            self.run_state.queue.follow(trigger.events, self.run_state.state.time)

    def _log(self, logged_event: LoggedEvent, time: float | None = None) -> None:
        time = self.run_state.state.time if time is None else time
        self.run_state.logged_events.append((time, logged_event))
        self.recorder.happened(time, logged_event)

    def _energy(self) -> float:
        state = self.run_state.state
        energies = observables.energies(state, state.time, state.position, state.velocity)
        return float(energies.total)


MOST_LOOKS = 8  # in a run: each may factorise a matrix


def unstable_rest(run_state: RunState, span: Span) -> LoggedEvent | None:
    """Return a note for the event log if the net rests at an unstable equilibrium now.

    After the first such note, or ``MOST_LOOKS`` looks, nothing is looked for.

    Args:
        span: Of the note.
    """
    if run_state.looks >= MOST_LOOKS or not rests_pressed(run_state.state):
        return None
    run_state.looks += 1
    if is_stable(run_state.state):
        return None
    from tissuec.mechanics import stability  # SciPy: only where it is needed

    node = stability.unstable_node(run_state.state)
    if node is None:
        return None
    run_state.looks = MOST_LOOKS
    network = run_state.state.network
    where = f"node {network.node_ids[node]}{of_body(network, node)}"
    text = (
        "the net is at rest in an unstable equilibrium: any disturbance makes it buckle, "
        f"mainly at {where}; `settle` finds the buckled shape"
    )
    return LoggedEvent("note", (), text, span)


#: By limit: what of an element exceeds it, and what it is called.
_EXCEEDED = {
    "strain": ("strain", "breaking strain"),
    "stress": ("stress", "strength"),
    "toughness": ("energy", "toughness"),
}


def broken_elements(
    network: Network, position: Floats, elements: Indices, edges: Indices
) -> Iterator[LoggedEvent]:
    """Yield an event for all that broke by one entry of a scene.

    Args:
        position: Of all nodes [m], shape (node, 3).
        elements: Those that break now, as entities, shape (n,).
        edges: Springs that are lost with them, shape (m,); they are entered with the first.
    """
    if not len(elements):
        return
    known = network.provenance["breaking"]
    part = known.index[elements - network.line_count]
    for index in np.unique(part).tolist():
        of_part = elements[part == index]
        limit = np.array([_exceeded(network, position, one) for one in of_part.tolist()])
        for name in dict.fromkeys(limit.tolist()):
            own = of_part[limit == name]
            springs = (*own.tolist(), *edges.tolist())
            # The first origin of a part is that of its strain, if it has two.
            place = int(index) + int(str(name) == "stress")
            span = known.origins[place].span
            yield LoggedEvent("rupture", springs, _cause(network, own, name), span)
            edges = edges[:0]


def _torn_faces(network: Network, position: Floats, torn: Torn) -> Iterator[LoggedEvent]:
    """Yield one event for all elements of a body whose faces have opened, and for interfaces.

    Without faces of tears, the events are those of ``broken_elements``.

    Args:
        position: Of all nodes [m], shape (node, 3).
        torn: What tore in it.
    """
    for one in torn.peeled:
        yield _opened(network, one)
    if not torn.area:
        yield from broken_elements(network, position, torn.elements, torn.edges)
        return
    first = int(torn.elements[0])
    known = network.provenance["breaking"]
    origin = known.origins[int(known.index[first - network.line_count])]
    count = len(torn.elements)
    what = _place_of_element(network, first) if count == 1 else counted(count, "element")
    of = "" if count == 1 else f", first {_place_of_element(network, first)}"
    text = f"the faces in {what} have opened ({_taken(torn)}){of}"
    springs = (*torn.elements.tolist(), *torn.edges.tolist())
    yield LoggedEvent("rupture", springs, text, origin.span)


def _opened(network: Network, one: Peeled) -> LoggedEvent:
    """Return the event of an interface or of glue that has opened."""
    at = "at" if len(one.elements) == 1 else "first at"
    text = f"{one.name} has opened ({_taken(one)}), {at} "
    text += _place_of_element(network, int(one.elements[0]))
    return LoggedEvent("rupture", tuple(one.elements.tolist()), text, one.span)


def _taken(faces: Torn | Peeled) -> str:
    """Return the area as drawn and the energy of faces that are free now."""
    return f"{show_in(faces.area, 'mm^2')}, {show(faces.energy, ENERGY)}"


def _exceeded(network: Network, position: Floats, element: int) -> str:
    """Return which limit an element exceeded: the one that it exceeds the most."""
    field, item = _element(network, element)
    limits = [name for name in _EXCEEDED if np.isfinite(getattr(field.limits, name)[item])]
    if len(limits) < 2:
        return limits[0]
    breakable = field.breakable
    alone = breakable.some(np.flatnonzero(breakable.entities == element))

    def load(name: str) -> float:
        without = {one: np.array([np.inf]) for one in limits if one != name}
        limited = replace(alone.limits, **without)
        return float(replace(alone, limits=limited).loads(position)[0])

    return max(limits, key=load)


def _element(network: Network, element: int) -> tuple[Any, int]:
    """Return the field of an element, and its number there."""
    body = network.owner(element).name
    field = next(one for one in network.elements_of(body) if element in one.walls)
    return field, int(np.flatnonzero(field.walls == element)[0])


def _cause(network: Network, elements: Indices, limit: str) -> str:
    """Return why elements of one body broke, with the number and place of the first."""
    what, of = _EXCEEDED[limit]
    place = _place_of_element(network, int(elements[0]))
    if len(elements) == 1:
        return f"the {what} of {place} exceeded the {of}"
    return f"the {what} of {counted(len(elements), 'element')} exceeded the {of}, first {place}"


def _place_of_element(network: Network, element: int) -> str:
    """Return the number of an element, and where it is as drawn."""
    body, (field, item) = network.owner(element).name, _element(network, element)
    corners = network.position[field.nodes[item]]
    centre = ", ".join(show(float(x), LENGTH) for x in corners.mean(axis=0))
    return f"element {network.number_of(element)} of {body} around ({centre})"


Log = Sequence[tuple[float, LoggedEvent]]

#: Kinds of events that take springs away, and how they do before and after the time.
_TEARING = {
    "cut": ("torn", " by:"),
    "rupture": ("ruptured", ", as"),
    "crush": ("crushed", ", as"),
}


def leaking(enclosure: "KeptVolumes", cells: int, state: State, log: Log) -> str:
    """Describe the leak of an enclosure, with the event that tore it.

    Args:
        enclosure: As it was before.
        cells: Number of torn cells.
        state: The present state.
        log: What has happened until now, with times [s].
    """
    torn = torn_by(enclosure.lost_walls(state.alive), state.time, log)
    if enclosure.block.kind == "fluid":
        if enclosure.item_count == 1:
            return f"the cavity of {enclosure.name} leaks and no longer holds pressure{torn}"
        which = "1 cavity" if cells == 1 else f"{cells} cavities"
        return f"{which} of {enclosure.name} {'leaks' if cells == 1 else 'leak'}{torn}"
    if enclosure.item_count == 1:
        return f"the surface of {enclosure.name} is torn and no longer holds pressure{torn}"
    verb, holds = ("is", "holds") if cells == 1 else ("are", "hold")
    which = counted(cells, "cell")
    return f"{which} of {enclosure.name} {verb} torn and no longer {holds} pressure{torn}"


def torn_by(springs: Indices, time: float, log: Log) -> str:
    """Name the last event that removed any of the springs: "; torn by: cut … (scene.tis:7)".

    It includes the time of the event unless that is the present one. It is empty if no event
    in the log removed one of them.

    Args:
        springs: Indices, shape (n,).
        time: The present time [s].
        log: What has happened until now, with times [s].
    """
    for when, event in reversed(log):
        if event.kind in _TEARING and np.isin(springs, list(event.springs)).any():
            at = "" if when == time else f" at {show(when, TIME, digits=6)}"
            verb, joint = _TEARING[event.kind]
            return f"; {verb}{at}{joint} {event.cause} ({event.span.place})"
    return ""
