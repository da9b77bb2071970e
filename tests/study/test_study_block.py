"""What a study block says, and what is told before any run."""

import pytest

from tests.every import every
from tests.study.scenes import SCENE, STUDY, prepared, request
from tissuec.core.errors import CompileError, TissueError
from tissuec.pipeline import check_request
from tissuec.scene.study.model import Distribution, Levels
from tissuec.studies.study import prepare

MEASURE = "measure pull = max(force of hand)"


def study(*lines: str):
    """Return a study of these lines alone."""
    return prepared(*lines, text=SCENE).study


def factor(text: str, *more: str):
    """Return the factor of a line."""
    return study(text, MEASURE, *more).factors[0]


def refused(*lines: str) -> str:
    """Return what ``check`` says of a block with these lines."""
    block = "study pulling {\n" + "".join(f"  {line}\n" for line in lines) + "}\n"
    with pytest.raises(CompileError) as error:
        check_request(request(SCENE + block))
    return str(error.value)


@every(
    ("text", "values"),
    [
        ("vary lift = 2 mm to 10 mm in 5 steps", (2, 4, 6, 8, 10)),
        ("vary lift = 10 mm to 2 mm in 3 steps", (10, 6, 2)),
        ("vary lift = 0.1 mm to 0.3 mm in 3 steps", (0.1, 0.2, 0.3)),
        ("vary lift = 1 mm to 2 mm by 0.3 mm", (1, 1.3, 1.6, 1.9)),
        ("vary lift = 1 mm to 1 cm by 5 mm", (1, 6)),
        ("vary lift = [2 mm, 0.5 cm]", (2, 5)),
        ("vary lift = 3 mm", (3,)),
        ("vary tolerance = [1e-3, 1e-05]", (1e-3, 1e-5)),
    ],
)
def test_numbers_are_listed_in_the_unit_that_is_written(text, values):
    found = factor(text)
    assert isinstance(found.spread, Levels)
    assert found.spread.values == values
    assert found.unit == ("mm" if "lift" in text else "")


def test_values_are_written_so_that_the_command_line_takes_them():
    lift = factor("vary lift = [2.5 mm]")
    assert [lift.override(value) for value in (2.5, 1e-7, 3.0)] == [
        "lift = 2.5 mm", "lift = 1e-07 mm", "lift = 3 mm",
    ]  # fmt: skip
    weight = factor("vary weight of spring = [low, slightly high]")
    assert weight.override("slightly high") == "weight of spring is slightly high"
    assert weight.own == "medium" and factor("vary lift = [1 mm]").own == 2.0


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("lift = 2 mm to 10 mm", Distribution("uniform", (2.0, 10.0))),
        ("lift", Distribution("uniform", (0.0, 20.0))),
        ("lift = normal(5 mm, 0.1 cm)", Distribution("normal", (5.0, 1.0))),
        (
            "lift = lognormal(5 mm, 1.2) between 2 mm and 9 mm",
            Distribution("lognormal", (5.0, 1.2), 2.0, 9.0),
        ),
        ("lift = triangular(1 mm, 2 mm, 3 mm)", Distribution("triangular", (1.0, 2.0, 3.0))),
    ],
)
def test_ranges_without_steps_and_distributions_are_for_random_designs(text, expected):
    found = study(f"vary {text}", MEASURE)
    assert found.factors[0].spread == expected
    assert found.design == "latin hypercube"


def test_an_entry_of_a_region_can_be_named_in_quotes():
    assert factor('vary "weight of tissue spring" = [low]').name == "weight of tissue spring"


def test_options_replace_the_sentences_of_the_block():
    ready = prepared("vary lift = [1 mm]", "measure pull = min(force of hand)", "seed = 3")
    assert [one.name for one in ready.study.factors] == ["lift", "tissue of bar"]
    assert len(ready.planned) == 2 and ready.study.settings.seed == 3
    assert len(ready.study.measures) == 4


