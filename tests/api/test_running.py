"""Scenes run from Python: parameters, places of results, and how runs end."""

import gc
import os
import signal
import threading
import warnings
from pathlib import Path

import numpy as np
import pytest

import tissuec
from tests.api.scenes import FLYING, PULL
from tissuec.engine.execution.companion import Companion
from tissuec.results import kept_open


def last(trajectory, name="bob"):
    return trajectory.position[-1, trajectory.nodes_of(name)[0]]


def test_a_text_a_path_and_the_name_of_a_file_give_the_same_motion(tmp_path):
    file = tmp_path / "pull.tis"
    file.write_text(PULL)
    runs = [tissuec.run(scene) for scene in (PULL, file, str(file))]
    first = runs[0].position[:]
    assert all(np.array_equal(run.position[:], first) for run in runs)
    assert [run.scene for run in runs] == ["scene", str(file), str(file)]


def test_options_that_a_run_does_not_have_are_refused():
    with pytest.raises(ValueError, match='must be one of "auto", "process", "inline", "off"'):
        tissuec.run(PULL, companion="maybe")
    with pytest.raises(ValueError, match="threads must be 1 or more, not 0"):
        tissuec.run(PULL, threads=0)


@pytest.mark.parametrize("lines", ["language 1; x", "language 1"])
def test_a_line_that_begins_with_language_is_a_text(lines):
    assert all(finding.code != "TIS604" for finding in tissuec.check(lines))


GIVEN = [
    ({"stretch_time": "0.05 s"}, "stretch time = 0.05 s"),
    ({"stretch_time": 0.05}, "stretch time = 0.05 s"),
    ({"stretch_time": np.float32(0.0625)}, "stretch time = 0.0625 s"),
    ({"params": {"Stretch  time": 0.05}}, "stretch time = 0.05 s"),
    ({"pull": 1}, "pull = 1 m"),
    ({"pull": 1e-05}, "pull = 1e-05 m"),
    ({"pull": 1e-300}, "pull = 1e-300 m"),
    ({"way": (0, 1.5, -1)}, "way = (0, 1.5, -1)"),
    ({"way": np.array([0.0, 1.0, 0.0])}, "way = (0, 1, 0)"),
]


@pytest.mark.parametrize(("given", "written"), GIVEN, ids=str)
def test_values_are_written_as_the_command_line_takes_them(given, written):
    text = PULL.replace(" between 0 mm and 2 mm", "")
    text = text.replace("expect", "# expect")
    assert list(tissuec.run(text, **given).manifest["overrides"]) == [written]


def test_numbers_are_meant_in_si_units_to_the_last_digit():
    pull = 0.1e-3 / 3.0
    place = last(tissuec.run(PULL.replace("expect", "# expect"), pull=pull))
    assert place[0] == pytest.approx(0.02 + pull, rel=1e-12)


@pytest.mark.parametrize(
    ("unit", "value", "shown"),
    [("Hz", 30.0, "30 1/s"), ("m^3", 2.0, "2 m^3"), ("kg*m/s^3", 2.0, "2 kg*m*s^-3")],
)
def test_a_number_takes_the_dimension_of_its_param(unit, value, shown):
    text = PULL.replace("param pull", f"param odd = 1 {unit}\nlet even = odd * 2\nparam pull")
    compiled = tissuec.compile(text, odd=value) if unit else None
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        (odd,) = [p for p in compiled.scene.constants.parameters() if p.name == "odd"]
    assert str(odd.value) == shown
    assert odd.overridden


WRONG = [
    ({"pull": float("nan")}, "pull must be a finite number, not nan"),
    ({"pull": np.inf}, "pull must be a finite number, not inf"),
    ({"pull": True}, "pull = True is not a text"),
    ({"pull": None}, "pull = None is not a text"),
    ({"way": (1, 2)}, r"way = \(1, 2\) is not a text"),
    ({"stretch_time": 1, "params": {"stretch time": 2}}, '"stretch time" is given twice'),
]


@pytest.mark.parametrize(("given", "message"), WRONG, ids=str)
def test_what_is_no_value_is_a_plain_value_error(given, message):
    with pytest.raises(ValueError, match=message):
        tissuec.run(PULL, **given)


