"""``tissuec validate`` as users meet it: text, JSON and exit codes."""

import json

import pytest
from click.testing import CliRunner

from tests.validate.scenes import rod
from tissuec.cli import group
from tissuec.cli import validate as command
from tissuec.core.structs import replace
from tissuec.validate import stepping
from tissuec.validate import validation as module
from tissuec.validate.engine_run import observe


@pytest.fixture
def call(tmp_path):
    """Return a function that validates a text with options; gives the exit code and outputs."""

    def call(text, *options):
        path = tmp_path / "scene.tis"
        path.write_text(text, encoding="utf-8")
        result = CliRunner().invoke(
            group, ["validate", str(path), *options], standalone_mode=False
        )
        if result.exception is not None:
            raise result.exception
        return result.return_value, result.stdout, result.stderr

    return call


def test_kept_promise_is_a_table_on_stdout_and_talk_on_stderr(call):
    code, out, err = call(rod())
    assert code == 0
    headings = ["quantity", "error", "limit", "relative", "to", "worst", "at"]
    assert out.splitlines()[0].split() == headings
    for expected in ("position", "energy balance", "velocity", "force of right"):
        assert expected in out
    assert "PASS: errors are within their limits (tolerance 0.0001)" in out
    assert err.splitlines()[0] == "run …"
    assert "reference, DOP853 with rtol 1e-07 …" in err


def test_quiet_leaves_only_the_report(call):
    code, out, err = call(rod(), "-q")
    assert (code, err) == (0, "")
    assert "PASS: errors are within their limits" in out


def test_json_gives_all_numbers(call):
    code, out, _ = call(rod(rupture="allowed"), "--json", "--method", "LSODA", "--rtol", "1e-9")
    document = json.loads(out)
    assert code == 0
    assert document["ok"] is True
    assert document["verdict"] == "kept"
    assert document["tolerance"] == 1e-4
    assert document["output_times"] == document["compared_times"] == 31
    names = [quantity["name"] for quantity in document["quantities"]]
    assert names[:3] == ["position", "energy balance", "velocity"]
    for quantity in document["quantities"]:
        assert set(quantity) == {
            "name", "error", "bound", "expected", "scale", "time", "kept", "node",
        }  # fmt: skip
    assert set(document["ruptures"]) == set(document["triggers"])
    assert document["ruptures"]["misses"] == []
    assert document["run"]["accepted"] > 0
    assert document["run"]["wall_time"] > 0.0
    reference = document["reference"]
    assert (reference["method"], reference["rtol"]) == ("LSODA", 1e-9)
    assert reference["steps"] > 0
    assert 0.0 < reference["uncertainty"] < 1e-5
    assert reference["compared_with"]["rtol"] == pytest.approx(1e-8)


def test_broken_promise_ends_with_one(call, monkeypatch):
    def bent(*arguments):
        run = observe(*arguments)
        return replace(run, position=run.position * 1.001)

    monkeypatch.setattr(module, "observe", bent)
    code, out, _ = call(rod())
    assert code == 1
    assert "FAIL: errors exceed their limits" in out
    assert "above the limit 0.0001" in out


def test_undecided_promise_ends_with_one(call):
    text = rod(method="integrator is automatic; tolerance = 1e-8")
    code, out, _ = call(text, "--method", "RK23", "--rtol", "1e-4")
    assert code == 1
    assert "UNDECIDED: errors cannot be checked for the whole run" in out
    assert "position, whole run" in out


def test_fixed_step_ends_with_zero(call):
    code, out, _ = call(rod(method="integrator is velocity verlet; step = 0.1 ms"))
    assert code == 0
    assert "NOT CHECKED: errors have no limits with a fixed step" in out


def test_run_that_diverges_ends_with_three(call):
    text = rod(method="integrator is velocity verlet; step = 20 ms")
    code, out, _ = call(text)
    assert code == 3
    assert "the run could not continue" in out
    code, out, _ = call(text, "--json")
    document = json.loads(out)
    assert (code, document["ok"], document["verdict"]) == (3, False, "diverged")


def test_wrong_text_ends_with_two(call):
    code, _, err = call("language 1\nbody {")
    assert code == 2
    assert "error[" in err
    code, out, _ = call("language 1\nbody {", "--json")
    assert code == 2
    assert json.loads(out)["diagnostics"]


def test_parameters_can_be_set(call):
    text = rod().replace("language 1", "language 1\nparam far = 2 mm").replace(
        "(2, 0, 1) mm", "(far, 0 mm, 1 mm)"
    )  # fmt: skip
    code, out, _ = call(text, "--set", "far=5 mm", "--json")
    scale = json.loads(out)["quantities"][0]["scale"]
    assert code == 0
    assert scale > 1e-3


def test_solver_that_cannot_go_on_ends_with_one(call, monkeypatch):
    monkeypatch.setattr(stepping, "LARGEST_FULL", 3)
    code, _, err = call(rod(), "--method", "LSODA")
    assert code == 1
    assert "LSODA keeps a full matrix" in err
    code, out, _ = call(rod(), "--method", "LSODA", "--json")
    assert json.loads(out)["verdict"] == "undecided"


def test_solvers_offered_are_those_of_the_reference():
    assert command.METHODS == stepping.METHODS
