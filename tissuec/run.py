"""The run: from event to event, until the end, a failure or an interruption.

At one time things happen in this order: expectations whose interval ends are judged, then come
ends of motions and whatever else earlier actions have entered, then the events of the script as
they are written, then the triggers that have become true; samples at that time see it all.
"""

import time as clock
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from tissuec import mechanics
from tissuec.agenda import Timetable
from tissuec.checkpoint import read_state, write_state
from tissuec.failing import explain
from tissuec.interrupting import Interrupt, asked_to_stop
from tissuec.measures.moment import Ledger, Moment
from tissuec.network import Floats, Indices, Network
from tissuec.plan import Plan
from tissuec.recording import Failure, Memory, Recorder
from tissuec.sampling import SAME
from tissuec.situation import Situation
from tissuec.verbs import Happening

if TYPE_CHECKING:
    from tissuec.engine import Engine, Interruption, Statistics

CHECKPOINT_EVERY = 5.0
"""Least wall time between checkpoints [s]."""

Kind = Literal["done", "diverged", "stuck", "interrupted"]
Progress = Callable[[float], None]


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """How a run ended.

    Attributes:
        message: A sentence; of a failure it names spring, nodes, time and line of the scene.
        wall_time: Of this call [s].
        statistics: What the engine did.
        failures: Expectations that did not hold, in the order of the scene.
        happenings: The event log, each with its time [s].
        situation: The state at the end.
    """

    kind: Kind
    message: str
    wall_time: float
    statistics: "Statistics"
    failures: tuple[Failure, ...]
    happenings: tuple[tuple[float, Happening], ...]
    situation: Situation


def run(
    network: Network,
    plan: Plan,
    recorder: Recorder,
    *,
    progress: Progress | None = None,
    interrupt: Interrupt | None = None,
    resume: Mapping[str, Any] | None = None,
) -> Outcome:
    """Carry out a plan.

    Args:
        recorder: A new one, of the same network and plan.
        progress: Told the simulated time [s] now and then.
        interrupt: Asked now and then; True ends the run at once, with a checkpoint. Ctrl-C
            does the same.
        resume: The checkpoint of an earlier run of the same plan, which goes on from there as
            if it had never stopped.
    """
    with asked_to_stop(interrupt) as stop:
        course = _Run(network, plan, recorder, progress or (lambda time: None), stop)
        if resume is None:
            course.begin()
        else:
            course.go_on(resume)
        return course.finish()


@dataclass(slots=True, eq=False)
class Standing:
    """All that a run must know to go on, beside network and plan.

    Attributes:
        waiting: Triggers that have not fired, by their places in the plan.
        ruptured: Which springs broke by themselves, shape (spring,).
        initial, switched: Of the energy ledger [J].
        engine: What the engine keeps.
    """

    situation: Situation
    agenda: Timetable
    waiting: list[int]
    ruptured: Any
    initial: float
    switched: float
    happenings: list[tuple[float, Happening]]
    memory: Memory
    engine: dict[str, Any]


