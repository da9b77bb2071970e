"""Records the events of a script once, as the schedule of all following runs.

The engine reports what breaks, which conditions become true, and when; everything else
follows from the script and the motion between its events.
"""

from collections.abc import Iterator
from math import inf

import numpy as np
from msgspec import Struct

from tissuec.core.structs import replace
from tissuec.engine.execution.event_queue import SAME, ActionQueue
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run import run
from tissuec.learn.derivatives.event_schedule import (
    AFTER,
    ArrayChange,
    EventSchedule,
    Leg,
    leg_of,
)
from tissuec.learn.derivatives.motion import Diverged, Motion
from tissuec.learn.derivatives.stepping import Stepping
from tissuec.learn.parameters.numbers import NumberOrder
from tissuec.mechanics.state import State
from tissuec.model.network import Floats, Indices, Network
from tissuec.script.plan import Plan, ScheduledAction
from tissuec.script.verbs import Action
from tissuec.script.verbs.change import ChangeMotion, ChangeParameter


class RupturesAt(Struct, frozen=True, eq=False):
    """Springs that break at a time [s]."""

    time: float
    springs: Indices


class EventRecorder:
    """Makes schedules of a plan.

    Args:
        stepping, step: By which the motion between events is found.
    """

    def __init__(self, plan: Plan, stepping: Stepping, order: NumberOrder, step: float):
        self.plan, self.stepping, self.order, self.step = plan, stepping, order, step

    def schedule(self, network: Network, vector: Floats, stop: float) -> EventSchedule:
        """Return the schedule up to a time.

        Args:
            vector: Its numbers in SI units, shape (number,).
            stop: The time [s].
        """
        plan = self.plan
        present = self.order.network(vector, network)
        state = plan.start(present)
        queue = ActionQueue.of(plan)
        breaks = self._logged_events(present, queue)
        changes: dict[str, ArrayChange] = {}
        legs: list[Leg] = []
        while state.time < stop * (1.0 - SAME):
            before, thrown = state.velocity.copy(), np.zeros(len(state.velocity), bool)
            while breaks and breaks[0].time <= state.time + queue.near:
                state.alive = state.alive.copy()
                state.alive[breaks.pop(0).springs] = False
            for action in queue.due(state.time):
                note(action, changes, state)
                if isinstance(action, ChangeMotion):
                    thrown[action.group.indices] = True
                action.apply(state, queue)
            state.let_leak()
            state.place_held()
            if abs(queue.next - stop) <= SAME * stop:
                # What is measured at the time of an event shows what is after it.
                stop *= 1.0 + AFTER
            until = min(queue.next, breaks[0].time if breaks else inf, stop)
            until = _before_knots(state, until)
            set_anew = (state.velocity != before).any(axis=1) | thrown
            legs.append(leg_of(state, until, changes, self.order, set_anew))
            if until < stop:  # nothing needs the state at the end
                self._go(legs[-1], state, vector)
            state.time = until
        return EventSchedule(tuple(legs))

    def _go(self, leg: Leg, state: State, vector: Floats) -> None:
        """Step a state to the end of a leg."""
        start = vector.copy()
        nodes = state.network.node_count
        self.order.array(start, "position")[: 3 * nodes] = state.position.ravel()
        self.order.array(start, "velocity")[:] = state.velocity.ravel()
        motion = Motion(
            EventSchedule((leg,)), self.stepping, self.order, self.step, np.array([leg.stop])
        )
        end = motion.forward(start)
        state.position[:] = end.x[0].reshape(-1, 3)[:nodes]
        state.velocity[:] = end.v[0].reshape(-1, 3)

    def _logged_events(self, network: Network, queue: ActionQueue) -> list[RupturesAt]:
        """Enter what is after conditions; return what breaks, in the order of time."""
        plan = self.plan
        if not (plan.triggers or plan.breakable):
            return []
        breaks: list[RupturesAt] = []
        for event in _told(network, plan):
            if isinstance(event, RupturesAt):
                breaks.append(event)
            else:
                queue.follow([event], 0.0)
        return breaks


def _told(network: Network, plan: Plan) -> Iterator[RupturesAt | ScheduledAction]:
    """Yield ruptures, and the events of conditions, as the engine finds them."""
    silent = replace(plan, expectations=(), needs_ledger=False)
    outcome = run(network, silent, Recorder(network, silent, _Nowhere()))
    if outcome.kind != "done":
        raise Diverged(outcome.state.time)
    waiting = list(plan.triggers)
    for time, logged_event in outcome.logged_events:
        if logged_event.kind in ("rupture", "crush"):
            yield RupturesAt(time, np.asarray(logged_event.springs, dtype=np.int64))
        elif logged_event.kind == "trigger":
            fired = next(t for t in waiting if t.span == logged_event.span)
            waiting.remove(fired)
            yield from (replace(event, time=time + event.time) for event in fired.events)


class _Nowhere(MemoryRecording):
    """Takes what a run writes, and forgets all rows."""

    def _add(self, table: str, *columns: np.ndarray) -> None:
        """Keep nothing."""


def note(action: Action, changes: dict[str, ArrayChange], state: State) -> None:
    """Store the effect of an action on an array.

    Args:
        changes: What the script changed so far, by name; changed in place.
        state: The present state.
    """
    if not isinstance(action, ChangeParameter):
        return
    network = state.network
    is_mass = action.array == "mass"
    size = network.row_count if is_mass else len(network.array(action.array))
    old = changes.get(action.array, ArrayChange(np.ones(size), np.zeros(size)))
    factor, more = old.factor.copy(), old.more.copy()
    chosen = action.chosen(state.network)
    factor[chosen] *= action.number if action.is_factor else 0.0
    more[chosen] = more[chosen] * action.number if action.is_factor else action.number
    if action.array in ("mass", "stiffness", "damping", "rest"):
        changes[action.array] = ArrayChange(factor, more)


def _before_knots(state: State, until: float) -> float:
    """Return a time [s], or that of an earlier knot of what fields follow."""
    profiles = (profile for field in state.fields for _, profile in field.changes)
    knots = (knot for profile in profiles for knot in profile.knots.tolist())
    return min([until, *(knot for knot in knots if state.time < knot)])
