"""move, turn and stop: paths, their ends, and how they add up."""

import numpy as np
import pytest

from tests.hand_net import Diary, Refused, chain, make_net, order, start, table

SETS = {"all": [0, 1, 2, 3], "left": [0, 1], "end": [3]}
TOOLS = {"forceps A": "forceps"}
SQUARE = [(1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0)]


@pytest.fixture
def situation():
    return start(chain(4))


@pytest.fixture
def diary():
    return Diary()


def say(situation, diary, sentence, **clauses):
    return order(sentence, SETS, tools=TOOLS, **clauses).apply(situation, diary)


def test_a_moved_set_ends_exactly_and_at_rest_and_stays_held(situation, diary):
    situation.time = 0.1
    say(situation, diary, "move left", duration=0.3, by=(0.1, 0.2, 0.7), using="constant speed")
    diary.play(situation, 0.25)
    assert situation.velocity[0] == pytest.approx(np.array([0.1, 0.2, 0.7]) / 0.3)
    assert situation.position[0] == pytest.approx(np.array([0.1, 0.2, 0.7]) / 2)
    diary.play(situation, 1.0)
    assert situation.position[:2].tolist() == [[0.1, 0.2, 0.7], [1.1, 0.2, 0.7]]
    assert np.all(situation.velocity == 0.0)
    assert situation.holders["left"].tolist() == [0, 1]
    assert not situation.motions


def test_a_tool_moves_what_it_holds_and_nothing_when_it_is_empty(situation, diary):
    (happening,) = say(
        situation, diary, "move forceps A", duration=1, by=(1, 0, 0), using="ramp"
    )
    assert happening.kind == "note"
    assert not situation.motions
    say(situation, diary, "grasp left", with_="forceps A")
    say(situation, diary, "move forceps A", duration=1, by=(1, 0, 0), using="ramp")
    diary.play(situation, 2.0)
    assert situation.position[:, 0].tolist() == [1, 2, 2, 3]


def test_motions_of_one_mover_add_up(situation, diary):
    say(situation, diary, "move left", duration=2.0, by=(2, 0, 0), using="constant speed")
    diary.play(situation, 1.0)
    say(situation, diary, "move left", duration=2.0, by=(0, 0, 4), using="constant speed")
    assert situation.position[0].tolist() == [1, 0, 0]
    assert situation.velocity[0].tolist() == [1, 0, 2]
    diary.play(situation, 2.5)
    assert situation.position[0].tolist() == [2, 0, 3]
    diary.play(situation, 9.0)
    assert situation.position[:2].tolist() == [[2, 0, 4], [3, 0, 4]]


def test_of_two_movers_that_drive_a_node_the_later_counts(situation, diary):
    say(situation, diary, "grasp all", with_="forceps A")
    say(situation, diary, "move forceps A", duration=1, by=(1, 0, 0), using="ramp")
    diary.play(situation, 0.5)
    say(situation, diary, "move end", duration=1, by=(0, 0, 1), using="ramp")
    diary.play(situation, 3.0)
    assert situation.position[3].tolist() == [3.5, 0, 1]
    assert situation.position[0].tolist() == [1, 0, 0]


def test_what_a_moving_tool_grasps_moves_along_from_there(situation, diary):
    say(situation, diary, "grasp left", with_="forceps A")
    say(situation, diary, "move forceps A", duration=1, by=(0, 0, 2), using="ramp")
    diary.play(situation, 0.5)
    say(situation, diary, "grasp end", with_="forceps A")
    assert situation.velocity[3].tolist() == [0, 0, 2]
    diary.play(situation, 3.0)
    assert situation.position[:, 2].tolist() == [2, 2, 0, 1]


def test_what_a_turning_tool_grasps_turns_along_from_there(diary):
    situation = start(make_net(SQUARE, []))
    say(situation, diary, "grasp left", with_="forceps A")
    say(
        situation,
        diary,
        "turn forceps A",
        duration=1,
        by=np.pi,
        around=(0, 0, 1),
        through=(0, 0, 0),
        using="ramp",
    )
    diary.play(situation, 0.5)
    say(situation, diary, "grasp end", with_="forceps A")
    diary.play(situation, 2.0)
    # The end, at (0, -1, 0), goes on for the second quarter only.
    assert situation.position[3] == pytest.approx([1, 0, 0], abs=1e-15)
    assert situation.position[0] == pytest.approx([-1, 0, 0], abs=1e-15)


def test_a_turn_is_right_handed_about_the_mean_position(diary):
    situation = start(make_net(SQUARE, []))
    say(
        situation,
        diary,
        "turn all",
        duration=1,
        by=np.pi / 2,
        around=(0, 0, 2),
        using="smooth profile",
    )
    diary.play(situation, 1.5)
    assert situation.position == pytest.approx(np.roll(SQUARE, -1, axis=0), abs=1e-15)


def test_a_turn_goes_through_the_point_that_is_written(diary):
    situation = start(make_net(SQUARE, []))
    say(
        situation,
        diary,
        "turn end",
        duration=1,
        by=np.pi,
        around=(0, 0, 1),
        through=(1, -1, 0),
        using="ramp",
    )
    diary.play(situation, 1.0)
    assert situation.position[3] == pytest.approx([2, -1, 0], abs=1e-15)