CAUGHT = [
    ({"pull": "3 mm"}, "TIS308", "pull = 3 mm is not between 0 m and 2 mm"),
    ({"pull": 3e-3}, "TIS308", "pull = 3 mm is not between 0 m and 2 mm"),
    ({"pull": "1 s"}, "TIS502", "1 | pull = 1 s\n  |        ^^^"),
    ({"pull": (1, 2, 3)}, "TIS312", "pull must be one number"),
    ({"pul": 1.0}, "TIS505", 'did you mean "pull"?'),
]


@pytest.mark.parametrize(("given", "code", "message"), CAUGHT, ids=str)
def test_the_scene_judges_values_as_it_judges_those_of_the_command_line(given, code, message):
    with pytest.raises(tissuec.CompileError) as caught:
        tissuec.run(PULL, **given)
    assert f"error[{code}]" in str(caught.value)
    assert message in str(caught.value)


def test_a_compile_error_is_all_findings_with_their_places():
    text = PULL.replace("40 N/m", "40 N").replace("cut far spring", "cut fra spring")
    with pytest.raises(tissuec.CompileError) as caught:
        tissuec.run(text)
    told = str(caught.value)
    assert "--> scene:5:33\n" in told and "\n  |                                 ^^^^\n" in told
    assert "error[TIS301]" in told and told.count("error[") == 2
    assert told == "\n\n".join(map(str, tissuec.check(text)))


def test_all_that_is_wrong_is_told_also_when_params_are_given():
    text = PULL.replace("40 N/m", "40 N").replace("cut far spring", "cut fra spring")
    with pytest.raises(tissuec.CompileError) as caught:
        tissuec.run(text, pull=1e-3)
    assert len(caught.value.diagnostics) == 2


def test_a_good_scene_has_no_findings_and_a_missing_file_is_one():
    assert tissuec.check(PULL, pull=2e-3) == []
    (finding,) = tissuec.check("there is none.tis")
    assert (finding.code, finding.severity) == ("TIS604", "error")


def test_warnings_of_the_text_are_warnings_of_the_line_that_ran_it():
    text = PULL.replace("param pull", "param idle = 3\nparam pull")
    with pytest.warns(tissuec.TissueWarning, match='param "idle" is never used') as caught:
        tissuec.run(text)
    assert caught[0].filename == __file__
    with pytest.raises(tissuec.CompileError, match="W501"):
        tissuec.run(text, strict=True)


def test_a_run_that_cannot_go_on_says_so_or_is_an_error():
    with pytest.warns(tissuec.TissueWarning, match=r"scene: .*settle"):
        trajectory = tissuec.run(FLYING)
    assert not trajectory.finished and "settle" in trajectory.outcome
    assert trajectory.times[-1] == pytest.approx(0.1, abs=0.011)
    with pytest.raises(tissuec.SimulationError, match=r"scene: .*settle"):
        tissuec.run(FLYING, strict=True)


def test_an_expectation_that_fails_says_so_or_is_an_error():
    with pytest.warns(tissuec.TissueWarning, match="failed at 120 ms: position"):
        trajectory = tissuec.run(PULL, pull="0.5 mm")
    (judged,) = trajectory.expectations
    assert (judged.state, judged.time, judged.place) == ("fails", 0.12, "scene:20")
    assert judged.expect == PULL.splitlines()[-1]
    with pytest.raises(tissuec.ExpectationError, match=r"scene:20: expect position\(bob"):
        tissuec.run(PULL, pull="0.5 mm", strict=True)


def folders(tmp_path):
    return [path for path in tmp_path.iterdir() if path.name.startswith("tissuec-")]


