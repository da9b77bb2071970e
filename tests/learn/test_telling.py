"""What is said of a learning: exact texts of small ones, and its plain data."""

import json

import numpy as np
import pytest

from tests.learn.learnings import BLIND, compiled_of, estimates, learnt, learnt_of
from tissuec.core.report import as_text
from tissuec.learn.fit.outcome import Fitted, errors_of, joined, judged
from tissuec.learn.report import (
    as_dict,
    differences,
    drifts,
    is_identified,
    learnt_parts,
    numbers_of,
    uncertainty,
)
from tissuec.learn.vocabulary.moving import WordsModel

GUM = """tissue gum {
  spring constant = 40 N/m; viscosity = 10 mN*s/m; mass = 10 mg; prestress = 0 %
}
"""


@pytest.fixture
def compiled(tmp_path):
    adjust = "adjust = [spring constant, viscosity]"
    end = "expect error(held out) < 4 % over run\nexpect error(data) < 4 %\n"
    return compiled_of(tmp_path, adjust, top=GUM, tissue="gum", fit_problem="gum", end=end)[0]


def test_the_whole_text(compiled):
    found = learnt_of(compiled, zeros={"force(pressed)": 1e-4}, notes=("mind the gap",))
    assert as_text(learnt_parts(found)) == [
        "learn gum: the error no longer decreases",
        "parameter               before     learned       95 % interval                 change",
        "spring constant of gum  40 N/m     49.38 N/m     48.89 N/m to 49.88 N/m        "
        "+23.5 %",
        "viscosity of gum        10 mN*s/m  12.35 mN*s/m  12.22 mN*s/m to 12.47 mN*s/m  "
        "+23.5 %",
        "data                error  points  residuals",
        "one.csv             3.1 %  100     force(pressed) 2 mN",
        "two.csv (held out)  4.2 %  50      force(pressed) 3 mN",
        "noise of force(pressed): 2.01 mN (estimated)",
        "zero of force(pressed): 100 uN",
        "note: mind the gap",
        "error function: 120 before, 0.5 after",
        "method: least squares, forward sensitivities; 3 passes, 40 evaluations, 1.5 s",
        "steps: velocity verlet, 1000 steps of 50 us; halving the step changes predictions by "
        "2.1e-05 of the range of the data",
    ]


def test_what_cannot_be_told_is_said_with_what_would_tell_it(compiled):
    one = learnt_of(compiled).estimates[0]
    unknown = estimates(one.adjust, one.start, told=[False])
    found = learnt(compiled.fit_problems[0], [unknown], blind=(BLIND,))
    lines = as_text(learnt_parts(found))
    assert lines[2].split("  ")[-2:] == ["not identified", "+23.5 %"]
    place = lines.index("not identified: only their ratios can be determined")
    assert lines[place + 1] == "  to identify it: give one mass"
    assert not is_identified(found)
    assert is_identified(learnt_of(compiled))
    # A common factor of very many numbers shows in none of them alone.
    assert not is_identified(learnt_of(compiled, blind=(BLIND,)))


def test_what_was_zero_changes_by_a_difference(tmp_path):
    compiled, _ = compiled_of(tmp_path, "adjust prestress of gum", top=GUM, tissue="gum")
    adjust = compiled.fit_problems[0].adjusts[0]
    one = estimates(adjust, [0.0])
    changed = type(one)(
        adjust, one.names, one.start, np.array([0.02]), np.array([0.019]), np.array([np.inf]),
        one.identified, (),
    )  # fmt: skip
    assert as_text(numbers_of([changed])) == [
        "parameter         before  learned  95 % interval  change",
        "prestress of gum  0 %     2 %      unknown        +2 %",
    ]


