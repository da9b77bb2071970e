"""Rules are revised where what was held out says so, and nowhere else."""

import math
from functools import cache

import pytest

from tests.learn.wordy import SETTING, scene_of
from tissuec.learn.vocabulary.revision import RuleTexts, dropped, other_conclusions, revise
from tissuec.learn.vocabulary.texts import apply
from tissuec.learn.vocabulary.used import reread, warnings_of

HEAD = """language 1
hedge very = shift(50 %, outward)
property hardness from 0 to 1 { evenly = [soft, medium, hard] }
property "use of it" from 0 to 1 { evenly = [rare, "now and then", often] }
quantity spring constant from 2 N/m to 2000 N/m on log scale {
  evenly = [low, Medium, high]; applies to each spring
  otherwise is Medium
}
quantity viscosity from 1 mN*s/m to 1 N*s/m on log scale {
  low = triangle(1 mN*s/m, 1 mN*s/m, 1 N*s/m); high = triangle(1 mN*s/m, 1 N*s/m, 1 N*s/m)
  applies to each spring
  otherwise is low
}
"""
RULES = """rules simple {
  # Soft things first.
  if hardness is soft then spring constant is low  # felt
  if hardness is medium  # between
    then spring constant is Medium
  if hardness is hard then spring constant is high and viscosity is low
  if "use of it" is often then viscosity is high
}
"""
BODY = """
tissue sample {k} {{ described in simple; hardness is {hardness}; "use of it" is {use}
  mass = 1 mg }}
body sample {k} {{ mesh is explicit; tissue is sample {k} }}
table nodes of sample {k} in mm with columns "id x y" {{ 1 0 0; 2 1 0 }}
table springs of sample {k} with columns "a b" {{ 1 2 }}
"""
HARDNESS = ("soft", "medium", "hard")
USES = ("rare", "often")


def text_of(rules: str) -> str:
    """Return a scene with a tissue for each combination of words."""
    samples = [(hardness, use) for use in USES for hardness in HARDNESS]
    bodies = "".join(
        BODY.format(k=letter, hardness=hardness, use=use)
        for letter, (hardness, use) in zip("bcdfgh", samples, strict=True)
    )
    return HEAD + rules + bodies + SETTING


def answers(scene):
    return {
        (tissue.name, quantity): math.log(tissue.given[quantity].value)
        for tissue in scene.tissues.values()
        for quantity in ("spring constant", "viscosity")
    }


@cache
def answers_of(text: str):
    """Return the answers of a text, as of one of which its words were changed."""
    return answers(reread(scene_of(text_of(RULES)), {"words.tis": text}))


def judged(scene, truth: str, *, blind: bool = False):
    """Return the errors of texts: what is often used is held out."""
    wanted = list(answers(scene_of(text_of(truth))).items())

    def score(texts):
        found = answers_of(texts.get("words.tis", scene.source.text))
        off = [(found[key] - value) ** 2 for key, value in wanted]
        return math.sqrt(sum(off[:6])), 1.0 if blind else math.sqrt(sum(off[6:]))

    return score


def edited(rules: str, old: str, new: str) -> str:
    assert rules.count(old) == 1
    return rules.replace(old, new)


def test_a_wrong_conclusion_is_found():
    wrong = edited(RULES, "is low  # felt", "is Medium  # felt")
    scene = scene_of(text_of(wrong))
    (change,) = revise(scene, "Simple", judged(scene, RULES))
    assert change.kind == "conclusion" and change.errors == (0.0, 0.0)
    assert change.text == text_of(RULES)
    assert change.diff.split("\n")[:3] == [
        "--- words.tis",
        "+++ words.tis",
        "@@ -13,7 +13,7 @@",
    ]
    assert [line for line in change.diff.split("\n") if line[:2] in ("- ", "+ ")] == [
        "-  if hardness is soft then spring constant is Medium  # felt",
        "+  if hardness is soft then spring constant is low  # felt",
    ]
    assert change.sentence.startswith(
        'the rule in line 16 concludes "low" instead of "Medium" for the spring constant: '
        "the error of rows that it was not fitted to falls from "
    )


def test_a_rule_too_many_is_dropped_and_its_remarks_stay():
    more = "  if hardness is not soft  # seldom\n    then spring constant is low\n"
    wrong = edited(RULES, "}\n", f"{more}}}\n")
    scene = scene_of(text_of(wrong))
    (change,) = revise(scene, "simple", judged(scene, RULES), most=1)
    assert change.kind == "drop"
    assert change.text == text_of(edited(RULES, "}\n", "  # seldom\n}\n"))


