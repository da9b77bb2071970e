"""The run: the loop over its events, until the end, a failure or an interruption.

At one time things happen in this order: expectations whose interval ends are judged; springs
rupture; ends of motions come, and whatever else earlier actions have entered; then the events
of the script as they are written; then the triggers that have become true. Samples at that time
show what is after all of it.
"""

import signal
import time as clock
from collections.abc import Callable, Mapping, Sequence
from math import inf
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from msgspec import Struct, field

from tissuec.core.errors import counted
from tissuec.core.signals import Halted, Interrupt, StopRequest, asked_to_stop
from tissuec.core.units import ENERGY, TIME, show
from tissuec.engine.execution.event_handler import EventHandler
from tissuec.engine.execution.expectations import Failure
from tissuec.engine.execution.failure_messages import explain
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run_state import RunState, read_run_state
from tissuec.mechanics import observables
from tissuec.mechanics.state import State
from tissuec.model.network import Floats, Network
from tissuec.results.promise import Doubt
from tissuec.results.recording import WithoutEffect
from tissuec.script.measures.snapshot import EnergyBalance
from tissuec.script.plan import EQUILIBRIUM, RELAXATION, Plan, ScheduledAction
from tissuec.script.verbs import LoggedEvent

if TYPE_CHECKING:
    from tissuec.engine.engine import Engine
    from tissuec.engine.equilibria import Phases
    from tissuec.engine.method import Interruption, Pause, Statistics
    from tissuec.engine.quasistatic import QuasiStatic

Kind = Literal["done", "diverged", "stuck", "interrupted"]


