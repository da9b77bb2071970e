"""Courses, motions and loads against closed forms and finite differences."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import CubicHermiteSpline, PchipInterpolator

from tests.hand_net import chain, span, start
from tissuec.core.arrays import monotone_slopes
from tissuec.forces.acting.load import Load, LoadTerm
from tissuec.mechanics.state import PrescribedMotion, PrescribedRotation
from tissuec.model.profiles import TimeProfile

TIMES = np.array([0.0, 0.3, 0.4, 1.0])
VALUES = np.array([0.0, 2.0, 1.5, 1.5])
COURSES = {
    "constant": TimeProfile("constant", 1.0, 3.0),
    "ramp": TimeProfile("ramp", 1.0, 3.0),
    "smooth": TimeProfile("smooth", 1.0, 3.0),
    "sine": TimeProfile("sine", 1.0, 3.0, 2.3),
    "table": TimeProfile("table", 1.0, 2.0, 0.0, TIMES, VALUES, monotone_slopes(TIMES, VALUES)),
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
    profile = COURSES[kind]
    assert profile.at(-9.0) == (profile.at(profile.start)[0], 0.0)
    assert profile.at(99.0) == (profile.at(profile.stop)[0], 0.0)


def test_courses_have_their_closed_forms():
    assert COURSES["ramp"].at(1.5) == (0.25, 0.5)
    assert COURSES["constant"].at(0.0) == (1.0, 0.0)
    assert COURSES["sine"].at(1.1)[0] == pytest.approx(np.sin(2 * np.pi * 2.3 * 0.1))
    assert COURSES["smooth"].at(2.0) == pytest.approx((0.5, 15 / 16))


def test_a_smooth_course_begins_and_ends_without_speed_or_acceleration():
    profile, step = COURSES["smooth"], 1e-4
    for end, inward in ((1.0, step), (3.0, -step)):
        assert profile.at(end)[1] == 0.0
        # The rate leaves zero with the square of the time: 30 p² / length.
        assert abs(profile.at(end + inward)[1]) < 30 * (step / 2) ** 2


@given(st.lists(st.floats(-10, 10), min_size=2, max_size=12), st.integers(0, 2**31))
def test_table_slopes_are_those_of_fritsch_and_butland_and_keep_it_monotone(values, seed):
    times = np.cumsum(np.random.default_rng(seed).uniform(0.1, 2.0, len(values)))
    times -= times[0]
    slopes = monotone_slopes(times, np.array(values))
    with np.errstate(over="ignore"):
        reference = PchipInterpolator(times, values)
    assert slopes == pytest.approx(reference.derivative()(times), abs=1e-9, rel=1e-9)
    profile = TimeProfile("table", 0.0, times[-1], 0.0, times, np.array(values), slopes)
    for low, high in zip(range(len(values)), range(1, len(values)), strict=False):
        inside = [profile.at(t)[0] for t in np.linspace(times[low], times[high], 9)]
        bounds = sorted((values[low], values[high]))
        assert bounds[0] - 1e-9 <= min(inside)
        assert max(inside) <= bounds[1] + 1e-9


def test_a_table_is_the_cubic_through_its_values_and_slopes():
    profile = COURSES["table"]
    reference = CubicHermiteSpline(TIMES, VALUES, profile.slopes)
    for time in np.linspace(0.0, 1.0, 37):
        assert profile.at(1.0 + time)[0] == pytest.approx(float(reference(time)), abs=1e-14)


def test_a_course_begins_when_it_is_told_and_is_broken_off_when_it_is_told():
    written = TimeProfile("table", 0.0, 1.0, 0.0, TIMES, VALUES, monotone_slopes(TIMES, VALUES))
    begun = written.begin(5.0, until=5.35)
    assert begun.at(5.2) == pytest.approx(written.at(0.2))
    assert begun.at(9.0) == pytest.approx((written.at(0.35)[0], 0.0))
    assert begun.knots.tolist() == [5.0, 5.3, 5.35]
    assert TimeProfile("sine", 0.0, np.inf, 1.0).begin(2.0).stop == np.inf


def test_knots_are_where_derivatives_jump():
    assert COURSES["table"].knots == pytest.approx(1.0 + TIMES)
    assert TimeProfile("constant", 1.0, np.inf).knots.tolist() == [1.0]


def test_a_turn_keeps_distances_and_moves_at_right_angles_to_arm_and_axis():
    axis = np.array([1.0, 2.0, -2.0]) / 3.0
    turn = PrescribedRotation(np.array([0.5, 0.0, 1.0]), axis, 2.5, COURSES["smooth"])
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
    turn = PrescribedRotation(
        np.zeros(3), np.array([0.0, 0.0, 1.0]), np.pi / 2, TimeProfile("constant", 0.0, np.inf)
    )
    assert turn.apply(np.array([[1.0, 0.0, 7.0]]), 0.0)[0] == pytest.approx(
        np.array([[0, 1, 7]])
    )


def test_a_motion_is_its_turn_and_its_shifts_together():
    turn = PrescribedRotation(np.zeros(3), np.array([0.0, 0.0, 1.0]), np.pi, COURSES["ramp"])
    shifts = (
        LoadTerm(np.array([1.0, 0, 0]), COURSES["ramp"]),
        LoadTerm(np.array([0, 0, 2.0]), COURSES["smooth"]),
    )
    motion = PrescribedMotion(np.array([0]), np.array([[1.0, 0, 0]]), shifts, turn, span())
    position, velocity = motion.at(2.0)
    assert position == pytest.approx(np.array([[0.5, 1.0, 1.0]]))
    assert velocity == pytest.approx(np.array([[0.5 - np.pi / 2, 0.0, 15 / 8]]))


def test_a_load_is_the_sum_of_its_terms():
    terms = (
        LoadTerm(np.array([1.0, 0, 0]), COURSES["ramp"]),
        LoadTerm(np.array([0, 3.0, 0]), COURSES["constant"]),
    )
    assert Load(np.array([0]), terms, span()).at(2.0).tolist() == [[0.5, 3.0, 0.0]]


def test_a_new_situation_is_free_and_whole_and_shares_nothing_that_changes():
    network = chain(3, velocity=(1.0, 0.0, 0.0))
    state = start(network)
    state.position[0] = 9.0
    state.velocity[0] = 9.0
    assert network.position[0].tolist() == [0, 0, 0]
    assert network.velocity[0].tolist() == [1, 0, 0]
    assert state.alive.all()
    assert not state.held.any()


def test_held_nodes_are_placed_at_rest_and_driven_ones_on_their_paths():
    state = start(chain(3, velocity=(1.0, 0.0, 0.0)))
    motion = PrescribedMotion(
        np.array([1]),
        np.array([[5.0, 0, 0]]),
        (LoadTerm(np.array([0, 2.0, 0]), COURSES["ramp"]),),
        None,
        span(),
    )
    state.holders = {"fix": np.array([0]), "tool": np.array([1])}
    state.motions = {"tool": motion}
    state.time = 2.0
    state.place_held()
    assert state.position[1].tolist() == [5, 1, 0]
    assert state.velocity.tolist() == [[0, 0, 0], [0, 1, 0], [1, 0, 0]]
