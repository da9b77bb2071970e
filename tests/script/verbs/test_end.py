"""The order to end the run."""

import numpy as np
import pytest

import tissuec
from tests.test_cli import OSCILLATOR
from tests.test_cli import tissuec as tissuec_command
from tests.validate.scenes import compiled_scene, validated
from tissuec.core.errors import ExpectationError
from tissuec.core.structs import replace
from tissuec.engine.execution.companion import Companion
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run import run

ROPE = """language 1
tissue gut {{ spring constant = 2 N/m; viscosity = 1 mN*s/m; breaking force = {strength} }}
body rope {{ mesh is explicit; tissue is gut; rupture is allowed }}
table nodes of rope in mm with columns "id x mass in g" {{
  1 0 4
  2 12 4
  3 20 4
}}
table springs of rope with columns "a b rest length in mm" {{
  1 2 10
  2 3 10
}}
set wall = nodes of rope where id == 1
set tip = nodes of rope where id == 3
environment {{ gravity = (0, 0, 0) m/s^2; contact is off; damping = 0 N*s/m }}
script {{
  at 0 s: fix wall
  at 0.1 s: push tip with (10, 0, 0) mN
  {end}
}}
simulate {{ duration = 0.5 s; {method} }}
output {{ trajectory every 20 ms; position of tip every 1 ms; energy every 10 ms }}
{expect}
"""


def rope(end="", *, strength="1 kN", method="tolerance = 1e-6", expect=""):
    return ROPE.format(end=end, strength=strength, method=method, expect=expect)


def carried_out(text):
    compiled = compiled_scene(text)
    recording = MemoryRecording()
    return run(compiled.network, compiled.plan, Recorder(*_of(compiled), recording)), recording


def _of(compiled):
    return compiled.network, compiled.plan


WHEN = "when position(tip along (1, 0, 0)) > 24 mm: end the run"


def test_a_run_that_is_ended_is_the_beginning_of_one_that_is_not():
    whole, all_rows = carried_out(rope())
    outcome, rows = carried_out(rope("at 0.3 s: end the run"))
    assert (whole.kind, outcome.kind) == ("done", "done")
    assert outcome.state.time == 0.3
    assert outcome.ended.span.text == "end the run"
    assert "ended at 300 ms of 500 ms by scene.tis:" in outcome.message
    time, position = rows.log_arrays("position of tip")
    assert time[-1] == 0.3
    assert len(time) == 301
    expected = all_rows.log_arrays("position of tip")[1][:301]
    # Steps land on 0.3 s in one of them only: apart by no more than both are wrong.
    assert np.abs(position - expected).max() < 2e-6 * 0.01


def test_events_after_the_end_do_not_happen():
    end = "at 0.2 s: end the run\n  at 0.3 s: change gravity to (0, 0, -9.81) m/s^2"
    outcome, _ = carried_out(rope(end))
    assert [event.kind for _, event in outcome.logged_events] == ["fix", "push", "end the run"]


def test_what_stands_behind_it_at_the_same_time_still_happens():
    end = "at 0.2 s: end the run\n  at 0.2 s: fix tip"
    outcome, _ = carried_out(rope(end))
    assert [event.kind for _, event in outcome.logged_events] == [
        "fix",
        "push",
        "end the run",
        "fix",
    ]


@pytest.mark.parametrize(
    "method", ["tolerance = 1e-6", "integrator is relaxation; step = 5 ms"]
)
def test_a_condition_ends_a_run_at_its_time(method):
    outcome, rows = carried_out(rope(WHEN, method=method))
    assert outcome.kind == "done"
    assert 0.1 <= outcome.state.time < 0.5
    tip = outcome.state.position[2, 0]
    assert tip >= 0.024 - 1e-12
    assert rows.log_arrays("position of tip")[0][-1] <= outcome.state.time
    assert rows.energy_arrays()[0][-1] <= outcome.state.time


def test_it_can_end_at_0_s():
    outcome, rows = carried_out(rope("at 0 s: end the run"))
    assert outcome.state.time == 0.0
    assert list(rows.frame_arrays()[0]) == [0.0]


