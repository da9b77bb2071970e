"""Arteries under pressure in whole runs, against felupe and the integral over their wall."""

import pytest

from benchmarks.arteries import CASES, by_integral, by_library, by_run


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_an_artery_widens_as_in_another_library(name):
    case = CASES[name]
    known = by_library(case, 4)
    assert by_run(case, 2, 16) == pytest.approx(known, rel=0.03)
    if not case.length:
        assert known == pytest.approx(by_integral(case), rel=0.01)
