"""Presets: what is written compiles strictly, is laid out, and gives the learnt numbers."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.learn.learnings import BLIND, CHANGED, compiled_of, estimates, learnt, learnt_of
from tests.learn.learnings import starts as starts_of
from tissuec.core.errors import TissueError
from tissuec.core.source import Source
from tissuec.core.units import LENGTH, MASS, NUMBER, STIFFNESS, parse_unit
from tissuec.lang.printer import format_source
from tissuec.learn.presets.preset import compose, place
from tissuec.learn.presets.tissues import digits, exact
from tissuec.learn.presets.tissues import learnt as learnt_text
from tissuec.learn.vocabulary.moving import WordsModel
from tissuec.pipeline import check_request, compile_request, read_words
from tissuec.scene.request import Request

ROUNDED = 6e-6  # relative: half a unit in the sixth digit
GUM = """tissue gum {
  spring constant = 40 N/m; viscosity = 10 mN*s/m per 2 mm; mass = 10 mg; prestress = 1.25 %
  breaking force is none
  spring law is exponential { stiffening = 3 }
}
"""
SCARRED = GUM + "tissue scarred like gum { spring constant = 80 N/m }\n"
SCAR = "region scar where x > 12 mm { tissue is scarred }\n  interface is softer"
FREE = """param cube = 4 N/m^3
let twice = -2 * cube
tissue gum {
  viscosity = 10 mN*s/m; spring constant = 3 N/m; mass = 1 g
  spring force of e = c * e + cube * e^3 - twice * e^3
  viscous force of drawn and rate = d * (1 + cube / (1 N/m^3) * drawn / rest length) * rate
}
"""
DESCRIBED = """tissue fat {
  described in soft tissue
  hardness is slightly soft; elasticity is between small and medium; weight = 0.3
  shiftability is high; consistency is smooth
}
"""
OWN_WORDS = """property hardness from 0 to 1 { evenly = [soft, hard] }
quantity spring constant from 2 N/m to 2000 N/m on log scale {
  evenly = [low, high]
  applies to each spring of 1 mm
}
rules own {
  conjunction is minimum; disjunction is maximum; result is centre of gravity
  if hardness is soft then spring constant is low
  if hardness is hard then spring constant is high
}
tissue fat { described in own; hardness is soft; viscosity = 1 mN*s/m; mass = 10 mg }
"""


def written(folder, adjust, *, change=None, **options):
    """Write the preset of a learning; return its text, its words, and the scene's tissues."""
    compiled, request = compiled_of(folder, adjust, **options)
    found = learnt_of(compiled)
    if change is not None:
        found = change(compiled, found)
    target = compiled.fit_problems[0].write
    files = place(compose(found, compiled, request, target), force=False)
    assert files[0] == target
    return target.read_text(), words_of(target), compiled


def words_of(target):
    """Return what a preset says by itself; it is checked strictly and is laid out."""
    text = target.read_text()
    assert format_source(Source("preset", text)) == text
    request = Request.file(target, strict=True)
    assert check_request(request) == (None, ())
    return read_words(request)[0]


def value(words, tissue, quantity):
    return words.tissues[tissue].given[quantity].value


def test_a_tissue_of_the_library_is_like_its_original(tmp_path):
    adjust = "adjust = [spring constant, viscosity]"
    text, words, compiled = written(tmp_path, adjust, top='use "tissues/fat"')
    before = compiled.scene.tissues["fat"].given
    assert text.startswith('language 1\nabout "fat, learned from one.csv"\nuse "tissues/fat"\n')
    assert "tissue learned fat like fat {" in text
    for name in ("spring constant", "viscosity"):
        expected = before[name].value * CHANGED
        assert value(words, "learned fat", name) == pytest.approx(expected, rel=ROUNDED)
    assert value(words, "learned fat", "mass") == before["mass"].value


def test_a_number_is_written_with_its_interval_and_what_it_was(tmp_path):
    text, _, _ = written(tmp_path, "adjust spring constant of gum", top=GUM, tissue="gum")
    line = next(line for line in text.splitlines() if line.startswith("  spring constant"))
    assert line == (
        "  spring constant = 49.3827 N/m  # 95 %: 48.89 N/m to 49.88 N/m; before: 40 N/m"
    )


