"""The command: what it prints where, what it writes and keeps, and its exit codes."""

import json
import shlex
import sys
from pathlib import Path

import pytest

from tests.learn.learnings import BLIND, compiled_of, learnt_of
from tests.test_progress import Terminal
from tissuec.cli import group, run_guarded
from tissuec.core import progress as progress_lines
from tissuec.core.errors import CompileError, Diagnostic
from tissuec.learn.fit import expense, gradient_check, learning, session
from tissuec.learn.fit.gradient_check import Compared
from tissuec.learn.fit.learning import LearnProgress, Unlearnable
from tissuec.measurements.reading import read_experiment
from tissuec.pipeline import check_request
from tissuec.scene.request import Request

GUM = "tissue gum { spring constant = 40 N/m; viscosity = 10 mN*s/m; mass = 10 mg }\n"
END = "expect error(held out) < 5 %\n"
TWO = """learn second {
  data = "one.csv"
  fit = force(pressed) using column "force_N" in N
  adjust viscosity of gum
}
"""


class Learner:
    """Stands in the place of the learning; remembers how it was called."""

    def __init__(self, **changes):
        self.changes, self.calls, self.error = changes, [], None
        self.told = ()

    def __call__(
        self, compiled, fit_problem, request, *, session, state, fresh, progress, workers
    ):
        self.calls.append((fit_problem.name, state, fresh))
        for one in self.told:
            progress(one)
        if isinstance(self.error, KeyboardInterrupt):
            state.write_text("a pass")
        if self.error is not None:
            raise self.error
        state.write_text("the last pass")
        return learnt_of(compiled, **self.changes)


@pytest.fixture
def here(tmp_path, monkeypatch):
    compiled_of(
        tmp_path,
        "adjust spring constant of gum",
        top=GUM,
        tissue="gum",
        fit_problem="gum",
        end=END,
    )
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def call(monkeypatch, capsys):
    """Return a function that runs the command and returns code, stdout and stderr."""

    def run(learner, *arguments):
        monkeypatch.setattr(learning, "learn", learner)
        monkeypatch.setattr(sys, "argv", ["tissuec", "learn", *map(str, arguments)])
        code = run_guarded(group)
        return code, *capsys.readouterr()

    return run


def test_what_was_learnt_is_told_and_written(here, call):
    code, out, err = call(Learner(), "scene.tis")
    assert code == 0
    assert out.startswith("learn gum: the error no longer decreases\n")
    assert err.startswith("warning[W801]: the preset is valid on this mesh only")
    assert err.endswith("\nexpectations: 1 of 1 hold\nwrote learned/gum.tis\n")
    assert check_request(Request.file(here / "learned/gum.tis", strict=True)) == (None, ())
    assert not (here / "learned/gum.tis.learning").exists()


def test_each_file_is_read_once(here, call, monkeypatch):
    files = []

    def read(data, *others):
        files.append(data.path.name)
        return read_experiment(data, *others)

    # The scale of what starts at 0 is chosen with the data.
    text = (
        (here / "scene.tis")
        .read_text()
        .replace("mass = 10 mg", "mass = 10 mg; prestress = 0 %")
    )
    text = text.replace("adjust spring constant of gum", "adjust prestress of gum")
    (here / "scene.tis").write_text(text)
    monkeypatch.setattr(session, "read_experiment", read)
    assert call(learning.learn, "scene.tis", "--anyway", "-q")[0] in (0, 1)
    assert files == ["one.csv", "two.csv"]


def test_a_failed_expectation_exits_with_1(here, call):
    text = (here / "scene.tis").read_text().replace("< 5 %", "< 4 %")
    (here / "scene.tis").write_text(text)
    code, _, err = call(Learner(), "scene.tis", "-q")
    assert code == 1
    assert err.splitlines()[1] == "       error(held out) = 4.2 %"
    assert err.splitlines()[2].startswith("FAILED: 1 expectation failed; no preset is written")
    assert not (here / "learned/gum.tis").exists()
    assert call(Learner(), "scene.tis", "-q", "--anyway")[0] == 1
    assert (here / "learned/gum.tis").exists()


@pytest.mark.parametrize("anyway", [False, True])
def test_what_is_not_identified_is_written_only_if_told_so(here, call, anyway):
    options = ("--anyway",) if anyway else ()
    code, _, err = call(Learner(blind=(BLIND,)), "scene.tis", *options)
    assert code == (0 if anyway else 1)
    assert (here / "learned/gum.tis").exists() is anyway
    assert ("no preset is written (to write it: --anyway)" in err) is not anyway
    # With the passes that are kept, writing anyway costs no learning.
    assert (here / "learned/gum.tis.learning").exists() is not anyway


