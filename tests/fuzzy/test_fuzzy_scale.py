"""Scales: ranges, logarithms, layouts of words, and gaps between them."""

import math
from itertools import product

import pytest

from tests.every import every
from tissuec.fuzzy.scale import Axis, OutOfRange, Plateau, evenly, gaps, plateaus, shaped
from tissuec.fuzzy.sets import Gaussian, trapezoid, triangle

AXES = [
    Axis("hardness", 0.0, 1.0),
    Axis("offset", 1000.0, 1001.0),
    Axis("sign", -3.0, 7.0),
    Axis("stiffness", 2.0, 2000.0, log=True),
    Axis("wide", 1e-6, 1e6, log=True),
    Axis("ends that exp(log) leaves", 5.0, 70.0, log=True),
]


def places(axis: Axis, count: int = 200) -> list[float]:
    low, high = axis.bounds
    return [low + (high - low) * k / count for k in range(count)] + [high]


@every(("axis", "count"), product(AXES, range(1, 8)))
def test_even_words_sum_to_one_everywhere(axis, count):
    scale = evenly(axis, [f"word {k}" for k in range(count)])
    for u in places(axis):
        total = math.fsum(shape.degree(u) for shape in scale.words.values())
        assert total == pytest.approx(1.0, abs=1e-15)  # two interpolations


@every(("axis", "count"), product(AXES, range(1, 8)))
def test_each_even_word_peaks_in_the_middle_of_its_part_where_its_neighbours_are_false(
    axis, count
):
    scale = evenly(axis, [str(k) for k in range(count)])
    low, high = axis.bounds
    for k in range(count):
        peak = low + (high - low) * ((2 * k + 1) / (2 * count))
        assert [scale.words[str(j)].degree(peak) for j in range(count)] == [
            float(j == k) for j in range(count)
        ]


def test_outer_even_words_stay_true_to_the_ends_and_stand_for_the_middle_of_that_part():
    axis = Axis("hardness", 0.0, 1.0)
    words = evenly(axis, ["soft", "medium", "hard"]).words
    assert words["soft"].degree(0.0) == words["hard"].degree(1.0) == 1.0
    assert axis.value_of(words["soft"]) == pytest.approx(1 / 12, rel=1e-15, abs=0)
    assert axis.value_of(words["medium"]) == 0.5
    assert axis.value_of(words["hard"]) == pytest.approx(11 / 12, rel=1e-15, abs=0)


def test_a_single_word_is_true_everywhere_and_stands_for_the_middle():
    axis = Axis("hardness", 0.0, 1.0)
    scale = evenly(axis, ["any"])
    assert all(scale.words["any"].degree(u) == 1.0 for u in places(axis))
    assert axis.value_of(scale.words["any"]) == 0.5
    assert gaps(scale) == []


def test_words_are_needed_and_needed_once():
    with pytest.raises(ValueError, match="needs words"):
        evenly(AXES[0], [])
    with pytest.raises(ValueError, match="each of them once"):
        evenly(AXES[0], ["soft", "soft"])


def test_on_a_log_scale_the_middle_word_stands_for_the_geometric_mean():
    axis = Axis("stiffness", 2.0, 2000.0, log=True)
    words = evenly(axis, ["low", "medium", "high"]).words
    assert axis.value_of(words["medium"]) == pytest.approx(
        math.sqrt(2.0 * 2000.0), rel=1e-14, abs=0
    )


def test_explicit_shapes_have_feet_in_values_and_straight_edges_in_the_logarithm():
    axis = Axis("mass", 1e-6, 1e-4, log=True)
    scale = shaped(axis, {"medium": triangle(1e-6, 1e-5, 1e-4)})
    word = scale.words["medium"]
    assert word.degree(axis.to_scale(1e-5)) == 1.0
    assert word.degree(axis.to_scale(1e-6 * math.sqrt(10))) == pytest.approx(0.5, abs=1e-14)


def test_a_bell_on_a_log_scale_keeps_the_degrees_of_its_mean_and_of_one_sigma_above():
    axis = Axis("mass", 1.0, 100.0, log=True)
    bell = shaped(axis, {"medium": Gaussian(10.0, 5.0)}).words["medium"]
    assert bell.degree(math.log(10.0)) == 1.0
    assert bell.degree(math.log(15.0)) == pytest.approx(math.exp(-0.5), rel=1e-14, abs=0)


def test_a_shape_that_does_not_fit_is_refused_by_name():
    axis = Axis("mass", 1.0, 100.0, log=True)
    with pytest.raises(ValueError, match='mass, "high": the peak is outside'):
        shaped(axis, {"low": triangle(1, 1, 10), "high": triangle(200, 300, 400)})
    with pytest.raises(ValueError, match='mass, "low": 0 is not on the log scale'):
        shaped(axis, {"low": triangle(0, 1, 10)})


@pytest.mark.parametrize(
    ("value", "log"),
    [
        (-0.1, False),
        (1.1, False),
        (math.nan, False),
        (math.inf, False),
        (0.0, True),
        (-1, True),
    ],
)
def test_a_value_out_of_range_is_refused_and_named(value, log):
    axis = Axis("hardness", 0.5 if log else 0.0, 1.0, log=log)
    with pytest.raises(
        OutOfRange, match=r"hardness = .* is outside its range from .* to 1"
    ) as e:
        axis.to_scale(value)
    assert e.value.axis is axis


