"""The order to settle, in a run."""

import numpy as np
import pytest

from tests.hand_net import Refused, chain, order
from tests.hand_plan import carry_out, event, make_plan
from tests.validate.scenes import quantity, rod, validated

DOWN = (0.0, 0.0, -9.81)


def hanging(*orders, strength=np.inf, duration=0.2, **more):
    """Return a chain of three from a nail, which settles at 0 s, and the plan of its run."""
    network = chain(4, spacing=0.01, stiffness=40.0, mass=0.01, strength=strength, damping=0.1)
    groups = {"nail": [0], "net": [0, 1, 2, 3]}
    events = [event(0.0, "fix nail", groups)]
    events += [event(time, sentence, groups) for time, sentence in orders]
    return network, make_plan(network, duration, events, gravity=DOWN, **more)


def test_a_settled_start_is_a_run_at_rest():
    outcome, recording = carry_out(*hanging((0.0, "settle"), every=0.05))
    assert outcome.kind == "done"
    position = recording.frame_arrays()[1]
    assert np.ptp(position, axis=0).max() < 1e-12
    length = 3 * 0.01 + 0.01 * 9.81 / 40.0 * 6
    assert position[0, -1] == pytest.approx([0.0, 0.0, -length], abs=1e-12)


def test_energy_that_settling_takes_is_booked_as_switched():
    outcome, recording = carry_out(*hanging((0.1, "settle net"), energy=0.05))
    assert outcome.kind == "done"
    _, rows = recording.energy_arrays()
    assert rows[-1, 0] == pytest.approx(0.0, abs=1e-20)  # kinetic
    assert rows[-1, -1] < -1e-4  # switched
    balance = rows[:, 0] + rows[:, 1] + rows[:, 2] - rows[:, 3] + rows[:, 4] - rows[:, 5]
    assert np.abs(balance - balance[0]).max() < 1e-7 * np.abs(rows).max()


def test_what_is_overstretched_after_settling_ruptures_at_that_time():
    network, plan = hanging((0.0, "settle"), strength=0.25)
    outcome, _ = carry_out(network, plan)
    torn = [(t, h) for t, h in outcome.logged_events if h.kind == "rupture"]
    assert torn[0][0] == 0.0
    assert list(torn[0][1].springs) == [0]  # 0.294 N hang on it, 0.196 N on the next


def test_a_net_without_equilibrium_ends_the_run_in_a_sentence():
    network, plan = hanging((0.0, "free nail"), (0.0, "settle net"))
    outcome, _ = carry_out(network, plan)
    assert outcome.kind == "stuck"
    assert outcome.message.startswith(
        "the run stopped at 0 s; settle net: there is no equilibrium: no support "
        "balances a force of 392 mN; node 100 of net"
    )


def test_a_later_failure_keeps_what_was_recorded_until_then():
    network, plan = hanging((0.1, "free nail"), (0.1, "settle net"), every=0.05)
    outcome, recording = carry_out(network, plan)
    assert outcome.kind == "stuck"
    assert "at 100 ms" in outcome.message
    assert recording.frame_arrays()[0].tolist() == [0.0, 0.05, 0.1]  # with the last state


def test_a_mechanism_is_noted():
    network, plan = hanging((0.0, "settle"))
    plan = make_plan(network, 0.1, [event(0.0, "settle net", {"net": [0, 1, 2, 3]})])
    outcome, _ = carry_out(network, plan)
    note = [h for _, h in outcome.logged_events if h.kind == "note"][-1]
    assert "the net is a mechanism here" in note.cause
    assert "node 10" in note.cause


def test_a_part_of_a_scene_settles_at_one_time_only():
    with pytest.raises(Refused, match="cannot settle over an interval"):
        order("settle net", {"net": [0]}, duration=1.0)


@pytest.mark.parametrize("text", ["at 0 s: settle", "at 0.05 s: settle rod"])
def test_validate_settles_by_its_own_means(text):
    found = validated(rod(extra=text, method="integrator is automatic; tolerance = 1e-6"))
    assert found.verdict == "kept"
    assert quantity(found, "energy balance").is_kept