def test_the_origin_is_told_in_comments(tmp_path):
    text, _, _ = written(tmp_path, "adjust spring constant of fat", top='use "tissues/fat"')
    comments = [line for line in text.splitlines() if line.startswith("#")]
    assert comments[0].startswith("# Learned by tissuec ")
    assert comments[0].endswith("from scene.tis, learn fat, seed 7")
    assert comments[1:] == [
        "#",
        "# data       one.csv: error 3.1 %",
        f"#            sha256 {'ab' * 32}",
        "# data       two.csv, held out: error 4.2 %",
        f"#            sha256 {'cd' * 32}",
        "# fit        force(pressed)",
        "# noise      force(pressed): 2.01 mN",
        "# method     least squares, forward sensitivities; velocity verlet, 1000 steps of "
        "50 us",
        "# error      120 before, 0.5 after",
        "# end        the error no longer decreases",
    ]


def test_a_tissue_of_the_scene_itself_is_written_in_full(tmp_path):
    adjust = "adjust = [spring constant, prestress, stiffening]"
    text, words, compiled = written(tmp_path, adjust, top=GUM, tissue="gum", fit_problem="gum")
    assert "use " not in text and "tissue learned gum {" in text
    old, new = compiled.scene.tissues["gum"], words.tissues["learned gum"]
    assert new.given["viscosity"].value == old.given["viscosity"].value
    assert new.given["viscosity"].length == 2e-3
    assert new.given["mass"].value == old.given["mass"].value
    assert new.given["breaking force"].value == np.inf
    assert new.given["prestress"].value == pytest.approx(0.0125 * CHANGED, rel=ROUNDED)
    assert new.laws["spring law"].law.stiffening == pytest.approx(3 * CHANGED, rel=ROUNDED)


def test_the_words_of_a_tissue_of_the_scene_are_kept(tmp_path):
    top = f'use "fuzzy/soft_tissue"\n{DESCRIBED}'
    text, words, compiled = written(tmp_path, "adjust viscosity of fat", top=top)
    assert 'use "fuzzy/soft_tissue"' in text and "hardness is slightly soft" in text
    old, new = compiled.scene.tissues["fat"], words.tissues["learned fat"]
    assert [fact.number for fact in new.facts] == [fact.number for fact in old.facts]
    assert new.given["spring constant"].value == old.given["spring constant"].value
    assert new.given["viscosity"].how == "written"


def test_numbers_stand_in_the_place_of_words_that_only_the_scene_has(tmp_path):
    text, words, compiled = written(tmp_path, "adjust viscosity of fat", top=OWN_WORDS)
    old, new = compiled.scene.tissues["fat"].given, words.tissues["learned fat"].given
    assert "# hardness is soft" in text
    # The rules give it for springs of 1 mm, and so must the number.
    assert new["spring constant"].value == old["spring constant"].value
    assert new["spring constant"].length == old["spring constant"].length == 1e-3


def test_a_single_tissue_is_called_like_the_block_where_that_is_free(tmp_path):
    _, words, _ = written(
        tmp_path, "adjust viscosity of fat", top='use "tissues/fat"', fit_problem="phantom"
    )
    assert "phantom" in words.tissues


def test_a_name_that_another_tissue_has_is_not_given_again(tmp_path):
    top = GUM + "tissue learned gum like gum { mass = 1 mg }\n"
    _, words, _ = written(
        tmp_path, "adjust viscosity of gum", top=top, tissue="gum", fit_problem="gum"
    )
    assert list(words.tissues) == ["learned gum 2"]


def test_each_part_of_a_body_has_a_tissue_of_its_own(tmp_path):
    adjust = "adjust viscosity of block per region; adjust spring constant of gum"
    text, words, _ = written(
        tmp_path, adjust, top=SCARRED, tissue="gum", fit_problem="gum", regions=SCAR
    )
    assert "# for scar of block\ntissue learned scar {" in text
    assert set(words.tissues) == {"learned gum", "learned block", "learned scar"}
    grown = pytest.approx(0.01 * CHANGED, rel=ROUNDED)
    assert value(words, "learned scar", "viscosity") == grown
    assert value(words, "learned scar", "spring constant") == 80.0
    # What the tissue learnt as a whole holds for the part that is made of it.
    stiffer = pytest.approx(40.0 * CHANGED, rel=ROUNDED)
    assert value(words, "learned block", "spring constant") == stiffer
    assert value(words, "learned gum", "viscosity") == 0.01


