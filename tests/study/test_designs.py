"""Designs: which values each run has."""

import numpy as np
import pytest
from scipy import stats

from tests.study.scenes import SCENE, prepared
from tissuec.cli.study import command
from tissuec.core.errors import TissueError
from tissuec.scene.study.entries import DESIGNS
from tissuec.studies.designs import _DESIGNS, MOST_RUNS, points_of

MEASURE = "measure pull = max(force of hand)"
TWO = ("vary lift = [1 mm, 2 mm]", "vary tolerance = [1e-3, 1e-4]", MEASURE)
RANDOM = ("vary lift = 2 mm to 10 mm", "vary tolerance = 1e-6 to 1e-3", MEASURE)


def points(*lines):
    return points_of(prepared(*lines, text=SCENE).study)


def test_every_design_is_there():
    assert set(_DESIGNS) == set(DESIGNS)


def test_a_grid_has_every_combination():
    assert points(*TWO) == [(1, 1e-3), (1, 1e-4), (2, 1e-3), (2, 1e-4)]


def test_a_list_has_values_side_by_side():
    assert points(*TWO, "design is list") == [(1, 1e-3), (2, 1e-4)]


def test_one_at_a_time_leaves_the_others_as_they_are():
    found = points(*TWO, "design is one at a time")
    assert found == [(None, None), (1, None), (2, None), (None, 1e-3), (None, 1e-4)]


def test_a_latin_hypercube_has_one_point_in_each_part_of_each_range():
    lift = np.array([point[0] for point in points(*RANDOM, "runs = 40")])
    parts = np.floor((lift - 2.0) / 8.0 * 40).astype(int)
    assert sorted(parts) == list(range(40))


@pytest.mark.parametrize("design", ["latin hypercube", "sobol", "sobol indices"])
def test_random_points_follow_from_the_seed(design):
    lines = (*RANDOM, "runs = 16", f"design is {design}")
    assert points(*lines, "seed = 1") == points(*lines, "seed = 1")
    assert points(*lines, "seed = 1") != points(*lines, "seed = 2")


def test_a_sobol_sequence_is_balanced():
    lift = np.array([point[0] for point in points(*RANDOM, "design is sobol", "runs = 64")])
    assert np.histogram(lift, 8, (2.0, 10.0))[0].tolist() == [8] * 8


def test_sobol_indices_have_two_blocks_and_one_for_each_factor():
    found = np.array(points(*RANDOM, "design is sobol indices", "runs = 8"))
    a, b, first, second = found.reshape(4, 8, 2)
    assert np.array_equal(first, np.stack([b[:, 0], a[:, 1]], axis=1))
    assert np.array_equal(second, np.stack([a[:, 0], b[:, 1]], axis=1))
    assert not np.isclose(a, b).any()


@pytest.mark.parametrize(
    ("written", "family"),
    [
        ("normal(5 mm, 1 mm)", stats.norm(5, 1)),
        ("uniform(2 mm, 7 mm)", stats.uniform(2, 5)),
        ("lognormal(5 mm, 1.3)", stats.lognorm(np.log(1.3), scale=5)),
        ("triangular(2 mm, 3 mm, 7 mm)", stats.triang(0.2, 2, 5)),
        ("normal(5 mm, 1 mm) between 4 mm and 7 mm", stats.truncnorm(-1, 2, 5, 1)),
    ],
)
def test_values_are_distributed_as_they_are_written(written, family):
    lines = (f"vary lift = {written}", MEASURE, "runs = 400", "design is latin hypercube")
    lift = [point[0] for point in points(*lines)]
    assert stats.kstest(lift, family.cdf).statistic < 1.0 / 400.0


def test_listed_values_are_equally_likely_in_a_random_design():
    lines = ("vary lift = [1 mm, 2 mm, 4 mm, 8 mm]", MEASURE, "design is sobol", "runs = 64")
    lift = [point[0] for point in points(*lines)]
    assert [lift.count(value) for value in (1, 2, 4, 8)] == [16] * 4


def test_too_many_runs_are_refused():
    lines = (
        "vary lift = 1 mm to 2 mm in 9999 steps",
        "vary duration = 1 s to 2 s in 9999 steps",
    )
    with pytest.raises(TissueError, match="99980001 runs"):
        points(*lines, MEASURE)
    assert MOST_RUNS < 9999**2


def test_the_command_offers_every_design():
    (design,) = (option for option in command.params if option.name == "design")
    assert tuple(design.type.choices) == tuple(DESIGNS)
