"""Whole runs into memory, interrupted and resumed, and everything that they recorded."""

import numpy as np

import tissuec
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run import run


class AfterAsking:
    """Asks to stop the n-th time it is asked, and then for good."""

    signal = None  # no signal made it so

    def __init__(self, count):
        self.count = count

    def __call__(self):
        self.count -= 1
        return self.count <= 0


def carried_out(compiled, **options):
    """Return the outcome of a run and its recording; options are those of ``run``."""
    recording = MemoryRecording()
    recorder = Recorder(compiled.network, compiled.plan, recording)
    return run(compiled.network, compiled.plan, recorder, **options), recording


def every_array(log, *recordings):
    """Return all rows of one recording, or of several one behind the other."""
    tables = [[*r.frame_arrays(), *r.log_arrays(log), *r.energy_arrays()] for r in recordings]
    return [np.concatenate(columns) for columns in zip(*tables, strict=True)]


def same_on_threads(scene, *counts):
    """Return a run on one thread, after comparing positions and energies of others with it."""
    one, *others = (tissuec.run(scene, threads=n, companion="off") for n in (1, *counts))
    used = [run.manifest["statistics"]["threads"] for run in (one, *others)]
    assert used == [1, *counts]
    for other in others:
        assert np.array_equal(one.position[:], other.position[:])
        assert np.array_equal(one.energies.value, other.energies.value)
    return one


def same_when_resumed(compiled, log, *counts):
    """Compare all rows of runs that stop and go on with those of a run that does not.

    Args:
        log: Compared beside frames and energies.
        counts: When to stop, one for each run; see ``AfterAsking``.

    Returns:
        Outcome of the whole run, and those of both parts of each other run.
    """
    whole, undisturbed = carried_out(compiled)
    expected, parts = every_array(log, undisturbed), []
    for count in counts:
        first, before = carried_out(compiled, interrupt=AfterAsking(count))
        assert first.kind == "interrupted"
        second, after = carried_out(compiled, resume=before.state)
        assert whole.kind == second.kind == "done"
        assert all(map(len, every_array(log, after)))
        for one, other in zip(expected, every_array(log, before, after), strict=True):
            assert np.array_equal(one, other)
            assert one.tobytes() == other.tobytes()
        parts.append((first, second))
    return whole, *parts


def same_on_two_threads(compiled, log):
    """Return the outcome of a run on one thread, after comparing all of it with one on two."""
    (one, alone), (two, both) = (carried_out(compiled, threads=count) for count in (1, 2))
    assert (one.statistics.threads, two.statistics.threads) == (1, 2)
    for first, second in zip(every_array(log, alone), every_array(log, both), strict=True):
        assert np.array_equal(first, second)
    assert np.array_equal(one.state.velocity, two.state.velocity)
    return one


def open_balance(recording):
    """Return which part of the largest work came or went for no reason, shape (row,)."""
    kinetic, elastic, gravity, work, lost, switched = recording.energy_arrays()[1].T
    return (kinetic + elastic + gravity - switched - work + lost) / work.max()
