"""Words and weights fitted to numbers of tissues: recovered, exact, in order, and written."""

import random
from math import log
from pathlib import Path

import numpy as np
import pytest

from tests.learn.measured_gels import LEARN, request_of, tissues, vocabulary
from tissuec.core.errors import CompileError
from tissuec.core.resources import library
from tissuec.learn.words_fit import LEAST, VocabularyModel, fit_words, reread_words
from tissuec.pipeline import read_vocabulary_fits, read_words
from tissuec.scene.request import Request


def fitted(request):
    (fit,), _ = read_vocabulary_fits(request)
    return fit_words(request, fit, read_words(request)[0])


@pytest.mark.parametrize(
    "disturbed",
    [
        {"LOW": "9 kPa"}, {"MEDIUM": "90 kPa"}, {"WEIGHT": "0.1"},
        {"LOW": "2 kPa", "MEDIUM": "20 kPa", "HIGH": "600 kPa", "WEIGHT": "1"},
    ],
    ids=lambda places: " ".join(places),
)  # fmt: skip
def test_a_disturbed_vocabulary_is_recovered(tmp_path, disturbed):
    learnt = fitted(
        request_of(tmp_path, vocabulary(**disturbed), "\n".join(tissues(vocabulary())) + LEARN)
    )
    before = max(one.factor_before for one in learnt.numbers)
    assert before > 1.3
    assert learnt.converged
    assert max(one.factor for one in learnt.numbers) < 1.0 + 0.1 * (before - 1.0)
    assert learnt.error < 0.05 * learnt.first_error


def test_words_that_give_the_numbers_do_not_change(tmp_path):
    learnt = fitted(
        request_of(tmp_path, vocabulary(), "\n".join(tissues(vocabulary())) + LEARN)
    )
    assert learnt.texts == {} and learnt.moved == () and learnt.weights == ()
    assert learnt.errors["data"] < 1e-9


def test_slopes_are_those_of_differences(tmp_path):
    request = request_of(tmp_path, vocabulary(), "\n".join(tissues(vocabulary())) + LEARN)
    (fit,), _ = read_vocabulary_fits(request)
    model = VocabularyModel(read_words(request)[0], fit)
    # Of words: two knots of each of three peaks are one. Of weights: four rules conclude it.
    assert model.size == 3 + 4
    source = np.random.default_rng(3)
    theta = np.minimum(source.normal(scale=0.3, size=model.size), model.bounds()[1] - 0.1)
    _, slopes = model.places(theta)
    step = 1e-5
    for number in range(model.size):
        moved = np.zeros(model.size)
        moved[number] = step
        differences = (
            (model.places(theta + moved)[0] - model.places(theta - moved)[0]) / 2 / step
        )
        assert slopes[:, number] == pytest.approx(differences, rel=1e-6, abs=1e-9)


def test_targets_are_numbers_or_else_the_middle_of_the_evidence(tmp_path):
    facts = "described in gel; firmness is soft; weight is heavy"
    text = f"""
    tissue one {{ {facts}; Young's modulus = 5 kPa }}
    tissue two {{ {facts}; known Young's modulus from 4 kPa to 9 kPa by "A 2000" }}
    tissue three {{ {facts}; Young's modulus = 5 kPa
      known Young's modulus from 4 kPa to 9 kPa by "A 2000" }}
    tissue four {{ {facts}; known Young's modulus = 7 kPa by "A 2000" }}
    tissue five {{ {facts}; known density from 1 g/cm^3 to 1.2 g/cm^3 by "A 2000" }}
    tissue six {{ {facts} }}
    learn gels {{
      fit = Young's modulus of all tissues weighing 3
      fit = density of five
      adjust words of density
    }}
    """
    (fit,), _ = read_vocabulary_fits(request_of(tmp_path, vocabulary(), text))
    found = {(one.tissue, one.quantity): one for one in fit.targets}
    expected = {
        ("one", "young's modulus"): (5e3, log(1.1), "written", 3.0),
        ("two", "young's modulus"): (6e3, 0.5 * log(9 / 4), "evidence", 3.0),
        ("three", "young's modulus"): (5e3, log(1.1), "written", 3.0),
        ("four", "young's modulus"): (7e3, log(1.1), "evidence", 3.0),
        ("five", "density"): (1100.0, 100.0, "evidence", 1.0),
    }
    assert found.keys() == expected.keys()
    for key, (value, deviation, how, weight) in expected.items():
        one = found[key]
        assert (one.value, one.deviation) == (pytest.approx(value), pytest.approx(deviation))
        assert (one.how, one.weight) == (how, weight)
    assert fit.left_out == ("without a number for their Young's modulus: five, six",)


def test_weights_stay_positive_and_no_rule_vanishes(tmp_path):
    # Numbers as if the rule of light gels were not there.
    true = vocabulary().replace(" and Young's modulus is low weighing 0.2", "")
    learnt = fitted(
        request_of(
            tmp_path, vocabulary(), "\n".join(tissues(true, many=26)) + LEARN.replace(
                "  adjust words of Young's modulus\n", ""
            )
        )
    )  # fmt: skip
    weights = {weight.start: now for weight, now in learnt.weights}
    assert LEAST <= weights[0.2] < 0.15
    assert all(0.0 < now <= 1.0 for now in weights.values())