def test_a_formula_is_written_with_its_constants_as_numbers(tmp_path):
    text, words, _ = written(
        tmp_path, "adjust cube of gum", top=FREE, tissue="gum", fit_problem="gum"
    )
    force = words.tissues["learned gum"].laws["spring law"].formula
    at = 0.3
    found = float(force.at({"e": at, "c": 3.0, "rest": 1.0}))
    # The let is computed of the param as it was before, and only the param was learnt.
    assert found == pytest.approx(3.0 * at + (4.0 * CHANGED + 8.0) * at**3, rel=ROUNDED)
    assert "# cube: 95 %:" in text
    braked = words.tissues["learned gum"].laws["viscosity law"].formula
    found = float(braked.at({"e": at, "w": 2.0, "d": 5.0, "rest": 1.0}))
    assert found == pytest.approx(10.0 * (1.0 + 4.0 * CHANGED * at), rel=ROUNDED)


def test_what_another_param_says_on_the_command_line_is_not_lost(tmp_path):
    organs = tmp_path / "learned"
    organs.mkdir()
    (organs / "gum.tis").write_text(f"language 1\nparam heavy = 10 mg\n{GUM}".replace(
        "mass = 10 mg", "mass = heavy"
    ))  # fmt: skip
    compiled_of(tmp_path, "adjust viscosity of gum", top=GUM, tissue="gum")
    scene = tmp_path / "scene.tis"
    scene.write_text(scene.read_text().replace(GUM, 'use "gum"'))
    library = (organs,)
    for overrides, start in (((), "tissue fat like gum {"), (("heavy=3 mg",), "tissue fat {")):
        request = Request.file(scene, overrides=overrides, libraries=library)
        compiled, _ = compile_request(request)
        target = compiled.fit_problems[0].write
        preset = compose(learnt_of(compiled), compiled, request, target)
        assert start in preset.text
        place(preset, force=False)
        expected = 3e-6 if overrides else 1e-5
        assert value(words_of(target), "fat", "mass") == pytest.approx(expected, rel=1e-12)


def test_what_the_data_does_not_tell_is_marked(tmp_path):
    def unknown(compiled, found):
        adjust = found.fit_problem.adjusts[0]
        start = starts_of(compiled, adjust)
        return learnt(
            found.fit_problem, [estimates(adjust, start, told=[False])], blind=(BLIND,)
        )

    text, _, _ = written(
        tmp_path, "adjust viscosity of gum", top=GUM, tissue="gum", change=unknown
    )
    assert "mN*s/m per 2 mm  # not identified by the data; before: 10 mN*s/m" in text
    assert "# not known  only their ratios can be determined (give one mass)" in text


# --- single springs and nodes -----------------------------------------------------------------


def test_numbers_of_single_springs_stand_in_a_table(tmp_path):
    adjust = "adjust spring constant of block per spring; adjust mass of block per node"
    text, words, compiled = written(tmp_path, adjust, top=GUM, tissue="gum")
    assert not words.tissues
    assert "# numbers    spring constant per spring of block: fat_springs.csv" in text
    lines = (tmp_path / "learned" / "fat_springs.csv").read_text().splitlines()
    assert lines[1] == "# spring constant per spring of block, in N/m; low and high: 95 %"
    assert lines[2] == "id,a,b,value,low,high,identified"
    network = compiled.network
    rows = [line.split(",") for line in lines[3:]]
    assert [int(row[0]) for row in rows] == network.springs.ids.tolist()
    ends = network.node_ids[network.springs.ends]
    assert [[int(row[1]), int(row[2])] for row in rows] == ends.tolist()
    assert [float(row[3]) for row in rows] == (network.springs.stiffness * CHANGED).tolist()
    nodes = (tmp_path / "learned" / "fat_nodes.csv").read_text().splitlines()
    assert len(nodes) == 3 + len(network.mass)