def test_rows_come_from_a_file(tmp_path):
    (tmp_path / "points.csv").write_text(
        "lift [cm],tissue of bar\n0.2,spring\n0.3,stiff spring\n"
    )
    text = SCENE + f'study rows {{ rows "points.csv"; {MEASURE} }}\n'
    ready = prepare(request(text, tmp_path))
    assert ready.study.design == "list"
    assert [one.overrides for one in ready.planned] == [
        ("lift = 0.2 cm", "tissue of bar is spring"),
        ("lift = 0.3 cm", "tissue of bar is stiff spring"),
    ]


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ("lift [mm]\n2\n30\n1\n40\n", "lift = 40 mm is not between 0 m and 20 mm (runs 1, 3)"),
        ("lift [N]\n2\n", 'call it "lift [mm]"'),
        ("lfit [mm]\n2\n", 'did you mean "lift"'),
        ("lift [mm]\n2\nx\n", 'line 3 of "points.csv": "x" is not a number'),
        ("lift [mm]\n2,3\n", "has 2 cells instead of 1"),
        ("lift [mm]\n", "has no rows"),
        ("lift (mm)\n2\n", 'wrong name of column "lift (mm)" of "points.csv"'),
        ("lift [mm] tolerance\n2 1e-4\n", "commas, semicolons or tabs separate columns"),
        ("lift [mm],\n2,1\n", 'wrong name of column "" of "points.csv"'),
        ("lift = 2 mm\n2\n", 'wrong name of column "lift = 2 mm"'),
        ("lfit [mm]\n2\n", 'column "lfit [mm]" of "points.csv": '),
        ("lift [inch]\n2\n", 'column "lift [inch]" of "points.csv": "inch" is not a unit'),
        ("tissue of bar\nspring\nsteel\n", 'no tissue called "steel" (run 1)'),
    ],
)
def test_wrong_rows_are_told_with_their_numbers(tmp_path, rows, said):
    (tmp_path / "points.csv").write_text(rows)
    text = SCENE + f'study rows {{ rows "points.csv"; {MEASURE} }}\n'
    with pytest.raises(CompileError) as error:
        prepare(request(text, tmp_path))
    assert said in str(error.value)


@pytest.mark.parametrize("separator", [",", ";", "\t"])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_rows_have_any_separator(tmp_path, separator, end):
    rows = [("lift [mm]", "tolerance"), ("2", "1e-4"), ("3.5", "1e-3")]
    lines = [separator.join(row) for row in rows]
    (tmp_path / "points.csv").write_bytes(end.join([*lines, ""]).encode())
    text = SCENE + f'study rows {{ rows "points.csv"; {MEASURE} }}\n'
    assert [one.overrides for one in prepare(request(text, tmp_path)).planned] == [
        ("lift = 2 mm", "tolerance = 0.0001"),
        ("lift = 3.5 mm", "tolerance = 0.001"),
    ]


