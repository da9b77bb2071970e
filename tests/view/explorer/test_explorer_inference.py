"""The page infers what Python infers, on vocabularies that nobody prepared."""

import math
import re

import pytest

from tests.examples import examples
from tests.view.explorer.scripts import INFER, script  # noqa: F401  # a fixture
from tests.view.explorer.vocabularies import facts, of_file, vocabulary
from tissuec.core.prefixes import shown_units
from tissuec.core.resources import library
from tissuec.core.units import DIMENSION_NAMES, show, si_unit
from tissuec.fuzzy.rulebase import Inference
from tissuec.fuzzy.rules import CHOICES
from tissuec.scene.tissues.conclusions import why
from tissuec.scene.tissues.quantities import QUANTITIES
from tissuec.view.explorer.tables import shown_units_of

SEEDS = range(60)
CASES = 40
#: Relative. Both do the same steps; only exp, log and erfc differ, in their last digits.
ALIKE = 1e-9


def expected(one, rules, case):
    """Return what Python says in the form of the script."""
    chosen = one.words.vocabulary.rules[rules]
    answers, degrees = {}, [0.0] * len(chosen.base.rules)
    for key, answer in chosen.base.infer(case).items():
        is_found = isinstance(answer, Inference)
        for firing in (*(answer.fired if is_found else ()), *answer.silent):
            degrees[firing.rule] = firing.degree
        answers[key] = {
            "source": answer.source if is_found else "none",
            "value": answer.value if is_found else None,
            "reason": "" if is_found else re.sub(r" at \S*/", " at ", why(chosen, answer)),
        }
    return {"degrees": degrees, "answers": answers}


def assert_alike(found, wanted):
    # A word that is woken by rounding alone could be the only one that speaks.
    assert [d > 0 for d in found["degrees"]] == [d > 0 for d in wanted["degrees"]]
    assert found["degrees"] == pytest.approx(wanted["degrees"], rel=ALIKE, abs=1e-15)
    for key, answer in wanted["answers"].items():
        assert found["answers"][key]["source"] == answer["source"]
        assert found["answers"][key]["reason"] == answer["reason"]
        assert found["answers"][key]["value"] == (
            answer["value"] and pytest.approx(answer["value"], rel=ALIKE, abs=1e-15)
        )


def compare(script, one, seed, count):  # noqa: F811
    cases = [
        {"rules": rules, "facts": case}
        for rules in one.words.vocabulary.rules
        for case in facts(one, rules, count, seed)
    ]
    answers = script(INFER, {"tables": one.tables, "cases": cases})
    for case, found in zip(cases, answers, strict=True):
        assert_alike(found, expected(one, case["rules"], case["facts"]))


@pytest.mark.parametrize(
    "seed",
    [pytest.param(seed, marks=() if seed % 4 == 0 else pytest.mark.slow) for seed in SEEDS],
)
def test_a_random_vocabulary_infers_as_python_does(script, seed):  # noqa: F811
    compare(script, vocabulary(seed), seed, CASES)


@pytest.mark.parametrize("path", sorted(library().glob("fuzzy/*.tis")), ids=lambda p: p.stem)
def test_a_shipped_vocabulary_infers_as_python_does(script, path):  # noqa: F811
    compare(script, of_file(path), 0, examples(2000))


def test_random_vocabularies_meet_what_they_are_meant_to_meet():
    pages = [vocabulary(seed).tables for seed in SEEDS]
    kinds = [key for page in pages for row in page["shapes"] for key in row]
    assert min(kinds.count(kind) for kind in ("xs", "sigma", "exponent")) > 30
    rules = [rules for page in pages for rules in page["rules"]]
    assert {r["operators"]["result"] for r in rules} == set(CHOICES["result"])
    assert any(r["otherwise"] for r in rules) and not all(r["otherwise"] for r in rules)
    scales = [scale for page in pages for scale in page["properties"]]
    assert any(scale["log"] for scale in scales) and any(scale["unit"] for scale in scales)


def test_tails_keep_their_digits(script):  # noqa: F811
    places = [k / 16 for k in range(16 * 26)]
    found = script("return given.map(erfc);", places)
    # The series ends below 2 with erf near 1, which costs three of sixteen digits.
    assert found == pytest.approx([math.erfc(x) for x in places], rel=1e-12)


def test_values_are_shown_as_messages_show_them(script):  # noqa: F811
    values = [m * 10.0**p for p in range(-12, 13) for m in (0, 1, -1, 9.996, 9.994, 3.16228)]
    pairs = [(value, kind) for kind in DIMENSION_NAMES for value in values]
    given = [
        (value, [(one.size, one.unit) for one in shown_units(si_unit(kind))])
        for value, kind in pairs
    ]
    expected = [show(value, kind) for value, kind in pairs]
    for quantity in (one for one in QUANTITIES.values() if one.unit):
        given += [(value, shown_units_of(quantity)) for value in (*values, 9999.0, 1e4)]
        expected += [quantity.show(value) for value in (*values, 9999.0, 1e4)]
    found = script("return given.map(([value, units]) => show(value, units));", given)
    assert found == expected


# --- the curve of stress ----------------------------------------------------------------------


@pytest.mark.parametrize("stiffening", [None, 8.0])
def test_the_curve_of_stress_is_that_of_the_law(script, stiffening):  # noqa: F811
    strains = [0.0, 1e-3, 0.1, 0.5, 1.0]
    given = {"numbers": {"young": 5e3, "stiffening": stiffening}, "strains": strains}
    found = script("return given.strains.map((one) => stressAt(given.numbers, one));", given)
    k = stiffening or 1.0
    expected = [
        5e3 / k * math.expm1(k * one) if stiffening else 5e3 / 3 * (1 + one - (1 + one) ** -2)
        for one in strains
    ]
    assert found == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("limits", "strain"),
    [
        ({"breaking": 0.4, "strength": None}, 0.4),
        ({"breaking": 0.4, "strength": 1e9}, 0.4),
        ({"breaking": 0.4, "strength": 1000.0}, math.log(1 + 8 * 0.2) / 8),
        ({"breaking": None, "strength": 1000.0}, math.log(1 + 8 * 0.2) / 8),
        ({"breaking": None, "strength": None}, None),
    ],
)
def test_the_curve_ends_where_the_tissue_tears(script, limits, strain):  # noqa: F811
    numbers = {"young": 5e3, "stiffening": 8.0, **limits}
    found = script("return tearing(given);", numbers)
    assert found == (strain if strain is None else pytest.approx(strain, rel=1e-9))


def test_the_nearest_tissue_is_that_of_the_least_ratio(script):  # noqa: F811
    pairs = [["liver", 5e3], ["muscle", 4e4], ["none", None]]
    lines = "return given.values.map((one) => nearest(given.pairs, one)?.[0] ?? null);"
    assert script(lines, {"pairs": pairs, "values": [1e3, 1.3e4, 1.5e4]}) == [
        "liver", "liver", "muscle",
    ]  # fmt: skip
    assert script(lines, {"pairs": [], "values": [1e3]}) == [None]