def test_expectations_are_judged_up_to_the_end():
    expect = (
        "expect position(tip) < 1 m over run\n"
        "expect position(tip) < 24.5 mm over run\n"
        "expect position(tip) < 23 mm over run\n"
        "expect position(tip) < 1 m at 0.4 s"
    )
    outcome, _ = carried_out(rope(WHEN, expect=expect))
    assert [failure.expectation for failure in outcome.failures] == [2]
    assert outcome.unreached == (3,)
    assert outcome.held[0][0] == outcome.state.time


def test_its_error_is_estimated_up_to_the_end():
    compiled = compiled_scene(rope(WHEN))
    with Companion(*_of(compiled), "inline") as beside:
        recorder = Recorder(*_of(compiled), MemoryRecording(), tap=beside.tap)
        outcome = run(*_of(compiled), recorder)
        estimate = beside.estimate(outcome.statistics)
    assert estimate.state == "kept"
    assert 0.15 < estimate.times[-1] <= outcome.state.time
    assert 0.0 < estimate.error < 1e-6


def test_a_companion_that_never_meets_the_condition_goes_as_far_as_the_run():
    compiled = compiled_scene(rope(WHEN))
    plan = replace(compiled.plan, triggers=())
    with Companion(compiled.network, plan, "inline") as beside:
        recorder = Recorder(*_of(compiled), MemoryRecording(), tap=beside.tap)
        estimate = beside.estimate(run(*_of(compiled), recorder).statistics)
    assert estimate.state == "kept"


@pytest.mark.parametrize(
    "end",
    [
        "at 0.3 s: end the run",
        WHEN,
        "when count(pieces of rope) > 1: end the run",
        "when speed(tip) > 0.1 m/s: { after 0 s: change viscosity of rope by 2; "
        "after 20.5 ms: end the run }",
    ],
)
def test_scipy_agrees(end):
    found = validated(rope(end, strength="8 mN" if "pieces" in end else "1 kN"))
    assert found.run.outcome.ended is not None
    assert found.verdict == "kept"
    assert found.comparison.quantities[0].error > 0.0
    assert not found.comparison.ruptures.misses
    assert not found.comparison.triggers.misses


def test_a_result_file_says_what_ended_the_run(tmp_path):
    result = tissuec.run(rope(WHEN), out=tmp_path / "end.h5")
    assert result.events[-1].kind == "end the run"
    assert result.events[-1].cause == "end the run"
    assert result.promise.state == "kept"
    assert result.times[-1] < 0.2


def test_the_last_state_is_in_every_table_once(tmp_path):
    result = tissuec.run(rope(WHEN), out=tmp_path / "end.h5")
    end = result.events[-1].time
    assert end % 0.02 > 1e-6 and end % 0.001 > 1e-9  # no sample is due then
    log = result.logs["position of tip"]
    for time in (result.times, log.time, result.energies.time, result.errors.time):
        assert time[-1] == end
        assert np.all(np.diff(time) > 0.0)
    # The condition is met there, to the accuracy with which its time is found.
    assert log.value[-1, 0] == pytest.approx(0.024, rel=1e-9)
    assert result.position[-1][2, 0] == log.value[-1, 0]
    on_time = tissuec.run(rope("at 0.3 s: end the run"))
    assert on_time.times[-2:] == pytest.approx([0.28, 0.3], abs=0.0)
    assert len(on_time.logs["position of tip"].time) == 301


FIBRE = """language 1
tissue band {
  Young's modulus = 100 kPa; density = 1000 kg/m^3; retardation time = 0.1 ms
  strength = 20 kPa
}
body fibre {
  mesh is thread { line from (0, 0, 0) mm to (20, 0, 0) mm; pieces = 4; thickness = 2 mm }
  tissue is band; rupture is allowed
}
set left = nodes of fibre where x == 0 mm
set right = nodes of fibre where x == 20 mm
environment { gravity = (0, 0, 0) m/s^2 }
script {
  at 0 s: fix left
  from 0 s to 0.5 s: move right by (10, 0, 0) mm using constant speed
  when ruptured(fibre): end the run
}
simulate { duration = 0.5 s; tolerance = 1e-3 }
output { force(right) every 50 ms; trajectory every 0.5 s }
study tear {
  vary strength of band = [16 kPa, 20 kPa, 23 kPa]
  measure peak = max(force(right along (1, 0, 0)))
  measure curve = force(right along (1, 0, 0)) every 50 ms
}
"""