def test_velocities_of_a_turning_and_moving_set_are_those_of_its_path(diary):
    situation = start(make_net(SQUARE, []))
    say(situation, diary, "move all", duration=2, by=(1, 2, 3), using="smooth profile")
    diary.play(situation, 0.4)
    say(
        situation,
        diary,
        "turn all",
        duration=1,
        by=2.0,
        around=(1, 1, 0),
        using="smooth profile",
    )
    motion = situation.motions["all"]
    step = 1e-6
    for time in (0.5, 0.8, 1.3):
        slope = (motion.at(time + step)[0] - motion.at(time - step)[0]) / (2 * step)
        # A central difference of a smooth path: error step² times its third derivative.
        assert motion.at(time)[1] == pytest.approx(slope, abs=1e-8)


def test_a_turn_carries_its_axis_along_with_a_motion_and_stays_rigid(diary):
    situation = start(make_net(SQUARE, []))
    say(situation, diary, "move all", duration=2, by=(4, 0, 0), using="constant speed")
    diary.play(situation, 1.0)
    say(
        situation,
        diary,
        "turn all",
        duration=2,
        by=np.pi,
        around=(0, 0, 1),
        using="constant speed",
    )
    diary.play(situation, 2.5)
    centre = situation.position.mean(axis=0)
    assert centre == pytest.approx([4, 0, 0], abs=1e-14)
    diary.play(situation, 4.0)
    assert situation.position == pytest.approx(-np.array(SQUARE) + [4, 0, 0], abs=1e-14)


def test_a_second_turn_begins_where_the_first_is_and_ends_it(diary):
    situation = start(make_net(SQUARE, []))
    say(
        situation,
        diary,
        "turn all",
        duration=2,
        by=np.pi,
        around=(0, 0, 1),
        using="constant speed",
    )
    diary.play(situation, 1.0)
    say(
        situation,
        diary,
        "turn all",
        duration=2,
        by=np.pi,
        around=(1, 0, 0),
        using="constant speed",
    )
    diary.play(situation, 9.0)
    expected = np.roll(SQUARE, -1, axis=0) * np.array([1, -1, -1])
    assert situation.position == pytest.approx(expected, abs=1e-14)


def test_prescribed_displacements_are_followed_through_their_rows(situation, diary):
    times = [0.0, 0.5, 1.0]
    rows = table(times, [0, 1, 1]), table(times, [0, 0, 2]), table(times, [0, -1, 0])
    say(situation, diary, "move end", using=rows)
    assert {0.0, 0.5, 1.0} <= diary.landings
    diary.play(situation, 0.5)
    assert situation.position[3] == pytest.approx([4, 0, -1])
    diary.play(situation, 2.0)
    assert situation.position[3].tolist() == [4, 2, 0]
    assert not situation.motions


def test_an_interval_breaks_off_a_longer_table(situation, diary):
    say(
        situation, diary, "move end", duration=0.5, by=(1, 0, 0), using=(table([0, 1], [0, 1]),)
    )
    diary.play(situation, 2.0)
    assert situation.position[3] == pytest.approx([3.5, 0, 0])


def test_stop_moving_freezes_the_set_where_it_is_still_held(situation, diary):
    say(situation, diary, "move left", duration=2, by=(2, 0, 0), using="constant speed")
    diary.play(situation, 1.0)
    (happening,) = say(situation, diary, "stop moving left")
    assert happening.kind == "stop"
    diary.play(situation, 5.0)
    assert situation.position[0].tolist() == [1, 0, 0]
    assert situation.held[:2].all()


def test_stop_turning_leaves_the_motion_alone(diary):
    situation = start(make_net(SQUARE, []))
    say(situation, diary, "move all", duration=2, by=(0, 0, 2), using="constant speed")
    say(
        situation,
        diary,
        "turn all",
        duration=2,
        by=np.pi,
        around=(0, 0, 1),
        using="constant speed",
    )
    diary.play(situation, 1.0)
    say(situation, diary, "stop turning all")
    diary.play(situation, 3.0)
    expected = np.roll(SQUARE, -1, axis=0) + np.array([0, 0, 2])
    assert situation.position == pytest.approx(expected, abs=1e-15)


@pytest.mark.parametrize(
    "what", ["moving left", "turning left", "pushing left", "pulling left"]
)
def test_stopping_what_is_not_under_way_is_noted(situation, diary, what):
    (happening,) = say(situation, diary, f"stop {what}")
    assert happening.kind == "note"


def test_only_forces_and_motions_can_be_stopped():
    with pytest.raises(Refused, match="TIS305"):
        order("stop holding left", SETS)


def test_a_motion_must_state_its_profile():
    with pytest.raises(Refused, match="TIS304"):
        order("move left", SETS, duration=1, by=(1, 0, 0))


def test_a_motion_must_not_begin_with_a_jump():
    with pytest.raises(Refused, match="TIS306"):
        order("move left", SETS, duration=1, by=(1, 0, 0), using=(table([0, 1], [0.5, 1]),))


def test_one_plan_can_be_carried_out_again(diary):
    action = order("move left", SETS, duration=1, by=(1, 0, 0), using="smooth profile")
    ends = []
    for begin in (0.0, 3.0):
        situation, diary = start(chain(4)), Diary()
        situation.time = begin
        action.apply(situation, diary)
        diary.play(situation, begin + 2.0)
        ends.append(situation.position.tolist())
    assert ends[0] == ends[1]
