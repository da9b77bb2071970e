"""The companion run tells the error of a run, and whether anybody can know better."""

import os
import re
import time
import warnings

import h5py
import numpy as np
import pytest

import tissuec
from tests.engine.execution.test_run import OMEGA, oscillator
from tests.hand_net import chain
from tests.hand_plan import make_plan
from tissuec.cli import companion as command
from tissuec.compiled import loading
from tissuec.core.errors import SimulationError, TissueWarning
from tissuec.core.source import Source
from tissuec.engine import run_arrays
from tissuec.engine.execution import companion
from tissuec.engine.execution.companion import Companion, launcher
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run import run
from tissuec.pipeline import compile_request, simulate
from tissuec.results.promise import Promise
from tissuec.results.trajectory import Trajectory
from tissuec.scene.request import Request


def accompany(network, plan):
    """Run a plan with a companion; return its frames and the estimate."""
    beside, recording = Companion(network, plan, "inline"), MemoryRecording()
    ran = run(network, plan, Recorder(network, plan, recording, tap=beside.tap)).statistics
    return recording.frame_arrays(), beside.estimate(ran)


def statistics_of(network, plan):
    """Return what the engine does in a run without a companion."""
    return run(network, plan, Recorder(network, plan, MemoryRecording())).statistics


@pytest.mark.parametrize(
    ("method", "tolerance", "step"),
    [("velocity verlet", 1e-3, None), ("velocity verlet", None, 0.01), ("trbdf2", 1e-3, None)],
)
def test_the_difference_is_about_the_error_against_the_closed_form(method, tolerance, step):
    network = oscillator()
    plan = make_plan(network, 2.0, every=0.1, integrator=method, tolerance=tolerance, step=step)
    (time, position, *_), estimate = accompany(network, plan)
    exact = 0.8 + 0.2 * np.cos(OMEGA * time)
    # The lighter of the two masses, 1 and 3 kg, has three quarters of the error of the length.
    error = 0.75 * np.abs(position[:, 1, 0] - position[:, 0, 0] - exact).max()
    assert estimate.state == ("kept" if step is None else "not checked")
    # Orders of 2: a companion of a quarter of the error is three quarters of the error away.
    assert 0.5 * error < estimate.apart[-1] < 1.2 * error
    assert np.isfinite(estimate.allowed) == (step is None)


SWINGING = """language 1
tissue cord { mass = 1 g; spring constant = 50 N/m; viscosity = 1 mN*s/m }
body pair { mesh is explicit; tissue is cord }
table nodes of pair in mm with columns "id x vx in m/s" { 1 0 0; 2 11 0.05 }
table springs of pair in mm with columns "a b rest length" { 1 2 10 }
set wall = nodes of pair in [1]
environment { gravity = (0, 0, 0) m/s^2 }
script { at 0 s: fix wall }
simulate { duration = 0.1 s; tolerance = 1e-4; integrator is trbdf2 }
output { trajectory every 2 ms }
"""


def test_what_has_come_back_by_the_first_frame_has_moved(tmp_path):
    """Within 2 ms the node goes 25 um and back: errors are not relative to what is left."""
    run = simulated(tmp_path, scene=SWINGING)
    assert run.estimate.state == "kept"
    assert 1e-6 < run.estimate.relative[-1] < 3e-5


def test_nothing_is_promised_of_a_run_resumed_after_the_last_recorded_time():
    network = oscillator()
    plan = make_plan(network, 0.1, every=0.1, tolerance=1e-3)
    estimate = Companion(network, plan, "inline").estimate(statistics_of(network, plan))
    assert estimate.state == "not checked" and "resumed" in estimate.reason


def test_a_chaotic_motion_is_recognised_and_from_when_on():
    velocity = np.random.default_rng(0).normal(size=(5, 3)) * 5.0
    network = chain(5, mass=0.1, stiffness=300.0, rest=1.0, velocity=velocity)
    plan = make_plan(
        network, 12.0, gravity=(0.0, -9.81, 0.0), every=0.1, tolerance=1e-6, ledger=False
    )
    _, estimate = accompany(network, plan)
    assert estimate.state == "unknown"
    assert "chaotic" in estimate.reason
    assert 0.5 < estimate.since < 12.0
    assert estimate.relative[-1] > 1e3 * estimate.allowed


