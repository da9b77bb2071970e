"""Membership functions: degrees, edges, and what is no membership function."""

import math
from fractions import Fraction

import pytest

from tests.every import every
from tissuec.fuzzy.sets import Gaussian, Piecewise, Powered, points, trapezoid, triangle


def test_a_triangle_rises_and_falls_in_straight_lines():
    word = triangle(0.0, 1.0, 3.0)
    assert [word.degree(x) for x in (-1, 0, 0.25, 1, 2, 3, 4)] == [0, 0, 0.25, 1, 0.5, 0, 0]
    assert word.core == (1.0, 1.0)
    assert word.support == (0.0, 3.0)


def test_a_trapezoid_stands_for_the_middle_of_its_core():
    word = trapezoid(0.0, 1.0, 2.0, 5.0)
    assert word.core == (1.0, 2.0)
    assert word.middle == 1.5


def test_a_vertical_edge_has_its_largest_degree():
    assert triangle(0.0, 0.0, 1.0).degree(0.0) == 1.0
    assert points([(0, 0), (1, 0), (1, 0.5), (2, 1), (2, 0)]).degree(1.0) == 0.5
    assert points([(0, 0), (1, 0), (1, 1), (1, 0.25), (2, 0)]).degree(1.0) == 1.0


def test_beyond_its_points_a_set_keeps_the_degree_of_its_ends():
    word = points([(0.2, 1.0), (0.6, 0.25)])
    assert (word.degree(-5.0), word.degree(0.1), word.degree(9.0)) == (1.0, 1.0, 0.25)


def test_degrees_next_to_a_foot_keep_their_digits():
    word = triangle(0.1, 0.37, 0.93)
    a, b, c = map(Fraction, word.xs)
    for x in (0.1 + 1e-13, 0.93 - 1e-13, math.nextafter(0.93, 0.0), math.nextafter(0.1, 1.0)):
        exact = (Fraction(x) - a) / (b - a) if x < b else (c - Fraction(x)) / (c - b)
        few_roundings = pytest.approx(float(exact), rel=1e-15, abs=0)
        assert word.degree(x) == few_roundings


@every(
    ("xs", "ys", "problem"),
    [
        ((0.0,), (1.0,), "two points"),
        ((0.0, 1.0), (1.0,), "two points"),
        ((0.0, math.nan), (0.0, 1.0), "finite"),
        ((0.0, math.inf), (0.0, 1.0), "finite"),
        ((1.0, 0.0), (0.0, 1.0), "ascending"),
        ((0.0, 1.0), (0.0, 1.5), "between 0 and 1"),
        ((0.0, 1.0), (math.nan, 1.0), "between 0 and 1"),
        ((0.0, 1.0), (0.0, 0.0), "degree above 0 somewhere"),
        ((0.0, 1.0, 2.0), (1.0, 0.0, 1.0), "one peak"),
    ],
)
def test_what_is_no_membership_function_is_refused(xs, ys, problem):
    with pytest.raises(ValueError, match=problem):
        Piecewise(xs, ys)


def test_sets_that_agree_on_the_range_become_equal():
    shoulder = points([(0.0, 1.0), (0.25, 1.0), (0.75, 0.0)]).within(0.0, 1.0)
    spellings = [
        trapezoid(0.0, 0.0, 0.25, 0.75),
        trapezoid(-3.0, -2.0, 0.25, 0.75),
        points([(0.25, 1.0), (0.75, 0.0), (0.75, 0.0), (4.0, 0.0)]),
    ]
    assert all(word.within(0.0, 1.0).degree(0.0) == 1.0 for word in spellings)
    assert {word.within(0.0, 1.0).xs for word in spellings[:2]} == {(0.0, 0.25, 0.75, 1.0)}
    assert all(word.within(0.0, 1.0) == shoulder for word in spellings)


def test_a_foot_outside_the_range_is_cut_off_where_the_edge_crosses_it():
    assert triangle(-1.0, 1.0, 5.0).within(0.0, 3.0) == points([(0, 0.5), (1, 1), (3, 0.5)])


def test_within_changes_no_degree_inside_the_range():
    word = points(
        zip(
            (-1, 0, 0.25, 0.25, 0.25, 0.5, 0.5, 0.5, 0.75, 2),
            (0, 0.25, 0.25, 0.75, 0.25, 0.5, 0.125, 0.25, 1, 0),
            strict=True,
        )
    )
    cut = word.within(0.0, 1.0)
    places = [k / 64 for k in range(65)]
    assert [cut.degree(x) for x in places] == pytest.approx([word.degree(x) for x in places])


def test_a_word_must_have_its_peak_and_some_width_in_the_range():
    with pytest.raises(ValueError, match="outside the range"):
        triangle(2.0, 3.0, 4.0).within(0.0, 1.0)
    with pytest.raises(ValueError, match="single point"):
        triangle(0.5, 0.5, 0.5).within(0.0, 1.0)
    with pytest.raises(ValueError, match="single point"):
        triangle(-1.0, 0.0, 0.0).within(0.0, 1.0)
    with pytest.raises(ValueError, match="outside the range"):
        Gaussian(2.0, 0.1).within(0.0, 1.0)
    with pytest.raises(ValueError, match="wider than the range"):
        Gaussian(0.5, 1.5).within(0.0, 1.0)


def test_a_bell_has_its_textbook_degrees():
    bell = Gaussian(2.0, 0.5)
    assert bell.degree(2.0) == 1.0
    assert (
        bell.degree(2.5) == bell.degree(1.5) == pytest.approx(math.exp(-0.5), rel=1e-15, abs=0)
    )
    assert bell.core == (2.0, 2.0)
    low, high = bell.support
    assert bell.degree(low) == bell.degree(high) == 0.0
    assert bell.degree(0.999 * high) > 0.0


@pytest.mark.parametrize(
    "parameters", [(0.0, 0.0), (0.0, -1.0), (math.nan, 1.0), (0.0, math.inf)]
)
def test_a_bell_without_a_width_is_refused(parameters):
    with pytest.raises(ValueError, match="bell"):
        Gaussian(*parameters)


def test_a_power_acts_on_degrees_and_leaves_the_middle():
    squared = Powered(triangle(0.0, 1.0, 2.0), 2.0)
    assert squared.degree(0.5) == 0.25
    assert squared.middle == 1.0
