"""The run: from event to event, until the end, a failure or an interruption.

At one time things happen in this order: expectations whose interval ends are judged; springs
rupture; ends of motions come, and whatever else earlier actions have entered; then the events
of the script as they are written; then the triggers that have become true. Samples at that time
show what is after all of it.
"""

import signal
import time as clock
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Literal

from msgspec import Struct, field

from tissuec.engine.execution.event_handler import EventHandler
from tissuec.engine.execution.expectations import Failure
from tissuec.engine.execution.failure_messages import explain
from tissuec.engine.execution.notes import notes
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run_state import RunState, read_run_state
from tissuec.engine.execution.signals import Interrupt, StopRequest, asked_to_stop
from tissuec.mechanics.state import State
from tissuec.model.network import Floats, Network
from tissuec.script.measures.snapshot import EnergyBalance
from tissuec.script.plan import RELAXATION, Plan
from tissuec.script.verbs import LoggedEvent

if TYPE_CHECKING:
    from tissuec.engine.engine import Engine
    from tissuec.engine.method import Statistics
    from tissuec.engine.quasistatic import QuasiStatic

CHECKPOINT_EVERY = 5.0
"""Least wall time between checkpoints [s]."""

Kind = Literal["done", "diverged", "stuck", "interrupted"]
Progress = Callable[[float], None]


class Outcome(Struct, frozen=True, eq=False):
    """Outcome of a run.

    Attributes:
        message: A sentence; of a failure it names spring, nodes, time and line of the scene.
        wall_time: Of this call [s].
        statistics: What the engine did.
        failures: Expectations that did not hold, in the order of the scene.
        unreached: Expectations that the run did not come to, or not to the end of, by their
            places in the plan.
        held: Of those that hold, when each was judged last [s] and what was measured then.
        logged_events: The event log, each entry with its time [s].
        state: The state at the end.
        notes: What else is to be known of it, in sentences.
        signal: Number of the signal that interrupted it, if one did.
    """

    kind: Kind
    message: str
    wall_time: float
    statistics: "Statistics"
    failures: tuple[Failure, ...]
    unreached: tuple[int, ...]
    logged_events: tuple[tuple[float, LoggedEvent], ...]
    state: State
    notes: tuple[str, ...] = ()
    held: Mapping[int, tuple[float, str]] = field(default_factory=dict[int, tuple[float, str]])
    signal: int | None = None


def run(
    network: Network,
    plan: Plan,
    recorder: Recorder,
    *,
    progress: Progress | None = None,
    interrupt: Interrupt | None = None,
    resume: Mapping[str, Any] | None = None,
    threads: int = 1,
) -> Outcome:
    """Carry out a plan.

    Args:
        recorder: A new one, of the same network and plan.
        progress: Told the simulated time [s] now and then.
        interrupt: Asked now and then; True ends the run between two steps, with a checkpoint.
            Ctrl-C, SIGTERM and SIGHUP do the same.
        resume: The checkpoint of an earlier run of the same plan, which goes on from there as
            if it had never stopped.
        threads: See ``Method``.

    Raises:
        ValueError: ``resume`` is not the checkpoint of a run.
    """
    started = clock.monotonic()
    with asked_to_stop(interrupt) as stop:
        loop = _Loop(network, plan, recorder, progress or (lambda time: None), stop, threads)
        if resume is None:
            loop.begin()
        else:
            loop.go_on(resume)
        kind, message = loop.finish()
    failures = recorder.memory.failures
    return Outcome(
        kind,
        message,
        clock.monotonic() - started,
        loop.engine.statistics,
        tuple(failures[number] for number in sorted(failures)),
        recorder.unreached,
        tuple(loop.run_state.logged_events),
        loop.run_state.state,
        loop.notes(),
        recorder.memory.held,
        stop.signal if kind == "interrupted" else None,
    )


