"""Texts of moved words compile to what the model gave, and change nothing else."""

import re
from pathlib import Path

import numpy as np
import pytest

from tests.every import every
from tests.learn.wordy import SETTING, everything, random_scene, scene_of, words_of
from tissuec.core.source import Source
from tissuec.core.structs import replace
from tissuec.lang.printer import format_source
from tissuec.learn.vocabulary.moving import WordsModel
from tissuec.learn.vocabulary.texts import TextEdit, apply
from tissuec.learn.vocabulary.used import request_of, reread
from tissuec.pipeline import check_request
from tissuec.scene.request import Request

NUMERAL = re.compile(r"[0-9.]+(e[+-]?[0-9]+)?")

ONE = (
    """language 1
# Words of a hand.
let edge = 0.4
property hardness from 0 to 1 { evenly = [soft, "on edge", hard] }  # how it feels
property weight from 0 to 100 % {
  light until 15 %  # feather
  middling from 40 % to edge; heavy from 85%
}
quantity mass from 3 mg to 0.3 g on log scale {
  low = triangle(3 mg, 3 mg, 30 mg)  # explicit
  medium = trapezoid(3 mg,30mg, 0.05 g, 300 mg); high = triangle(0.05 g, 300 mg, 0.3 g)
  odd = gaussian(10 mg, 2 * 1 mg)
  applies to each node  # of them
}
rules simple {
  if hardness is soft and weight is light then mass is low
  if hardness is not soft then mass is odd weighing 0.5
  if weight is middling then mass is medium
}
tissue flesh { described in simple; hardness is between soft and "on edge"; weight = 17 % }
body part P {
  mesh is tube { axis from (0, 0, 0) cm to (4, 0, 0) cm; radius = 3 mm
    rings = 3; sides = 4; diagonals is both; interior is none }
  tissue is flesh
}
"""
    + SETTING
)


def moves(model: WordsModel, seed: int, size: float = 0.4):
    return size * np.random.default_rng(seed).normal(size=model.size)


@every("seed", range(25))
def test_texts_compile_to_what_the_model_gives(seed):
    scene = random_scene(seed)
    model = everything(scene)
    theta = moves(model, seed)
    again = reread(scene, model.texts(theta))
    for (tissue, quantity), value in model.given(theta).items():
        found = again.tissues[tissue].given[quantity].value
        assert found == pytest.approx(value, rel=1e-9, abs=0)


def test_numbers_alone_are_replaced():
    scene = scene_of(ONE)
    model = WordsModel(scene, [words_of("weight"), words_of("mass")])
    text = model.texts(moves(model, 1))["words.tis"]
    before, after = ONE.split("\n"), text.split("\n")
    assert len(before) == len(after)
    changed = [k for k, (a, b) in enumerate(zip(before, after, strict=True)) if a != b]
    assert changed == [5, 6, 9, 10, 11]
    bare = [NUMERAL.sub("0", one) for one in after]
    assert bare[5] == "  light until 0 %  # feather"
    assert bare[6] == "  middling from 0 % to 0; heavy from 0%"
    assert bare[9] == "  low = triangle(0 mg, 0 mg, 0 mg)  # explicit"
    shared = re.findall(r"[0-9.]+ ?m?g", after[9] + after[10])
    assert float(shared[2].split()[0]) == float(shared[4].removesuffix("mg"))
    assert bare[11] == "  odd = gaussian(0 mg, 0 mg)"  # where a product stood


def test_an_even_layout_is_written_in_full():
    scene = scene_of(ONE)
    model = WordsModel(scene, [words_of("hardness")])
    text = model.texts(np.array([0.2, 0.0, -0.1]))["words.tis"]
    lines = [NUMERAL.sub("0", line) for line in text.split("\n")[3:9]]
    assert lines == [
        "property hardness from 0 to 0 {",
        "  soft = trapezoid(0, 0, 0, 0)",
        '  "on edge" = triangle(0, 0, 0)',
        "  hard = trapezoid(0, 0, 0, 0)",
        "}  # how it feels",
        "property weight from 0 to 0 % {",
    ]
    assert text.split("\n")[8:] == ONE.split("\n")[4:]


def test_a_list_on_a_line_of_its_own_becomes_lines():
    text = ONE.replace("{ evenly", "{\n    evenly").replace("hard] }", "hard]  # words\n  }")
    scene = scene_of(text)
    model = WordsModel(scene, [words_of("hardness")])
    lines = model.texts(np.array([0.2, 0.0, -0.1]))["words.tis"].split("\n")
    assert [line[:8] for line in lines[4:7]] == ["    soft", '    "on ', "    hard"]
    assert lines[6].endswith(")  # words") and lines[7] == "  }  # how it feels"