class RunLoop:
    """One run under way.

    Args:
        network, plan: Of the run.
        recorder: A new one, of the same network and plan.
        threads: See ``Method``.

    Attributes:
        ending: How the run ended, and a sentence about it; None while it continues.
        has_begun: Whether the events at its start are over.
        is_saved: Whether there is a checkpoint.
    """

    run_state: RunState
    handler: EventHandler

    def __init__(self, network: Network, plan: Plan, recorder: Recorder, threads: int):
        self.network, self.plan, self.recorder = network, plan, recorder
        self.engine: Engine | QuasiStatic | Phases
        self.engine = _make_engine(network, plan, recorder, threads)
        self.engine.follow = recorder.follow
        self.ending: tuple[Kind, str] | None = None
        self.has_begun = self.is_saved = False
        self._true: list[int] = []

    def begin(self, further: Sequence[ScheduledAction] = ()) -> None:
        """Start at 0 s with the events of that time.

        Args:
            further: Events beside those of the plan.
        """
        self._attach(RunState.begin(self.network, self.plan, self.recorder.memory))
        self.run_state.queue.write(further)
        self.handler.begin()
        self._restart()
        self.handler.enter()
        self._look_for_end()
        self.has_begun = True

    def resume(self, saved: Mapping[str, Any]) -> None:
        """Start from a checkpoint.

        Raises:
            ValueError: This is not the checkpoint of a run.
        """
        run_state = read_run_state(saved, self.network, self.plan)
        self.recorder.memory = run_state.memory
        self._attach(run_state)
        if "inner" in run_state.engine:
            self._enter_phases()
        self.engine.restore(run_state.state, run_state.engine)
        self.handler.enter()
        self.has_begun = self.is_saved = True

    def checkpoint(self) -> dict[str, Any]:
        """Return the state from which ``resume`` continues; only between two steps."""
        saved = self.engine.checkpoint()
        assert saved is not None, "the engine pauses between steps only"
        self.run_state.engine = saved
        return self.run_state.write(self.network, self.plan)

    def advance(self, pause: "Pause", view: float = inf) -> "Interruption":
        """Step to the next event, which is not handled yet, or to a pause or view.

        Args:
            pause, view: See ``Engine.advance``.
        """
        state = self.run_state.state
        until = min(self.run_state.queue.next, self.plan.simulation.duration)
        watch = self._watch if self._is_watched() else None
        survey = self._survey if watch and not state.is_slipping else None
        view = view if view < until else inf
        return self.engine.advance(state, until, watch, pause, survey, view)

    def handle(self, reason: "Interruption") -> None:
        """Carry out everything that happens at the time to which the run has come.

        Args:
            reason: Why ``advance`` returned; not for a pause.
        """
        state = self.run_state.state
        if reason.kind == "diverged" or reason.kind == "stuck":
            self.ending = reason.kind, explain(reason, state)
            self._close()
            return
        sums = self.sums()
        self.handler.leave(*sums)
        if self.recorder.takes_notes:
            if reason.kind == "reached":
                self.handler.look_at_rest()
            self.handler.look_for_doubts()
        true = self._true if reason.kind == "triggered" else None
        self._true = []
        if self.handler.handle(ruptured=reason.springs, true=true):
            self._restart()
            self.handler.enter()
            # A net without inertia is elsewhere after events: where it is relaxed again.
            if not self._is_static:
                self.handler.record_jumps(*sums)
        self._look_for_end()

    def sums(self) -> tuple[float, float]:
        """Return work and dissipated energy until now [J]; zero where they are not kept."""
        saved = self.engine.checkpoint() if self.plan.needs_ledger else None
        return (
            (0.0, 0.0)
            if saved is None
            else (float(saved["ledger"][0]), float(saved["ledger"][1]))
        )

    @property
    def statistics(self) -> "Statistics":
        """Return the statistics of the engine."""
        from tissuec.engine.method import Statistics

        return self.engine.statistics if self.has_begun else Statistics.of_nothing()

    def notes(self) -> tuple[str, ...]:
        """Return notes on the effect of a fixed step on the energy, and on lost equilibria."""
        if not self.has_begun:
            return ()
        simulation = self.plan.simulation
        if simulation.is_static or simulation.step is None:
            return tuple(self.engine.remarks)
        run_state = self.run_state
        ledger = EnergyBalance(run_state.initial, *self.sums(), run_state.switched)
        kept = ledger if self.plan.needs_ledger else None
        return (*self.engine.remarks, *notes(self.engine.statistics, run_state.state, kept))

    def _restart(self) -> None:
        """Have the engine take over the state, which may be in equilibrium from now on."""
        state = self.run_state.state
        if state.still_until > state.time and not self.plan.simulation.is_static:
            self._enter_phases()
        self.engine.restart(state)

    def _enter_phases(self) -> None:
        """Have the engine step static intervals, too, also those that no plan foresaw."""
        from tissuec.engine.engine import Engine
        from tissuec.engine.equilibria import Phases

        if isinstance(self.engine, Engine):
            self.engine = Phases(self.engine, self.recorder.times, self.recorder.record)

    @property
    def _is_static(self) -> bool:
        """Return whether the net has no inertia now."""
        state = self.run_state.state
        return self.plan.simulation.is_static or state.still_until > state.time

    def _attach(self, run_state: RunState) -> None:
        self.run_state = run_state
        self.handler = EventHandler(self.network, self.plan, self.recorder, run_state)

    def _look_for_end(self) -> None:
        """End the run if it failed, was ended by an action, or has lasted its duration."""
        state, duration = self.run_state.state, self.plan.simulation.duration
        ended = self.run_state.queue.ended
        if self.handler.failure:
            self.ending = "stuck", self.handler.failure
        elif ended is not None or state.time >= duration:
            self.engine.finish(state)
            message = f"done: {duration:g} s were simulated"
            if ended is not None:
                self.handler.end(*self.sums())
                at = f"{show(state.time, TIME, digits=6)} of {show(duration, TIME)}"
                message = f"done: ended at {at} by {ended.span.place}: {ended.cause}"
            self.ending = "done", message
        if self.ending is not None:
            self._close()

    def _close(self) -> None:
        """Record the state with which the run ends, and what it shows."""
        assert self.ending is not None, "the run ends"
        if self.ending[0] == "done" and self.recorder.awaits_jumps:
            self.handler.record_jumps(*self.sums())
        self._record_end()
        if self.recorder.takes_notes:
            self.handler.look_for_doubts(always=True)

    def _record_end(self) -> None:
        """Record the state with which the run ends early, in every table.

        A net without inertia that failed is not in equilibrium: its last state is none. A run
        that is interrupted does not end: it continues from its checkpoint.
        """
        state = self.run_state.state
        assert self.ending is not None, "the run ends"
        is_done = self.ending[0] == "done"
        if state.time < self.plan.simulation.duration if is_done else not self._is_static:
            self.recorder.record_end(self.engine.sample(state))

    def _is_watched(self) -> bool:
        """Return whether states on the way to the next event must be examined."""
        waits = self.run_state.waiting or self.recorder.awaits_jumps
        return bool(waits) or self.run_state.state.is_slipping

    def _watch(self, time: float, position: Floats, velocity: Floats) -> bool:
        if self.recorder.awaits_jumps:
            self.handler.record_jumps(*self.sums())
        found = self.handler.true_triggers(self.handler.snapshot_at(time, position, velocity))
        # The engine closes in on the earliest time that is true: the last such answer counts.
        self._true = found or self._true
        return bool(found) or bool(self.run_state.state.seizing(time, position, velocity))

    def _survey(self, time: Floats, position: Floats, velocity: Floats) -> bool:
        return self.handler.may_be_true(self.handler.snapshot_at(time, position, velocity))


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
        spacing=recorder.spacing,
    )
    if method.name == RELAXATION:
        from tissuec.engine.quasistatic import Relaxations

        return Relaxations(network, method, recorder.times, recorder.record)
    if method.name == EQUILIBRIUM:
        from tissuec.engine.equilibria import Equilibria

        return Equilibria(network, method, recorder.times, recorder.record)
    return Engine(network, method, recorder.times, recorder.record)