PEAKS = np.array([16e3, 20e3, 23e3]) * np.pi * 1e-3**2  # strength times cross-section


def test_the_force_that_tears_a_fibre_is_measured():
    result = tissuec.run(FIBRE)
    # Inertia and viscosity add less than 1e-5 at this speed.
    assert result.logs["force of right"].largest == pytest.approx(PEAKS[1], rel=1e-5)
    assert list(result.times) == [0.0, result.events[-1].time]


def test_a_study_measures_what_is_largest_as_its_runs_end(tmp_path):
    scene = tmp_path / "fibre.tis"
    scene.write_text(FIBRE)
    table = tissuec.study(scene, out=tmp_path / "tear.csv", workers=1)
    assert table.column("peak").numbers == pytest.approx(PEAKS, rel=1e-5)
    # Curves have the same times in all runs, so that rows can be compared.
    (curve,) = table.curves
    assert [np.isfinite(row).sum() for row in curve.values] == [4, 4, 5]
    # Torn at a strain of 16, 20 and 23 % at a rate of 1/s, less the retardation time of 0.1 ms.
    assert table.end == pytest.approx([0.1599, 0.1999, 0.2299], abs=1e-5)


def test_the_largest_force_is_known_wherever_a_fibre_tears_and_however_a_run_goes_on(tmp_path):
    """The force falls later than at the rupture where the first piece to tear is not held."""
    scene = tmp_path / "fibre.tis"
    scene.write_text(FIBRE.replace("  when ruptured(fibre): end the run\n", ""))
    table = tissuec.study(scene, out=tmp_path / "tear.csv", workers=1)
    assert table.column("peak").numbers == pytest.approx(PEAKS, rel=1e-5)


def test_a_static_run_ends_with_the_equilibrium_in_which_the_condition_is_true():
    text = FIBRE.replace("tolerance = 1e-3", "integrator is equilibrium; step = 50 ms")
    text = text.replace("when ruptured(fibre)", "when force(right) > 30 mN")
    result = tissuec.run(text.replace("; rupture is allowed", ""))
    force = result.logs["force of right"].value
    # Closed in on to a part of a step.
    assert force[-1, 0] == pytest.approx(30e-3, rel=1e-3)
    assert result.times[-1] == result.logs["force of right"].time[-1] < 0.5


def test_a_run_that_fails_keeps_its_last_state():
    coarse = OSCILLATOR.replace(
        "tolerance = 1e-6", "integrator is velocity verlet; step = 40 ms"
    )
    long = coarse.replace("duration = 0.5 s", "duration = 50 s").partition("expect")[0]
    outcome, rows = carried_out(long.replace("every 50 ms", "every 50 s"))
    assert outcome.kind == "diverged"
    time, position, *_ = rows.frame_arrays()
    assert list(time) == [0.0, outcome.state.time]
    assert outcome.state.time > 0.1
    assert np.array_equal(position[-1], outcome.state.position)


def test_expectations_that_an_end_leaves_open_are_no_success(tmp_path):
    scene = tmp_path / "rope.tis"
    scene.write_text(rope(WHEN, expect="expect position(tip) < 1 m at 0.4 s"))
    ran = tissuec_command("run", scene, cwd=tmp_path)
    assert ran.returncode == 1
    assert "the run ended before this could be checked" in ran.stderr
    with pytest.raises(ExpectationError, match="ended before"):
        tissuec.run(scene, strict=True)
    scene.write_text(rope(WHEN, expect="expect position(tip) < 1 m over run"))
    assert tissuec_command("run", scene, cwd=tmp_path).returncode == 0


def test_a_stepped_run_logs_the_state_with_which_it_ends():
    run = tissuec.start(rope(WHEN))
    run.step("0.5 s")
    assert run.ended
    time, rows = run.log("position of tip")
    assert time[-1] == run.time
    assert rows[-1, 0] == pytest.approx(0.024, rel=1e-9)


def test_only_the_run_can_be_ended():
    (finding,) = tissuec.check(rope("at 0.1 s: end tip"))
    assert "only the run can" in str(finding)
    assert "end the run" in str(finding)
