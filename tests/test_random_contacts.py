"""Scenes of things that meet, which nobody prepared: none beyond its promise without a word."""

from functools import cache

import numpy as np
import pytest

from tests.contact.scenes import by_loops
from tests.every import every
from tests.random_contacts import touching_scene
from tests.validate.scenes import compiled_scene
from tissuec.core.errors import CompileError
from tissuec.core.structs import replace
from tissuec.engine.execution.companion import Companion
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run import run
from tissuec.engine.run_arrays import FLOOR
from tissuec.validate.reference import reference

FINER = 100.0  # times: the tolerance of what a run is compared with


@cache
def played(seed):
    """Return the scene of a seed, its frames, what ran, and the state of the promise.

    It is None of scenes that contradict themselves.
    """
    try:
        compiled, recording = compiled_scene(touching_scene(seed)), MemoryRecording()
    except CompileError:
        return None
    network, plan = compiled.network, compiled.plan
    beside = Companion(network, plan, "inline")
    outcome = run(network, plan, Recorder(network, plan, recording, tap=beside.tap))
    assert outcome.kind == "done", outcome.message
    state = beside.estimate(outcome.statistics).state
    return compiled, recording.frame_arrays(), outcome.statistics, state


def by_another_method(compiled, time, ran):
    """Return positions at times [s] by a method that the run did not use [m]."""
    name = "rkn4" if {change.method for change in ran.changes} == {"dop853"} else "dop853"
    simulation = compiled.plan.simulation
    simulation = replace(simulation, integrator=name, tolerance=simulation.tolerance / FINER)
    plan, recording = replace(compiled.plan, simulation=simulation), MemoryRecording()
    outcome = run(compiled.network, plan, Recorder(compiled.network, plan, recording))
    # Low orders cannot step over every corner of contact at such tolerances, and say so.
    return recording.frame_arrays()[1] if outcome.kind == "done" else by_scipy(compiled, time)


def by_scipy(compiled, time):
    """Return positions at times [s] [m]."""
    network, plan = compiled.network, compiled.plan
    rtol = 1e-3 * plan.simulation.tolerance
    return reference(network, plan, time, method="DOP853", rtol=rtol).position


def error(compiled, found, exact):
    """Return the largest error so far over the largest displacement so far, in tolerances."""
    off = np.linalg.norm(found - exact, axis=2).max(axis=1)
    moved = np.maximum.accumulate(np.linalg.norm(exact - exact[0], axis=2).max(axis=1))
    scale = np.maximum(moved, FLOOR * compiled.network.extent)
    return float((off / scale).max()) / compiled.plan.simulation.tolerance


def verdict_of(seed):
    """Return "kept", "told" or "refused", and fail if none of it is true."""
    if played(seed) is None:
        return "refused"
    compiled, (time, position, *_), ran, state = played(seed)
    if state != "kept":
        return "told"
    found = error(compiled, position, by_another_method(compiled, time, ran))
    assert found < 1.0, f"{found:.2g} tolerances off, without a word"
    return "kept"


def touches(seed):
    """Return when something touches: "from 0 s", "later" or "never"."""
    if played(seed) is None:
        return "never"
    compiled, (_, position, velocity, *_), *_ = played(seed)
    contact, network = compiled.network.contact, compiled.network
    none = np.zeros((network.row_count, 3))
    speeds = (np.concatenate([here, none[len(here) :]]) for here in velocity)
    pressed = [by_loops(contact, *at)[0].any() for at in zip(position, speeds, strict=True)]
    if pressed[0]:
        return "from 0 s"
    return "later" if any(pressed) else "never"


#: Of the first ones, those that take the least time.
BRIEF = (3, 10, 12, 26, 27, 29, 41, 44, 60, 62)


@pytest.mark.parametrize(
    "seeds",
    [
        BRIEF,
        *(pytest.param(range(k, k + 40), marks=pytest.mark.slow) for k in range(0, 200, 40)),
    ],
    ids=lambda seeds: f"{min(seeds)} to {max(seeds)}",
)
def test_what_meets_something_is_as_accurate_as_the_run_says(seeds):
    verdicts = [verdict_of(seed) for seed in seeds]
    assert verdicts.count("kept") > 0.75 * len(seeds)
    when = [touches(seed) for seed in seeds]
    assert when.count("later") > 0.4 * len(seeds)
    assert when.count("from 0 s") > 0.1 * len(seeds)
    played.cache_clear()


#: Scenes in which SciPy takes the fewest evaluations of forces.
QUICK = (29,)
SLOWER = (4, 9, 17, 19, 25, 26, 30, 44, 47, 60, 63, 69)


@every("seed", QUICK)
def test_scipy_agrees(seed):
    agrees(seed)


@pytest.mark.slow
@every("seed", SLOWER)
def test_scipy_agrees_on_more(seed):
    agrees(seed)


def agrees(seed):
    compiled, (time, position, *_), *_ = played(seed)
    assert error(compiled, position, by_scipy(compiled, time)) < 1.0