def test_of_many_numbers_a_summary_is_told(tmp_path):
    adjust = "adjust spring constant of block per spring"
    compiled, _ = compiled_of(tmp_path, adjust, top=GUM, tissue="gum")
    entry = compiled.fit_problems[0].adjusts[0]
    count = len(entry.members)
    start, part = np.full(count, 40.0), np.linspace(0.01, 0.05, count)
    told = np.ones(count, dtype=bool)
    told[3] = False
    names = tuple(f"spring {k}" for k in range(count))
    one = estimates(entry, start, factor=0.5 + part * 10, part=part, names=names, told=told)
    assert as_text(numbers_of([one])) == [
        "spring constant per spring of block: 78 parameters",
        "          median  quartiles         range",
        "  before  40 N/m  40 N/m to 40 N/m  40 N/m to 40 N/m",
        "  learnt  32 N/m  28 N/m to 36 N/m  24 N/m to 40 N/m",
        "  accurate to 3.03 % (median), 5 % (worst)",
        "  not identified: 1 of them",
        f"  least accurate: spring 3: {24 + 16 * 3 / 77:.4g} N/m (not identified)",
        "  least accurate: spring 77: 40 N/m (38 N/m to 42 N/m)",
        f"  least accurate: spring 76: {40 - 16 / 77:.4g} N/m "
        f"({(40 - 16 / 77) * (0.95 + 0.04 / 77):.4g} N/m to "
        f"{(40 - 16 / 77) * (1.05 - 0.04 / 77):.4g} N/m)",
    ]
    assert np.isinf(uncertainty(one)[3])


def test_errors_are_told_by_what_was_seen_and_by_file():
    fitted = (
        Fitted("a.csv", False, 30, 0.1, {}, ""),
        Fitted("b.csv", False, 10, 0.3, {}, ""),
        Fitted("a.csv", True, 10, 0.2, {}, ""),
    )
    errors = errors_of(fitted)
    assert errors["held out"] == pytest.approx(0.2, rel=1e-14)
    assert errors["data"] == pytest.approx(np.sqrt((30 * 0.01 + 10 * 0.09) / 40), rel=1e-14)
    assert errors["a.csv"] == pytest.approx(np.sqrt((30 * 0.01 + 10 * 0.04) / 40), rel=1e-14)
    assert set(errors) == {"held out", "data", "a.csv", "b.csv"}
    assert "held out" not in errors_of(fitted[:2])
    assert joined([]) == 0.0


def test_expectations_are_judged_by_these_errors(compiled):
    first, second = judged(learnt_of(compiled))
    assert (first.holds, first.measured) == (False, "error(held out) = 4.2 %")
    assert (second.holds, second.measured) == (True, "error(data) = 3.1 %")


def test_plain_data_is_json_with_everything(compiled):
    document = json.loads(json.dumps(as_dict(learnt_of(compiled))))
    assert document["errors"]["held out"] == pytest.approx(0.042)
    assert document["estimates"][0]["names"] == ["spring constant of gum"]
    assert document["estimates"][0]["unit"] == "N/m"
    assert [one["holds"] for one in document["expectations"]] == [False, True]
    assert document["identified"] and document["converged"] and document["seed"] == 7


def test_words_that_moved_are_told_and_shown(tmp_path):
    compiled, _ = compiled_of(
        tmp_path, "adjust words of spring constant", top='use "tissues/fat"'
    )
    model = WordsModel(compiled.scene, compiled.fit_problems[0].adjusts)
    theta = np.full(model.size, 0.2)
    moved = drifts(compiled.scene, model.texts(theta))
    assert [one.word for one in moved] == [one.word for one in model.drift(theta)]
    # Texts have fewer digits than numbers.
    for one, other in zip(moved, model.drift(theta), strict=True):
        assert one.centre == pytest.approx(other.centre, abs=1e-6)
    texts = model.texts(theta)
    found = learnt(
        compiled.fit_problems[0], [], words=texts, notes=(moved[0].sentence, "other")
    )
    lines = as_text(learnt_parts(found, moved))
    assert sum(moved[0].sentence in line for line in lines) == 1 and "note: other" in lines
    (diff,) = differences(compiled.scene, texts)
    assert diff.startswith("--- fuzzy/soft_tissue.tis\n+++ fuzzy/soft_tissue.tis (learned)\n")
    removed = [line for line in diff.splitlines() if line.startswith("-  ")]
    assert removed == [
        "-  evenly = [very low, low, slightly low, medium, slightly high, high, very high]"
    ]
    assert drifts(compiled.scene, {}) == []
