"""Rows of a study are what single runs are: the same numbers, or the reason why not."""

import numpy as np
import pytest

import tissuec
from tests.engine.execution.test_doubts import SOLID
from tests.every import every
from tests.study.scenes import SCENE, STUDY, carried_out, prepared
from tests.test_cli import tissuec as command
from tissuec.api.study_table import read_table
from tissuec.core.workers.workers import OwnProcess
from tissuec.studies.report import summary
from tissuec.studies.study import run_study
from tissuec.view.report.study import render_study

pytestmark = pytest.mark.filterwarnings("ignore::tissuec.TissueWarning")


def largest(log):
    """Return the largest value of a log, at samples and on both sides of events."""
    sides = (log.value, log.jumps.before, log.jumps.after)
    return np.linalg.norm(np.concatenate(sides), axis=1).max()


def test_each_row_is_a_run_with_its_values():
    table = carried_out().table
    assert table.column("lift").values.tolist() == [2, 2, 4, 4, 6, 6]
    assert table.column("tissue of bar").values == ("spring", "stiff spring") * 3
    assert set(table.outcome) == {"done"} and set(table.promise) == {"kept"}
    assert (table.error < 1e-4).all()
    for row, (lift, tissue) in enumerate([("2 mm", "spring"), ("4 mm", "stiff spring")]):
        row *= 3
        result = tissuec.run(SCENE, params={"lift": lift, "tissue of bar": tissue})
        log = result.logs["force of hand"]
        force = np.linalg.norm(log.value, axis=1)
        assert table.column("pull").numbers[row] == pytest.approx(largest(log), rel=1e-12)
        at = np.searchsorted(result.times, 0.15)
        place = result.position[at][1, 0]
        assert table.column("place").numbers[row] == pytest.approx(place, rel=1e-12)
        (curve,) = table.curves
        assert curve.values[row] == pytest.approx(force[::50], rel=1e-12)
        assert curve.times == pytest.approx([0, 0.05, 0.1, 0.15, 0.2])


def test_observing_does_not_change_the_motion():
    few = carried_out("measure end = last(position of middle along (1, 0, 0))").table
    text = SCENE + STUDY.replace(
        "measure pull", "measure many = max(speed of middle)\n measure pull"
    )
    many = carried_out(
        "measure end = last(position of middle along (1, 0, 0))", text=text
    ).table
    assert np.array_equal(few.column("end").numbers, many.column("end").numbers)


def test_the_time_of_an_event_is_that_of_the_run_and_empty_without_it():
    table = carried_out("vary lift = [4 mm, 20 mm]").table
    tear = table.column("tear").numbers
    assert np.isnan(tear[:2]).all() and (tear[2:] > 0.0).all()
    result = tissuec.run(SCENE, lift="20 mm")
    first = next(event for event in result.events if event.kind == "rupture")
    assert tear[2] == pytest.approx(first.time, rel=1e-9)


@every(
    ("written", "expected"),
    [
        ("min(position of tip along (1, 0, 0))", 0.02),
        ("first(position of tip along (1, 0, 0))", 0.02),
        ("last(position of tip along (1, 0, 0))", 0.022),
        ("mean(position of tip along (1, 0, 0)) from 0 s to 0.1 s", 0.021),
        ("max(position(tip along (1, 0, 0)) - 20 mm) until 50 ms", 0.001),
        ("distance of foot to tip at 0.1 s", 0.022),
        ("position(tip along (1, 0, 0), 0.1 s) - 20 mm", 0.002),
        ("max(distance(foot, tip)) every 10 ms", 0.022),
    ],
)
def test_measures_have_the_values_of_the_prescribed_motion(written, expected):
    table = carried_out("vary lift = [2 mm]", "vary tissue of bar = [spring]",
                        f"measure asked = {written}").table  # fmt: skip
    assert table.column("asked").numbers[0] == pytest.approx(expected, abs=2e-6)


def test_a_run_whose_values_are_refused_is_a_row_that_says_why():
    text = SCENE.replace("id == 2", "x > lift * 3") + STUDY
    table = carried_out("vary lift = [2 mm, 8 mm]", text=text).table
    assert table.outcome == ("done", "done", "refused", "refused")
    assert "no nodes" in table.reason[2] or "empty" in table.reason[2], table.reason[2]
    assert np.isnan(table.column("pull").numbers[2:]).all()
    assert "\n" not in table.reason[2]


def test_a_run_that_its_script_ends_says_so():
    text = SCENE.replace("script {", "script {\n  at 0.05 s: end the run") + STUDY
    table = carried_out("measure end = last(position of tip along (1, 0, 0))", text=text).table
    assert set(table.outcome) == {"ended"}
    assert "end the run" in table.reason[0]
    assert table.column("end").numbers[0] == pytest.approx(0.021, abs=1e-5)
    assert np.isnan(table.column("place").numbers).all()


