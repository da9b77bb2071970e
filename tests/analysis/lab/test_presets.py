"""Every shipped preset of matter agrees with its evidence, by its law and in the laboratory."""

import pytest

import tissuec
from docs.reference.curves import curve_table, curves_by_law
from tissuec.analysis.lab.bench import TestBench as Bench
from tissuec.analysis.lab.rows import INSIDE, curve_rows
from tissuec.core.resources import library
from tissuec.pipeline import read_words
from tissuec.scene.request import Request

FILES = sorted((library() / "matter").glob("*.tis"))


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_numbers_and_curves_of_a_preset_agree_with_its_evidence(path):
    request = Request.file(path)
    words, warnings = read_words(request)
    assert not [str(one) for one in warnings if one.code == "W208"]
    wrong = [
        (tissue.name, row.test, row.quantity, row.verdict)
        for tissue in words.tissues.values()
        if tissue.span.source.name == request.source.name
        for curve in curves_by_law(Bench(request, tissue, spacing=1.0))
        for row in curve_rows(curve.mode, curve, "it tears")
        if not row.is_good
    ]
    assert not wrong


#: Tissues with a published curve: none of them may lose it.
WITH_CURVES = {
    "brain", "fat", "fibrous muscle", "heart muscle", "muscle", "nerve", "skin", "aged skin",
    "tendon",
}  # fmt: skip


def test_tissues_with_published_curves_are_those_of_the_table():
    rows = [line.split(" | ") for line in curve_table().splitlines()[2:]]
    assert {row[0].strip("| ") for row in rows} == WITH_CURVES
    assert {row[4] for row in rows} == {INSIDE}


@pytest.mark.slow  # 3 s each; that a contradiction is told is tested by default
@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_preset_of_matter_passes_the_laboratory(path):
    for examined in tissuec.examine(path):
        assert examined.is_good, [row for row in examined.rows if not row.is_good]
