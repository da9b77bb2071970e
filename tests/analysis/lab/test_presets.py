"""Every shipped preset of matter agrees with its evidence, by its law and in the laboratory."""

import numpy as np
import pytest

import tissuec
from tissuec.analysis.lab import homogeneous, relaxation
from tissuec.analysis.lab.bench import TestBench as Bench
from tissuec.analysis.lab.closed_form import LawCurve
from tissuec.analysis.lab.rows import LabCurve, curve_rows
from tissuec.core.resources import library
from tissuec.pipeline import read_words
from tissuec.scene.known_curves import COMPRESSION
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


def curves_by_law(bench):
    """Yield the known curves of a tissue, each by the closed form of its law."""
    law = LawCurve.of(bench.tissue)
    for known in bench.tissue.curves:
        if not known.mode:
            place, branches = np.array(known.places), relaxation.branches_of(bench)
            value = np.ones_like(place)
            if branches:
                value = relaxation.left_by_law(branches, 1e-9, place)
        else:
            limit = homogeneous.limits_in(bench, law, known.mode).strain
            within = [one for one in known.places if one <= limit]
            start = 0.0 if known.mode == COMPRESSION else 1e-4
            place = np.array(within)
            value = law.stress(known.mode, [start, *within])[1:] if within else np.zeros(0)
        yield LabCurve(known.mode, place, value, value, (known,))


@pytest.mark.slow  # 3 s each; that a contradiction is told is tested by default
@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_preset_of_matter_passes_the_laboratory(path):
    for examined in tissuec.examine(path):
        assert examined.is_good, [row for row in examined.rows if not row.is_good]
