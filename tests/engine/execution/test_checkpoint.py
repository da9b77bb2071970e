"""What goes into a checkpoint comes out again, and nothing else can."""

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec import Struct

from tests.examples import examples
from tests.hand_net import chain, order, span, start, table
from tissuec.engine.execution.run_state import read_state, write_state
from tissuec.script.verbs.motion import EndMotion


@settings(max_examples=examples(25))
@given(st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(),
    lambda inner: st.lists(inner) | st.tuples(inner, inner) | st.dictionaries(st.text(), inner),
))  # fmt: skip
def test_plain_values_come_back_as_they_were(value):
    assert read_state(write_state(value, []), []) == value


def test_numbers_come_back_to_the_last_bit():
    value = [0.1 + 0.2, 5e-324, -0.0, np.inf, np.float64(1 / 3), np.int64(7), np.bool_(True)]
    back = read_state(write_state(value, []), [])
    assert [float(x).hex() for x in back] == [float(x).hex() for x in value]


def test_arrays_keep_shape_and_kind():
    arrays = (np.arange(6).reshape(2, 3), np.array([True, False]), np.zeros((0, 3)))
    for one, other in zip(arrays, read_state(write_state(arrays, []), []), strict=True):
        assert one.dtype == other.dtype
        assert np.array_equal(one, other)


def test_a_situation_comes_back_with_its_motions_and_shares_what_the_network_has():
    network = chain(4)
    state, groups = start(network), {"a": [0, 1], "b": [3]}
    words = span("move")

    class Agenda:
        def add(self, time, action):
            pass

        def land(self, times):
            pass

    profile = table([0.0, 0.5, 1.0], [0, 1, 3])
    order("move a", groups, by=(1, 2, 3), using=(profile,)).apply(state, Agenda())
    order("turn a", groups, duration=1, by=1.0, around=(0, 0, 1), using="ramp").apply(
        state, Agenda()
    )
    order("push b", groups, with_=(1, 0, 0)).apply(state, Agenda())
    order("fix b", groups).apply(state, Agenda())
    sources = [m.span.source for m in state.motions.values()]
    sources += [load.span.source for load in state.loads.values()]
    known = [network, network.mass, network.springs.stiffness, *sources, words.source]
    back, end = read_state(write_state((state, EndMotion("a", 1.0, words)), known), known)
    assert back.network is network
    assert back.mass is network.mass
    assert back.springs.stiffness is network.springs.stiffness
    assert back.springs.rest is not network.springs.rest
    assert np.array_equal(back.springs.rest, state.springs.rest)
    assert end == EndMotion("a", 1.0, words)
    for time in (0.0, 0.3, 0.77, 2.0):
        for one, other in zip(
            state.motions["a"].at(time), back.motions["a"].at(time), strict=True
        ):
            assert np.array_equal(one, other)
    assert [load.at(0.5).tolist() for load in back.loads.values()] == [[[1, 0, 0]]]
    assert back.holders["fix"].tolist() == [3]


class Foreign(Struct):
    number: int = 0


def test_only_values_of_this_package_go_in():
    for value in (Foreign(), object(), {1, 2}, print):
        with pytest.raises(TypeError, match="cannot hold"):
            write_state(value, [])


@pytest.mark.parametrize(
    "text",
    [
        {"record": "subprocess:Popen", "fields": {"args": "ls"}},
        {"record": "tissuec.engine.execution.run_state:json", "fields": {}},
        {"record": "tissuec.engine.execution.run_state:write_state", "fields": {}},
        {"record": "tissuec.script.verbs.hold:nothing", "fields": {}},
        {"something": 1},
    ],
)
def test_only_records_of_this_package_come_out(text):
    with pytest.raises(ValueError, match=r"record of tissuec|checkpoint of a run"):
        read_state({"text": json.dumps(text)}, [])
