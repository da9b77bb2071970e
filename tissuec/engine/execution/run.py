"""The run: from event to event, until the end, a failure or an interruption."""

import signal
import time as clock
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from msgspec import Struct, field

from tissuec.engine.execution.expectations import Failure
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run_loop import Kind, RunLoop
from tissuec.engine.execution.signals import Interrupt, StopRequest, asked_to_stop
from tissuec.mechanics.state import State
from tissuec.model.network import Network
from tissuec.results.doubts import Doubt
from tissuec.script.plan import Plan
from tissuec.script.verbs import LoggedEvent

if TYPE_CHECKING:
    from tissuec.engine.method import Statistics

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
        doubts: What makes its numbers doubtful, by the time at which it was seen first.
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
    doubts: tuple[Doubt, ...] = ()


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
        if resume is None:
            loop.begin()
        else:
            loop.resume(resume)
        tell = _both(loop, progress, watch)
        kind, message = _finish(loop, tell, stop)
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
        loop.run_state.queue.ended,
        tuple(sorted(recorder.memory.doubts.found.values(), key=lambda one: one.time)),
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
        kept = clock.monotonic()
        if stop():
            return "interrupted", _interrupted(loop, stop)
    return loop.ending


def _interrupted(loop: RunLoop, stop: StopRequest) -> str:
    """Return how far an interrupted run has come."""
    now, duration = loop.run_state.state.time, loop.plan.simulation.duration
    number = stop.signal
    by = "" if number in (None, signal.SIGINT) else f" by {signal.Signals(number).name}"
    return f"interrupted{by} at {now:g} s of {duration:g} s; the run can be resumed"
