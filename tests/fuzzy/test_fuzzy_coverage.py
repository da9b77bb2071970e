"""Static analysis of rules: silence and contradictions, against trying facts out."""

import math
import random
from itertools import pairwise, product

import pytest

from tests.every import every
from tissuec.fuzzy.coverage import coverage
from tissuec.fuzzy.rulebase import Inference, NoRule, RuleBase
from tissuec.fuzzy.rules import (
    CHOICES,
    And,
    ConcludedQuantity,
    Conclusion,
    Conflict,
    Is,
    Not,
    Operators,
    Or,
    Rule,
    conflicts,
)
from tissuec.fuzzy.scale import Axis, evenly, shaped
from tissuec.fuzzy.sets import Gaussian, Powered, Word, points, trapezoid, triangle

AXIS = Axis("q", 0.0, 1.0)
LOW, HIGH = (
    Conclusion("q", Word(w, s)) for w, s in evenly(AXIS, ["low", "high"]).words.items()
)
THREE = evenly(Axis("p", 0.0, 1.0), ["low", "medium", "high"]).words


def when(text, name="p", words=THREE):
    return Is(name, Word(text, words[text]))


def base(*conditions, properties=("p",), operators=Operators()):  # noqa: B008  (immutable)
    return RuleBase(
        {name: Axis(name, 0.0, 1.0) for name in properties},
        {"q": ConcludedQuantity(AXIS)},
        tuple(Rule(condition, (LOW,)) for condition in conditions),
        operators,
    )


def test_rules_for_every_word_leave_no_hole():
    found = coverage(base(when("low"), when("medium"), when("high")), "q")
    assert (found.checked, found.hole) == (True, None)


def test_a_hole_is_given_as_the_whole_place_where_no_rule_fires():
    assert coverage(base(when("low")), "q").hole == {"p": (0.5, 1.0)}
    assert coverage(base(when("medium"), when("high")), "q").hole == {"p": (0.0, 1 / 6)}


def test_a_single_silent_value_is_found_too():
    assert coverage(base(when("low"), when("high")), "q").hole == {"p": (0.5, 0.5)}


def test_of_several_holes_alike_the_widest_is_given():
    words = {"a": trapezoid(0.1, 0.2, 0.3, 0.4).within(0, 1)}
    assert coverage(base(when("a", words=words)), "q").hole == {"p": (0.4, 1.0)}


def test_a_hole_is_given_in_values_on_a_log_scale():
    axis = Axis("p", 1.0, 100.0, log=True)
    words = shaped(axis, {"low": triangle(1, 1, 10)}).words
    rules = RuleBase(
        {"p": axis}, {"q": ConcludedQuantity(AXIS)}, (Rule(when("low", words=words), (LOW,)),)
    )
    hole = coverage(rules, "q").hole
    assert hole is not None
    assert hole["p"] == pytest.approx((10.0, 100.0), rel=1e-14, abs=0)


def test_a_quantity_without_rules_is_silent_everywhere():
    assert coverage(base(), "q").hole == {}
    with pytest.raises(ValueError, match='"r" is not a quantity'):
        coverage(base(), "r")


def test_negations_count_as_true_wherever_a_word_is_not_fully_true():
    assert coverage(base(Not(when("medium"))), "q").hole == {"p": (0.5, 0.5)}
    assert coverage(base(Not(when("low"))), "q").hole == {"p": (0.0, 1 / 6)}
    assert coverage(base(when("low"), Not(when("low"))), "q").hole is None


