"""fix, free, hold, grasp and release: who holds what, and what velocity is left."""

import numpy as np
import pytest

from tests.hand_net import Diary, Refused, chain, order, start

SETS = {"left": [0, 1], "right": [1, 2], "end": [3]}
TOOLS = {"forceps A": "forceps", "forceps B": "forceps"}


@pytest.fixture
def situation():
    return start(chain(4, velocity=(0.0, 0.0, 2.0)))


def say(situation, sentence, diary=None, **clauses):
    action = order(sentence, SETS, tools=TOOLS, **clauses)
    return action.apply(situation, diary or Diary())


def test_fixed_nodes_are_stopped_and_stay_fixed_when_released(situation):
    say(situation, "fix left")
    assert situation.held.tolist() == [True, True, False, False]
    assert np.all(situation.velocity[:2] == 0.0)
    assert situation.velocity[2, 2] == 2.0
    (happening,) = say(situation, "release left")
    assert happening.kind == "note"
    assert situation.held[:2].all()


def test_free_ends_every_hold_on_the_nodes_and_on_no_others(situation):
    say(situation, "fix left")
    say(situation, "grasp right", with_="forceps A")
    (happening,) = say(situation, "free right")
    assert happening.kind == "free"
    assert situation.held.tolist() == [True, False, False, False]
    assert situation.holders["fix"].tolist() == [0]
    assert "forceps A" not in situation.holders


def test_freeing_what_nobody_holds_is_noted(situation):
    (happening,) = say(situation, "free end")
    assert happening.kind == "note"


def test_grips_of_one_tool_add_up(situation):
    say(situation, "grasp left", with_="forceps A")
    say(situation, "grasp right", with_="forceps A")
    assert situation.holders["forceps A"].tolist() == [0, 1, 2]


def test_a_node_is_free_only_when_its_last_holder_lets_go(situation):
    say(situation, "grasp left", with_="forceps A")
    say(situation, "grasp right", with_="forceps B")
    say(situation, "release right", from_="forceps B")
    assert situation.held.tolist() == [True, True, False, False]
    say(situation, "release left", from_="forceps A")
    assert not situation.held.any()


def test_releasing_a_set_from_a_tool_leaves_the_rest_of_the_grip(situation):
    say(situation, "grasp left", with_="forceps A")
    say(situation, "grasp end", with_="forceps A")
    say(situation, "release left", from_="forceps A")
    assert situation.holders["forceps A"].tolist() == [3]


def test_releasing_a_tool_empties_its_grip_only(situation):
    say(situation, "grasp left", with_="forceps A")
    say(situation, "grasp end", with_="forceps B")
    (happening,) = say(situation, "release forceps A")
    assert happening.kind == "release"
    assert list(situation.holders) == ["forceps B"]


def test_releasing_a_set_takes_it_from_every_tool(situation):
    say(situation, "grasp right", with_="forceps A")
    say(situation, "grasp right", with_="forceps B")
    say(situation, "release right")
    assert not situation.held.any()


def test_releasing_twice_is_noted_and_changes_nothing(situation):
    say(situation, "grasp left", with_="forceps A")
    say(situation, "release left", from_="forceps A")
    (happening,) = say(situation, "release left", from_="forceps A")
    assert happening.kind == "note"


def test_released_nodes_that_rested_start_from_rest(situation):
    say(situation, "grasp left", with_="forceps A")
    say(situation, "release left")
    assert np.all(situation.velocity[:2] == 0.0)


def test_a_driven_node_flies_on_with_the_velocity_of_its_path(situation):
    say(situation, "move left", duration=2.0, by=(0, 0, 3), using="constant speed")
    situation.time = 1.0
    say(situation, "release left")
    assert situation.velocity[:2] == pytest.approx(np.array([[0, 0, 1.5]] * 2))
    assert situation.position[:2, 2] == pytest.approx([1.5, 1.5])
    assert not situation.motions


def test_a_hold_for_an_interval_ends_by_itself(situation):
    diary = Diary()
    say(situation, "hold left", diary, duration=1.0)
    assert situation.held[:2].all()
    diary.play(situation, 0.999)
    assert situation.held[:2].all()
    diary.play(situation, 1.0)
    assert not situation.held.any()


def test_a_hold_without_an_end_lasts(situation):
    diary = Diary()
    say(situation, "hold left", diary)
    assert not diary.added
    assert situation.held[:2].all()


def test_the_end_of_a_hold_does_not_end_a_later_hold_of_the_same_set(situation):
    diary = Diary()
    say(situation, "hold left", diary, duration=1.0)
    situation.time = 0.5
    say(situation, "release left", diary)
    say(situation, "hold left", diary)
    diary.play(situation, 2.0)
    assert situation.held[:2].all()


def test_a_move_takes_the_place_of_a_hold(situation):
    diary = Diary()
    say(situation, "hold left", diary, duration=1.0)
    situation.time = 0.5
    say(situation, "move left", diary, duration=1.0, by=(1, 0, 0), using="smooth profile")
    diary.play(situation, 1.2)
    assert "left" in situation.motions
    diary.play(situation, 3.0)
    assert situation.held[:2].all()
    assert situation.position[0].tolist() == [1.0, 0.0, 0.0]


def test_holding_a_moving_set_stops_it_where_it_is(situation):
    diary = Diary()
    say(situation, "move left", diary, duration=2.0, by=(0, 0, 2), using="constant speed")
    situation.time = 1.0
    situation.place_held()
    say(situation, "hold left", diary)
    diary.play(situation, 5.0)
    assert situation.position[0].tolist() == [0.0, 0.0, 1.0]
    assert np.all(situation.velocity[:2] == 0.0)


def test_grasping_needs_a_tool():
    with pytest.raises(Refused, match="TIS304"):
        order("grasp left", SETS, tools=TOOLS)


def test_a_tool_cannot_be_released_from_a_tool():
    with pytest.raises(Refused, match="TIS306"):
        order("release forceps A", SETS, tools=TOOLS, from_="forceps B")