def test_a_run_that_diverges_is_a_row():
    step = ("vary integrator = [velocity verlet]", "vary step = [0.1 ms, 100 ms]")
    table = carried_out("vary lift = [2 mm]", "vary tissue of bar = [spring]", *step).table
    assert table.outcome[0] == "done" and table.promise[0] == "not checked"


def test_without_error_estimate_nothing_is_promised():
    table = carried_out("error estimate is off").table
    assert set(table.promise) == {"not checked"} and np.isnan(table.error).all()


def test_one_at_a_time_shows_what_the_scene_has_by_itself():
    table = carried_out("design is one at a time").table
    assert table.column("lift").values.tolist() == [2, 2, 4, 6, 2, 2]
    assert table.column("tissue of bar").values == ("spring",) * 5 + ("stiff spring",)
    assert table.column("pull").numbers[0] == table.column("pull").numbers[1]


def test_expectations_are_about_all_runs():
    found = carried_out(
        "expect max(pull) < 1 N and share(tear < 1 s) > 10 %",
        "expect quantile(pull, 0.5) > 1 N",
        "expect mean(lift) == 4 mm",
    )
    assert [verdict.holds for verdict in found.verdicts] == [True, False, True]
    assert found.verdicts[1].measured.startswith("quantile(pull, 0.5) = ")


def test_results_of_runs_are_kept_on_demand(tmp_path):
    ready = prepared(
        "keep is results", "vary lift = [2 mm, 3 mm]", "vary tissue of bar = [spring]"
    )
    table = run_study(ready, OwnProcess(), out=tmp_path / "table.csv").table
    files = sorted(path.name for path in (tmp_path / "table.runs").iterdir())
    assert files == ["run_00000.vtkhdf", "run_00001.vtkhdf"]
    result = tissuec.load(tmp_path / "table.runs" / files[1])
    assert result.manifest["overrides"] == ["lift = 3 mm", "tissue of bar is spring"]
    assert list(result.logs) == ["force of hand"]
    pull = largest(result.logs["force of hand"])
    assert table.column("pull").numbers[1] == pytest.approx(pull, rel=1e-12)


def test_nothing_is_written_that_nobody_asked_for(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    carried_out("vary lift = [2 mm]")
    assert list(tmp_path.iterdir()) == []


def test_python_takes_numbers_in_si_units():
    table = tissuec.study(
        SCENE,
        vary={"lift": np.array([0.001, 0.002]), "tissue_of_bar": ["spring", "stiff spring"]},
        measure={"pull": "max(force of hand)"},
        workers=1,
    )
    assert table.column("lift").title == "lift [m]"
    assert table.column("lift").values.tolist() == [0.001, 0.001, 0.002, 0.002]
    assert table.column("pull").numbers[1] > 1.9 * table.column("pull").numbers[0]


def test_the_end_of_the_run_is_told_from_that_of_a_motion():
    text = SCENE.replace(
        "  from 0 s to 0.1 s: move",
        "  when position(tip along (1, 0, 0)) > 23 mm: end the run\n  from 0 s to 0.1 s: move",
    )
    table = carried_out(
        "vary lift = [2 mm, 4 mm]", "measure ended = time of end the run",
        "measure moved = time of end", text=text,
    ).table  # fmt: skip
    assert table.outcome == ("done", "ended")
    assert table.column("ended").numbers == pytest.approx([np.nan, 0.075], nan_ok=True)
    assert table.end == pytest.approx([0.2, 0.075])
    assert "0.075" not in table.reason[1] and "75 ms" not in table.reason[1]
    assert table.column("moved").numbers == pytest.approx([0.1, np.nan], nan_ok=True)


def test_doubtful_runs_are_marked_in_table_summary_command_and_report(tmp_path):
    """A block that is pressed flat turns inside out; one that is pressed less does not."""
    study = "study pressing { vary depth = [1 mm, 7 mm]; measure pull = max(force of lid) }"
    (tmp_path / "press.tis").write_text(f"{SOLID}{study}\n")
    path = tmp_path / "press.pressing.csv"
    done = command("study", "press.tis", "--workers", "1", cwd=tmp_path)
    assert "doubtful: 1 run (1 inside out)" in done.stderr
    table = read_table(path)
    assert table.doubts == ("", "inside out")
    assert summary(table, path)["doubtful"] == {"runs": 1, "inside out": 1}
    assert "Doubtful: 1 run (1 inside out)." in render_study(table, path)
