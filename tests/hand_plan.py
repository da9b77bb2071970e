"""Plans written by hand, and their runs with a recording in memory."""

import numpy as np

from tests.hand_net import order, span
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run import run
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.plan import (
    Expectation,
    LogRequest,
    Output,
    Plan,
    ScheduledAction,
    Simulation,
    Trigger,
)


def event(time, sentence, groups=None, *, duration=None, tools=None, **clauses):
    action = order(sentence, groups or {}, tools=tools, duration=duration, **clauses)
    return ScheduledAction(time, action)


def make_plan(
    network,
    duration,
    events=(),
    *,
    gravity=(0.0, 0.0, 0.0),
    drag=0.0,
    triggers=(),
    logs=(),
    every=np.inf,
    energy=np.inf,
    expectations=(),
    integrator="dop853",
    tolerance=1e-9,
    step=None,
    ledger=True,
    choices=None,
):
    frames = np.arange(network.node_count if np.isfinite(every) else 0)
    return Plan(
        simulation=Simulation(duration, integrator, tolerance, step, span("simulate"), choices),
        gravity=np.array(gravity, dtype=float),
        drag=drag,
        events=tuple(sorted(events, key=lambda event: event.time)),
        triggers=tuple(triggers),
        output=Output(frames, every, False, tuple(logs), energy),
        expectations=tuple(expectations),
        needs_ledger=ledger,
        breakable=bool(np.isfinite(network.springs.strength).any()),
    )


def subject(name, nodes=None, springs=()):
    found = None if nodes is None else np.asarray(nodes, dtype=np.int64)
    return Subject(name, found, np.asarray(springs, dtype=np.int64))


def log(measure, *subjects, every):
    title = f"{measure} of {' to '.join(s.name for s in subjects)}"
    return LogRequest(title, MEASURES[measure], subjects, every, span(title))


def value(measure, *subjects):
    """Return a function of a snapshot."""
    kind = MEASURES[measure]
    return lambda snapshot: kind.value(kind.sample(subjects, snapshot))


class Condition:
    """A condition by a function of one snapshot."""

    def __init__(self, function):
        self.function = function

    def __call__(self, snapshot):
        return bool(self.function(snapshot))

    def holds(self, snapshots):
        count = len(snapshots.time)
        return np.array([self(snapshots.pick(place)) for place in range(count)], dtype=bool)


def when(condition, *events):
    return Trigger(Condition(condition), tuple(events), span("when something holds"))


def expect(condition, start, stop=None, *, pinned=()):
    def describe(snapshot):
        return f"at {float(snapshot.time):g} s"

    return Expectation(
        Condition(condition),
        describe,
        start,
        start if stop is None else stop,
        pinned,
        span("expect"),
    )


def carry_out(network, plan, **options):
    """Run and return the outcome and the recording."""
    recording = MemoryRecording()
    recorder = Recorder(network, plan, recording)
    return run(network, plan, recorder, **options), recording
