"""``tissuec study``: options, exit codes, what is printed, and what is told before any run."""

import json

import numpy as np
import pytest

from tests.study.scenes import SCENE, STUDY
from tests.test_cli import tissuec
from tissuec.studies.table_files import read_table

PULL = "pull = max(force of hand)"
TWO = ("--vary", "lift = [2 mm, 4 mm]", "--measure", PULL)


@pytest.fixture
def call(tmp_path):
    """Return what runs the command in a folder with the scene "bar.tis"."""
    (tmp_path / "bar.tis").write_text(SCENE + STUDY, "utf-8")
    (tmp_path / "plain.tis").write_text(SCENE, "utf-8")

    def run(scene, *words, before=()):
        # One process: no test here is about workers.
        return tissuec(*before, "study", scene, *words, "--workers", "1", cwd=tmp_path)

    return run


def column(path, name):
    return read_table(path).column(name).values


# --- options ----------------------------------------------------------------------------------


def test_the_table_is_named_after_scene_and_study(call, tmp_path):
    found = call("bar.tis", "--no-error-estimate")
    assert found.returncode == 0
    assert "bar.tis: study pulling: 6 runs" in found.stderr
    assert "  done: 6\n  table: bar.pulling.csv\n" in found.stderr and found.stdout == ""
    assert len(read_table(tmp_path / "bar.pulling.csv")) == 6
    again = call("bar.tis", "pulling", "--no-error-estimate")
    assert "6 runs, 6 of them done before" in again.stderr
    fresh = call("bar.tis", "pulling", "--no-error-estimate", "--fresh")
    assert "done before" not in fresh.stderr


def test_a_scene_without_a_study_needs_options_only(call, tmp_path):
    assert call("plain.tis", *TWO).returncode == 0
    assert column(tmp_path / "plain.study.csv", "lift").tolist() == [2.0, 4.0]


@pytest.mark.parametrize(
    ("text", "lifts"),
    [
        ("lift = 2 mm to 10 mm in 3 steps", [2, 6, 10]),
        ("lift = 2 mm to 10 mm in 3 step", [2, 6, 10]),
        ("lift = 2 mm to 10 mm by 4 mm", [2, 6, 10]),
        ("lift = [2 mm, 0.5 cm]", [2, 5]),
        ("lift = 3 mm", [3]),
    ],
)
def test_forms_of_listed_values(call, tmp_path, text, lifts):
    words = ("--vary", text, "--measure", PULL, "--no-error-estimate", "-o", "t.csv")
    assert call("plain.tis", *words).returncode == 0
    assert column(tmp_path / "t.csv", "lift").tolist() == lifts


@pytest.mark.parametrize(
    "text",
    [
        "lift", "lift = 2 mm to 10 mm", "lift = uniform(2 mm, 10 mm)",
        "lift = normal(5 mm, 1 mm)", "lift = normal(5 mm, 9 mm) between 2 mm and 8 mm",
        "lift = lognormal(5 mm, 1.1)", "lift = triangular(2 mm, 3 mm, 8 mm)",
    ],
)  # fmt: skip
def test_forms_of_distributions_are_drawn_by_their_seed(call, tmp_path, text):
    def lifts(seed, design):
        words = ("--runs", "3", "--seed", str(seed), "--design", design, "-o", f"{seed}.csv")
        found = call(
            "plain.tis", "--vary", text, "--measure", PULL, "--no-error-estimate", *words
        )
        assert found.returncode == 0, found.stderr
        return column(tmp_path / f"{seed}.csv", "lift").tolist()

    first = lifts(1, "latin hypercube")
    assert len(set(first)) == 3 and all(0.0 <= lift <= 20.0 for lift in first)
    assert lifts(2, "sobol") != first