class _Run:
    """One run under way."""

    def __init__(
        self,
        network: Network,
        plan: Plan,
        recorder: Recorder,
        progress: Progress,
        stop: Interrupt,
    ):
        from tissuec.engine import Engine, Method  # loads compilers, which not all that imports this needs

        self.network, self.plan, self.recorder = network, plan, recorder
        self.progress, self.stop = progress, stop
        self.started = self.kept = clock.monotonic()
        simulation = plan.simulation
        self.duration = simulation.duration
        method = Method(
            simulation.integrator,
            simulation.tolerance,
            simulation.step,
            simulation.duration,
            ledger=plan.needs_ledger,
            watch_strength=plan.breakable,
        )
        self.engine: Engine = Engine(network, method, recorder.times, recorder.record)
        self.became_true: list[int] = []

    # --- beginning -----------------------------------------------------------------------------

    def begin(self) -> None:
        """Start at 0 s with the events of that time."""
        situation = Situation.start(self.network, gravity=self.plan.gravity, drag=self.plan.drag)
        agenda = Timetable(SAME * self.duration, written=[e.time for e in self.plan.events])
        agenda.script(self.plan.events, 0.0)
        springs, triggers = self.network.spring_count, len(self.plan.triggers)
        self.standing = Standing(
            situation,
            agenda,
            list(range(triggers)),
            np.zeros(springs, dtype=bool),
            0.0,
            0.0,
            [],
            self.recorder.memory,
            {},
        )
        self._happen()
        if self.plan.needs_ledger:
            self.standing.initial, self.standing.switched = self._energy(), 0.0
        self._take_up()

    def go_on(self, state: Mapping[str, Any]) -> None:
        """Start from a checkpoint."""
        self.standing = read_state(state, self._known())
        self.recorder.memory = self.standing.memory
        self.engine.restart(self.standing.situation)
        self.engine.restore(self.standing.engine)
        self._enter()

    # --- the loop ------------------------------------------------------------------------------

    def finish(self) -> Outcome:
        """Step to the end."""
        standing = self.standing
        while True:
            until = min(standing.agenda.next, self.duration)
            watch = self._watch if standing.waiting else None
            reason = self.engine.advance(standing.situation, until, watch, self._pause)
            self.progress(standing.situation.time)
            if reason.kind in ("diverged", "stuck"):
                message = explain(reason, standing.situation)
                return self._outcome("diverged" if reason.kind == "diverged" else "stuck", message)
            if reason.kind == "paused":
                self._checkpoint()
                if self.stop():
                    return self._outcome("interrupted", self._interrupted())
                continue
            self.recorder.leave(self._moment())
            if self._happen(reason.springs):
                self._take_up()
            if standing.situation.time >= self.duration:
                self.engine.finish(standing.situation)
                return self._outcome("done", f"done: {self.duration:g} s were simulated")

    def _pause(self, time: float) -> bool:
        self.progress(time)
        return self.stop() or clock.monotonic() - self.kept >= CHECKPOINT_EVERY

    def _watch(self, time: float, position: Floats, velocity: Floats) -> bool:
        self.became_true = self._true_triggers(self._moment(time, position, velocity))
        return bool(self.became_true)

    # --- events --------------------------------------------------------------------------------

    def _happen(self, ruptured: Indices | None = None) -> bool:
        """Carry out what is due at the present time; return whether anything happened."""
        standing = self.standing
        before = len(standing.happenings)
        with self._booked():
            if ruptured is not None and len(ruptured):
                self._rupture(ruptured)
            self._carry_out()
            while fired := self.became_true or self._true_triggers(self._moment()):
                self.became_true = []
                self._fire(fired)
                self._carry_out()
        return len(standing.happenings) > before

    def _carry_out(self) -> None:
        situation = self.standing.situation
        for action in self.standing.agenda.due(situation.time):
            for happening in action.apply(situation, self.standing.agenda):
                self._log(happening)
        situation.place_held()

    def _rupture(self, springs: Indices) -> None:
        standing = self.standing
        standing.situation.alive = standing.situation.alive.copy()
        standing.situation.alive[springs] = False
        standing.ruptured[springs] = True
        origins = self.network.provenance.get("strength")
        groups: dict[Any, list[int]] = {}
        for spring in springs.tolist():
            origin = origins[spring].span if origins else self.plan.simulation.span
            groups.setdefault(origin, []).append(spring)
        for span, found in groups.items():
            self._log(Happening("rupture", tuple(found), "the tension exceeded the fraction force", span))

    def _fire(self, triggers: list[int]) -> None:
        time = self.standing.situation.time
        for number in triggers:
            trigger = self.plan.triggers[number]
            self.standing.waiting.remove(number)
            cause = " ".join(trigger.span.text.split())
            self._log(Happening("trigger", (), cause, trigger.span))
            self.standing.agenda.script(trigger.events, time)

    def _true_triggers(self, moment: Moment) -> list[int]:
        return [n for n in self.standing.waiting if self.plan.triggers[n].condition(moment)]

    def _log(self, happening: Happening) -> None:
        time = self.standing.situation.time
        self.standing.happenings.append((time, happening))
        self.recorder.happened(time, happening)

    # --- bookkeeping ---------------------------------------------------------------------------

    @contextmanager
    def _booked(self) -> Iterator[None]:
        """Enter the energy that events put in or take out into the ledger."""
        if not self.plan.needs_ledger:
            yield
            return
        before = self._energy()
        yield
        self.standing.switched += self._energy() - before

    def _energy(self) -> float:
        situation = self.standing.situation
        energies = mechanics.energies(situation, situation.position, situation.velocity)
        return float(energies.total)

    def _ledger(self) -> Ledger | None:
        if not self.plan.needs_ledger:
            return None
        standing = self.standing
        sums = self.engine.work, self.engine.dissipated
        return Ledger(standing.initial, *sums, standing.switched, self.recorder.memory.scale)

    def _moment(
        self, time: float | None = None, position: Floats | None = None, velocity: Floats | None = None
    ) -> Moment:
        """Return the present moment, or one on the way that the engine shows."""
        standing = self.standing
        moment = replace(Moment.of(standing.situation), ruptured=standing.ruptured, ledger=self._ledger())
        if time is None or position is None or velocity is None:
            return moment
        return replace(moment, time=time, position=position, velocity=velocity)

    def _take_up(self) -> None:
        self.engine.restart(self.standing.situation)
        self._enter()

    def _enter(self) -> None:
        standing = self.standing
        ledger = Ledger(standing.initial, switched=standing.switched)
        self.recorder.enter(standing.situation, standing.ruptured, ledger)

    # --- ends ----------------------------------------------------------------------------------

    def _checkpoint(self) -> None:
        self.standing.engine = self.engine.checkpoint()
        self.recorder.checkpoint(write_state(self.standing, self._known()))
        self.kept = clock.monotonic()

    def _known(self) -> list[object]:
        """Return what a checkpoint need not hold, always in the same order."""
        network, plan = self.network, self.plan
        arrays = [getattr(network, entry.name) for entry in fields(network)]
        events = [*plan.events, *(event for trigger in plan.triggers for event in trigger.events)]
        actions = [event.action for event in events]
        spans = [action.span for action in actions] + [trigger.span for trigger in plan.triggers]
        spans += [plan.simulation.span, *(body.span for body in network.bodies)]
        spans += [o.span for p in network.provenance.values() for o in p.origins]
        sources = list({id(span.source): span.source for span in spans}.values())
        return [network, *(a for a in arrays if isinstance(a, np.ndarray)), *actions, *sources]

    def _interrupted(self) -> str:
        time = self.standing.situation.time
        return f"interrupted at {time:g} s of {self.duration:g} s; the run can be resumed"

    def _outcome(self, kind: Kind, message: str) -> Outcome:
        standing = self.standing
        failures = self.recorder.memory.failures
        return Outcome(
            kind,
            message,
            clock.monotonic() - self.started,
            self.engine.statistics,
            tuple(failures[number] for number in sorted(failures)),
            tuple(standing.happenings),
            standing.situation,
        )