@pytest.fixture
def temporary(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    return tmp_path


def test_a_temporary_result_lasts_as_long_as_what_is_returned(temporary):
    trajectory = tissuec.run(PULL)
    (folder,) = folders(temporary)
    assert [path.name for path in folder.iterdir()] == ["scene.vtkhdf"]
    assert trajectory.path.parent == folder
    del trajectory
    gc.collect()
    assert folders(temporary) == []


def test_arrays_and_logs_outlive_the_trajectory_that_they_came_from(temporary):
    position, log = tissuec.run(PULL).position, tissuec.run(PULL).logs["position of bob"]
    tension = tissuec.run(PULL).tension
    gc.collect()
    assert position[-1, 2, 0] == log.value[-1, 0] == pytest.approx(0.021)
    assert np.isnan(tension[-1, 1]) and np.isfinite(tension[0]).all()


def test_more_results_can_be_kept_than_files_be_open(temporary, monkeypatch):
    """Those read last are open; a log keeps the folder of a result that is gone."""
    monkeypatch.setattr(kept_open, "MOST_OPEN", 2)
    before = len(kept_open._open)
    kept = [tissuec.run(PULL, pull=f"{pull} mm") for pull in (0.5, 1.0, 1.5, 2.0)]
    logs = [one.logs["position of bob"] for one in kept]
    for _ in range(2):
        ends = [log.value[-1, 0] for log in logs]
        assert ends == pytest.approx([0.0205, 0.021, 0.0215, 0.022], abs=1e-9)
        assert len(kept_open._open) <= max(before, 2)
    kept.clear()
    gc.collect()
    assert len(folders(temporary)) == 4
    assert logs[0].value[-1, 0] == ends[0]
    logs.clear()
    gc.collect()
    assert folders(temporary) == []


def test_a_kept_result_is_not_mixed_with_one_that_replaces_it(tmp_path, monkeypatch):
    monkeypatch.setattr(kept_open, "MOST_OPEN", 1)
    out = tmp_path / "a.vtkhdf"
    first = tissuec.run(PULL, out=out)
    second = tissuec.run(PULL, out=out, pull="2 mm")  # the first cannot be opened again
    tissuec.run(PULL, out=tmp_path / "b.vtkhdf")
    for one, end in ((first, 0.021), (second, 0.022)):
        assert one.position[-1, 2, 0] == pytest.approx(end, abs=1e-9)
    other = tissuec.load(tmp_path / "b.vtkhdf")  # which closes the second
    assert other.position[-1, 2, 0] == pytest.approx(0.021, abs=1e-9)
    out.unlink()
    with pytest.raises(tissuec.ResultError, match="cannot be read"):
        _ = second.velocity[:]


def fail(time):
    raise ZeroDivisionError


@pytest.mark.parametrize("options", [{"pull": "0.5 mm", "strict": True}, {"progress": fail}])
def test_a_run_that_fails_leaves_no_temporary_file(temporary, options):
    with pytest.raises((tissuec.ExpectationError, ZeroDivisionError)):
        tissuec.run(PULL, **options)
    gc.collect()
    assert folders(temporary) == []


def test_a_result_can_be_given_a_place_or_saved_to_one(tmp_path):
    given = tissuec.run(PULL, out=tmp_path / "new" / "a.vtkhdf")
    assert given.path == tmp_path / "new" / "a.vtkhdf"
    saved = tissuec.run(PULL).save(tmp_path / "b.vtkhdf")
    with tissuec.load(saved) as read:
        assert np.array_equal(read.position[:], given.position[:])
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(tissuec.PlaceError, match="not a result of tissuec"):
        given.save(tmp_path / "notes.txt")
    with pytest.raises(tissuec.PlaceError, match="is this result itself"):
        given.save(given.path)
    with pytest.raises(tissuec.PlaceError, match="not a result of tissuec"):
        tissuec.run(PULL, out=tmp_path / "notes.txt")
    assert (tmp_path / "notes.txt").read_text() == "mine"


def test_surfaces_are_saved_with_what_shows_them(tmp_path):
    text = """language 1
use "tissues/muscle"
body ball {
  mesh is sphere { centre = (0, 0, 0) mm; radius = 5 mm; subdivisions = 1; interior is spokes }
  tissue is muscle
}
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 1 ms }
output { surface of ball every 1 ms }
"""
    trajectory = tissuec.run(text)
    trajectory.save(tmp_path / "ball.vtkhdf")
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "ball.ball.vtkhdf",
        "ball.vtkhdf",
    ]
    assert "surfaces: ball" in repr(trajectory)


def test_progress_goes_to_whom_it_is_told(capfd):
    times = []
    tissuec.run(PULL, progress=times.append)
    assert times[-1] == 0.2 and times == sorted(times)
    tissuec.run(PULL, progress=True)
    assert "scene" not in capfd.readouterr().out


@pytest.mark.usefixtures("interruptible")
def test_an_interrupted_run_is_a_keyboard_interrupt_and_can_be_resumed(tmp_path):
    whole = tissuec.run(PULL)
    out = tmp_path / "a.vtkhdf"

    def press(time):
        if time > 0.05 and not pressed:
            pressed.append(time)
            signal.raise_signal(signal.SIGINT)

    pressed = []
    assert threading.current_thread() is threading.main_thread()
    with pytest.raises(KeyboardInterrupt, match="can be resumed"):
        tissuec.run(PULL, out=out, progress=press)
    assert pressed and not out.exists()
    begun = tissuec.load(out.with_name("a.partial.vtkhdf"))
    assert not begun.finished and len(begun.times) < len(whole.times)
    assert begun.expectations[0].state == "not reached"
    begun.close()
    resumed = tissuec.run(PULL, out=out, resume=True)
    assert np.array_equal(resumed.position[:], whole.position[:])
    assert resumed.expectations[0].state == "holds"