@pytest.mark.parametrize(
    ("text", "name", "values"),
    [
        ("weight of spring = [low, slightly high]", "weight of spring",
         ("low", "slightly high")),
        ("tissue of bar = [spring, stiff spring]", "tissue of bar", ("spring", "stiff spring")),
        ("integrator = [dop853, velocity verlet]", "integrator", ("dop853", "velocity verlet")),
        ("tolerance = [1e-3, 1e-4]", "tolerance", (1e-3, 1e-4)),
    ],
)  # fmt: skip
def test_words_tissues_and_settings_vary(call, tmp_path, text, name, values):
    words = ("--vary", text, "--measure", PULL, "--no-error-estimate", "-o", "t.csv")
    assert call("plain.tis", *words).returncode == 0
    assert tuple(column(tmp_path / "t.csv", name)) == values


@pytest.mark.parametrize(
    ("design", "runs"),
    [("grid", 4), ("list", 2), ("one at a time", 5), ("latin hypercube", 3), ("sobol", 3),
     ("sobol indices", 12)],
)  # fmt: skip
def test_every_design_has_its_runs(call, tmp_path, design, runs):
    words = ["--design", design, "-o", "t.csv", "--no-error-estimate"]
    words += ["--runs", "3"] if runs in (3, 12) else []
    vary = ("--vary", "lift = [2 mm, 4 mm]", "--vary", "tissue of bar = [spring, stiff spring]")
    found = call("plain.tis", *vary, "--measure", PULL, *words)
    assert found.returncode == 0, found.stderr
    table = read_table(tmp_path / "t.csv")
    assert (len(table), table.head.design) == (runs, design)


def test_rows_of_a_file_and_measures_with_and_without_a_name(call, tmp_path):
    (tmp_path / "points.csv").write_text("lift [mm]\n2\n3\n")
    words = ("--rows", "points.csv", "--measure", PULL, "--measure", "max(speed of tip)")
    assert call("plain.tis", *words, "-o", "t.csv").returncode == 0
    table = read_table(tmp_path / "t.csv")
    assert table.head.design == "list"
    assert [one.name for one in table.measures] == ["pull", "max(speed of tip)"]


def test_set_holds_for_every_run_and_vary_replaces_the_line_of_the_block(call, tmp_path):
    words = ("--vary", "lift = [2 mm]", "--set", "spring constant of spring = 8 N/m")
    assert call("bar.tis", *words, "--no-error-estimate", "-o", "t.csv").returncode == 0
    table = read_table(tmp_path / "t.csv")
    assert table.column("lift").values.tolist() == [2.0, 2.0]
    pull = table.column("pull").numbers
    assert pull[0] > 1.5 * pull[1]  # 8 N/m beside the 4 N/m of the stiff spring


def test_results_are_kept_on_demand_and_hdf5_is_written(call, tmp_path):
    found = call("plain.tis", *TWO, "--keep-results", "-o", "t.h5")
    assert found.returncode == 0 and "  results: t.runs\n  table: t.h5" in found.stderr
    assert sorted(path.name for path in (tmp_path / "t.runs").iterdir()) == [
        "run_00000.vtkhdf", "run_00001.vtkhdf",
    ]  # fmt: skip
    assert set(read_table(tmp_path / "t.h5").promise) == {"kept"}


def test_strict_makes_errors_of_warnings(call, tmp_path):
    assert "warning[W502]" in call("plain.tis", *TWO, "-o", "t.csv").stderr
    found = call("plain.tis", *TWO, "-o", "s.csv", "--strict")
    assert found.returncode == 2 and "W502" in found.stderr
    assert not (tmp_path / "s.csv").exists()


def test_quiet_says_nothing(call):
    assert call("plain.tis", *TWO, before=("-q",)).stderr == ""


# --- exit codes and JSON ----------------------------------------------------------------------


