"""Events at one time of a run: ruptures, actions and triggers, with their energy."""

from typing import Any

from msgspec.structs import replace

from tissuec.core.source import Span
from tissuec.engine.execution.damage_messages import broken_elements, leaking, torn_by
from tissuec.engine.execution.failure_messages import explain_action, of_body
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run_state import RunState
from tissuec.mechanics import observables
from tissuec.mechanics.rest import is_stable, rests_pressed
from tissuec.model.network import Floats, Indices, Network
from tissuec.script.measures.snapshot import EnergyBalance, Snapshot
from tissuec.script.plan import Plan
from tissuec.script.verbs import ActionFailed, LoggedEvent
from tissuec.script.verbs.tie import seized, slipped

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
        before = len(self.run_state.logged_events)
        if self.plan.needs_ledger and self._may_happen(ruptured):
            energy = self._energy()
            self._happen(ruptured, true)
            # What events put in or take out.
            self.run_state.switched += self._energy() - energy
        else:
            self._happen(ruptured, true)
        return len(self.run_state.logged_events) > before

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
                for logged_event in action.apply(state, queue):
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
        is_pressed = observables.tension(state, *motion, springs) < 0.0
        edges = state.break_springs(springs)
        self.run_state.ruptured[springs] = self.run_state.ruptured[edges] = True
        is_mark = springs >= self.network.first_mark
        self._log_broken("rupture", springs[~is_pressed & ~is_mark])
        self._log_broken("crush", springs[is_pressed])
        for event in broken_elements(self.network, motion[0], springs[is_mark], edges):
            self._log(event)

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