def test_bells_and_powers_are_silent_where_they_are_negligible():
    words = {"bell": Gaussian(0.5, 0.1), "narrow": Gaussian(0.5, 0.01)}
    assert coverage(base(when("bell", words=words)), "q").hole is None
    hole = coverage(base(when("narrow", words=words)), "q").hole
    assert hole is not None
    # exp(-z²/2) is a millionth at z = 5.257; a square of a bell is narrower by sqrt(2).
    reach = math.sqrt(-2 * math.log(1e-6))
    assert hole["p"][1] - hole["p"][0] == pytest.approx(0.5 - 0.01 * reach, rel=1e-13, abs=0)
    squared = {"bell": Powered(words["bell"], 2.0)}
    hole = coverage(base(when("bell", words=squared)), "q").hole
    assert hole is not None
    width = 0.5 - 0.1 * reach / math.sqrt(2)
    assert hole["p"][1] - hole["p"][0] == pytest.approx(width, rel=1e-13, abs=0)
    squared = {"low": Powered(THREE["low"], 2.0)}
    assert coverage(base(when("low", words=squared)), "q").hole == {"p": (0.5, 1.0)}


def test_corners_that_differ_by_rounding_are_no_hole_with_a_width():
    a, b = points([(0, 1), (0.3, 0)]), triangle(0.1 + 0.2, 0.4, 0.6)
    c = triangle(0.6, 0.7, 1.5)
    words = {name: word.within(0, 1) for name, word in (("a", a), ("b", b), ("c", c))}
    on_a, on_b, on_c = (when(name, words=words) for name in words)
    assert coverage(base(on_a, on_b, And((on_a, on_c))), "q").hole == {"p": (0.7, 1.0)}


def test_a_search_that_would_take_too_long_says_so():
    names = [f"p{k}" for k in range(8)]
    # Pairs of neighbours: no branch is decided early, and there is a hole only at the last.
    conditions = [
        And((when(a, x), when(b, y)))
        for x, y in pairwise(names)
        for a, b in product(("low", "medium", "high"), repeat=2)
    ]
    assert coverage(base(*conditions, properties=names), "q").checked
    short = coverage(base(*conditions, properties=names), "q", limit=3)
    assert (short.checked, short.hole) == (False, None)


def random_condition(dice, depth=2):
    kind = dice.choice(["is", "not", "and", "or"] if depth else ["is"])
    if kind == "is":
        return when(dice.choice(list(THREE)), dice.choice(["p", "r"]))
    if kind == "not":
        return Not(random_condition(dice, depth - 1))
    parts = tuple(random_condition(dice, depth - 1) for _ in range(2))
    return And(parts) if kind == "and" else Or(parts)


@every("seed", range(40))
def test_coverage_agrees_with_trying_facts_out(seed):
    dice = random.Random(seed)
    operators = Operators(**{name: dice.choice(words) for name, words in CHOICES.items()})
    conditions = [random_condition(dice) for _ in range(dice.randint(1, 4))]
    rules = base(*conditions, properties=("p", "r"), operators=operators)
    found = coverage(rules, "q")
    assert found.checked
    if found.hole is None:
        places = [*(k / 12 for k in range(13)), *(dice.random() for _ in range(7))]
        for p, r in product(places, repeat=2):
            assert isinstance(rules.infer({"p": p, "r": r})["q"], Inference)
        return
    for _ in range(20):
        inside = {n: a + (b - a) * dice.uniform(0.01, 0.99) for n, (a, b) in found.hole.items()}
        facts = {"p": dice.random(), "r": dice.random()} | inside
        assert isinstance(rules.infer(facts)["q"], NoRule)


def test_rules_with_one_condition_and_two_conclusions_are_found():
    one, other = when("low"), when("high", "r")
    rules = [
        Rule(And((one, other)), (LOW,)),
        Rule(one, (LOW,)),
        Rule(And((other, one)), (HIGH,)),
        Rule(And((one, other)), (LOW,)),
        Rule(Not(one), (LOW, HIGH)),
    ]
    assert conflicts(rules) == [Conflict(0, 2, "q"), Conflict(4, 4, "q")]


def test_different_quantities_or_equal_sets_are_no_conflict():
    elsewhere = Conclusion("t", HIGH.word)
    spelled = Conclusion("q", Word("LOW", LOW.word.shape))
    condition = when("low")
    rules = [
        Rule(condition, (LOW,)),
        Rule(condition, (elsewhere,)),
        Rule(condition, (spelled,)),
    ]
    assert conflicts(rules) == []
