"""Scenes at random places of all axes of the stress test at once: right, or said not to be."""

from math import sqrt

import numpy as np
import pytest

from benchmarks.stability.cells import FRAMES, MASS, STIFFNESS, SWING, Cell, tube
from benchmarks.stability.known import find_known
from tissuec.analysis.bench_solvers import BenchProblem, Deadline, OutOfTime
from tissuec.core.source import Source
from tissuec.core.structs import replace
from tissuec.engine.execution.companion import Companion
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run import run
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

TOLERANCE = 1e-4
BUDGET = 4.0  # of the processor for a run [s]


def scene(seed):
    """Return a cell whose tube has something of every axis."""
    rng = np.random.default_rng(seed)

    def often(chance, value, otherwise):
        return value if rng.random() < chance else otherwise

    stiffer, lighter = 10.0 ** rng.uniform(0.0, 8.0), 10.0 ** rng.uniform(0.0, 6.0)
    ring = often(0.4, f"spring constant = {STIFFNESS * stiffer!r} N/m", "")
    ring = often(0.3, f"mass = {MASS / lighter!r} kg", ring)
    ratio = often(0.8, 10.0 ** rng.uniform(-3.0, 3.0), 0.0)
    squeeze = float(rng.integers(0, 91))
    held = bool(rng.random() < 0.6)
    force = 10.0 ** rng.uniform(-6.0, 6.0)
    hertz = SWING / (2.0 * np.pi) * 10.0 ** rng.uniform(-1.0, 1.0)
    push = f"push far with (0, {force!r}, 0) N"
    text = tube(
        viscosity=2.0 * ratio * sqrt(STIFFNESS * MASS),
        ring=ring,
        wall=often(0.3, f"prestress = {-squeeze!r} %", ""),
        extra=often(0.3, "spin = (30, 20, 10) rad/s", ""),
        fixed=held,
        gravity=often(0.7, 9.81, 0.0),
        orders=often(0.5, push, ""),
    )
    if rng.random() < 0.2 and held:
        text = text.replace(
            "fix near", f"move near by (0, 0, 0.1) mm using sine of {hertz!r} Hz"
        )
    duration = FRAMES * 10.0 ** rng.uniform(-3.0, 2.0) / SWING
    return Cell("all", str(seed), text, duration)


def verdict_of(seed):
    """Return what came of a scene that is run as ``tissuec run`` would."""
    cell = scene(seed)
    compiled, _ = compile_request(Request(Source("scene.tis", cell.text("automatic"))))
    problem = BenchProblem.of(compiled)
    deadline = Deadline(BUDGET)
    network, plan = compiled.network, compiled.plan
    beside = Companion(network, plan, "inline")
    recorder = Recorder(network, plan, MemoryRecording(), tap=beside.tap)
    outcome = run(network, plan, recorder, interrupt=lambda: deadline.is_over)
    if outcome.kind != "done":
        return "slow" if outcome.kind == "interrupted" else "refused"
    if beside.estimate(outcome.statistics).since is not None:
        return "warned"
    known = find_known(problem, BUDGET)
    if not known.judges:
        return "unknown"
    whole = np.searchsorted(problem.times, beside.times)
    assert len(whole) > 10  # or nothing would be compared
    error = problem_at(problem, whole).error(beside._own, known.truth.position[whole])
    return "kept" if error <= 10.0 * TOLERANCE else f"silently off by {error:.1e}"


def problem_at(problem, rows):
    return replace(problem, times=problem.times[rows])


@pytest.mark.parametrize(
    "first",
    [
        22,
        *(
            pytest.param(first, marks=pytest.mark.slow)
            for first in (*range(2, 22, 10), *range(32, 202, 10))
        ),
    ],
)
def test_no_scene_is_silently_wrong(first):
    try:
        verdicts = {seed: verdict_of(seed) for seed in range(first, first + 10)}
    except OutOfTime:
        verdicts = {}
    wrong = {seed: found for seed, found in verdicts.items() if found.startswith("silently")}
    assert not wrong
    assert list(verdicts.values()).count("kept") >= 3, verdicts
