"""push, pull and stop pushing."""

import numpy as np
import pytest

from tests.hand_net import Diary, Refused, chain, order, start

SETS = {"left": [0, 1], "end": [3], "left from": [2]}


@pytest.fixture
def situation():
    return start(chain(4))


def acting(situation):
    force = np.zeros((4, 3))
    for load in situation.loads.values():
        force[load.nodes] += load.at(situation.time)
    return force


def say(situation, sentence, diary=None, **clauses):
    return order(sentence, SETS, **clauses).apply(situation, diary or Diary())


def test_a_force_is_shared_equally_by_the_nodes(situation):
    say(situation, "push left", with_=(0, 0, -0.1))
    assert acting(situation)[:, 2].tolist() == [-0.05, -0.05, 0, 0]


def test_each_node_can_get_the_whole_force(situation):
    say(situation, "push left", with_=(0, 0, -0.1), on="each node")
    assert acting(situation)[:, 2].tolist() == [-0.1, -0.1, 0, 0]


def test_an_amount_along_a_direction_is_a_force(situation):
    say(situation, "pull end", with_=0.5, along=(0, 3, 4))
    assert acting(situation)[3] == pytest.approx([0, 0.3, 0.4])


def test_forces_on_one_set_add_up_and_are_stopped_together(situation):
    say(situation, "push left", with_=(2, 0, 0))
    say(situation, "pull left", with_=(0, 4, 0))
    say(situation, "push left from", with_=(0, 0, 1))
    assert acting(situation)[0].tolist() == [1, 2, 0]
    say(situation, "stop pushing left")
    assert acting(situation).tolist() == [[0, 0, 0], [0, 0, 0], [0, 0, 1], [0, 0, 0]]


def test_a_force_over_an_interval_ends_by_itself_and_ends_no_other(situation):
    diary = Diary()
    say(situation, "push end", diary, duration=1.0, with_=(1, 0, 0))
    say(situation, "push end", diary, duration=2.0, with_=(0, 1, 0))
    diary.play(situation, 1.0)
    assert acting(situation)[3].tolist() == [0, 1, 0]
    diary.play(situation, 2.0)
    assert not situation.loads


def test_the_end_of_a_stopped_force_ends_no_later_one(situation):
    diary = Diary()
    say(situation, "push end", diary, duration=1.0, with_=(1, 0, 0))
    situation.time = 0.5
    say(situation, "stop pushing end", diary)
    say(situation, "push end", diary, duration=5.0, with_=(3, 0, 0))
    assert diary.play(situation, 1.0) == []
    assert acting(situation)[3].tolist() == [3, 0, 0]


def test_a_ramp_rises_from_nothing_over_the_interval(situation):
    situation.time = 2.0
    say(situation, "push end", duration=4.0, with_=(1, 0, 0), using="ramp")
    assert acting(situation)[3, 0] == 0.0
    situation.time = 3.0
    assert acting(situation)[3, 0] == 0.25


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
