"""Going through a script once, to find the course of a run that is then kept.

What breaks and which conditions become true, and when, is told by the engine; everything else
follows from the script and the motion between its events.
"""

from collections.abc import Iterator, Sequence
from math import inf

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from tissuec.engine.execution.event_queue import Timetable
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run import run
from tissuec.engine.execution.sampling import SAME
from tissuec.learn.derivatives.event_schedule import Change, Course, Leg, leg_of
from tissuec.learn.derivatives.motion import Diverged, Motion
from tissuec.learn.derivatives.stepping import Stepping
from tissuec.learn.parameters.numbers import Order
from tissuec.mechanics.situation import Situation
from tissuec.model.network import Floats, Indices, Network
from tissuec.script.plan import RELAXATION, Event, Plan
from tissuec.script.verbs import Action
from tissuec.script.verbs.change import ChangeMotion, ChangeParameter

_NONE: Floats = np.zeros(0)


class Breaks(Struct, frozen=True, eq=False):
    """Springs that break at a time [s]."""

    time: float
    springs: Indices


class Freezer:
    """Makes courses of a plan.

    Args:
        stepping, step: By which the motion between events is found.
    """

    def __init__(self, plan: Plan, stepping: Stepping, order: Order, step: float):
        self.plan, self.stepping, self.order, self.step = plan, stepping, order, step

    def course(self, network: Network, vector: Floats, stop: float) -> Course:
        """Return the course up to a time [s].

        Args:
            vector: The numbers of the net.
        """
        plan = self.plan
        present = self.order.network(vector, network)
        situation = plan.start(present)
        agenda = Timetable.of(plan)
        breaks = self._happenings(present, agenda)
        changes: dict[str, Change] = {}
        legs: list[Leg] = []
        while situation.time < stop * (1.0 - SAME):
            before, thrown = situation.velocity.copy(), np.zeros(len(situation.velocity), bool)
            while breaks and breaks[0].time <= situation.time + agenda.near:
                situation.alive = situation.alive.copy()
                situation.alive[breaks.pop(0).springs] = False
            for action in agenda.due(situation.time):
                note(action, changes, situation)
                if isinstance(action, ChangeMotion):
                    thrown[action.group.indices] = True
                action.apply(situation, agenda)
            situation.place_held()
            until = min(agenda.next, breaks[0].time if breaks else inf, stop)
            set_anew = (situation.velocity != before).any(axis=1) | thrown
            legs.append(leg_of(situation, until, changes, set_anew))
            if until < stop:  # nobody asks for the state at the end
                self._go(legs[-1], situation, vector)
            situation.time = until
        return Course(tuple(legs))

    def _go(self, leg: Leg, situation: Situation, vector: Floats) -> None:
        """Step a situation to the end of a leg."""
        start = vector.copy()
        for name in ("position", "velocity"):
            self.order.array(start, name)[:] = getattr(situation, name).ravel()
        motion = Motion(
            Course((leg,)), self.stepping, self.order, self.step, np.array([leg.stop])
        )
        end = motion.forward(start)
        situation.position[:] = end.x[0].reshape(-1, 3)
        situation.velocity[:] = end.v[0].reshape(-1, 3)

    def _happenings(self, network: Network, agenda: Timetable) -> list[Breaks]:
        """Enter what is behind conditions; return what breaks, in the order of time."""
        plan = self.plan
        if not (plan.triggers or plan.breakable):
            return []
        breaks: list[Breaks] = []
        for event in _told(network, plan):
            if isinstance(event, Breaks):
                breaks.append(event)
            else:
                agenda.script([event], 0.0)
        return breaks


def _told(network: Network, plan: Plan) -> Iterator[Breaks | Event]:
    """Yield what breaks, and the events behind conditions, as the engine finds them."""
    silent = replace(plan, expectations=(), needs_ledger=False)
    outcome = run(network, silent, Recorder(network, silent, _Nowhere()))
    if outcome.kind != "done":
        raise Diverged(outcome.situation.time)
    waiting = list(plan.triggers)
    for time, happening in outcome.happenings:
        if happening.kind in ("rupture", "crush"):
            yield Breaks(time, np.asarray(happening.springs, dtype=np.int64))
        elif happening.kind == "trigger":
            fired = next(t for t in waiting if t.span == happening.span)
            waiting.remove(fired)
            yield from (replace(event, time=time + event.time) for event in fired.events)


class _Nowhere(MemoryRecording):
    """Takes what a run writes, and forgets all rows."""

    def _add(self, table: str, *columns: np.ndarray) -> None:
        """Keep nothing."""


def note(action: Action, changes: dict[str, Change], situation: Situation) -> None:
    """Enter what an action makes of an array."""
    if not isinstance(action, ChangeParameter):
        return
    size = len(getattr(situation, action.array))
    old = changes.get(action.array, Change(np.ones(size), np.zeros(size)))
    factor, more = old.factor.copy(), old.more.copy()
    chosen = action.group.indices
    factor[chosen] *= action.number if action.is_factor else 0.0
    more[chosen] = more[chosen] * action.number if action.is_factor else action.number
    if action.array in ("mass", "stiffness", "damping", "rest"):
        changes[action.array] = Change(factor, more)


def refusal(plan: Plan, network: Network, *, at_rest: bool = False) -> str:
    """Return why the motion, or the net at rest, has no exact derivatives; empty if it has."""
    actions = [event.action for event in _every(plan)]
    if at_rest and plan.triggers:
        return "the script waits for a condition"
    for kind, reason in _UNKNOWN.items():
        if at_rest and kind == "settle":
            continue
        if any(type(action).__module__ == f"tissuec.script.verbs.{kind}" for action in actions):
            return reason
    if plan.contact is not None:
        return "contact is not smooth"
    if plan.forces:
        return f"{plan.forces[0].name} acts"
    if network.drag is not None:
        return "ambient damping goes by mass or surface"
    if network.hinges is not None:
        return "walls resist bending"
    if network.inelastic is not None:
        return "springs relax or yield"
    if plan.simulation.integrator == RELAXATION:
        return "the net is in equilibrium all the time"
    if any(isinstance(action, ChangeMotion) and action.is_spin for action in actions):
        return "a spin is set during the script"
    return ""


def _every(plan: Plan) -> Sequence[Event]:
    return [*plan.events, *(event for t in plan.triggers for event in t.events)]


#: Verbs whose effect is not derived, and why, by their modules.
_UNKNOWN = {
    "preserve": "a volume is preserved",
    "irrigate": "a jet acts",
    "tie": "knots can slip",
    "tighten": "a thread is tightened",
    "settle": "the net settles during the script",
    "turn": "nodes are turned",
}