GROWN = 0.01  # of the energy at the end: imbalances that are reported


def notes(
    statistics: "Statistics", state: State, ledger: EnergyBalance | None
) -> tuple[str, ...]:
    """Return sentences about a run with a fixed step.

    Args:
        statistics: Counts of the run.
        state: The last good state.
        ledger: Energies until then; None where they are not kept.
    """
    found = [_stalls(statistics)] if statistics.stalls else []
    if ledger is not None:
        found += _growth(state, ledger)
    return tuple(found)


def _stalls(statistics: "Statistics") -> str:
    return (
        f"{statistics.method} stalled in {counted(statistics.stalls, 'step')}: the forces rose "
        f"even at the smallest step size; "
        f"{counted(statistics.evaluations, 'force evaluation')} for "
        f"{counted(statistics.accepted, 'frame')}"
    )


def _growth(state: State, ledger: EnergyBalance) -> list[str]:
    """Return notes on unexplained gains or losses of energy, if they are large."""
    energies = observables.energies(state, state.time, state.position, state.velocity)
    surplus, size = float(ledger.balance(energies)), float(ledger.size(energies))
    if not np.isfinite(surplus) or abs(surplus) <= GROWN * size:
        return []
    verb, part = ("added", "to") if surplus > 0.0 else ("took", "from")
    return [
        f"the steps {verb} {show(abs(surplus), ENERGY)} {part} the energy of the net, which is "
        f"{show(float(energies.kinetic + energies.elastic), ENERGY)} at the end; smaller steps "
        "reduce this"
    ]


CHECKPOINT_EVERY = 5.0
"""Least wall time between checkpoints [s]."""

Progress = Callable[[float], None]
Watch = Callable[[float, "Statistics"], None]


