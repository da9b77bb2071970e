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