class _Loop:
    """One run under way."""

    run_state: RunState
    handler: EventHandler

    def __init__(
        self,
        network: Network,
        plan: Plan,
        recorder: Recorder,
        progress: Progress,
        stop: StopRequest,
        threads: int,
    ):
        self.network, self.plan, self.recorder = network, plan, recorder
        self.progress, self.stop = progress, stop
        self.engine = _make_engine(network, plan, recorder, threads)
        self.kept = clock.monotonic()
        self.true: list[int] = []
        self.relaxes = plan.simulation.integrator == RELAXATION

    def begin(self) -> None:
        """Start at 0 s with the events of that time."""
        self.run_state = RunState.begin(self.network, self.plan, self.recorder.memory)
        self.handler = EventHandler(self.network, self.plan, self.recorder, self.run_state)
        self.handler.begin()
        self.engine.restart(self.run_state.state)
        self.handler.enter()

    def go_on(self, saved: Mapping[str, Any]) -> None:
        """Start from a checkpoint."""
        self.run_state = read_run_state(saved, self.network, self.plan)
        self.recorder.memory = self.run_state.memory
        self.handler = EventHandler(self.network, self.plan, self.recorder, self.run_state)
        self.engine.restore(self.run_state.state, self.run_state.engine)
        self.handler.enter()

    def finish(self) -> tuple[Kind, str]:
        """Step to the end; return how that went."""
        state, duration = self.run_state.state, self.plan.simulation.duration
        while not self.handler.failure:
            until = min(self.run_state.queue.next, duration)
            watch = self._watch if self._is_watched() else None
            survey = self._survey if watch and not state.is_slipping else None
            reason = self.engine.advance(state, until, watch, self._pause, survey)
            self.progress(state.time)
            if reason.kind == "diverged" or reason.kind == "stuck":
                return reason.kind, explain(reason, state)
            if reason.kind == "paused":
                self._checkpoint()
                if self.stop():
                    return "interrupted", self._interrupted()
                continue
            sums = self._sums()
            self.handler.leave(*sums)
            if reason.kind == "reached":
                self.handler.look_at_rest()
                self.handler.look_at_threads()
            true = self.true if reason.kind == "triggered" else None
            self.true = []
            if self.handler.handle(ruptured=reason.springs, true=true):
                self.engine.restart(state)
                self.handler.enter()
                # A net without inertia is elsewhere after events: where it is relaxed again.
                if not self.relaxes or state.time >= duration:
                    self.handler.record_jumps(*sums)
            if state.time >= duration and not self.handler.failure:
                self.engine.finish(state)
                return "done", f"done: {duration:g} s were simulated"
        return "stuck", self.handler.failure

    def notes(self) -> tuple[str, ...]:
        """Return what a fixed step did to the energy, and how it was kept."""
        simulation = self.plan.simulation
        if simulation.step is None or simulation.integrator == RELAXATION:
            return ()
        run_state = self.run_state
        ledger = EnergyBalance(run_state.initial, *self._sums(), run_state.switched)
        kept = ledger if self.plan.needs_ledger else None
        return notes(self.engine.statistics, run_state.state, kept)

    def _pause(self, time: float) -> bool:
        self.progress(time)
        return self.stop() or clock.monotonic() - self.kept >= CHECKPOINT_EVERY

    def _is_watched(self) -> bool:
        """Return whether states on the way to the next event must be looked at."""
        waits = self.run_state.waiting or self.recorder.awaits_jumps
        return bool(waits) or self.run_state.state.is_slipping

    def _watch(self, time: float, position: Floats, velocity: Floats) -> bool:
        if self.recorder.awaits_jumps:
            self.handler.record_jumps(*self._sums())
        found = self.handler.true_triggers(self.handler.snapshot_at(time, position, velocity))
        # The engine closes in on the earliest time that is true: the last such answer counts.
        self.true = found or self.true
        return bool(found) or bool(self.run_state.state.seizing(time, position, velocity))

    def _survey(self, time: Floats, position: Floats, velocity: Floats) -> bool:
        return self.handler.may_be_true(self.handler.snapshot_at(time, position, velocity))

    def _sums(self) -> tuple[float, float]:
        """Return work and dissipated energy until now [J]; zero where they are not kept."""
        saved = self.engine.checkpoint() if self.plan.needs_ledger else None
        return (
            (0.0, 0.0)
            if saved is None
            else (float(saved["ledger"][0]), float(saved["ledger"][1]))
        )

    def _checkpoint(self) -> None:
        saved = self.engine.checkpoint()
        assert saved is not None, "the engine pauses between steps only"
        self.run_state.engine = saved
        self.recorder.checkpoint(self.run_state.write(self.network, self.plan))
        self.kept = clock.monotonic()

    def _interrupted(self) -> str:
        now, duration = self.run_state.state.time, self.plan.simulation.duration
        number = self.stop.signal
        by = "" if number in (None, signal.SIGINT) else f" by {signal.Signals(number).name}"
        return f"interrupted{by} at {now:g} s of {duration:g} s; the run can be resumed"


def _make_engine(
    network: Network, plan: Plan, recorder: Recorder, threads: int
) -> "Engine | QuasiStatic":
    """Return a new engine; imported only here, because it brings much along."""
    from tissuec.engine.engine import Engine
    from tissuec.engine.method import Method

    simulation = plan.simulation
    method = Method(
        simulation.integrator,
        simulation.tolerance,
        simulation.step,
        simulation.duration,
        ledger=plan.needs_ledger,
        watch_strength=plan.breakable,
        choices=simulation.choices,
        threads=threads,
    )
    if method.name == RELAXATION:
        from tissuec.engine.quasistatic import QuasiStatic

        return QuasiStatic(network, method, recorder.times, recorder.record)
    return Engine(network, method, recorder.times, recorder.record)
