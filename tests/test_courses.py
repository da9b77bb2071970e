"""Courses, motions and loads against closed forms and finite differences."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import CubicHermiteSpline, PchipInterpolator

from tests.hand_net import chain, span, start
from tissuec.core.interpolation import monotone_slopes
from tissuec.forces.load import Load, Term
from tissuec.mechanics.situation import Motion, Turn
from tissuec.model.profiles import Course

TIMES = np.array([0.0, 0.3, 0.4, 1.0])
VALUES = np.array([0.0, 2.0, 1.5, 1.5])
COURSES = {
    "constant": Course("constant", 1.0, 3.0),
    "ramp": Course("ramp", 1.0, 3.0),
    "smooth": Course("smooth", 1.0, 3.0),
    "sine": Course("sine", 1.0, 3.0, 2.3),
    "table": Course("table", 1.0, 2.0, 0.0, TIMES, VALUES, monotone_slopes(TIMES, VALUES)),
}


@pytest.mark.parametrize("kind", COURSES)
def test_the_rate_is_the_derivative_of_the_factor(kind):
    step = 1e-6
    for time in (0.5, 1.2, 1.37, 1.9, 2.5, 4.0):
        slope = (COURSES[kind].at(time + step)[0] - COURSES[kind].at(time - step)[0]) / (
            2 * step
        )
        # Rounding 1e-16 over the step, and step² times third derivatives up to 3e3.
        assert COURSES[kind].at(time)[1] == pytest.approx(slope, abs=2e-8)


@pytest.mark.parametrize("kind", COURSES)
def test_before_and_after_a_course_its_ends_hold(kind):
    course = COURSES[kind]
    assert course.at(-9.0) == (course.at(course.start)[0], 0.0)
    assert course.at(99.0) == (course.at(course.stop)[0], 0.0)


def test_courses_have_their_closed_forms():
    assert COURSES["ramp"].at(1.5) == (0.25, 0.5)
    assert COURSES["constant"].at(0.0) == (1.0, 0.0)
    assert COURSES["sine"].at(1.1)[0] == pytest.approx(np.sin(2 * np.pi * 2.3 * 0.1))
    assert COURSES["smooth"].at(2.0) == pytest.approx((0.5, 15 / 16))


def test_a_smooth_course_begins_and_ends_without_speed_or_acceleration():
    course, step = COURSES["smooth"], 1e-4
    for end, inward in ((1.0, step), (3.0, -step)):
        assert course.at(end)[1] == 0.0
        # The rate leaves zero with the square of the time: 30 p² / length.
        assert abs(course.at(end + inward)[1]) < 30 * (step / 2) ** 2


@given(st.lists(st.floats(-10, 10), min_size=2, max_size=12), st.integers(0, 2**31))
def test_table_slopes_are_those_of_fritsch_and_butland_and_keep_it_monotone(values, seed):
    times = np.cumsum(np.random.default_rng(seed).uniform(0.1, 2.0, len(values)))
    times -= times[0]
    slopes = monotone_slopes(times, np.array(values))
    with np.errstate(over="ignore"):
        reference = PchipInterpolator(times, values)
    assert slopes == pytest.approx(reference.derivative()(times), abs=1e-9, rel=1e-9)
    course = Course("table", 0.0, times[-1], 0.0, times, np.array(values), slopes)
    for low, high in zip(range(len(values)), range(1, len(values)), strict=False):
        inside = [course.at(t)[0] for t in np.linspace(times[low], times[high], 9)]
        bounds = sorted((values[low], values[high]))
        assert bounds[0] - 1e-9 <= min(inside)
        assert max(inside) <= bounds[1] + 1e-9


def test_a_table_is_the_cubic_through_its_values_and_slopes():
    course = COURSES["table"]
    reference = CubicHermiteSpline(TIMES, VALUES, course.slopes)
    for time in np.linspace(0.0, 1.0, 37):
        assert course.at(1.0 + time)[0] == pytest.approx(float(reference(time)), abs=1e-14)


def test_a_course_begins_when_it_is_told_and_is_broken_off_when_it_is_told():
    written = Course("table", 0.0, 1.0, 0.0, TIMES, VALUES, monotone_slopes(TIMES, VALUES))
    begun = written.begin(5.0, until=5.35)
    assert begun.at(5.2) == pytest.approx(written.at(0.2))
    assert begun.at(9.0) == pytest.approx((written.at(0.35)[0], 0.0))
    assert begun.knots.tolist() == [5.0, 5.3, 5.35]
    assert Course("sine", 0.0, np.inf, 1.0).begin(2.0).stop == np.inf


def test_knots_are_where_derivatives_jump():
    assert COURSES["table"].knots == pytest.approx(1.0 + TIMES)
    assert Course("constant", 1.0, np.inf).knots.tolist() == [1.0]


def test_a_turn_keeps_distances_and_moves_at_right_angles_to_arm_and_axis():
    axis = np.array([1.0, 2.0, -2.0]) / 3.0
    turn = Turn(np.array([0.5, 0.0, 1.0]), axis, 2.5, COURSES["smooth"])
    base = np.random.default_rng(1).normal(size=(5, 3))
    turned, velocity = turn.apply(base, 2.2)
    assert np.linalg.norm(turned - turn.centre, axis=1) == pytest.approx(
        np.linalg.norm(base - turn.centre, axis=1)
    )
    assert (turned - base) @ axis == pytest.approx(np.zeros(5), abs=1e-15)
    step = 1e-6
    slope = (turn.apply(base, 2.2 + step)[0] - turn.apply(base, 2.2 - step)[0]) / (2 * step)
    assert velocity == pytest.approx(slope, abs=1e-8)


def test_a_quarter_turn_about_z_takes_x_to_y():
    turn = Turn(
        np.zeros(3), np.array([0.0, 0.0, 1.0]), np.pi / 2, Course("constant", 0.0, np.inf)
    )
    assert turn.apply(np.array([[1.0, 0.0, 7.0]]), 0.0)[0] == pytest.approx(
        np.array([[0, 1, 7]])
    )


def test_a_motion_is_its_turn_and_its_shifts_together():
    turn = Turn(np.zeros(3), np.array([0.0, 0.0, 1.0]), np.pi, COURSES["ramp"])
    shifts = (
        Term(np.array([1.0, 0, 0]), COURSES["ramp"]),
        Term(np.array([0, 0, 2.0]), COURSES["smooth"]),
    )
    motion = Motion(np.array([0]), np.array([[1.0, 0, 0]]), shifts, turn, span())
    position, velocity = motion.at(2.0)
    assert position == pytest.approx(np.array([[0.5, 1.0, 1.0]]))
    assert velocity == pytest.approx(np.array([[0.5 - np.pi / 2, 0.0, 15 / 8]]))


def test_a_load_is_the_sum_of_its_terms():
    terms = (
        Term(np.array([1.0, 0, 0]), COURSES["ramp"]),
        Term(np.array([0, 3.0, 0]), COURSES["constant"]),
    )
    assert Load(np.array([0]), terms, span()).at(2.0).tolist() == [0.5, 3.0, 0.0]


def test_a_new_situation_is_free_and_whole_and_shares_nothing_that_changes():
    network = chain(3, velocity=(1.0, 0.0, 0.0))
    situation = start(network)
    situation.position[0] = 9.0
    situation.velocity[0] = 9.0
    assert network.position[0].tolist() == [0, 0, 0]
    assert network.velocity[0].tolist() == [1, 0, 0]
    assert situation.alive.all()
    assert not situation.held.any()


def test_held_nodes_are_placed_at_rest_and_driven_ones_on_their_paths():
    situation = start(chain(3, velocity=(1.0, 0.0, 0.0)))
    motion = Motion(
        np.array([1]),
        np.array([[5.0, 0, 0]]),
        (Term(np.array([0, 2.0, 0]), COURSES["ramp"]),),
        None,
        span(),
    )
    situation.holders = {"fix": np.array([0]), "tool": np.array([1])}
    situation.motions = {"tool": motion}
    situation.time = 2.0
    situation.place_held()
    assert situation.position[1].tolist() == [5, 1, 0]
    assert situation.velocity.tolist() == [[0, 0, 0], [0, 1, 0], [1, 0, 0]]