#: A sheet that stands on its edge, and falls in folds.
CRUMPLING = """language 1
tissue gel { spring constant = 1.6 N/m; density = 1000 kg/m^3; retardation time = 1 ms }
body wall {
  mesh is sheet {
    corner = (0, 0, 0) mm; first edge = (20, 1, 0) mm; second edge = (0, 1, 20) mm
    columns = 6; rows = 6; diagonals is both
  }
  tissue is gel
  thickness = 1 mm
}
set foot = nodes of wall where z < 1 mm
environment { gravity = (0, 0, -9.81) m/s^2 }
script { at 0 s: fix foot }
simulate { duration = 1 s }
output { position of wall every 10 ms }
"""


def test_of_walls_that_crumple_the_way_out_is_told():
    with pytest.warns(tissuec.TissueWarning, match="wall does not resist bending and crumples"):
        tissuec.run(CRUMPLING, companion="inline")
    soft = CRUMPLING.replace("thickness = 1 mm", "thickness = 1 mm; bending is soft")
    elastic = CRUMPLING.replace("spring constant = 1.6 N/m", "Young's modulus = 2 kPa")
    elastic = elastic.replace("; diagonals is both", "")
    membrane = elastic.replace("thickness = 1 mm", "thickness = 1 mm; bending is none")
    for text, is_limp in ((CRUMPLING, True), (soft, False), (membrane, True), (elastic, False)):
        network = tissuec.compile(text).network
        assert companion._is_limp(network, network.bodies[0]) == is_limp
    assert not companion._is_limp(chain(3), chain(3).bodies[0])


def test_steps_that_are_too_large_are_told_from_chaos_by_trying():
    """A run that was stepped more coarsely than promised is inaccurate, not chaotic."""
    network = oscillator()
    plan = make_plan(network, 2.0, every=0.1, integrator="velocity verlet", tolerance=1e-4)
    coarse = make_plan(network, 2.0, every=0.1, integrator="velocity verlet", tolerance=1e-1)
    beside = Companion(network, plan, "inline")
    recorder = Recorder(network, coarse, MemoryRecording(), tap=beside.tap)
    estimate = beside.estimate(run(network, coarse, recorder).statistics)
    assert estimate.state == "broken"
    assert estimate.promise.startswith("broken from 0.")
    assert estimate.reason == "write tolerance = 2.5e-05 or integrator is dop853"


@pytest.mark.parametrize(("error", "state"), [(0.9, "kept"), (1.2, "broken")])
def test_errors_near_the_tolerance_are_decided_by_a_third_run(error, state, monkeypatch):
    """A companion with a quarter of the error is only three quarters of it away."""
    network = oscillator()
    plan = make_plan(network, 2.0, every=0.1, tolerance=1e-6)

    def wrong_by(part):
        beside = Companion(network, plan, "inline")
        run(network, plan, Recorder(network, plan, MemoryRecording(), tap=beside.tap))
        beside._own += part * (beside._own - network.position)
        return beside

    def stepped(network, plan, times, factor, **more):
        return wrong_by(error * 1e-6 / factor)._own

    ran = statistics_of(network, plan)
    beside = wrong_by(error * 1e-6)
    monkeypatch.setattr(companion, "stepped", stepped)
    assert beside.estimate(ran).state == state


def test_a_wrong_companion_does_not_make_a_run_look_inaccurate(monkeypatch):
    """Its first steps are off by five tolerances, and its smaller ones by nothing."""
    network = oscillator()
    plan = make_plan(network, 2.0, every=0.1, tolerance=1e-4)
    beside = Companion(network, plan, "inline")
    ran = run(network, plan, Recorder(network, plan, MemoryRecording(), tap=beside.tap))
    moved = beside._own - network.position

    def stepped(network, plan, times, factor, **more):
        return beside._own + (5e-4 if factor == companion.FINER else 0.0) * moved

    monkeypatch.setattr(companion, "stepped", stepped)
    estimate = beside.estimate(ran.statistics)
    assert estimate.state == "kept" and estimate.error < 1e-4  # what is told is what decided
    assert (np.diff(estimate.relative) >= 0.0).all()