def test_rounding_of_a_unit_conversion_does_not_put_an_end_out_of_range():
    assert Axis("share", 0.0, 0.3).to_scale(0.1 + 0.2) == 0.3  # 0.30000000000000004
    axis = Axis("mass", 1e-6, 1e-4, log=True)
    assert axis.to_scale(math.nextafter(1e-6, 0.0)) == axis.bounds[0]


def test_rounding_of_a_unit_conversion_does_not_put_a_peak_out_of_range():
    axis = Axis("share", 0.1, 0.3)
    word = shaped(axis, {"high": triangle(0.2, 0.1 + 0.2, 0.1 + 0.2)}).words["high"]
    assert word.core == (0.3, 0.3)


@pytest.mark.parametrize("axis", AXES, ids=lambda axis: axis.name)
def test_values_survive_the_way_to_the_scale_and_back(axis):
    for u in places(axis):
        value = axis.from_scale(u)
        assert axis.low <= value <= axis.high
        assert axis.to_scale(value) == pytest.approx(u, abs=axis.rounding)


@pytest.mark.parametrize(
    ("low", "high", "log"),
    [
        (1.0, 1.0, False),
        (2.0, 1.0, False),
        (0.0, math.inf, False),
        (math.nan, 1.0, False),
        (0.0, 1.0, True),
        (1.0, math.nextafter(1.0, 2.0), False),
    ],
)
def test_an_impossible_range_is_refused(low, high, log):
    with pytest.raises(ValueError, match="hardness"):
        Axis("hardness", low, high, log=log)


def test_plateaus_share_their_slopes():
    axis = Axis("hardness", 0.0, 1.0)
    parts = [
        Plateau("soft", None, 0.15),
        Plateau("medium", 0.4, 0.6),
        Plateau("hard", 0.85, None),
    ]
    scale = plateaus(axis, parts)
    for u in places(axis):
        assert sum(s.degree(u) for s in scale.words.values()) == pytest.approx(1.0, abs=1e-15)
    assert scale.words["soft"].degree(0.275) == pytest.approx(0.5)
    assert scale.words["medium"].core == (0.4, 0.6)
    assert scale.words["hard"].support == (0.6, 1.0)


def test_touching_plateaus_have_a_sharp_edge_on_which_both_are_true():
    scale = plateaus(
        Axis("x", 0.0, 1.0), [Plateau("low", None, 0.5), Plateau("high", 0.5, None)]
    )
    low, high = scale.words["low"], scale.words["high"]
    assert (low.degree(0.499), high.degree(0.499)) == (1.0, 0.0)
    assert (low.degree(0.5), high.degree(0.5)) == (1.0, 1.0)
    assert (low.degree(0.501), high.degree(0.501)) == (0.0, 1.0)


@pytest.mark.parametrize(
    ("parts", "problem"),
    [
        ([("a", None, 0.5), ("b", 0.4, None)], '"b": plateaus must ascend'),
        ([("a", None, 0.5), ("b", 0.7, 0.6), ("c", 0.8, None)], '"b": plateaus must ascend'),
        ([("a", 0.1, 0.5), ("b", 0.6, None)], "reach the ends"),
        ([("a", None, 0.5), ("b", 0.6, 0.9)], "reach the ends"),
        ([("a", None, 0.5), ("a", 0.6, None)], "each of them once"),
        ([("a", None, 0.5), ("b", 1.6, None)], "outside its range"),
        ([], "needs words"),
    ],
)
def test_plateaus_that_do_not_cover_the_range_in_order_are_refused(parts, problem):
    with pytest.raises(ValueError, match=problem):
        plateaus(Axis("x", 0.0, 1.0), [Plateau(*part) for part in parts])


def test_gaps_are_the_parts_that_belong_to_no_word():
    axis = Axis("x", 0.0, 10.0)
    scale = shaped(axis, {"a": triangle(1, 2, 3), "b": trapezoid(5, 6, 7, 8)})
    assert gaps(scale) == [(0.0, 1.0), (3.0, 5.0), (8.0, 10.0)]


def test_gaps_are_reported_in_values_on_a_log_scale():
    axis = Axis("x", 1.0, 1000.0, log=True)
    ((low, high),) = gaps(
        shaped(axis, {"a": triangle(1, 1, 10), "b": triangle(100, 1000, 1000)})
    )
    assert (low, high) == pytest.approx((10.0, 100.0), rel=1e-14, abs=0)


def test_touching_feet_overlapping_words_and_bells_leave_no_gap():
    axis = Axis("x", 0.0, 1.0)
    assert gaps(shaped(axis, {"a": triangle(0, 0, 0.5), "b": triangle(0.5, 1, 1)})) == []
    assert gaps(shaped(axis, {"a": triangle(0, 0, 0.7), "b": triangle(0.3, 1, 1)})) == []
    assert gaps(shaped(axis, {"a": Gaussian(0.5, 0.1)})) == []


def test_corners_that_differ_by_rounding_leave_no_gap():
    axis = Axis("x", 0.0, 1.0)
    words = {"a": triangle(0, 0, 0.3), "b": triangle(math.nextafter(0.1 + 0.2, 1.0), 1, 1)}
    assert gaps(shaped(axis, words)) == []


def test_half_way_between_two_words_is_half_way_on_the_scale():
    axis = Axis("x", 1.0, 10000.0, log=True)
    scale = shaped(axis, {"a": triangle(1, 1, 10), "b": triangle(10, 100, 1000)})
    assert axis.halfway(scale.words["a"], scale.words["b"]) == pytest.approx(
        10.0, rel=1e-14, abs=0
    )