def test_corners_of_words_that_others_pass_over_are_written():
    text = ONE.replace(
        'evenly = [soft, "on edge", hard]',
        'soft = points(0, 1, 0.5, 0.5, 1, 0); "on edge" = triangle(0, 1, 1)',
    )
    scene = scene_of(text)
    model = WordsModel(scene, [words_of("hardness")])
    theta = np.array([0.5])
    new = model.texts(theta)["words.tis"]
    line = NUMERAL.sub("0", new.split("\n")[3])
    assert "soft = points(0, 0, 0, 0, 0, 0)" in line
    assert '"on edge" = points(0, 0, 0, 0, 0, 0, 0, 0)' in line  # with the edge at the end
    again = reread(scene, {"words.tis": new}).vocabulary.properties["hardness"].scale.words
    for word, shape in model.vocabulary(theta).properties["hardness"].scale.words.items():
        assert again[word].xs == pytest.approx(shape.xs, abs=1e-11)  # as numerals are close


def test_nothing_is_written_where_nothing_moved():
    model = everything(scene_of(ONE))
    assert model.texts(np.zeros(model.size)) == {}


def test_only_files_whose_words_moved_are_written(repository):
    path = repository / "library" / "scenes" / "indentation.tis"
    compiled, _ = check_request(Request.file(path), thorough=False)
    assert compiled is not None
    model = WordsModel(compiled.scene, [words_of("elasticity"), words_of("spring constant")])
    texts = model.texts(moves(model, 3))
    # The properties stand in the first, the quantities in the second.
    assert set(texts) == {"fuzzy/words.tis", "fuzzy/soft_tissue.tis"}
    for name, text in texts.items():
        assert format_source(Source(name, text)) == text  # laid out as the file was
    again = reread(compiled.scene, texts)
    for (tissue, quantity), value in model.given(moves(model, 3)).items():
        found = again.tissues[tissue].given[quantity].value
        assert found == pytest.approx(value, rel=1e-9)


def test_a_scene_is_read_again_as_it_was_set():
    text = ONE.replace("let edge", "param edge")
    scene = scene_of(text, "edge=0.5")
    new = text.replace("30 mg", "20 mg").replace("30mg", "20mg")
    assert request_of(scene, {"words.tis": new}).overrides == ("edge=0.5",)
    again = reread(scene, {"words.tis": new}).vocabulary
    low = again.quantities["mass"].named.scale.words["low"]
    assert np.exp(low.support[1]) == pytest.approx(20e-6)
    assert again.properties["weight"].scale.words["middling"].core == (0.4, 0.5)


def test_texts_of_others_are_kept_where_a_result_kept_them():
    scene = scene_of(ONE)
    library = replace(scene.declarations.library, kept={"a.tis": "old", "b.tis": "b"})
    kept = replace(scene, declarations=replace(scene.declarations, library=library))
    files = request_of(kept, {"a.tis": "new"}).files
    assert [files.read(Path(n), n).text for n in ("a.tis", "b.tis")] == ["new", "b"]


def test_an_even_quantity_on_one_line_stays_one_block():
    text = ONE.replace(
        "rules simple",
        "quantity viscosity from 1 mN*s/m to 1 N*s/m { evenly = [low, high]; applies to "
        "each spring }\nrules simple",
    )
    scene = scene_of(text)
    model = WordsModel(scene, [words_of("viscosity")])
    new = model.texts(np.array([0.3, -0.2]))
    lines = [NUMERAL.sub("0", line) for line in new["words.tis"].split("\n")]
    at = lines.index("quantity viscosity from 0 mN*s/m to 0 N*s/m {")
    assert lines[at + 1 : at + 3] == [
        "  low = trapezoid(0 mN*s/m, 0 mN*s/m, 0 mN*s/m, 0 mN*s/m)",
        "  high = trapezoid(0 mN*s/m, 0 mN*s/m, 0 N*s/m, 0 N*s/m); applies to each spring }",
    ]
    found = reread(scene, new).vocabulary.quantities["viscosity"].named.scale.words
    wanted = model.vocabulary(np.array([0.3, -0.2])).quantities["viscosity"].named.scale.words
    for word, shape in wanted.items():
        assert found[word].xs == pytest.approx(shape.xs, rel=1e-10)  # as numerals are close


def test_edits_keep_what_is_between_them():
    module = scene_of(ONE).declarations.of("tissue")["flesh"].item
    first, *_, last = module.items
    new = apply(
        [TextEdit(last.span, "weight = 1 %"), TextEdit(first.span, "described in simple # x\n")]
    )
    assert new == {
        "words.tis": ONE.replace("weight = 17 %", "weight = 1 %").replace(
            "described in simple", "described in simple # x\n"
        )
    }
