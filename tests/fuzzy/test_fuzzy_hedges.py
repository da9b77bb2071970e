"""Hedges: where they move words, and that every word stays a word."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.examples import examples
from tissuec.fuzzy.centroid import centre_of_gravity
from tissuec.fuzzy.hedges import PowerHedge, Shift, has_effect, hedged, moves
from tissuec.fuzzy.scale import Axis, evenly
from tissuec.fuzzy.sets import Gaussian, Piecewise, Powered, points, trapezoid, triangle

VERY = Shift(0.5, "outward")
SLIGHTLY = Shift(0.5, "inward")
UNIT = Axis("x", 0.0, 1.0)
WORDS = evenly(UNIT, ["low", "medium", "high"]).words


def corners(shape):
    assert isinstance(shape, Piecewise)
    return list(zip(shape.xs, shape.ys, strict=True))


def close(expected):
    return [pytest.approx(pair, abs=1e-15) for pair in expected]  # a few roundings near 1


def test_very_moves_a_shoulder_and_its_foot_half_the_way_of_its_inner_end():
    assert corners(hedged([VERY], WORDS["high"], UNIT)) == close(
        [(0, 0), (7 / 12, 0), (11 / 12, 1), (1, 1)]
    )
    assert corners(hedged([VERY], WORDS["low"], UNIT)) == close(
        [(0, 1), (1 / 12, 1), (5 / 12, 0), (1, 0)]
    )


def test_slightly_moves_the_core_of_a_shoulder_and_lets_it_fall_towards_the_end():
    assert corners(hedged([SLIGHTLY], WORDS["high"], UNIT)) == close(
        [(0, 0), (1 / 3, 0), (2 / 3, 1), (3 / 4, 1), (1, 0)]
    )


def test_very_moves_a_triangle_with_its_inner_foot_and_draws_the_outer_foot_along():
    word = triangle(0.5, 0.6, 0.7).within(0.0, 1.0)
    assert corners(hedged([VERY], word, UNIT)) == close(
        [(0, 0), (0.7, 0), (0.8, 1), (0.85, 0), (1, 0)]
    )


def test_slightly_moves_a_triangle_with_its_inner_foot_and_keeps_the_outer_foot():
    word = triangle(0.6, 0.7, 0.9).within(0.0, 1.0)
    assert corners(hedged([SLIGHTLY], word, UNIT)) == close(
        [(0, 0), (0.5, 0), (0.6, 1), (0.9, 0), (1, 0)]
    )


def test_slightly_stretches_the_outer_flank_between_core_and_foot():
    word = points([(0, 0), (0.6, 0), (0.7, 1), (0.8, 0.5), (0.9, 0)]).within(0.0, 1.0)
    assert corners(hedged([SLIGHTLY], word, UNIT)) == close(
        [(0, 0), (0.5, 0), (0.6, 1), (0.75, 0.5), (0.9, 0), (1, 0)]
    )


def test_rounding_swaps_no_neighbours_of_a_shifted_word():
    axis, edge = Axis("x", -3.0, 7.0), 2.365553393160996
    beside = math.nextafter(edge, 7.0)
    assert beside + 0.9 * (7.0 - beside) < edge + 0.9 * (7.0 - edge)  # the trap
    word = points([(-3, 0), (2.1, 1), (edge, 1), (beside, 0.5), (7, 0)])
    moved = hedged([Shift(0.9, "outward")], word, axis)
    assert isinstance(moved, Piecewise)
    assert list(moved.xs) == sorted(moved.xs)


def test_hedges_chain_and_the_one_next_to_the_word_acts_first():
    word = WORDS["high"]
    assert hedged([VERY, VERY], word, UNIT).middle == pytest.approx(1 - (1 / 12) / 4)
    inner_first = hedged([VERY], hedged([SLIGHTLY], word, UNIT), UNIT)
    assert hedged([VERY, SLIGHTLY], word, UNIT) == inner_first
    assert inner_first.middle == pytest.approx((17 / 24 + 1) / 2)


def test_a_word_in_the_middle_of_the_range_has_no_direction_to_move_in():
    for hedge in (VERY, SLIGHTLY):
        assert hedged([hedge], WORDS["medium"], UNIT) == WORDS["medium"]
        assert not has_effect(hedge, WORDS["medium"], UNIT)
        assert not moves(hedge, WORDS["medium"], UNIT)


def test_a_word_that_peaks_at_the_end_cannot_move_further_out():
    word = triangle(0.0, 0.0, 0.4).within(0.0, 1.0)
    assert hedged([VERY], word, UNIT) == word
    assert not has_effect(VERY, word, UNIT)
    assert has_effect(SLIGHTLY, word, UNIT)


def test_a_power_has_an_effect_unless_the_word_is_sharp_and_never_moves_a_fact():
    sharp = trapezoid(0.2, 0.2, 0.4, 0.4).within(0.0, 1.0)
    assert has_effect(PowerHedge(2.0), WORDS["low"], UNIT)
    assert has_effect(PowerHedge(2.0), Gaussian(0.3, 0.1), UNIT)
    assert not has_effect(PowerHedge(2.0), sharp, UNIT)
    assert not has_effect(PowerHedge(1.0), WORDS["low"], UNIT)
    assert not moves(PowerHedge(2.0), WORDS["low"], UNIT)


def test_powers_multiply_and_commute_with_shifts():
    word = WORDS["high"]
    shifted = hedged([VERY], word, UNIT)
    assert hedged([PowerHedge(2.0), PowerHedge(3.0)], word, UNIT) == Powered(word, 6.0)
    assert hedged([PowerHedge(2.0), VERY], word, UNIT) == Powered(shifted, 2.0)
    assert hedged([VERY, PowerHedge(2.0)], word, UNIT) == Powered(shifted, 2.0)


def test_a_bell_moves_its_mean_and_keeps_its_width():
    very, slightly = (hedged([h], Gaussian(0.6, 0.1), UNIT) for h in (VERY, SLIGHTLY))
    assert (very.mean, very.sigma) == (pytest.approx(0.8), 0.1)
    assert (slightly.mean, slightly.sigma) == (pytest.approx(0.55), 0.1)


def test_squaring_a_symmetric_triangle_leaves_its_centre_where_a_shift_moves_it():
    def simpson(f, a, b):  # exact for the cubics below
        return (b - a) / 6 * (f(a) + 4 * f((a + b) / 2) + f(b))

    word = triangle(0.5, 0.7, 0.9).within(0.0, 1.0)
    squared = Powered(word, 2.0)
    area = sum(simpson(squared.degree, *part) for part in ((0.5, 0.7), (0.7, 0.9)))
    moment = sum(
        simpson(lambda x: x * squared.degree(x), *part) for part in ((0.5, 0.7), (0.7, 0.9))
    )
    assert moment / area == pytest.approx(0.7, rel=1e-14, abs=0)
    moved = hedged([SLIGHTLY], word, UNIT)
    assert centre_of_gravity([(moved, 1.0)], 0.0, 1.0) < 0.69


@pytest.mark.parametrize("fraction", [0.0, 1.0, -0.5, 1.5, float("nan")])
def test_a_shift_that_would_lose_the_order_of_words_is_refused(fraction):
    with pytest.raises(ValueError, match="above 0 % and below 100 %"):
        Shift(fraction, "outward")


def test_nonsense_hedges_are_refused():
    with pytest.raises(ValueError, match="outward or inward"):
        Shift(0.5, "sideways")  # type: ignore[arg-type]
    for exponent in (0.0, -1.0, float("inf"), float("nan")):
        with pytest.raises(ValueError, match="above zero"):
            PowerHedge(exponent)


# --- laws on any set ---

AXES = st.sampled_from(
    [
        UNIT,
        Axis("offset", 1000.0, 1001.0),
        Axis("log", 1e-6, 1e6, log=True),
        Axis("s", -7.0, 2.0),
    ]
)
FRACTIONS = st.floats(0.01, 0.99)
DIRECTIONS = st.sampled_from(["outward", "inward"])


@st.composite
def sets_on(draw, axis: Axis) -> Piecewise:
    """Draw a set with vertical edges, shoulders, bumps, and feet outside the range."""
    low, high = axis.bounds
    places = draw(st.lists(st.integers(-3, 19), min_size=4, max_size=7).map(sorted))
    ys = draw(st.lists(st.integers(0, 3), min_size=len(places), max_size=len(places)))
    i = draw(st.integers(0, len(places) - 2))
    ys[i] = ys[i + 1] = 4
    try:
        xs = [low + (high - low) * k / 16 for k in places]
        return points(zip(xs, [y / 4 for y in ys], strict=True)).within(low, high)
    except ValueError:
        return trapezoid(low, low, high, high).within(low, high)


@st.composite
def hedge_cases(draw, count: int = 1):
    axis = draw(AXES)
    shift = Shift(draw(FRACTIONS), draw(DIRECTIONS))
    return axis, shift, [draw(sets_on(axis)) for _ in range(count)]


LAWS = settings(max_examples=examples(300), derandomize=True)


@LAWS
@given(hedge_cases())
def test_a_shift_moves_the_middle_by_its_fraction_towards_its_target(case):
    axis, shift, (word,) = case
    low, high = axis.bounds
    centre = (low + high) / 2
    middle = word.middle
    if abs(middle - centre) < 1e-9 * (high - low):
        assert hedged([shift], word, axis) == word
        return
    end = high if middle > centre else low
    target = end if shift.direction == "outward" else centre
    expected = middle + shift.fraction * (target - middle)
    near = 8 * axis.rounding
    assert hedged([shift], word, axis).middle == pytest.approx(expected, abs=near)


@LAWS
@given(hedge_cases())
def test_a_shifted_word_is_a_word_of_the_range(case):
    axis, shift, (word,) = case
    moved = hedged([shift], word, axis)
    low, high = axis.bounds
    assert moved.within(low, high) == moved
    assert (moved.xs[0], moved.xs[-1]) == (low, high)
    assert max(moved.ys) == max(word.ys)


@LAWS
@given(hedge_cases(count=2))
def test_a_shift_keeps_the_order_of_words(case):
    axis, shift, (one, other) = case
    first, second = sorted((one, other), key=lambda word: word.middle)
    before = hedged([shift], first, axis).middle
    after = hedged([shift], second, axis).middle
    assert before <= after + 8 * axis.rounding


@LAWS
@given(hedge_cases())
def test_what_points_up_and_what_points_down_are_mirror_images(case):
    axis, shift, (word,) = case
    low, high = axis.bounds
    reflected = Axis("mirror", -1.0, 1.0)

    def on_mirror(word: Piecewise, sign: float) -> Piecewise:
        half, centre = (high - low) / 2, (low + high) / 2
        pairs = [(sign * (x - centre) / half, y) for x, y in zip(word.xs, word.ys, strict=True)]
        clamped = [(min(max(x, -1.0), 1.0), y) for x, y in pairs]
        return points(clamped if sign > 0 else clamped[::-1]).within(-1.0, 1.0)

    up = hedged([shift], on_mirror(word, 1.0), reflected)
    down = hedged([shift], on_mirror(word, -1.0), reflected)
    assert [-x for x in reversed(down.xs)] == pytest.approx(list(up.xs), abs=1e-12)
    assert list(reversed(down.ys)) == pytest.approx(list(up.ys), abs=1e-9)


@LAWS
@given(hedge_cases())
def test_an_effect_is_reported_exactly_where_there_is_one(case):
    axis, shift, (word,) = case
    assert has_effect(shift, word, axis) == (hedged([shift], word, axis) != word)
