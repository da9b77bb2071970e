"""``tissuec bench`` as users meet it: a table, JSON and exit codes."""

import json
import re
import subprocess
import sys

import pytest
from click.testing import CliRunner

from tests.validate.scenes import rod
from tissuec.analysis.bench_solvers import EngineSolver
from tissuec.cli import group
from tissuec.core.errors import TissueError

#: Ends with 3 where threads are restricted before NumPy is loaded, with 4 where after.
EARLY = """import sys
from tissuec.cli import bench

def seen():
    raise SystemExit(4 if "numpy" in sys.modules else 3)

bench.use_one_thread = seen
bench.command(["scene.tis"], standalone_mode=False)
"""
SMALL = ("--tolerances", "1e-2,1e-4", "--repeat", "1", "--method", "dop853")


@pytest.fixture
def call(tmp_path):
    """Return a function that benches a text with options; gives the exit code and outputs.

    Nothing here depends on how long a run takes.
    """

    def call(text, *options):
        path = tmp_path / "scene.tis"
        path.write_text(text, encoding="utf-8")
        result = CliRunner().invoke(
            group, ["bench", str(path), *options], standalone_mode=False
        )
        if result.exception is not None:
            raise result.exception
        return result.return_value, result.stdout, result.stderr

    return call


def test_every_point_is_in_the_document(call):
    code, out, _ = call(rod(), "--json", *SMALL, "--method", "Velocity Verlet")
    found = json.loads(out)
    assert (code, found["ok"]) == (0, True)
    assert [(p["method"], p["tolerance"]) for p in found["points"]] == [
        ("dop853", 1e-2), ("dop853", 1e-4),
        ("velocity verlet", 1e-2), ("velocity verlet", 1e-4),
    ]  # fmt: skip
    assert found["reference"]["uncertainty"] < 1e-6
    for point in found["points"]:
        assert point["error"] < 100.0 * point["tolerance"]
        assert point["seconds"] > 0.0
        assert point["evaluations"] > 0


def test_threads_are_restricted_before_numpy_is_loaded():
    assert subprocess.run([sys.executable, "-c", EARLY], check=False).returncode == 3


def test_text_is_a_table_of_points(call):
    code, out, err = call(rod(), *SMALL)
    assert code == 0
    assert "method  tolerance  error" in out
    assert err.startswith("reference: dop853 at 1e-06, for up to ")


def test_each_run_is_announced_before_it_and_its_result_is_told(call, monkeypatch):
    said = []

    def solve(self, tolerance, deadline, solve=EngineSolver.solve):
        said.append(solve)
        return solve(self, tolerance, deadline)

    monkeypatch.setattr(EngineSolver, "solve", solve)
    monkeypatch.setattr("tissuec.cli.common.Settings.say", lambda self, text: said.append(text))
    call(rod(), "--tolerances", "1e-2,1e-4", "--repeat", "1", "--method", "dop853")
    runs = [number for number, one in enumerate(said) if callable(one)]
    assert len(runs) == 6  # the reference, a second opinion, and each point twice
    assert all(isinstance(said[number - 1], str) for number in runs)
    assert any(
        re.fullmatch(r"  0\.01: .* s, \d+ evaluations", one)
        for one in said
        if isinstance(one, str)
    )


def test_unknown_solver_is_an_error_with_a_hint(call):
    with pytest.raises(TissueError, match="did you mean"):
        call(rod(), "--method", "dop835", "--repeat", "1")


@pytest.mark.parametrize("tolerances", ["1e-2;1e-3", "2", "nan"])
def test_wrong_tolerances_are_refused(call, tolerances):
    with pytest.raises(Exception, match=r"tolerance|numbers"):
        call(rod(), "--tolerances", tolerances)


def test_wrong_text_ends_with_two(call):
    assert call("language 1\nbody {")[0] == 2


def test_plot_without_matplotlib_names_the_extra_before_the_work(call, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "matplotlib.figure", None)
    with pytest.raises(TissueError, match=r"tissuec\[plot\]"):
        call(rod(), "--plot", "curves.png", "--budget", "1e-9")


def test_plot_is_written(call, tmp_path):
    pytest.importorskip("matplotlib")
    call(rod(), *SMALL, "--plot", str(tmp_path / "curves.png"))
    assert (tmp_path / "curves.png").read_bytes().startswith(b"\x89PNG")


def test_a_format_that_cannot_be_drawn_is_told_before_the_work(call):
    pytest.importorskip("matplotlib")
    with pytest.raises(TissueError, match=r"ends with \.words"):
        call(rod(), "--plot", "curves.words", "--budget", "1e-9")
