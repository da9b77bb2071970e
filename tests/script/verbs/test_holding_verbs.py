"""fix, free, hold, grasp and release: who holds what, and what velocity is left."""

import numpy as np
import pytest

from tests.hand_net import Diary, Refused, chain, order, start

SETS = {"left": [0, 1], "right": [1, 2], "end": [3]}
TOOLS = {"forceps A": "forceps", "forceps B": "forceps"}


@pytest.fixture
def state():
    return start(chain(4, velocity=(0.0, 0.0, 2.0)))


def say(state, sentence, diary=None, **clauses):
    action = order(sentence, SETS, tools=TOOLS, **clauses)
    return action.apply(state, diary or Diary())


def test_fixed_nodes_are_stopped_and_stay_fixed_when_released(state):
    say(state, "fix left")
    assert state.held.tolist() == [True, True, False, False]
    assert np.all(state.velocity[:2] == 0.0)
    assert state.velocity[2, 2] == 2.0
    (logged_event,) = say(state, "release left")
    assert logged_event.kind == "note"
    assert state.held[:2].all()


def test_free_ends_every_hold_on_the_nodes_and_on_no_others(state):
    say(state, "fix left")
    say(state, "grasp right", with_="forceps A")
    (logged_event,) = say(state, "free right")
    assert logged_event.kind == "free"
    assert state.held.tolist() == [True, False, False, False]
    assert state.holders["fix"].tolist() == [0]
    assert "forceps A" not in state.holders


def test_freeing_what_nobody_holds_is_noted(state):
    (logged_event,) = say(state, "free end")
    assert logged_event.kind == "note"


def test_grips_of_one_tool_add_up(state):
    say(state, "grasp left", with_="forceps A")
    say(state, "grasp right", with_="forceps A")
    assert state.holders["forceps A"].tolist() == [0, 1, 2]


def test_a_node_is_free_only_when_its_last_holder_lets_go(state):
    say(state, "grasp left", with_="forceps A")
    say(state, "grasp right", with_="forceps B")
    say(state, "release right", from_="forceps B")
    assert state.held.tolist() == [True, True, False, False]
    say(state, "release left", from_="forceps A")
    assert not state.held.any()


def test_releasing_a_set_from_a_tool_leaves_the_rest_of_the_grip(state):
    say(state, "grasp left", with_="forceps A")
    say(state, "grasp end", with_="forceps A")
    say(state, "release left", from_="forceps A")
    assert state.holders["forceps A"].tolist() == [3]


def test_releasing_a_tool_empties_its_grip_only(state):
    say(state, "grasp left", with_="forceps A")
    say(state, "grasp end", with_="forceps B")
    (logged_event,) = say(state, "release forceps A")
    assert logged_event.kind == "release"
    assert list(state.holders) == ["forceps B"]


def test_releasing_a_set_takes_it_from_every_tool(state):
    say(state, "grasp right", with_="forceps A")
    say(state, "grasp right", with_="forceps B")
    say(state, "release right")
    assert not state.held.any()


def test_releasing_twice_is_noted_and_changes_nothing(state):
    say(state, "grasp left", with_="forceps A")
    say(state, "release left", from_="forceps A")
    (logged_event,) = say(state, "release left", from_="forceps A")
    assert logged_event.kind == "note"


def test_released_nodes_that_rested_start_from_rest(state):
    say(state, "grasp left", with_="forceps A")
    say(state, "release left")
    assert np.all(state.velocity[:2] == 0.0)


def test_a_driven_node_flies_on_with_the_velocity_of_its_path(state):
    say(state, "move left", duration=2.0, by=(0, 0, 3), using="constant speed")
    state.time = 1.0
    say(state, "release left")
    assert state.velocity[:2] == pytest.approx(np.array([[0, 0, 1.5]] * 2))
    assert state.position[:2, 2] == pytest.approx([1.5, 1.5])
    assert not state.motions


def test_a_hold_for_an_interval_ends_by_itself(state):
    diary = Diary()
    say(state, "hold left", diary, duration=1.0)
    assert state.held[:2].all()
    diary.play(state, 0.999)
    assert state.held[:2].all()
    diary.play(state, 1.0)
    assert not state.held.any()


def test_a_hold_without_an_end_lasts(state):
    diary = Diary()
    say(state, "hold left", diary)
    assert not diary.added
    assert state.held[:2].all()


def test_the_end_of_a_hold_does_not_end_a_later_hold_of_the_same_set(state):
    diary = Diary()
    say(state, "hold left", diary, duration=1.0)
    state.time = 0.5
    say(state, "release left", diary)
    say(state, "hold left", diary)
    diary.play(state, 2.0)
    assert state.held[:2].all()


def test_a_move_takes_the_place_of_a_hold(state):
    diary = Diary()
    say(state, "hold left", diary, duration=1.0)
    state.time = 0.5
    say(state, "move left", diary, duration=1.0, by=(1, 0, 0), using="smooth profile")
    diary.play(state, 1.2)
    assert "left" in state.motions
    diary.play(state, 3.0)
    assert state.held[:2].all()
    assert state.position[0].tolist() == [1.0, 0.0, 0.0]


def test_holding_a_moving_set_stops_it_where_it_is(state):
    diary = Diary()
    say(state, "move left", diary, duration=2.0, by=(0, 0, 2), using="constant speed")
    state.time = 1.0
    state.place_held()
    say(state, "hold left", diary)
    diary.play(state, 5.0)
    assert state.position[0].tolist() == [0.0, 0.0, 1.0]
    assert np.all(state.velocity[:2] == 0.0)


def test_grasping_needs_a_tool():
    with pytest.raises(Refused, match="TIS304"):
        order("grasp left", SETS, tools=TOOLS)


def test_a_tool_cannot_be_released_from_a_tool():
    with pytest.raises(Refused, match="TIS306"):
        order("release forceps A", SETS, tools=TOOLS, from_="forceps B")