@every(
    ("lines", "said"),
    [
        (
            ["vary lift = 2 to 10 in 9 steps", MEASURE],
            ["has no unit", '"2 mm"', "bar.tis:32:15"],
        ),
        (["vary lift = 2 mm to 10 N in 9 steps", MEASURE], ["is a force"]),
        (["vary lift = 2 mm to 10 mm in 9", MEASURE], ["in 9 steps"]),
        (["vary lift = 2 mm to 10 mm in 1 step", MEASURE], ["2 at the least"]),
        (["vary lift = 2 mm to 10 mm by -1 mm", MEASURE], ["do not lead to the end"]),
        (["vary lift = 10 mm to 2 mm", MEASURE], ["ends before it begins"]),
        (["vary lift = 2 mm to 30 mm in 3 steps", MEASURE], ["not between 0 m and 20 mm"]),
        (["vary lift = [2 mm, soft]", MEASURE], ["a word among numbers"]),
        (["vary lift = normal(2 mm)", MEASURE], ["normal(mean, standard deviation)"]),
        (["vary lift = uniform(3 mm, 2 mm)", MEASURE], ["must be below the second"]),
        (["vary lfit = [2 mm]", MEASURE], ['did you mean "lift"', "bar.tis:32:3"]),
        (["vary hardness of spring = [sofd]", MEASURE], ['"sofd" is not a word for hardness']),
        (["vary hardnes of spring = [soft]", MEASURE], ["did you mean", "hardness"]),
        (["vary hardness of sprin = [soft]", MEASURE], ['no block called "sprin"']),
        (["vary tolerance = [1]", MEASURE], ["tolerance must be"]),
        (["vary integrator = [dop85]", MEASURE], ['did you mean "dop853"']),
        (["vary lift = [2 mm]", "vary lift = [3 mm]", MEASURE], ["is given twice"]),
        ([MEASURE], ['needs "vary"']),
        (["vary lift = [2 mm]"], ['needs "measure"']),
        (["vary lift = [2 mm]", "mesure pull = max(force of hand)"], ['mean "measure"']),
        (["vary lift = [2 mm]", "measure a = max(force of hnd)"], ["hnd", 'mean "hand"']),
        (["vary lift = [2 mm]", "measure a = max(forc of hand)"], ["forc", 'mean "force"']),
        (["vary lift = [2 mm]", "measure a = max(3 N)"], ["measures nothing"]),
        (["vary lift = [2 mm]", "measure a = force of hand"], ["its time is missing"]),
        (["vary lift = [2 mm]", "measure a = force of hand at 3 s"], ["not within the run"]),
        (["vary lift = [2 mm]", "measure a = time of ruptur"], ['did you mean "rupture"']),
        (
            ["vary lift = [2 mm]", "measure a = max(force of hand) in 3 s"],
            ['does not take "in"'],
        ),
        (["vary lift = [2 mm]", "measure lift = max(force of hand)"], ["is given twice"]),
        (["vary lift = [2 mm]", MEASURE, "design is gird"], ['did you mean "grid"']),
        (["vary lift = 2 mm to 3 mm", MEASURE, "design is grid"], ["no steps", "latin"]),
        (["vary lift = [2 mm]", MEASURE, "runs = 9"], ["runs has no effect"]),
        (
            ["vary lift = [2 mm]", "vary tolerance = [1e-3, 1e-4]", MEASURE, "design is list"],
            ["tolerance has 2 values, and lift has 1"],
        ),
        (["vary lift = [2 mm]", MEASURE, "expect max(pul) < 2 N"], ['did you mean "pull"']),
        (["vary lift = [2 mm]", MEASURE, "expect max(pull) < 2 mm"], ["a force"]),
        (["vary lift = [2 mm]", MEASURE, "expect pull < 2 N"], ["compares single numbers"]),
        (["vary lift = [2 mm]", MEASURE, "expect max(pull) < 2 N at 1 s"], ["has no time"]),
        (["vary lift = [2 mm]", MEASURE, "keep is everything"], ["nothing, results"]),
        (["vary lift = [2 mm]", MEASURE, "error estimate is maybe"], ["choices: off"]),
        (["vary lift = [2 mm]", MEASURE, 'rows "nowhere.csv"'], ["nowhere.csv"]),
    ],
)
def test_mistakes_are_told_with_place_and_remedy(lines, said):
    message = refused(*lines)
    for part in said:
        assert part in message, message
    assert "bar.tis:" in message


def test_a_value_that_is_right_beside_those_of_other_factors_is_right():
    lines = ("vary integrator = [velocity verlet]", "vary step = [1 ms, 0.5 ms]", MEASURE)
    assert len(study(*lines).factors) == 2


def test_random_values_outside_of_limits_are_told_with_their_runs():
    with pytest.raises(
        CompileError, match=r"lift = .* is not between 0 m and 20 mm \(runs? \d+"
    ):
        study("vary lift = normal(10 mm, 8 mm)", MEASURE, "runs = 100")
    cut = "vary lift = normal(10 mm, 8 mm) between 0 mm and 20 mm"
    assert study(cut, MEASURE, "runs = 100").settings.runs == 100


def test_a_study_is_found_by_its_name():
    text = SCENE + STUDY + STUDY.replace("pulling", "other pulling")
    assert prepare(request(text), "Other Pulling").study.name == "other pulling"
    with pytest.raises(TissueError, match="several studies: pulling, other pulling"):
        prepare(request(text))
    with pytest.raises(TissueError, match='no study called "puling"; did you mean "pulling"'):
        prepare(request(text), "puling")
    with pytest.raises(TissueError, match="has no study; write a study block, or use --vary"):
        prepare(request(SCENE))


def test_a_study_without_a_scene_is_told():
    with pytest.raises(CompileError, match="the study block pulling has no scene"):
        check_request(request("language 1\n" + STUDY))