def test_json_tells_what_came_out(call, tmp_path):
    found = call("bar.tis", "--vary", "lift = [2 mm, 20 mm]", before=("--json",))
    told = json.loads(found.stdout)
    assert found.returncode == 0 and found.stderr == ""
    known = {"scene": "bar.tis", "study": "pulling", "ok": True, "table": "bar.pulling.csv"}
    assert told | known | {"runs": 4, "taken_over": 0} == told
    assert told["outcomes"] == {"done": 4} and told["expectations"] == []
    assert isinstance(told["diagnostics"], list)


def test_an_expectation_of_the_study_that_fails_gives_1(call, tmp_path):
    text = (SCENE + STUDY).replace("measure tear", "expect max(pull) < 1 mN\n  measure tear")
    (tmp_path / "bar.tis").write_text(text, "utf-8")
    found = call("bar.tis", "--no-error-estimate")
    assert found.returncode == 1
    assert "FAILED bar.tis:36: expect max(pull) < 1 mN" in found.stderr
    assert "max(pull) = " in found.stderr and "expectations: 0 of 1 hold" in found.stderr
    told = json.loads(call("bar.tis", "--no-error-estimate", before=("--json",)).stdout)
    assert told["ok"] is False and told["expectations"][0]["holds"] is False


def test_no_run_that_could_be_computed_gives_3_and_some_give_0(call, tmp_path):
    text = (SCENE + STUDY).replace("id == 2", "x > lift * 3")
    (tmp_path / "bar.tis").write_text(text, "utf-8")
    none = call("bar.tis", "--vary", "lift = [8 mm, 9 mm]", "-o", "none.csv")
    assert none.returncode == 3
    assert "  refused: 4\n    4 runs: " in none.stderr and "middle" in none.stderr
    some = call("bar.tis", "--vary", "lift = [2 mm, 9 mm]", "-o", "some.csv")
    assert some.returncode == 0 and "  done: 2\n  refused: 2\n" in some.stderr
    told = json.loads(call("bar.tis", "--vary", "lift = [8 mm]", "-o", "j.csv",
                           before=("--json",)).stdout)  # fmt: skip
    assert told["ok"] is False and told["outcomes"] == {"refused": 2}
    assert np.isnan(read_table(tmp_path / "none.csv").column("pull").numbers).all()


def test_expectations_say_which_runs_they_are_not_about(call, tmp_path):
    text = (SCENE + STUDY).replace("id == 2", "x > lift * 3")
    text = text.replace("measure tear", "expect max(pull) < 1 N\n  measure tear")
    (tmp_path / "bar.tis").write_text(text, "utf-8")
    found = call("bar.tis", "--vary", "lift = [2 mm, 9 mm]")
    assert "expectations: 1 of 1 hold (left out of 4 runs: 2 failed)" in found.stderr


# --- bad input, before any run ----------------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--vary", "lift = 2 to 10 in 9 steps"), ("2 has no unit", 'write "2 mm"')),
        (("--vary", "lift = 2 mm to 10 in 9 steps"), ("10 has no unit",)),
        (("--vary", "lift = 2 mm to 10 mm in 9"), ("in 9 steps",)),
        (("--vary", "lift = 2 mm to 10 mm", "--design", "grid"), ("no steps", "in 9 steps")),
        (("--vary", "lift 2 mm"), ('"=" is missing',)),
        (("--vary", "lift = []"), ("the values are missing",)),
        (("--vary", "lfit = [2 mm]"), ('did you mean "lift"',)),
        (("--vary", "hardness of spring = [sofd]"), ('did you mean "soft"',)),
        (("--vary", "shade of spring = [soft]"), ('"shade" is neither',)),
        (("--vary", "lift = [2 mm, 30 mm]"), ("30 mm is not between 0 m and 20 mm",)),
        (("--vary", "lift = normal(10 mm, 8 mm)", "--runs", "20"), ("(runs ",)),
        (("--vary", "lift = [2 mm]", "--runs", "5"), ("runs has no effect",)),
        (("--rows", "nowhere.csv"), ('no file "nowhere.csv"',)),
        (("--vary", "lift = [2 mm]", "--design", "gird"), ("'one at a time'",)),
        (("--vary", "lift = [2 mm]", "--set", "lfit = 2 mm"), ("lfit",)),
        (("other study", "--design", "grid"), ('needs "vary"',)),
    ],
)
def test_wrong_factors_are_told_before_any_run(call, tmp_path, words, said):
    found = call("plain.tis", *words, "--measure", PULL, "-o", "t.csv")
    assert found.returncode == 2
    assert all(part in found.stderr for part in said), found.stderr
    assert not (tmp_path / "t.csv").exists()


