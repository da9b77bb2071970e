"""move, turn and stop: paths, their ends, and how they add up."""

import numpy as np
import pytest

from tests.hand_net import Diary, Refused, chain, make_net, order, start, table

SETS = {"all": [0, 1, 2, 3], "left": [0, 1], "end": [3]}
TOOLS = {"forceps A": "forceps"}
SQUARE = [(1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0)]


@pytest.fixture
def state():
    return start(chain(4))


@pytest.fixture
def diary():
    return Diary()


def say(state, diary, sentence, **clauses):
    return order(sentence, SETS, tools=TOOLS, **clauses).apply(state, diary)


def turn(state, diary, sentence="turn all", *, using="constant speed", **clauses):
    return say(state, diary, sentence, using=using, **clauses)


def test_a_moved_set_ends_exactly_and_at_rest_and_stays_held(state, diary):
    state.time = 0.1
    say(state, diary, "move left", duration=0.3, by=(0.1, 0.2, 0.7), using="constant speed")
    diary.play(state, 0.25)
    assert state.velocity[0] == pytest.approx(np.array([0.1, 0.2, 0.7]) / 0.3)
    assert state.position[0] == pytest.approx(np.array([0.1, 0.2, 0.7]) / 2)
    diary.play(state, 1.0)
    assert state.position[:2].tolist() == [[0.1, 0.2, 0.7], [1.1, 0.2, 0.7]]
    assert np.all(state.velocity == 0.0)
    assert state.holders["left"].tolist() == [0, 1]
    assert not state.motions


def test_a_tool_moves_what_it_holds_and_nothing_when_it_is_empty(state, diary):
    (logged_event,) = say(
        state, diary, "move forceps A", duration=1, by=(1, 0, 0), using="ramp"
    )
    assert logged_event.kind == "note"
    assert not state.motions
    say(state, diary, "grasp left", with_="forceps A")
    say(state, diary, "move forceps A", duration=1, by=(1, 0, 0), using="ramp")
    diary.play(state, 2.0)
    assert state.position[:, 0].tolist() == [1, 2, 2, 3]


def test_motions_of_one_mover_add_up(state, diary):
    say(state, diary, "move left", duration=2.0, by=(2, 0, 0), using="constant speed")
    diary.play(state, 1.0)
    say(state, diary, "move left", duration=2.0, by=(0, 0, 4), using="constant speed")
    assert state.position[0].tolist() == [1, 0, 0]
    assert state.velocity[0].tolist() == [1, 0, 2]
    diary.play(state, 2.5)
    assert state.position[0].tolist() == [2, 0, 3]
    diary.play(state, 9.0)
    assert state.position[:2].tolist() == [[2, 0, 4], [3, 0, 4]]


def test_of_two_movers_that_drive_a_node_the_later_counts(state, diary):
    say(state, diary, "grasp all", with_="forceps A")
    say(state, diary, "move forceps A", duration=1, by=(1, 0, 0), using="ramp")
    diary.play(state, 0.5)
    say(state, diary, "move end", duration=1, by=(0, 0, 1), using="ramp")
    diary.play(state, 3.0)
    assert state.position[3].tolist() == [3.5, 0, 1]
    assert state.position[0].tolist() == [1, 0, 0]


def test_what_a_moving_tool_grasps_moves_along_from_there(state, diary):
    say(state, diary, "grasp left", with_="forceps A")
    say(state, diary, "move forceps A", duration=1, by=(0, 0, 2), using="ramp")
    diary.play(state, 0.5)
    say(state, diary, "grasp end", with_="forceps A")
    assert state.velocity[3].tolist() == [0, 0, 2]
    diary.play(state, 3.0)
    assert state.position[:, 2].tolist() == [2, 2, 0, 1]


def test_what_a_turning_tool_grasps_turns_along_from_there(diary):
    state = start(make_net(SQUARE, []))
    say(state, diary, "grasp left", with_="forceps A")
    turn(
        state,
        diary,
        "turn forceps A",
        duration=1,
        by=np.pi,
        around=(0, 0, 1),
        through=(0, 0, 0),
        using="ramp",
    )
    diary.play(state, 0.5)
    say(state, diary, "grasp end", with_="forceps A")
    diary.play(state, 2.0)
    # The end, at (0, -1, 0), goes on for the second quarter only.
    assert state.position[3] == pytest.approx([1, 0, 0], abs=1e-15)
    assert state.position[0] == pytest.approx([-1, 0, 0], abs=1e-15)


def test_a_turn_is_right_handed_about_the_mean_position(diary):
    state = start(make_net(SQUARE, []))
    turn(state, diary, duration=1, by=np.pi / 2, around=(0, 0, 2), using="smooth profile")
    diary.play(state, 1.5)
    assert state.position == pytest.approx(np.roll(SQUARE, -1, axis=0), abs=1e-15)


