"""Which springs a cut goes through."""

import numpy as np
import pytest

from tests.hand_net import Diary, Refused, chain, make_net, order, start

TOOLS = {"shears": "scissors", "forceps A": "forceps"}


def cut(network, springs=None, **clauses):
    state = start(network)
    chosen = np.arange(network.spring_count) if springs is None else springs
    action = order("cut net", {"net": chosen}, tools=TOOLS, **clauses)
    (logged_event,) = action.apply(state, Diary())
    gone = np.flatnonzero(~state.alive).tolist()
    assert list(logged_event.springs) == gone
    assert (logged_event.kind == "cut") == bool(gone)
    return gone


def ring_tube(turned=None):
    """Return rings of four at x = 0…4, joined lengthwise: springs 20… are ring springs."""
    angle = np.arange(4) * np.pi / 2
    ring = np.column_stack([np.zeros(4), np.cos(angle), np.sin(angle)])
    position = np.concatenate([ring + np.array([x, 0, 0]) for x in range(5)])
    number = np.arange(20).reshape(5, 4)
    along = np.column_stack([number[:-1].ravel(), number[1:].ravel()])
    around = np.column_stack([number.ravel(), np.roll(number, -1, axis=1).ravel()])
    return make_net(
        position if turned is None else position @ turned.T, np.concatenate([along, around])
    )


def test_a_plane_between_nodes_cuts_what_joins_its_sides():
    assert cut(chain(6), along="plane", through=(2.5, 0, 0), facing=(1, 0, 0)) == [2]


@pytest.mark.parametrize(("facing", "expected"), [((1, 0, 0), 1), ((-1, 0, 0), 2)])
def test_a_node_on_the_plane_counts_as_in_front_of_it(facing, expected):
    assert cut(chain(6), along="plane", through=(2, 0, 0), facing=facing) == [expected]


def test_a_plane_through_a_ring_cuts_the_springs_on_one_side_only_however_it_is_turned():
    for seed in range(20):
        # A random rotation puts the ring off its plane by rounding, to either side.
        turned, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
        gone = cut(
            ring_tube(turned),
            along="plane",
            through=turned @ [2, 0, 0],
            facing=turned @ [1, 0, 0],
        )
        assert gone == [4, 5, 6, 7]


def test_a_cut_spares_springs_of_others_and_dead_ones():
    network = ring_tube()
    plane = {"along": "plane", "through": (2.5, 0, 0), "facing": (1, 0, 0)}
    assert cut(network, springs=[0, 8, 9], **plane) == [8, 9]
    state = start(network)
    state.alive = state.alive.copy()
    state.alive[8] = False
    (logged_event,) = order("cut net", {"net": np.arange(36)}, **plane).apply(state, Diary())
    assert list(logged_event.springs) == [9, 10, 11]


def test_a_stroke_cuts_only_within_its_parallelogram():
    # Blade along y from (2.5, 0.5, -3) to (2.5, 2, -3), swept upwards by 6.
    stroke = {"along": "stroke", "from_": (2.5, 0.5, -3), "to": (2.5, 2, -3), "by": (0, 0, 6)}
    assert cut(ring_tube(), **stroke) == [8]
    assert cut(ring_tube(), **(stroke | {"by": (0, 0, 2.5)})) == []


def test_a_slanting_stroke_is_a_parallelogram_and_not_its_box():
    network = make_net(
        [(0.9, 0.9, -1), (0.9, 0.9, 1), (0.2, 0.9, -1), (0.2, 0.9, 1)], [(0, 1), (2, 3)]
    )
    stroke = {"along": "stroke", "from_": (0, 0, 0), "to": (0.5, 0, 0), "by": (0.5, 1, 0)}
    assert cut(network, **stroke) == [0]


def test_a_line_cuts_the_strip_between_its_ends():
    line = {"along": "line", "from_": (2.5, -0.5, 7), "to": (2.5, 2, 7), "facing": (1, 0, 0)}
    # Endless up and down; springs 8 (y = 1), 9 (y = 0) and 11 (y = 0) lie between the ends.
    assert cut(ring_tube(), **line) == [8, 9, 11]


def test_springs_are_cut_by_name_alone():
    assert cut(chain(6), springs=[1, 4]) == [1, 4]


def test_a_cut_that_meets_nothing_is_noted():
    assert cut(chain(6), along="plane", through=(9, 0, 0), facing=(1, 0, 0)) == []


def test_springs_in_the_plane_of_the_blade_are_not_crossed():
    assert cut(chain(3), along="plane", through=(0, 0, 0), facing=(0, 0, 1)) == []


def test_cutting_changes_no_array_of_the_network_or_of_an_earlier_situation():
    state = start(chain(3))
    before = state.alive
    order("cut net", {"net": [0]}).apply(state, Diary())
    assert before.all()
    assert not state.alive[0]


@pytest.mark.parametrize(
    ("clauses", "code"),
    [
        ({"along": "circle"}, "TIS305"),
        ({"along": "plane", "through": (0, 0, 0)}, "TIS304"),
        ({"along": "stroke", "from_": (0, 0, 0), "to": (1, 0, 0), "by": (2, 0, 0)}, "TIS306"),
        ({"along": "line", "from_": (0, 0, 0), "to": (1, 0, 0), "facing": (1, 0, 1)}, "TIS306"),
        ({"along": "line", "from_": (0, 0, 0), "to": (0, 0, 0), "facing": (1, 0, 0)}, "TIS306"),
        ({"with_": "forceps A"}, "TIS312"),
    ],
)
def test_a_blade_must_be_complete_and_possible(clauses, code):
    with pytest.raises(Refused, match=code):
        order("cut net", {"net": [0]}, tools=TOOLS, **clauses)