def test_a_factor_of_a_set_is_a_comment(tmp_path):
    text, _, _ = written(tmp_path, "adjust rest length of block", top=GUM, tissue="gum")
    joined = " ".join(line.removeprefix("#").strip() for line in text.splitlines())
    assert "rest length of block: " in joined and "1.23457 times what it was" in joined


# --- words ------------------------------------------------------------------------------------


def moved(compiled, found):
    model = WordsModel(compiled.scene, found.fit_problem.adjusts)
    texts = model.texts(np.full(model.size, 0.2))
    return learnt(found.fit_problem, found.estimates, words=texts)


def test_words_that_moved_lie_beside_the_preset(tmp_path):
    text, words, compiled = written(
        tmp_path, "adjust words of spring constant", top='use "tissues/fat"', change=moved
    )
    assert 'use "./soft_tissue"' in text and (tmp_path / "learned/soft_tissue.tis").exists()
    old, new = compiled.scene.tissues["fat"].given, words.tissues["learned fat"].given
    assert new["mass"].value == old["mass"].value
    assert new["spring constant"].value > 1.01 * old["spring constant"].value


def test_words_of_the_scene_are_taken_out_of_it(tmp_path):
    text, words, compiled = written(
        tmp_path, "adjust words of spring constant", top=OWN_WORDS, change=moved
    )
    assert 'use "./scene_words"' in text
    beside = (tmp_path / "learned" / "scene_words.tis").read_text()
    assert "body" not in beside and format_source(Source("words", beside)) == beside
    old = compiled.scene.tissues["fat"].given["spring constant"].value
    assert value(words, "learned fat", "spring constant") > 1.01 * old


# --- files ------------------------------------------------------------------------------------


def test_the_same_learning_gives_the_same_bytes_in_any_folder(tmp_path):
    texts = []
    for name in ("here", "there"):
        (tmp_path / name).mkdir()
        text, _, _ = written(
            tmp_path / name, "adjust viscosity of fat", top='use "tissues/fat"'
        )
        texts.append(text)
    assert texts[0] == texts[1] and str(tmp_path) not in texts[0]


def test_only_what_learning_wrote_is_replaced(tmp_path):
    compiled, request = compiled_of(
        tmp_path, "adjust viscosity of fat", top='use "tissues/fat"'
    )
    target = compiled.fit_problems[0].write
    preset = compose(learnt_of(compiled), compiled, request, target)
    for _ in range(2):
        place(preset, force=False)
    mine = 'language 1\n# of my own; Learned by tissuec\nuse "tissues/fat"\n'
    target.write_text(mine)
    with pytest.raises(
        TissueError, match="was not written by learning and would be overwritten"
    ):
        place(preset, force=False)
    assert target.read_text() == mine
    place(preset, force=True)
    assert target.read_text() == preset.text


# --- numbers ----------------------------------------------------------------------------------

FINITE = st.floats(min_value=1e-12, max_value=1e12)


@given(FINITE, st.sampled_from([LENGTH, MASS, STIFFNESS, NUMBER]), st.booleans())
def test_an_exact_number_is_read_as_itself(number, dimension, percent):
    text = exact(number, dimension, percent=percent)
    amount, _, unit = text.partition(" ")
    factor = parse_unit(unit).factor if unit else 1.0
    assert float(amount) * factor == number


@given(FINITE, st.floats(min_value=1e-14, max_value=0.5))
def test_the_digits_of_a_learnt_number_resolve_its_interval(number, part):
    low, high = number * (1 - part), number * (1 + part)
    amount, _, unit = learnt_text(number, low, high, STIFFNESS).partition(" ")
    found = float(amount) * parse_unit(unit).factor
    rounding = 1e-15 * number  # of the product with the factor
    assert abs(found - number) <= 0.1 * (high - low) / 2 + rounding
    assert digits(number, low, high) >= 6


def test_numbers_have_no_needless_exponents():
    assert exact(0.01, STIFFNESS) == "10 mN/m"
    assert exact(40.0, STIFFNESS) == "40 N/m"
    assert exact(0.0125, NUMBER, percent=True) == "1.25 %"