def test_held_out_tissues_are_not_fitted_and_can_be_expected(tmp_path):
    listed = tissues(vocabulary())
    listed[0] = listed[0].rpartition("=")[0] + "= 7 kPa }"
    text = "\n".join(listed)
    whole = LEARN.replace("  write", "  hold out gel A\n  write")
    expects = (
        "expect error(held out) > 5 %\nexpect error(gel B) < 1 %\nexpect error(data) < 1 %\n"
    )
    learnt = fitted(request_of(tmp_path, vocabulary(), text + whole + expects))
    assert [one.target.tissue for one in learnt.numbers if one.target.held_out] == ["gel a"]
    assert learnt.texts == {}  # the others agree
    assert learnt.errors["held out"] == learnt.errors["gel a"] == learnt.numbers[0].factor - 1.0
    assert [one.holds for one in learnt.verdicts] == [True] * 3


def test_a_change_of_numbers_that_are_not_fitted_is_reported(tmp_path):
    facts = "described in gel; firmness is medium; weight = 5"
    text = f"""
    tissue one {{ {facts}; density = 1.05 g/cm^3; Young's modulus = 10 kPa }}
    learn gels {{ fit = density of one; adjust weights of gel }}
    """
    learnt = fitted(request_of(tmp_path, vocabulary(), text))
    (note,) = learnt.notes
    assert note.startswith(
        "words also change the Young's modulus, which is not fitted, by up to"
    )
    assert note.endswith("(one)")


def test_the_passes_can_run_out(tmp_path):
    text = "\n".join(tissues(vocabulary())) + LEARN.replace("  write", "  passes = 2\n  write")
    learnt = fitted(request_of(tmp_path, vocabulary(LOW="9 kPa", MEDIUM="90 kPa"), text))
    assert not learnt.converged and learnt.reason == "the passes ran out"


# --- the shipped vocabulary -------------------------------------------------------------------

QUANTITY = "Young's modulus"


def disturbed_library(folder: Path, seed: int) -> Request:
    """Return a fit of shipped words, disturbed by up to a factor of three, to all presets."""
    source = random.Random(seed)
    text = (library() / "fuzzy" / "soft_matter.tis").read_text()
    old = {"4.95 kPa": 4.95e3, "350 kPa": 350e3, "24.75 MPa": 24.75e6}
    for written, value in old.items():
        assert written in text
        text = text.replace(written, f"{value * 3.0 ** source.uniform(-1, 1):.4g} Pa")
    (folder / "fuzzy").mkdir()
    (folder / "fuzzy" / "soft_matter.tis").write_text(text)
    presets = sorted(path.stem for path in (library() / "matter").glob("*.tis"))
    uses = "".join(f'use "matter/{name}"\n' for name in presets)
    learn = (
        f"learn soft matter {{\n  fit = {QUANTITY} of all tissues\n"
        f"  adjust words of {QUANTITY}\n  adjust weights of soft matter\n"
        '  hold out = [skin, liver]\n  write "learnt.tis"\n}\n'
    )
    (folder / "fit.tis").write_text(f"language 1\n{uses}{learn}")
    return Request.file(folder / "fit.tis", libraries=[folder])


@pytest.mark.parametrize("seed", [1, 2])
def test_shipped_words_that_were_disturbed_give_the_moduli_again_in_seconds(tmp_path, seed):
    learnt = fitted(disturbed_library(tmp_path, seed))
    assert learnt.converged
    assert max(one.factor_before for one in learnt.numbers) > 2.0
    assert len(learnt.numbers) > 20
    assert learnt.errors["data"] < 0.5  # within a factor of 1.5
    assert learnt.errors["held out"] < 0.6  # a hedge is a factor of 2.6, its half 1.6
    assert learnt.wall_time < 20.0
    again = reread_words(disturbed_request(tmp_path), learnt.texts)
    scale = again.vocabulary.quantities["young's modulus"].named.scale
    low, medium, high = scale.words.values()
    assert low.middle < medium.middle < high.middle
    # Words overlap: at each place, degrees still sum to 1 between the outer peaks.
    for place in np.linspace(low.middle, high.middle, 50):
        assert sum(one.degree(place) for one in (low, medium, high)) == pytest.approx(1.0)


def disturbed_request(folder: Path) -> Request:
    return Request.file(folder / "fit.tis", libraries=[folder])


def test_a_tissue_that_no_rule_reaches_is_refused(tmp_path):
    text = """
    tissue one { described in gel; weight is heavy; Young's modulus = 10 kPa }
    learn gels { fit = Young's modulus of one; adjust weights of gel }
    """
    with pytest.raises(CompileError) as error:
        read_vocabulary_fits(request_of(tmp_path, vocabulary(), text))
    (found,) = error.value.diagnostics
    assert found.code == "TIS802"
    assert "words do not give the Young's modulus of one: no rule of gel fires" in found.message