PAIR = """language 1
tissue cord { spring constant = 40 N/m; viscosity = 0 N*s/m; mass = 10 g }
body pair { mesh is explicit; tissue is cord }
table nodes of pair in mm with columns "id x" { 1 0; 2 11 }
table springs of pair in mm with columns "a b rest length" { 1 2 10 }
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 0.5 s; tolerance = 1e-5 }
output { trajectory every 10 ms }
"""


def simulated(folder, scene=PAIR, **options):
    request = Request(Source("pair.tis", scene))
    compiled, _ = compile_request(request)
    return simulate(compiled, folder / "pair.vtkhdf", request=request, **options)


@pytest.mark.parametrize("mode", ["auto", "inline", "process"])
def test_a_result_holds_the_same_promise_whoever_steps_the_companion(tmp_path, mode):
    result = simulated(tmp_path, companion=mode)
    with Trajectory.open(result.path) as trajectory:
        promise = trajectory.promise
    assert str(promise) == "kept"
    assert 0.0 < promise.error < promise.tolerance == 1e-5
    inline = simulated(tmp_path, companion="inline").estimate
    assert promise.error == inline.error
    with h5py.File(result.path) as file:
        steps = file["/tissuec/errors/value"][:, 0]
        assert len(steps) == 51 and (np.diff(steps) >= 0.0).all() and steps[-1] > 0.0
        assert file["/tissuec/companion/value"][-1, 0] == result.estimate.apart[-1]


def test_the_wall_time_of_a_run_is_one_number_without_that_of_the_estimate(
    tmp_path, monkeypatch
):
    estimate = Companion.estimate
    monkeypatch.setattr(
        Companion,
        "estimate",
        lambda *given, **more: (time.sleep(0.6), estimate(*given, **more))[1],
    )
    result = simulated(tmp_path, companion="inline")
    with Trajectory.open(result.path) as trajectory:
        assert trajectory.manifest["wall_time"] == result.outcome.wall_time < 0.6


def test_a_process_that_is_refused_is_replaced_by_this_one(tmp_path, monkeypatch):
    def refuse(*arguments, **options):
        raise PermissionError("no further process")

    monkeypatch.setattr(companion.subprocess, "Popen", refuse)
    assert simulated(tmp_path, companion="process").estimate.state == "kept"


def test_a_process_that_is_killed_leaves_the_run_as_it_is(tmp_path, monkeypatch):
    start = Companion._start

    def killed(self, launch):
        start(self, launch)
        self._process.kill()

    monkeypatch.setattr(Companion, "_start", killed)
    result = simulated(tmp_path, companion="process")
    assert result.outcome.kind == "done"
    assert result.estimate.promise == "unknown from 0 s"
    assert "companion run ended" in result.estimate.reason


def test_one_permitted_core_is_enough(tmp_path, monkeypatch):
    monkeypatch.setattr(companion, "permitted", lambda: 1)
    monkeypatch.setattr(companion, "KNOWN", 0.0)
    monkeypatch.setattr(companion, "STARTING", 0.0)
    monkeypatch.setattr(companion.subprocess, "Popen", None)
    assert simulated(tmp_path).estimate.state == "kept"


def test_what_is_switched_off_or_not_recorded_is_not_checked(tmp_path):
    off = simulated(tmp_path, companion="off").estimate
    assert off.promise == "not checked"
    assert "switched off" in off.reason
    network = oscillator()
    plan = make_plan(network, 1.0, ledger=False)
    nothing = Companion(network, plan).estimate(statistics_of(network, plan))
    assert nothing.promise == "not checked"


def test_python_tells_a_promise_that_is_not_kept():
    chaotic = PAIR.replace("1 0; 2 11", "1 0; 2 10; 3 20; 4 30").replace(
        "1 2 10", "1 2 10; 2 3 10; 3 4 10"
    )
    chaotic = chaotic.replace('"id x"', '"id x vy in m/s"').replace(
        "1 0; 2 10; 3 20; 4 30", "1 0 0; 2 10 3; 3 20 0; 4 30 -2"
    )
    chaotic = chaotic.replace("duration = 0.5 s", "duration = 2.6 s")
    with pytest.warns(TissueWarning, match="positions"):
        found = tissuec.run(chaotic)
    assert found.promise.state in ("broken", "unknown")
    with pytest.raises(SimulationError, match=r"after "):
        tissuec.run(chaotic, strict=True)


def test_a_result_that_says_nothing_of_it_promises_nothing():
    assert str(Promise.of({})) == "not checked"


