"""Scenes that nobody prepared, against SciPy: each keeps its promise or says what is off."""

import numpy as np
import pytest

from tests.random_scenes import random_scene
from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.core.structs import replace
from tissuec.engine import run_arrays
from tissuec.engine.execution.companion import Companion
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run import run
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request
from tissuec.validate.validation import validate


def verdict_of(seed):
    """Return what validation says of a seed's scene, "refused" if it does not compile."""
    source = Source(f"seed{seed}.tis", random_scene(seed))
    try:
        compiled, _ = compile_request(Request(source))
    except CompileError:
        return "refused"
    found = validate(compiled, method="DOP853", rtol=None, progress=lambda *_: None).verdict
    return "told" if found == "broken" and is_told(compiled) else found


def is_told(compiled):
    """Return whether a run says, by its companion, that positions are not known so well."""
    network, plan = compiled.network, compiled.plan
    beside = Companion(network, plan, "inline")
    outcome = run(network, plan, Recorder(network, plan, MemoryRecording(), tap=beside.tap))
    return beside.estimate(outcome.statistics).since is not None


@pytest.mark.parametrize(
    ("first", "count"),
    [(0, 3), *(pytest.param(k, 40, marks=pytest.mark.slow) for k in range(0, 400, 40))],
)
def test_random_scenes_keep_their_promises(first, count):
    verdicts = [verdict_of(seed) for seed in range(first, first + count)]
    # Some contradict themselves and are refused; in some motion is chaotic.
    assert set(verdicts) <= {"kept", "told", "refused", "undecided"}
    assert verdicts.count("kept") > 0.75 * len(verdicts)


# Not 189: two of its springs rupture, at times that differ by processors within the tolerance,
# which changes the balance from 0.3 to 1.04 of its limit.
@pytest.mark.parametrize("seed", [37, 231, 246, 264])
def test_energies_within_long_steps_are_balanced(seed):
    # Motions are accurate at ends of their last steps, but neither speeds nor powers within:
    # without shorter steps for these, the balance is off by 1.1 to 31 tolerances.
    assert verdict_of(seed) == "kept"


@pytest.mark.parametrize("seed", [189, 264])
def test_what_is_asked_of_energies_changes_no_position(seed):
    (compiled,) = free_scenes([seed])
    asked = replace(compiled, plan=replace(compiled.plan, needs_ledger=True))
    assert np.array_equal(positions(asked, 1e-3), positions(compiled, 1e-3))


def positions(compiled, tolerance):
    """Return positions in the frames of a run [m], with the method that is chosen for it."""
    simulation = replace(compiled.plan.simulation, integrator="automatic", tolerance=tolerance)
    plan, recording = replace(compiled.plan, simulation=simulation), MemoryRecording()
    run(compiled.network, plan, Recorder(compiled.network, plan, recording))
    return recording.frame_arrays()[1]


def error(found, exact):
    """Return the largest error so far over the largest displacement so far, at its largest."""
    moved = np.maximum.accumulate(np.linalg.norm(exact - exact[0], axis=2).max(axis=1))
    off = np.linalg.norm(found - exact, axis=2).max(axis=1)
    return float((off[moved > 0.0] / moved[moved > 0.0]).max(initial=0.0))


def free_scenes(seeds):
    """Yield the scenes among seeds that compile, move and have no step of their own."""
    for seed in seeds:
        try:
            compiled, _ = compile_request(
                Request(Source(f"seed{seed}.tis", random_scene(seed)))
            )
        except CompileError:
            continue
        if not compiled.plan.simulation.step and len(compiled.plan.output.frames) > 1:
            yield compiled


@pytest.mark.parametrize("count", [20, pytest.param(140, marks=pytest.mark.slow)])
def test_tolerances_are_kept_and_made_use_of(count):
    ratios = {1e-3: [], 1e-6: []}
    for compiled in free_scenes(range(count)):
        exact = positions(compiled, 1e-12)
        for tolerance, found in ratios.items():
            found.append(error(positions(compiled, tolerance), exact) / tolerance)
    for found in ratios.values():
        assert len(found) > 0.8 * count
        assert max(found) < 1.0
        # Where stability sets the steps, in about half of the scenes, errors are as small as
        # they come. The upper quartile of 10 to 87 scenes is from 0.03 to 0.07.
        assert np.quantile(found, 0.75) > 0.02


@pytest.mark.parametrize(("seed", "tolerance"), [(446, 1e-3), (564, 1e-3), (384, 1e-5)])
def test_samples_within_long_steps_keep_the_promise(seed, tolerance, monkeypatch):
    (compiled,) = free_scenes([seed])
    exact = positions(compiled, 1e-12)
    assert error(positions(compiled, tolerance), exact) < tolerance
    # Fast motions that die away are followed by steps whose polynomials are no good for them.
    monkeypatch.setattr(run_arrays, "INSIDE", np.inf)
    assert error(positions(compiled, tolerance), exact) > 2.0 * tolerance