def test_messages_name_a_study_without_a_name_once(call):
    found = call("plain.tis", "--vary", "lift = [2 mm]", "-o", "t.csv")
    assert 'the study needs "measure"' in found.stderr
    found = call("plain.tis", "--vary", "lift = [2 mm]", "--measure", PULL, "-o", "t.csv")
    assert "plain.tis: study: 1 run;" in found.stderr


@pytest.mark.parametrize(
    ("measure", "said"),
    [
        ("max(3 N)", '"3 N" measures nothing'),
        ("pull", '"pull" does not say what is measured'),
        ("max(force of nobody)", 'called "nobody"'),
        ("max(forc of hand)", 'did you mean "force"'),
        ("force of hand", "its time is missing"),
        ("force of hand at 9 s", "not within the run"),
        ("time of ruptur", 'did you mean "rupture"'),
        ("", "ends too early"),
    ],
)
def test_wrong_measures_are_told_before_any_run(call, tmp_path, measure, said):
    found = call("plain.tis", "--vary", "lift = [2 mm]", "--measure", measure, "-o", "t.csv")
    assert found.returncode == 2 and said in found.stderr, found.stderr
    assert not (tmp_path / "t.csv").exists()


@pytest.mark.parametrize(
    ("output", "said"),
    [
        ("t.txt", '"t.txt" does not end with .csv or .h5'),
        ("t", "for example: -o t.csv"),
        ("nowhere/t.csv", 'the folder "nowhere" does not exist; create it'),
        ("nowhere/t.h5", 'the folder "nowhere" does not exist; create it'),
        ("plain.tis", "is the input file"),
    ],
)
def test_wrong_places_are_told_before_any_run(call, tmp_path, output, said):
    found = call("plain.tis", *TWO, "-o", output)
    assert found.returncode == 2 and said in found.stderr, found.stderr
    assert not list(tmp_path.glob("t.*"))


def test_names_of_studies_are_told(call):
    assert 'did you mean "pulling"' in call("bar.tis", "puling").stderr
    found = call("plain.tis")
    assert found.returncode == 2 and "write a study block, or use --vary" in found.stderr


def test_a_scheduler_that_nobody_reaches_is_told_before_a_table_is_begun(
    call, tmp_path, monkeypatch
):
    pytest.importorskip("distributed", reason="the extra cluster is not installed")
    from tissuec.core.workers import cluster

    monkeypatch.setattr(cluster, "PATIENCE", 0.3)
    for address in ("tcp://127.0.0.1:9", "nonsense"):
        found = call("plain.tis", *TWO, "-o", "t.csv", "--scheduler", address)
        assert found.returncode == 3
        assert f'no scheduler answers at "{address}"' in found.stderr
        assert "dask scheduler" in found.stderr and not (tmp_path / "t.csv").exists()
    told = call("plain.tis", *TWO, "--scheduler", "nonsense", before=("--json",))
    assert json.loads(told.stdout)["error"].startswith("no scheduler answers")


def test_without_the_extra_a_scheduler_says_how_to_install_it(call, monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "distributed", None)
    found = call("plain.tis", *TWO, "--scheduler", "tcp://127.0.0.1:9")
    assert found.returncode == 3 and 'pip install "tissuec[cluster]"' in found.stderr