@pytest.mark.parametrize("is_orphan", [False, True])
def test_a_companion_whose_run_was_killed_removes_what_it_has_made(
    tmp_path, monkeypatch, is_orphan
):
    folder = tmp_path / "companion"
    folder.mkdir()
    request = Request(Source("pair.tis", PAIR))
    launcher((request, 1))(folder)
    compiled, _ = compile_request(request)
    found = Companion(compiled.network, compiled.plan).tap
    np.save(folder / companion.ROWS, found.position)
    np.save(folder / companion.TABLE, found.table)
    (folder / companion.ORDER).write_text(
        '{"method": "rkn4", "spacing": 0, "factor": 4, "every": 1}'
    )
    parents = iter([2])  # and then init
    monkeypatch.setattr(os, "getppid", lambda: next(parents, 1 if is_orphan else 2))
    command.step_companion(folder)
    assert folder.exists() != is_orphan


@pytest.mark.parametrize(("translating", "starts"), [(0.0, True), (1.9, False)])
def test_a_short_run_gets_no_process_because_kernels_were_translated(
    translating, starts, monkeypatch
):
    now, started = [0.0, 0.0], []
    monkeypatch.setattr(companion.clock, "monotonic", lambda: now[0])
    monkeypatch.setattr(loading, "time_of_translating", lambda: now[1])
    monkeypatch.setattr(companion, "permitted", lambda: 2)
    monkeypatch.setattr(Companion, "_start", lambda self, launch: started.append(launch))
    network = oscillator()
    plan = make_plan(network, 2.0, every=0.1)
    ran = statistics_of(network, plan)
    beside = Companion(network, plan, launch=launcher(None))
    now[:] = [2.0, translating]
    beside.tick(0.5, ran)
    assert bool(started) is starts


def test_a_net_at_rest_has_no_energy_that_could_drift(tmp_path):
    """Rounding alone makes energies of 1e-33 J, which are no measure of others."""
    resting = SWINGING.replace("0.05", "0").replace("2 11", "2 10").replace("trbdf2", "rkc2")
    resting = resting.replace("1 mN*s/m", "2 N*s/m") + "expect energy drift < 1e-6 over run\n"
    outcome = simulated(tmp_path, scene=resting).outcome
    assert len(outcome.held) == 1 and not outcome.failures


BLOCK = """language 1
tissue gum { spring constant = 200 N/m; viscosity = 0 N*s/m; mass = 0.2 g }
body block {
  made of springs
  mesh is lattice { kind is sodium chloride; cell = 5 mm; reach is second neighbours
                    box from (0, 0, 0) mm to (20, 10, 10) mm }
  tissue is gum
}
set base = nodes of block where x < 0.1 mm
set tip = nodes of block where x > 19.9 mm
environment { gravity = (0, 0, 0) m/s^2 }
script { at 0 s: { fix base; change velocity of tip to (0, 0, SPEED) m/s } }
simulate { duration = 20 ms; tolerance = 1e-9 }
output { trajectory every 0.4 ms }
"""


def promise_of(text):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return tissuec.run(text, companion="inline").promise


def test_steps_of_small_motions_are_put_down_to_rounding_no_more_than_tolerances_allow(
    monkeypatch,
):
    text = BLOCK.replace("SPEED", "1e-3")
    assert promise_of(text).state == "kept"
    monkeypatch.setattr(run_arrays, "LEAST_ROUNDING", run_arrays.ROUNDING)
    assert promise_of(text).state == "broken"  # of the companion, where the run is right


def test_rounding_is_told_from_chaos():
    text = BLOCK.replace("SPEED", "1e-5")
    found = promise_of(text)
    assert found.state == "unknown"
    assert "rounding errors of the coordinates" in found.reason
    (way_out,) = re.findall(r"write tolerance = (\S+)", found.reason)
    assert promise_of(text.replace("1e-9", way_out)).state == "kept"


def test_errors_of_a_net_that_hardly_moves_are_told_to_be_relative_to_its_size():
    found = promise_of(PAIR.replace("2 11", "2 10.0000000000001"))
    assert found.state == "kept"
    assert found.least == pytest.approx(1e-8)  # of 10 mm
    assert "of 10 nm, a millionth of the size" in found.sentence
    assert promise_of(PAIR).least is None