class Outcome(Struct, frozen=True, eq=False):
    """Outcome of a run.

    Attributes:
        message: A sentence; of a failure it names spring, nodes, time and line of the scene.
        wall_time: Of the run [s], without that of the error estimate.
        statistics: What the engine did.
        failures: Expectations that did not hold, in the order of the scene.
        unreached: Expectations that the run did not come to, or not to the end of, by their
            places in the plan.
        held: Of those that hold, when each was judged last [s] and what was measured then.
        logged_events: The event log, each entry with its time [s].
        state: The state at the end.
        notes: What else is to be known of it, in sentences.
        signal: Number of the signal that interrupted it, or its companion run, if one did.
        ended: What ended it before its duration, if anything did.
        is_saved: Whether it can be resumed if it was interrupted.
        doubts: What makes its numbers doubtful, by the time at which it was seen first.
        without_effect: Orders that changed nothing; of a run that is done.
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
    ended: LoggedEvent | None = None
    is_saved: bool = True
    doubts: tuple[Doubt, ...] = ()
    without_effect: tuple[WithoutEffect, ...] = ()


def run(
    network: Network,
    plan: Plan,
    recorder: Recorder,
    *,
    progress: Progress | None = None,
    watch: Watch | None = None,
    interrupt: Interrupt | None = None,
    resume: Mapping[str, Any] | None = None,
    threads: int = 1,
) -> Outcome:
    """Carry out a plan.

    Args:
        recorder: A new one, of the same network and plan.
        progress: Called with the simulated time [s] now and then.
        watch: Likewise, with the statistics of the engine as well.
        interrupt: Called now and then; True ends the run between two steps, with a checkpoint.
            Ctrl-C, SIGTERM and SIGHUP do the same.
        resume: The checkpoint of an earlier run of the same plan, which continues from there as
            if it had never stopped.
        threads: See ``Method``.

    Raises:
        ValueError: ``resume`` is not the checkpoint of a run.
    """
    started = clock.monotonic()
    with asked_to_stop(interrupt) as stop:
        loop = RunLoop(network, plan, recorder, threads)
        try:
            if resume is None:
                loop.begin()
            else:
                loop.resume(resume)
            kind, message = _finish(loop, _both(loop, progress, watch), stop)
        except Halted:  # within a step or an event: what was saved before them holds
            kind, message = "interrupted", _interrupted(loop, stop)
    failures, run_state = recorder.memory.failures, loop.run_state
    is_told = kind == "done" and recorder.takes_notes
    return Outcome(
        kind,
        message,
        clock.monotonic() - started,
        loop.statistics,
        tuple(failures[number] for number in sorted(failures)),
        recorder.unreached,
        tuple(loop.run_state.logged_events),
        loop.run_state.state,
        loop.notes(),
        recorder.memory.held,
        stop.signal if kind == "interrupted" else None,
        loop.run_state.queue.ended,
        loop.is_saved,
        tuple(sorted(recorder.memory.doubts.found.values(), key=lambda one: one.time)),
        recorder.without_effect(run_state.state, run_state.waiting) if is_told else (),
    )


def _both(loop: RunLoop, progress: Progress | None, watch: Watch | None) -> Progress:
    """Return a callback that passes the simulated time to both, each None if there is none."""

    def tell(time: float) -> None:
        if watch is not None:
            watch(time, loop.engine.statistics)
        if progress is not None:
            progress(time)

    return tell


def _finish(loop: RunLoop, progress: Progress, stop: StopRequest) -> tuple[Kind, str]:
    """Step to the end; return how that went."""
    state, kept = loop.run_state.state, clock.monotonic()

    def pause(time: float) -> bool:
        progress(time)
        return stop() or clock.monotonic() - kept >= CHECKPOINT_EVERY

    while loop.ending is None:
        reason = loop.advance(pause)
        progress(state.time)
        if reason.kind != "paused":
            loop.handle(reason)
            continue
        loop.recorder.checkpoint(loop.checkpoint())
        loop.is_saved = True
        kept = clock.monotonic()
        if stop():
            return "interrupted", _interrupted(loop, stop)
    return loop.ending


def _interrupted(loop: RunLoop, stop: StopRequest) -> str:
    """Return how far an interrupted run has come."""
    now, duration = loop.run_state.state.time, loop.plan.simulation.duration
    number = stop.signal
    by = "" if number in (None, signal.SIGINT) else f" by {signal.Signals(number).name}"
    way_out = "the run can be resumed" if loop.is_saved else "nothing is saved yet: run again"
    return f"interrupted{by} at {now:g} s of {duration:g} s; {way_out}"
