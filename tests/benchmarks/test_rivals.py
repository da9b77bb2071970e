"""Other solvers on our forces come to the engine's motion; so does MuJoCo on its own."""

import json
from importlib.util import find_spec
from math import inf

import numpy as np
import pytest
from click.testing import CliRunner

from benchmarks.rivals import by_mujoco
from benchmarks.rivals.__main__ import main
from benchmarks.rivals.by_cvode import CvodeSolver
from benchmarks.rivals.by_scipy import EXPLICIT, IMPLICIT, SciPySolver
from benchmarks.rivals.ratios import time_at
from benchmarks.rivals.scales import MotionScales
from tests.validate.scenes import rod
from tissuec.analysis.bench import MeasuredPoint, chosen
from tissuec.analysis.bench_solvers import (
    BenchProblem,
    Deadline,
    EngineSolver,
    OutOfTime,
    SolverFailed,
)
from tissuec.core.source import Source
from tissuec.core.structs import replace
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

RESTING = """language 1
tissue gum { spring constant = 40 N/m; viscosity = 2 mN*s/m; mass = 1 g }
body net { mesh is sheet { corner = (0, 0, 0) mm; first edge = (20, 0, 0) mm
  second edge = (0, 20, 0) mm; columns = 3; rows = 3; diagonals is both }; tissue is gum }
set wall = nodes of net where x < 1 mm
set tip = nodes of net where x > 19 mm
environment { gravity = (0, 0, -9.81) m/s^2; damping = 1 mN*s/m }
script { at 0 s: { fix wall; push tip with (10, 0, 5) mN } }
simulate { duration = 50 ms }
output { trajectory every 5 ms }
"""


def problem_of(text):
    compiled, _ = compile_request(Request(Source("scene.tis", text)))
    return BenchProblem.of(compiled)


def solved(problem, tolerance=1e-9, method="dop853"):
    return EngineSolver(problem, method).solve(tolerance, Deadline(inf)).position


def follows_the_script(kind, text, method, tolerance):
    """Check a solver against the engine's; return its run."""
    problem = problem_of(text)
    truth = solved(problem)
    solver = kind(problem, method, MotionScales.of(problem, truth))
    run = solver.solve(tolerance, Deadline(inf))
    # Errors per step add up; the methods of low order take the most steps.
    assert problem.error(run.position, truth) < 1e-4
    return run


@pytest.mark.parametrize("method", [*EXPLICIT, *IMPLICIT])
@pytest.mark.parametrize("text", [rod(), RESTING], ids=["driven by a script", "resting"])
def test_solvers_of_scipy_follow_the_script(method, text):
    assert follows_the_script(SciPySolver, text, method, 1e-7).evaluations > 10


@pytest.mark.skipif(find_spec("sksundae") is None, reason="needs scikit-sundae")
@pytest.mark.parametrize("method", ["BDF", "Adams"])
@pytest.mark.parametrize("text", [rod(), RESTING], ids=["driven by a script", "resting"])
def test_cvode_follows_the_script(method, text):
    follows_the_script(CvodeSolver, text, method, 1e-8)


@pytest.mark.skipif(find_spec("mujoco") is None, reason="needs MuJoCo")
def test_tendons_of_mujoco_are_the_same_springs():
    problem = problem_of(RESTING)
    trial = by_mujoco.MujocoSolver(problem, "RK4").solve(1e-6, Deadline(inf))
    assert problem.error(trial.position, solved(problem)) < 1e-6


def test_mujoco_is_not_asked_what_it_cannot_do():
    assert by_mujoco.refusal(problem_of(RESTING)) == ""
    assert "0 s" in by_mujoco.refusal(problem_of(rod()))
    sine = RESTING.replace("(10, 0, 5) mN", "(10, 0, 5) mN using sine of 20 Hz")
    assert "time-dependent force" in by_mujoco.refusal(problem_of(sine))


def test_the_engine_gives_up_at_a_deadline():
    problem = problem_of(RESTING.replace("50 ms", "5000 s"))
    with pytest.raises(OutOfTime):
        EngineSolver(problem, "velocity verlet").solve(1e-9, Deadline(0.0))


def test_solvers_of_scipy_give_up_at_a_deadline():
    problem = problem_of(RESTING)
    with pytest.raises(OutOfTime):
        SciPySolver(problem, "RK45", MotionScales(1e-3, 1.0)).solve(1e-9, Deadline(0.0))


def test_a_method_that_is_not_for_viscosity_is_no_point():
    with pytest.raises(SolverFailed, match="viscosity"):
        EngineSolver(problem_of(RESTING), "srkn11").solve(1e-4, Deadline(inf))


def test_names_of_solvers_know_no_capitals():
    solvers = [EngineSolver(problem_of(RESTING), name) for name in ("automatic", "dop853")]
    assert chosen(solvers, ["DOP853"]) == [solvers[1]]
    assert chosen(solvers, []) == solvers


def test_errors_count_as_a_tolerance_does():
    problem = problem_of(RESTING)
    truth = solved(problem)
    assert problem.error(truth, truth) == 0.0
    bent = problem.network.position + 1.01 * (truth - problem.network.position)
    assert problem.error(bent, truth) == pytest.approx(0.01, rel=1e-6)
    assert problem.error(np.full_like(truth, np.nan), truth) == np.inf


def test_times_are_found_between_points():
    blank = MeasuredPoint("a", True, 1e-2, 1e-2, 1.0, 1, np.zeros(0))
    points = [blank, replace(blank, error=1e-4, seconds=4.0)]
    points.append(replace(blank, error=1e-3, seconds=9.0))  # beaten by another
    assert time_at(points, "a", 1e-3, 0.0) == pytest.approx(2.0)
    assert time_at(points, "a", 1e-1, 0.0) == 1.0
    assert time_at(points, "a", 1e-5, 0.0) is None
    assert time_at(points, "a", 1e-3, 1e-3) == pytest.approx(4.0)


@pytest.fixture
def measured(tmp_path):
    """Return a function that measures a text; gives the document or the text."""

    def measured(text, *options):
        path = tmp_path / "scene.tis"
        path.write_text(text, encoding="utf-8")
        words = [str(path), "--tolerances", "1e-2,1e-4", "--repeat", "1", *options]
        ran = CliRunner().invoke(main, words, standalone_mode=False)
        assert ran.exception is None and ran.return_value == 0
        return json.loads(ran.stdout) if "--json" in options else ran.stdout

    return measured


def test_other_solvers_are_measured_and_compared(measured):
    methods = ("--method", "dop853", "--method", "scipy rk45")
    found = measured(rod(), *methods, "--json")
    assert [(p["method"], p["ours"]) for p in found["points"]] == [
        ("dop853", True), ("dop853", True), ("SciPy RK45", False), ("SciPy RK45", False),
    ]  # fmt: skip
    assert found["ok"] and found["ratios"][0]["best_other"][0] == "SciPy RK45"
    text = measured(rod(), *methods)
    assert "method      tolerance  error" in text and "times at the same error" in text


def test_what_cannot_be_asked_is_said(measured):
    method = ("--method", "dop853")
    assert "whose times are not known in advance" in measured(rod(rupture="allowed"), *method)
    if find_spec("sksundae") is None:
        assert 'pip install "tissuec[bench]"' in measured(rod(), *method)