def test_a_rule_that_is_missing_is_added():
    wrong = edited(RULES, '  if "use of it" is often then viscosity is high\n', "")
    wrong = edited(wrong, " and viscosity is low", "  # stiff")
    truth = edited(wrong, "  # stiff\n", '  # stiff\n  if "use of it" is often '
                   "then viscosity is high\n")  # fmt: skip
    scene = scene_of(text_of(wrong))
    (change,) = revise(scene, "simple", judged(scene, truth), most=1)
    assert change.kind == "add" and change.text == text_of(truth)
    assert change.sentence.startswith(
        'the rule "if "use of it" is often then viscosity is high" is added: '
        "no rule applies strongly to sample f: "
    )


def test_changes_follow_one_another():
    wrong = edited(RULES, "is low  # felt", "is Medium  # felt")
    wrong = edited(wrong, "constant is high and", "constant is Medium and")
    scene = scene_of(text_of(wrong))
    first, second = revise(scene, "simple", judged(scene, RULES), most=2)
    assert second.text == text_of(RULES) and first.text != second.text
    assert first.errors[1] > second.errors[1]


def test_nothing_changes_without_a_gain_on_what_was_held_out():
    wrong = edited(RULES, "is low  # felt", "is Medium  # felt")
    scene = scene_of(text_of(wrong))
    assert revise(scene, "simple", judged(scene, RULES, blind=True)) == []
    assert revise(scene, "simple", judged(scene, RULES), gain=1.0) == []


def test_what_was_learnt_from_must_not_be_met_worse():
    scene = scene_of(text_of(RULES))
    seen = []

    def score(texts):
        seen.append(texts)
        return (1.1, 0.5) if texts else (1.0, 1.0)

    assert revise(scene, "simple", score) == []
    assert len(seen) > 5 and seen[0] == {}
    assert len(revise(scene, "simple", score, slack=0.2, most=1)) == 1


def test_errors_that_are_no_numbers_change_nothing():
    scene = scene_of(text_of(RULES))
    for bad in (math.nan, math.inf):
        assert revise(scene, "simple", lambda t, bad=bad: (bad, bad) if t else (1, 1)) == []


def test_every_text_that_is_scored_passes_check():
    scene = scene_of(text_of(RULES))
    scored = []

    def score(texts):
        if texts:
            scored.append(texts)
            codes = [warning.code for warning in warnings_of(scene, texts)]
            assert "W204" not in codes  # no contradictions
        return 1.0, 1.0

    revise(scene, "simple", score)
    # Six other conclusions, five rules to drop, new ones for viscosity of what is not hard.
    assert len(scored) > 15
    assert len({texts["words.tis"] for texts in scored}) == len(scored)


def test_conclusions_move_to_the_next_words():
    scene = scene_of(text_of(edited(RULES, "is low  # felt", "is very low  # felt")))
    whats = [one.what for one in other_conclusions(RuleTexts.of(scene, "simple"))]
    assert [what for what in whats if "line 16" in what] == [
        'the rule in line 16 concludes "low" instead of "very low" for the spring constant'
    ]
    assert sum("line 17" in what for what in whats) == 2  # medium has a word on either side
    assert sum("line 19" in what for what in whats) == 2  # both conclusions


DROPS = {
    "{ if A then B; if C then D }": ["{ if C then D }", "{ if A then B }"],
    "{\n  if A then B  # one\n  if C then D\n}": [
        "{\n  # one\n  if C then D\n}",
        "{\n  if A then B  # one\n}",
    ],
    "{ if A  # x\n  then B; if C then D }": ["{ if A  # x\n  then B }"],
}


@pytest.mark.parametrize("block", DROPS)
def test_rules_are_taken_out_of_their_lines(block):
    words = {
        "A": "hardness is soft", "B": "spring constant is low",
        "C": "hardness is hard", "D": "spring constant is high",
    }  # fmt: skip

    def full(text):
        return text_of("rules simple " + text.translate(str.maketrans(words)) + "\n")

    texts = RuleTexts.of(scene_of(full(block)), "simple")
    found = [apply([one.edit])["words.tis"] for one in dropped(texts)]
    assert found == [full(text) for text in DROPS[block]]


def test_rules_that_are_not_there_are_told():
    scene = scene_of(text_of(RULES))
    with pytest.raises(KeyError):
        revise(scene, "others", lambda texts: (1.0, 1.0))
