"""The command that fits words to numbers of tissues: what it prints, writes and refuses."""

import json
import re
import sys
from pathlib import Path

import pytest

from tests.learn.measured_gels import LEARN, request_of, tissues, vocabulary
from tissuec.cli import group, run_guarded
from tissuec.core.errors import CompileError
from tissuec.pipeline import check_request, read_words
from tissuec.scene.request import Request

DISTURBED = {"LOW": "9 kPa", "MEDIUM": "60 kPa", "WEIGHT": "0.1"}


@pytest.fixture
def ran(capsys, monkeypatch):
    """Return a function that gives the exit code and what was printed on stdout and stderr."""

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["tissuec", "learn", *map(str, arguments)])
        code = run_guarded(group)
        return code, *capsys.readouterr()

    return run


@pytest.fixture
def gels(tmp_path):
    """Return a text that fits a disturbed vocabulary."""
    text = "\n".join(tissues(vocabulary())) + LEARN + "expect error(data) < 5 %"
    request_of(tmp_path, vocabulary(**DISTURBED), text)
    return tmp_path / "fit.tis"


def test_what_is_written_gives_what_is_reported(gels, ran):
    code, out, err = ran(gels, "--json")
    assert code == 0 and not err
    document = json.loads(out)
    target = gels.parent / "learnt" / "gels.tis"
    assert document["written"] == [str(target)]
    factors = [one["factor"] for one in document["numbers"]]
    assert document["errors"]["data"] == pytest.approx(max(factors) - 1.0)
    text = target.read_text()
    assert text.startswith("language 1\n# Learned by tissuec")
    assert "# The numbers of the gels." in text and "adjust" not in text
    # The same tissues use the new words.
    listed = "\n".join(tissues(vocabulary()))
    (gels.parent / "after.tis").write_text(f'language 1\nuse "./learnt/gels"\n{listed}\n')
    words, warnings = read_words(Request.file(gels.parent / "after.tis"))
    assert not warnings
    for one in document["numbers"]:
        assert words.tissues[one["tissue"]].concluded[one["quantity"]] == one["after"]
    # Shared corners are still shared, and written with few digits.
    scale = words.vocabulary.quantities["young's modulus"].named.scale
    low, medium, high = scale.words.values()
    assert low.support[1] == medium.middle == high.support[0]
    written = text[text.index("low = ") : text.index("rules gel")]
    numerals = re.findall(r"([\d.]+) [kM]?Pa", written)
    assert len(numerals) == 9
    assert all(len(numeral.replace(".", "")) <= 4 for numeral in numerals)


def test_the_report_names_ratios_words_and_weights(gels, ran):
    code, out, err = ran(gels, "--diff")
    assert code == 0
    lines = out.splitlines()
    assert lines[0] == "learn gels: the error no longer decreases"
    head = ["quantity of tissue", "number", "from words, before", "from words, after", "ratio"]
    assert re.split(r" {2,}", lines[1]) == head
    assert sum(line.startswith("Young's modulus of gel ") for line in lines) == 12
    assert any(line.startswith('word: "low" of Young\'s modulus moves down') for line in lines)
    assert any(line.startswith("weight: 0.1 becomes 0.") for line in lines)
    assert any(line.startswith("largest factor: 1.0") for line in lines)
    assert "-  low = triangle(1 kPa, 9 kPa, 60 kPa)" in lines
    assert "expectations: 1 of 1 hold" in err and f"wrote {gels.parent / 'learnt'}" in err


def test_a_failed_expectation_writes_nothing_unless_anyway(gels, ran):
    gels.write_text(gels.read_text().replace("< 5 %", "< 0.0001 %"))
    code, _, err = ran(gels)
    target = gels.parent / "learnt" / "gels.tis"
    assert code == 1 and not target.exists()
    assert "FAILED: 1 expectation failed; no preset is written (to write it: --anyway)" in err
    assert ran(gels, "--anyway")[0] == 1
    assert "# expected   FAILS: error(data) = " in target.read_text()


def test_files_of_others_are_kept(gels, ran):
    target = gels.parent / "learnt" / "gels.tis"
    target.parent.mkdir()
    target.write_text("language 1\n")
    code, _, err = ran(gels)
    assert code == 2 and "was not written by learning" in err
    assert target.read_text() == "language 1\n"
    assert ran(gels, "-o", gels.parent / "words.tis")[0] == 2  # a file of the text
    assert ran(gels, "--force")[0] == 0


def test_there_is_no_motion_whose_derivatives_could_be_checked(gels, ran):
    code, _, err = ran(gels, "--check-gradient")
    assert code == 2 and "learn gels has no data" in err


@pytest.fixture
def apart(tmp_path):
    """Return a text that fits words of a property, whose file the rules use."""
    head, rest = vocabulary().split("# The numbers", 1)
    (tmp_path / "properties.tis").write_text(head)
    facts = {"A": ("= 5.5", "90 kPa"), "B": ("= 4", "30 kPa")}
    text = "".join(
        f"tissue {name} {{ described in gel; firmness {place}; weight is light; "
        f"Young's modulus = {number} }}\n"
        for name, (place, number) in facts.items()
    )
    learn = "learn gels { fit = Young's modulus of all tissues; adjust words of firmness }\n"
    rules = f'language 1\nuse "./properties"\n# The numbers{rest}'
    request_of(tmp_path, rules, text + learn)
    return tmp_path / "fit.tis"


def test_words_of_properties_go_into_a_file_beside_that_of_the_rules(apart, ran):
    folder = apart.parent
    target = folder / "gels.tis"
    code, out, err = ran(apart, "--json", "-o", target)
    assert code == 0, out + err
    written = json.loads(out)["written"]
    assert [Path(one).name for one in written] == ["gels.tis", "properties_2.tis"]
    assert 'use "./properties_2"' in target.read_text()
    changed = (folder / "properties_2.tis").read_text()
    assert changed.startswith("language 1\n# Learned by") and "trapezoid(" in changed
    check_request(Request.file(target))


def test_a_place_where_files_are_missing_is_refused_before_the_fit(apart, ran):
    text = apart.read_text().replace("words of firmness", "words of Young's modulus")
    apart.write_text(text)
    target = apart.parent / "new" / "gels.tis"
    code, _, err = ran(apart, "-o", target)
    assert code == 2 and not target.exists()
    assert f"the vocabulary cannot be written as {target}, where it is not valid" in err


SCENE = """
body block {
  mesh is lattice {
    cell = 5 mm; box from (0, 0, 0) mm to (5, 5, 5) mm
  }
  tissue is gel A
}
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 1 ms }
"""


def test_a_scene_can_have_such_a_block(gels, ran):
    facts = "retardation time = 1 ms; density = 1 g/cm^3 }"
    text = gels.read_text().replace(" Pa }", f" Pa; {facts}", 1)
    gels.write_text(text + SCENE)
    compiled, _ = check_request(Request.file(gels))
    assert compiled.fit_problems == () and len(compiled.vocabulary_fits) == 1
    assert len(compiled.vocabulary_fits[0].demands) == 1
    assert ran(gels)[0] == 0
    assert (gels.parent / "learnt" / "gels.tis").exists()


def test_a_block_with_data_needs_a_scene(gels):
    gels.write_text(gels.read_text() + '\nlearn gum { data = "a.csv"; fit = force(tip) }\n')
    with pytest.raises(CompileError) as error:
        check_request(Request.file(gels))
    (found,) = error.value.diagnostics
    assert found.code == "TIS304" and found.message == "the learn block gum has no scene"