@pytest.mark.parametrize("strict", [False, True])
def test_a_doubtful_result_is_a_failure_where_warnings_are(here, call, strict):
    said = "the data and the expected value of spring constant differ by 245 of its deviations"
    text = (here / "scene.tis").read_text()
    (here / "scene.tis").write_text(text.replace('write "learned/gum.tis"', ""))  # no W801
    learner = Learner(notes=(said,), doubts=(said,))
    code, _, err = call(learner, "scene.tis", *(["--strict"] if strict else []))
    assert code == int(strict)
    assert (f"FAILED: {said}" in err) is strict


def test_what_is_no_answer_exits_with_1_and_is_not_written(here, call):
    learner = Learner(failure="the error is 98 %, and so on")
    code, _, err = call(learner, "scene.tis")
    assert code == 1 and not (here / "learned/gum.tis").exists()
    assert "FAILED: the error is 98 %, and so on; no preset is written" in err
    code, out, _ = call(learner, "scene.tis", "--anyway", "--json")
    document = json.loads(out)
    assert code == 1 and document["failure"] == "the error is 98 %, and so on"
    assert not document["ok"] and document["written"] == ["learned/gum.tis"]
    text = (here / "learned/gum.tis").read_text()
    assert "FAILED: the error is 98 %" in text


def test_passes_that_ran_out_exit_with_1(here, call):
    changes = {"converged": False, "reason": "200 passes are over"}
    code, out, err = call(Learner(**changes), "scene.tis")
    assert code == 1 and "NOT CONVERGED, 200 passes are over" in out
    assert "FAILED: 200 passes are over; increase passes, or start closer" in err
    assert "no preset is written (to write it: --anyway)" in err
    assert not (here / "learned/gum.tis").exists()
    code, out, err = call(Learner(**changes), "scene.tis", "--anyway")
    assert code == 1 and "FAILED: 200 passes are over" in err and "no preset" not in err
    assert "# end        NOT CONVERGED: 200 passes" in (here / "learned/gum.tis").read_text()


def test_an_interrupted_learning_says_how_to_go_on(here, call):
    learner = Learner()
    learner.error = KeyboardInterrupt()
    arguments = ("scene.tis", "gum", "-o", "my preset.tis", "--anyway", "--fresh")
    code, out, err = call(learner, *arguments)
    assert code == 130 and out == ""
    again = err.splitlines()[-1].removeprefix("  resume with: ")
    # Whoever goes on does not begin anew.
    assert shlex.split(again) == ["tissuec", "learn", *arguments[:-1]]
    learner.error = None
    code, _, err = call(learner, *shlex.split(again)[2:])
    assert code == 0 and "resumes from my preset.tis.learning" in err
    assert learner.calls[0][1:] == (Path("my preset.tis.learning"), True)
    assert learner.calls[1][1:] == (Path("my preset.tis.learning"), False)


def test_wrong_data_exits_with_2_and_what_cannot_be_computed_with_3(here, call):
    learner = Learner()
    learner.error = CompileError([Diagnostic("TIS604", "no such file", None)])
    code, _, err = call(learner, "scene.tis")
    assert code == 2 and "TIS604" in err
    learner.error = Unlearnable("the motion is not finite after 0.3 s")
    code, _, err = call(learner, "scene.tis")
    assert code == 3 and err.endswith("error: the motion is not finite after 0.3 s\n")
    code, out, err = call(learner, "scene.tis", "--json")
    assert code == 3 and err == ""
    assert json.loads(out)["error"] == "the motion is not finite after 0.3 s"


def test_a_wrong_text_exits_with_2(here, call):
    (here / "scene.tis").write_text("language 1\nbody {\n")
    learner = Learner()
    code, _, err = call(learner, "scene.tis")
    assert code == 2 and "error[" in err and not learner.calls


def test_a_file_of_ones_own_is_not_lost_and_no_time_is_spent(here, call):
    (here / "learned").mkdir()
    (here / "learned/gum.tis").write_text("language 1\n")
    learner = Learner()
    code, _, err = call(learner, "scene.tis")
    assert code == 2 and "was not written by learning" in err and not learner.calls
    code, _, err = call(learner, "scene.tis", "-o", "scene.tis", "--force")
    assert code == 2 and "is the input file" in err and not learner.calls
    assert call(learner, "scene.tis", "--force")[0] == 0
    assert call(learner, "scene.tis")[0] == 0  # now it is one of learning


VOCABULARY = """language 1
property firmness from 0 to 1 { evenly = [soft, medium, hard] }
quantity spring constant from 2 N/m to 2000 N/m on log scale {
  low = triangle(2 N/m, 20 N/m, 200 N/m); high = triangle(20 N/m, 200 N/m, 2000 N/m)
  applies to each spring
}
rules gum {
  if firmness is soft then spring constant is low
  if firmness is hard then spring constant is high
  if firmness is medium then spring constant is low
  if firmness is medium then spring constant is high
}
"""


