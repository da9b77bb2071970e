"""Words are proposed that lead to the numbers that were asked for."""

import json
import math
import re

import pytest
from click.testing import CliRunner

from tissuec.analysis.proposal import propose
from tissuec.cli import group
from tissuec.core.errors import CompileError, TissueError
from tissuec.core.source import Source
from tissuec.pipeline import read_words
from tissuec.scene.request import Request

WORDS = """language 1
hedge very = shift(50 %, outward)
hedge rather = shift(50 %, inward)
property hardness from 0 to 1 { evenly = [soft, medium, hard] }
property weight from 0 to 1 { evenly = [low, medium, high] }
property smell from 0 to 1 { evenly = [faint, strong] }
quantity Young's modulus from 1 kPa to 100 kPa on log scale { evenly = [low, medium, high] }
quantity density from 0.9 g/cm^3 to 1.2 g/cm^3 { evenly = [low, medium, high] }
rules simple {
  conjunction is product; result is gradual mean
  if hardness is soft then Young's modulus is low
  if hardness is medium then Young's modulus is medium
  if hardness is hard then Young's modulus is high
  if weight is low then density is low
  if weight is medium then density is medium
  if weight is high then density is high
}
"""


def read(text):
    return read_words(Request(Source("words.tis", text)))[0]


def proposed(numbers, text=WORDS):
    words = read(f"{text}tissue asked {{ {numbers} }}\n")
    return propose(words.vocabulary, words.tissues["asked"].given)


# A gradual mean moves the words at both ends outward.
@pytest.mark.parametrize(
    ("modulus", "phrase"),
    [
        ("1.5 kPa", "soft"),
        ("10 kPa", "medium"),
        ("68 kPa", "hard"),
        ("3.8 kPa", "rather soft"),
    ],
)
def test_the_words_of_a_number_lead_to_it(modulus, phrase):
    found = proposed(f"Young's modulus = {modulus}; density = 1.05 g/cm^3")
    words = {one.property: one.phrase for one in found.words}
    assert words["hardness"] == phrase
    for one in found.numbers:
        assert one.ratio == pytest.approx(1.0, abs=0.05)
        assert one.ratio == one.found / one.wanted


def test_the_text_that_is_proposed_gives_what_is_said_of_it():
    found = proposed("Young's modulus = 30 kPa; density = 1.11 g/cm^3")
    tissue = read(f"{WORDS}{found.text('pasted tissue')}\n").tissues["pasted tissue"]
    for one in found.numbers:
        assert tissue.given[one.quantity.lower()].value == pytest.approx(one.found, rel=1e-12)


def test_words_say_to_what_degree_they_hold_and_what_they_decide():
    found = proposed("Young's modulus = 4.6 kPa; density = 1.05 g/cm^3")
    (hardness,) = (one for one in found.words if one.property == "hardness")
    degrees = dict(hardness.degrees)
    assert 0.0 < degrees["medium"] < degrees["soft"] < 1.0
    assert hardness.decides == "Young's modulus"


def test_properties_without_effect_are_left_out():
    found = proposed("Young's modulus = 10 kPa")
    assert [one.property for one in found.words] == ["hardness"]
    assert found.left == ("weight",)  # no rule asks for the smell
    assert [one.quantity for one in found.numbers] == ["Young's modulus"]


def test_a_number_beyond_the_scale_has_the_outermost_words_and_its_ratio():
    found = proposed("Young's modulus = 1 GPa")
    (word,), (number,) = found.words, found.numbers
    assert word.phrase == "very hard"
    assert number.ratio < 0.2


def test_the_search_begins_with_the_words_that_a_tissue_has():
    text = WORDS.replace(
        "  if weight is low then density is low\n",
        """
  if weight is low then density is low and Young's modulus is medium weighing 0.01
""",
    )
    words = read(f"{text}tissue asked {{ Young's modulus = 10 kPa; density = 1.05 g/cm^3 }}\n")
    given, own = words.tissues["asked"].given, {"hardness": 0.5, "weight": 0.5}
    found = propose(words.vocabulary, given, "simple", own)
    assert {one.property: one.phrase for one in found.words} == {
        "hardness": "medium", "weight": "medium",
    }  # fmt: skip
    (density,) = (one for key, one in given.items() if key == "density")
    free = propose(
        words.vocabulary, {"density": density}, "simple", {"hardness": 0.9, "weight": 0.9}
    )
    assert [one.property for one in free.words] == ["weight"]


def test_numbers_that_no_rule_concludes_are_refused():
    with pytest.raises(TissueError, match=r"it concludes: density, Young's modulus"):
        proposed("strength = 5 kPa")
    with pytest.raises(TissueError, match="has no rules"):
        proposed("density = 1 g/cm^3", "language 1\n")


# --- the command ------------------------------------------------------------------------------


def words(*arguments):
    done = CliRunner().invoke(group, ["words", *arguments], standalone_mode=False)
    if isinstance(done.exception, CompileError | TissueError):
        return str(done.exception)
    assert done.exception is None, done.exception
    return done.stdout + done.stderr


def test_numbers_are_given_as_a_text():
    said = words("--from", "Young's modulus = 5 kPa, density = 1.05 g/cm^3")
    row = re.search(r"Young's modulus +5 kPa +(\S+) kPa +(\S+)$", said, re.M)
    assert row and float(row[1]) / 5.0 == pytest.approx(float(row[2]), abs=0.01)
    assert "described in soft matter" in said and "tissue proposed tissue {" in said


def test_shipped_tissues_are_found_by_name_wherever_they_are():
    numbers = json.loads(words("--json", "--from", "cirrhotic liver"))["numbers"]
    (modulus,) = (one for one in numbers if one["quantity"] == "Young's modulus")
    assert modulus["wanted"] == 25e3
    assert abs(math.log(modulus["ratio"])) < math.log(1.2)


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        ("livre", 'did you mean "liver"'),
        ("Yung's modulus = 5 kPa", 'did you mean "Young\'s modulus"'),
        ("Young's modulus = 5 mm", "must be a pressure"),
        ("Young's modulus = soft", "soft"),
        ("prestress = 5 %", "no rule of soft matter concludes any of these numbers"),
    ],
)
def test_what_is_wrong_is_said_with_a_way_out(asked, told):
    assert told in words("--from", asked)


def test_a_tissue_of_words_has_no_number_to_start_from(tmp_path):
    path = tmp_path / "mine.tis"
    path.write_text(
        f"{WORDS}tissue gum {{ described in simple; hardness is soft; weight is low }}\n"
    )
    assert "gum has no written number; its words are: hardness soft" in words(
        str(path), "--from", "gum"
    )


def test_a_file_of_my_own_can_have_the_words(tmp_path):
    path = tmp_path / "mine.tis"
    path.write_text(f"{WORDS}tissue gum {{ Young's modulus = 46 kPa; strength = 1 kPa }}\n")
    said = words(str(path), "--from", "gum")
    assert "hardness is hard" in said and "no rule concludes: strength" in said