def test_a_turn_goes_through_the_point_that_is_written(diary):
    state = start(make_net(SQUARE, []))
    turn(
        state,
        diary,
        "turn end",
        duration=1,
        by=np.pi,
        around=(0, 0, 1),
        through=(1, -1, 0),
        using="ramp",
    )
    diary.play(state, 1.0)
    assert state.position[3] == pytest.approx([2, -1, 0], abs=1e-15)


def test_velocities_of_a_turning_and_moving_set_are_those_of_its_path(diary):
    state = start(make_net(SQUARE, []))
    say(state, diary, "move all", duration=2, by=(1, 2, 3), using="smooth profile")
    diary.play(state, 0.4)
    turn(state, diary, duration=1, by=2.0, around=(1, 1, 0), using="smooth profile")
    motion = state.motions["all"]
    step = 1e-6
    for time in (0.5, 0.8, 1.3):
        slope = (motion.at(time + step)[0] - motion.at(time - step)[0]) / (2 * step)
        # A central difference of a smooth path: error step² times its third derivative.
        assert motion.at(time)[1] == pytest.approx(slope, abs=1e-8)


def test_a_turn_carries_its_axis_along_with_a_motion_and_stays_rigid(diary):
    state = start(make_net(SQUARE, []))
    say(state, diary, "move all", duration=2, by=(4, 0, 0), using="constant speed")
    diary.play(state, 1.0)
    turn(state, diary, duration=2, by=np.pi, around=(0, 0, 1))
    diary.play(state, 2.5)
    centre = state.position.mean(axis=0)
    assert centre == pytest.approx([4, 0, 0], abs=1e-14)
    diary.play(state, 4.0)
    assert state.position == pytest.approx(-np.array(SQUARE) + [4, 0, 0], abs=1e-14)


def test_a_second_turn_begins_where_the_first_is_and_ends_it(diary):
    state = start(make_net(SQUARE, []))
    turn(state, diary, duration=2, by=np.pi, around=(0, 0, 1))
    diary.play(state, 1.0)
    turn(state, diary, duration=2, by=np.pi, around=(1, 0, 0))
    diary.play(state, 9.0)
    expected = np.roll(SQUARE, -1, axis=0) * np.array([1, -1, -1])
    assert state.position == pytest.approx(expected, abs=1e-14)


def test_prescribed_displacements_are_followed_through_their_rows(state, diary):
    times = [0.0, 0.5, 1.0]
    rows = table(times, [0, 1, 1]), table(times, [0, 0, 2]), table(times, [0, -1, 0])
    say(state, diary, "move end", using=rows)
    assert {0.0, 0.5, 1.0} <= diary.landings
    diary.play(state, 0.5)
    assert state.position[3] == pytest.approx([4, 0, -1])
    diary.play(state, 2.0)
    assert state.position[3].tolist() == [4, 2, 0]
    assert not state.motions


def test_an_interval_breaks_off_a_longer_table(state, diary):
    say(state, diary, "move end", duration=0.5, by=(1, 0, 0), using=(table([0, 1], [0, 1]),))
    diary.play(state, 2.0)
    assert state.position[3] == pytest.approx([3.5, 0, 0])


def test_stop_moving_freezes_the_set_where_it_is_still_held(state, diary):
    say(state, diary, "move left", duration=2, by=(2, 0, 0), using="constant speed")
    diary.play(state, 1.0)
    (logged_event,) = say(state, diary, "stop moving left")
    assert logged_event.kind == "stop"
    diary.play(state, 5.0)
    assert state.position[0].tolist() == [1, 0, 0]
    assert state.held[:2].all()


def test_stop_turning_leaves_the_motion_alone(diary):
    state = start(make_net(SQUARE, []))
    say(state, diary, "move all", duration=2, by=(0, 0, 2), using="constant speed")
    turn(state, diary, duration=2, by=np.pi, around=(0, 0, 1))
    diary.play(state, 1.0)
    say(state, diary, "stop turning all")
    diary.play(state, 3.0)
    expected = np.roll(SQUARE, -1, axis=0) + np.array([0, 0, 2])
    assert state.position == pytest.approx(expected, abs=1e-15)


@pytest.mark.parametrize(
    "what", ["moving left", "turning left", "pushing left", "pulling left"]
)
def test_stopping_what_is_not_under_way_is_noted(state, diary, what):
    (logged_event,) = say(state, diary, f"stop {what}")
    assert logged_event.kind == "note"


def test_only_forces_and_motions_can_be_stopped():
    with pytest.raises(Refused, match="TIS305"):
        order("stop holding left", SETS)


def test_a_motion_must_state_its_profile():
    with pytest.raises(Refused, match="TIS304"):
        order("move left", SETS, duration=1, by=(1, 0, 0))


def test_one_plan_can_be_carried_out_again(diary):
    action = order("move left", SETS, duration=1, by=(1, 0, 0), using="smooth profile")
    ends = []
    for begin in (0.0, 3.0):
        state, diary = start(chain(4)), Diary()
        state.time = begin
        action.apply(state, diary)
        diary.play(state, begin + 2.0)
        ends.append(state.position.tolist())
    assert ends[0] == ends[1]