@pytest.mark.usefixtures("interruptible")
@pytest.mark.skipif(os.name == "nt", reason="ends by signals")
@pytest.mark.parametrize(
    ("number", "error"), [(signal.SIGINT, KeyboardInterrupt), (signal.SIGTERM, SystemExit)]
)
def test_a_signal_during_the_companion_run_ends_the_program_and_keeps_the_result(
    number, error, tmp_path, monkeypatch
):
    estimate = Companion.estimate

    def interrupted(self, *given, **named):
        signal.raise_signal(number)
        return estimate(self, *given, **named)

    monkeypatch.setattr(Companion, "estimate", interrupted)
    out = tmp_path / "a.vtkhdf"
    with pytest.raises(error) as raised:
        tissuec.run(PULL, out=out, companion="inline")
    if error is SystemExit:
        assert raised.value.code == 128 + number
    with tissuec.load(out) as whole:
        assert whole.finished
        # The companion of a short run may have come to the end all the same.
        assert whole.promise.state in ("unknown", "kept")


def test_a_library_can_be_given(tmp_path):
    (tmp_path / "own").mkdir()
    start = PULL.index("tissue cord")
    end = PULL.index("\n", start)
    (tmp_path / "own" / "cords.tis").write_text(f"language 1\n{PULL[start:end]}\n")
    text = PULL[:start] + 'use "own/cords"' + PULL[end:]
    assert tissuec.check(text)[0].code == "TIS601"
    trajectory = tissuec.run(text, libraries=[tmp_path])
    assert trajectory.provenance["mass"][0].span.place == "own/cords.tis:2"


def test_every_run_tells_its_promise():
    assert tissuec.run(PULL).promise.state == "kept"
    assert tissuec.run(PULL, companion="off").promise.state == "not checked"


def test_a_compiled_scene_has_arrays_and_names_for_solvers_of_ones_own():
    compiled = tissuec.compile(PULL)
    network = compiled.network
    assert network.springs.ends.tolist() == [[0, 1], [1, 2]]
    assert compiled.nodes_of("bob").tolist() == [2]
    assert compiled.nodes_of("pair").tolist() == [0, 1, 2]
    assert compiled.springs_of("Far  Spring").tolist() == [1]
    assert compiled.springs_of("pair").tolist() == [0, 1]
    with pytest.raises(ValueError, match='did you mean "bob"'):
        compiled.nodes_of("bobb")
    with pytest.raises(ValueError, match='no nodes called "far spring"'):
        compiled.nodes_of("far spring")


def test_the_present_folder_is_where_relative_names_lead(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("pull.tis").write_text(PULL)
    assert tissuec.run("pull.tis", out="pull.vtkhdf").path == Path("pull.vtkhdf")
    assert len(tissuec.load("pull.vtkhdf").times) == 21


PINT = """body dot { mesh is explicit }
table nodes of dot in mm with columns "id x mass in g" { 1 0 1; 2 5 1 }
set one = nodes of dot where id == 1
environment { gravity = (0, 0, 0) m/s^2 }
script {
  at 0 s: fix dot
  from 0 s to 0.1 s: move one by (lift, push / (1 N/m), 0) + way using smooth profile
}
simulate { duration = 0.1 s }
output { trajectory every 0.1 s }
"""


def test_quantities_of_pint_are_values_of_params():
    ureg = pytest.importorskip("pint").UnitRegistry()
    text = "param lift = 1 mm\nparam push = 1 mN\nparam way = (1, 0, 0) mm\n"
    scene = f"language 1\n{text}" + PINT
    given = {"lift": 0.3 * ureg.cm, "push": 2e-3 * ureg.newton, "way": [0, 0, 2] * ureg.mm}
    with tissuec.run(scene, params=given) as found:
        assert found.manifest["overrides"] == [
            "lift = 0.003 m", "push = 0.002 kg*m/s^2", "way = (0, 0, 0.002) m"
        ]  # fmt: skip
        assert found.position[-1, 0] == pytest.approx([0.003, 0.002, 0.002])
    with pytest.raises(tissuec.CompileError, match="must be a length"):
        tissuec.run(scene, params={"lift": 1 * ureg.newton})
