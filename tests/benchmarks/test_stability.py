"""The stress test: nothing at the ends of what can be written is silently wrong or crashes."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from benchmarks.stability import __main__ as command
from benchmarks.stability import grid, looking, verdict
from benchmarks.stability.cells import TOLERANCE, Cell, all_cells, tube
from benchmarks.stability.known import Known, find_known
from benchmarks.stability.verdict import Court
from tissuec.analysis.bench_solvers import BenchProblem, EngineSolver
from tissuec.core.source import Source
from tissuec.core.structs import replace
from tissuec.engine.integrators import INTEGRATORS
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

BUDGET = 2.0
QUICK = ("automatic", "dop853", "velocity verlet")
SMALL, FULL = list(all_cells(small=True)), list(all_cells(small=False))
REST = Cell("rest", "1", tube(), 0.05)


def bad_verdicts(cell, methods):
    """Return what is silently wrong or crashed on a scene, one line each."""
    court = Court(cell, BUDGET)
    found = [court.judge(method) for method in methods]
    return [f"{v.method}: {v.why}" for v in found if v.kind in grid.BAD]


@pytest.mark.parametrize("cell", SMALL, ids=lambda c: f"{c.axis} {c.value}")
def test_nothing_is_silently_wrong(cell):
    assert not bad_verdicts(cell, QUICK)


@pytest.mark.slow
@pytest.mark.parametrize("cell", FULL, ids=lambda c: f"{c.axis} {c.value}")
def test_nothing_of_the_full_grid_is_silently_wrong(cell):
    assert not bad_verdicts(cell, ("automatic", *INTEGRATORS))


def compiled(text):
    return compile_request(Request(Source("scene.tis", text)))[0]


def judged(monkeypatch, cell=REST, **changes):
    """Return the verdict on a run whose look was changed."""

    def bent(problem, plan, deadline):
        found, why = looking.look(problem, plan, deadline)
        return replace(found, **changes), why

    monkeypatch.setattr(verdict, "look", bent)
    return Court(cell, BUDGET).judge("dop853")


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"finite": False}, "no numbers"),
        ({"imbalance": 1e-3}, "energy is off"),
        ({"drift": 1e-3}, "momentum is off"),
    ],
)
def test_what_is_wrong_without_a_word_is_found_out(monkeypatch, changes, why):
    found = judged(monkeypatch, **changes)
    assert found.kind == "wrong"
    assert why in found.why


def moved(problem, budget):
    """Return a reference whose last positions are a millimetre off."""
    known = find_known(problem, budget)
    position = known.truth.position.copy()
    position[-1] += 1e-3
    return Known(replace(known.truth, position=position, apart=0.0), False)


def test_positions_that_are_off_are_found_out(monkeypatch):
    monkeypatch.setattr(verdict, "find_known", moved)
    found = Court(REST, BUDGET).judge("dop853")
    assert (found.kind, found.why[:17]) == ("wrong", "positions are off")


def test_a_twin_that_tells_of_positions_that_are_off_excuses(monkeypatch):
    class Solver(EngineSolver):
        def solve(self, tolerance, deadline):
            trial = super().solve(tolerance, deadline)
            trial.position[-1] += 1e-3 if tolerance < TOLERANCE else 0.0
            return trial

    monkeypatch.setattr(verdict, "find_known", moved)
    monkeypatch.setattr(verdict, "EngineSolver", Solver)
    found = Court(REST, BUDGET).judge("dop853")
    assert (found.kind, found.why[:13]) == ("warned", "a finer run i")


def test_a_warning_excuses(monkeypatch):
    (cell,) = [c for c in FULL if c.value == "no rest length"]
    found = judged(monkeypatch, cell, finite=False)
    assert (found.kind, found.why[:4]) == ("warned", "W304")


def test_what_stops_with_a_sentence_is_refused():
    cell = Cell("step × ω", "3", tube(), 0.2, step=0.015)
    assert Court(cell, BUDGET).judge("dop853").kind == "refused"


def test_a_crash_is_told(monkeypatch):
    def crash(problem, plan, deadline):
        raise ZeroDivisionError("by nothing")

    monkeypatch.setattr(verdict, "look", crash)
    found = Court(REST, BUDGET).judge("dop853")
    assert (found.kind, found.why) == ("crash", "ZeroDivisionError: by nothing")


def test_what_is_not_for_viscosity_and_what_takes_long_are_no_verdicts():
    assert Court(REST, BUDGET).judge("srkn11").kind == "none"
    long = Cell("frame × ω", "1e6", tube(), 1e6)
    assert Court(long, 0.1).judge("velocity verlet").kind == "slow"


def test_a_collapsing_tube_is_known_to_be_chaotic():
    (cell,) = [c for c in all_cells(small=False) if c.value == "-99 %"]
    assert find_known(BenchProblem.of(compiled(cell.text("dop853"))), BUDGET).is_chaotic
    assert not find_known(BenchProblem.of(compiled(REST.text("dop853"))), BUDGET).is_chaotic


def test_a_twin_differs_by_a_little():
    problem = BenchProblem.of(compiled(REST.text("dop853")))
    apart = looking.shaken(problem, 1e-9).network.position - problem.network.position
    assert 1e-9 < np.abs(apart).max() < 1e-8


def test_map_is_a_table_with_the_scenes_of_what_is_bad(tmp_path):
    good = Court(REST, BUDGET).judge("automatic")
    stress = grid.Stress(("automatic",), (good, replace(good, kind="wrong", why="it is off")))
    lines = grid.as_markdown(stress).splitlines()
    assert lines[0] == "| axis | value | automatic |"
    assert lines[2:4] == ["| rest | 1 | ok |", "| rest | 1 | WRONG |"]
    assert "| WRONG | 1 | silently wrong |" in lines
    assert "rest 1, `automatic`: it is off" in lines
    assert "language 1" in lines
    pytest.importorskip("matplotlib")
    from tissuec.view.plots import draw
    from tissuec.view.plots.formats import save

    save(draw("stability", grid.as_dict(stress)), tmp_path / "map.png")
    assert (tmp_path / "map.png").stat().st_size > 1000


def test_command_prints_the_map_and_ends_with_one_for_what_is_bad(monkeypatch):
    monkeypatch.setattr(command, "all_cells", lambda *, small: [REST])
    words = ["--method", "dop853", "--json"]
    result = CliRunner().invoke(command.main, words)
    document = json.loads(result.stdout)
    assert (result.exit_code, document["ok"], document["bad"]) == (0, True, 0)
    monkeypatch.setattr(grid, "BAD", ("good",))
    result = CliRunner().invoke(command.main, words[:-1])
    assert result.exit_code == 1
    assert result.stdout.startswith("| axis | value | dop853 |")


def test_a_method_that_promises_nothing_is_measured_at_a_step_that_suits_it():
    found = Court(REST, BUDGET).judge("propagation")
    assert (found.kind, "step = " in found.scene) == ("measured", True)
    # First order, 0.5 / ω being its frame: some per cent of the motion.
    assert 1e-4 < found.error < 0.2
    assert grid.sign_of(found) == f"{found.error:.0e}"