def test_what_can_be_written_is_known_before_anything_is_learnt(tmp_path, call, monkeypatch):
    """The vocabulary contradicts itself (W204) from the start, which keeps nobody from it."""
    (tmp_path / "words.tis").write_text(VOCABULARY)
    compiled_of(
        tmp_path,
        "adjust words of spring constant",
        top='use "./words"\ntissue gum { described in gum; firmness is medium\n'
        "  viscosity = 10 mN*s/m; mass = 10 mg }\n",
        tissue="gum",
        fit_problem="gum",
    )
    monkeypatch.chdir(tmp_path)
    learner = Learner()
    code, _, err = call(learner, "scene.tis", "-o", "preset.tis")
    assert code == 2 and not learner.calls
    assert '"words.tis" was not written by learning and would be overwritten' in err
    code, _, err = call(learner, "scene.tis")
    assert code == 0 and len(learner.calls) == 1, err


def test_one_block_of_several_can_be_named(here, call):
    path = here / "scene.tis"
    path.write_text(path.read_text() + TWO)
    learner = Learner()
    assert call(learner, "scene.tis", "Second")[0] == 0
    assert [name for name, *_ in learner.calls] == ["second"]
    # Without a preset, passes are kept in the present folder.
    assert learner.calls[0][1].name == "scene.second.learning"
    assert call(learner, "scene.tis")[0] == 0
    assert [name for name, *_ in learner.calls[1:]] == ["gum", "second"]
    code, _, err = call(learner, "scene.tis", "secund")
    assert code == 2 and 'did you mean "second"?' in err
    code, _, err = call(learner, "scene.tis", "-o", "other.tis")
    assert code == 2 and "give its name, too" in err


def test_a_scene_without_a_learn_block_is_refused(here, call):
    text = (here / "scene.tis").read_text()
    (here / "scene.tis").write_text(text[: text.index("learn gum")])
    code, _, err = call(Learner(), "scene.tis")
    assert code == 2 and '"scene.tis" has no learn block' in err


def test_json_is_one_document(here, call):
    code, out, err = call(Learner(), "scene.tis", "--json")
    document = json.loads(out)
    assert code == 0 and err == ""
    assert document["ok"] and document["learn"] == "gum" and document["identified"]
    assert document["written"] == ["learned/gum.tis"]
    assert document["estimates"][0]["start"] == [40.0]


@pytest.mark.parametrize(("apart", "code"), [(1e-9, 0), (1e-3, 1)])
def test_derivatives_are_held_against_differences(here, call, monkeypatch, apart, code):
    rows = [
        Compared("direction 1", 1.0, 1.0 + apart, apart),
        Compared("direction 2", -2.0, -2.0, 0.0),
    ]
    monkeypatch.setattr(gradient_check, "check_gradient", lambda *_: rows)
    learner = Learner()
    found, out, _ = call(learner, "scene.tis", "--check-gradient")
    assert found == code and not learner.calls
    lines = out.splitlines()
    assert lines[0].split("  ")[0] == "derivative by" and len(lines) == 4
    word = "good" if code == 0 else "WRONG"
    assert lines[-1].startswith(f"learn gum: derivatives are {word}: 2 directions, at worst ")


def test_many_runs_are_announced(here, call, monkeypatch):
    monkeypatch.setattr(expense, "MANY", 20)
    learner, said = Learner(), "derivatives are finite differences, which take about 20 runs"
    assert said not in call(learner, "scene.tis")[2]
    text = (here / "scene.tis").read_text()
    (here / "scene.tis").write_text(text.replace("fix pressed", "fix pressed; at 2 ms: settle"))
    assert said in "".join(call(learner, "scene.tis")[1:])


def test_the_line_tells_passes_errors_and_the_time_left(here, call, monkeypatch):
    learner = Learner()
    learner.told = (
        LearnProgress(2, 10, 0.25, 3.0, 60.0, 0.042, 5.0),
        LearnProgress(0, 10, 1.0, 0.0, 0.0, None, 0.1),
    )
    monkeypatch.setenv("COLUMNS", "200")
    monkeypatch.setattr(progress_lines, "FIRST_AFTER", 0.0)
    monkeypatch.setattr(progress_lines, "EVERY", 0.0001)
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    call(learner, "scene.tis")
    assert (
        "learn gum: pass 2 of at most 10, first 25 % of the data, error 5.00e-02 of the first, "
        "held out 4.2 %, 5 s, at most 20 s left"
    ) in terminal.getvalue()
