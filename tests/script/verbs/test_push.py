"""push, pull and stop pushing."""

import numpy as np
import pytest

from tests.hand_net import Diary, Refused, chain, order, start

SETS = {"left": [0, 1], "end": [3], "left from": [2]}


@pytest.fixture
def state():
    return start(chain(4))


def acting(state):
    force = np.zeros((4, 3))
    for load in state.loads.values():
        force[load.nodes] += load.at(state.time)
    return force


def say(state, sentence, diary=None, **clauses):
    return order(sentence, SETS, **clauses).apply(state, diary or Diary())


def test_a_force_is_shared_equally_by_the_nodes(state):
    say(state, "push left", with_=(0, 0, -0.1))
    assert acting(state)[:, 2].tolist() == [-0.05, -0.05, 0, 0]


def test_each_node_can_get_the_whole_force(state):
    say(state, "push left", with_=(0, 0, -0.1), on="each node")
    assert acting(state)[:, 2].tolist() == [-0.1, -0.1, 0, 0]


def test_an_amount_along_a_direction_is_a_force(state):
    say(state, "pull end", with_=0.5, along=(0, 3, 4))
    assert acting(state)[3] == pytest.approx([0, 0.3, 0.4])


def test_forces_on_one_set_add_up_and_are_stopped_together(state):
    say(state, "push left", with_=(2, 0, 0))
    say(state, "pull left", with_=(0, 4, 0))
    say(state, "push left from", with_=(0, 0, 1))
    assert acting(state)[0].tolist() == [1, 2, 0]
    say(state, "stop pushing left")
    assert acting(state).tolist() == [[0, 0, 0], [0, 0, 0], [0, 0, 1], [0, 0, 0]]


def test_a_force_over_an_interval_ends_by_itself_and_ends_no_other(state):
    diary = Diary()
    say(state, "push end", diary, duration=1.0, with_=(1, 0, 0))
    say(state, "push end", diary, duration=2.0, with_=(0, 1, 0))
    diary.play(state, 1.0)
    assert acting(state)[3].tolist() == [0, 1, 0]
    diary.play(state, 2.0)
    assert not state.loads


def test_the_end_of_a_stopped_force_ends_no_later_one(state):
    diary = Diary()
    say(state, "push end", diary, duration=1.0, with_=(1, 0, 0))
    state.time = 0.5
    say(state, "stop pushing end", diary)
    say(state, "push end", diary, duration=5.0, with_=(3, 0, 0))
    assert diary.play(state, 1.0) == []
    assert acting(state)[3].tolist() == [3, 0, 0]


def test_a_ramp_rises_from_nothing_over_the_interval(state):
    state.time = 2.0
    say(state, "push end", duration=4.0, with_=(1, 0, 0), using="ramp")
    assert acting(state)[3, 0] == 0.0
    state.time = 3.0
    assert acting(state)[3, 0] == 0.25


@pytest.mark.parametrize(
    ("clauses", "code"),
    [
        ({}, "TIS304"),
        ({"with_": 0.5}, "TIS304"),
        ({"with_": (0, 0, 1), "along": (0, 0, 1)}, "TIS306"),
        ({"with_": (0, 0, 1), "on": "every node"}, "TIS305"),
    ],
)
def test_a_force_needs_exactly_one_direction(clauses, code):
    with pytest.raises(Refused, match=code):
        order("push end", SETS, **clauses)
