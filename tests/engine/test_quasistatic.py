"""Runs by relaxation are in equilibrium at every time that they show."""

import warnings

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.hand_net import chain, make_net, table
from tests.hand_plan import carry_out, event, expect, make_plan, when
from tests.mechanics.test_settling import residual
from tests.whole_runs import AfterAsking
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run import run
from tissuec.laws import LINEAR, SPRING_LAWS, Law
from tissuec.script.procedures import RelaxationChoices

DOWN = (0.0, 0.0, -9.81)
DRAWN = {"net": [0, 1, 2, 3], "nail": [0], "hand": [3]}


def drawn_out(*events, strength=np.inf, duration=1.0, **more):
    """Return a chain of three springs whose end is drawn away by 2 cm in 1 s, and its plan."""
    network = chain(4, spacing=0.01, stiffness=40.0, mass=0.01, strength=strength, damping=0.1)
    line = table([0.0, 1.0], [0.0, 1.0])
    orders = [event(0.0, "fix nail", DRAWN)]
    orders += [event(0.0, "move hand", DRAWN, by=(0.02, 0, 0), using=(line,), duration=1.0)]
    plan = make_plan(
        network, duration, [*orders, *events], integrator="relaxation", tolerance=None,
        step=0.05, every=0.1, energy=0.1, **more,
    )  # fmt: skip
    return network, plan


def test_nodes_stand_where_springs_share_the_stretch():
    outcome, recording = carry_out(*drawn_out())
    time, position, velocity, *_ = recording.frame_arrays()
    expected = np.arange(4) * (0.01 + 0.02 * time[:, None] / 3)
    assert outcome.kind == "done"
    assert position[:, :, 0] == pytest.approx(expected, abs=1e-10)
    assert not velocity[:, 1:3].any()
    assert outcome.statistics.accepted >= 20
    assert outcome.statistics.largest == pytest.approx(0.05)


def test_work_is_that_of_drawing_a_spring_slowly():
    _, recording = carry_out(*drawn_out())
    time, rows = recording.energy_arrays()
    elastic, work, lost = rows[:, 1], rows[:, 3], rows[:, 4]
    stiffness = 40.0 / 3.0
    assert work == pytest.approx(0.5 * stiffness * (0.02 * time) ** 2, abs=1e-9)
    assert elastic == pytest.approx(work, abs=1e-9)
    assert np.abs(lost).max() < 1e-9


def test_a_force_that_is_let_in_at_once_does_twice_the_work_that_is_stored():
    pull = event(0.5, "push hand", DRAWN, with_=(0.4, 0, 0))
    network = chain(4, spacing=0.01, stiffness=40.0, mass=0.01)
    plan = make_plan(
        network, 1.0, [event(0.0, "fix nail", DRAWN), pull], integrator="relaxation",
        tolerance=None, step=0.1, energy=0.1,
    )  # fmt: skip
    _, recording = carry_out(network, plan)
    _, rows = recording.energy_arrays()
    stretch = 0.4 / 40.0 * 3
    assert rows[-1, 1] == pytest.approx(0.5 * 0.4 * stretch, rel=1e-8)
    assert rows[-1, 3] == pytest.approx(0.4 * stretch, rel=1e-8)
    assert rows[-1, 4] == pytest.approx(0.5 * 0.4 * stretch, rel=1e-8)


def test_springs_rupture_at_the_relaxation_that_finds_them_overstretched():
    outcome, _ = carry_out(*drawn_out(strength=0.2))
    torn = [(t, h) for t, h in outcome.logged_events if h.kind == "rupture"]
    # 0.2 N are reached at 0.75 s; all three springs carry the same, up to rounding.
    assert torn[0][0] in (pytest.approx(0.75), pytest.approx(0.8))


def test_conditions_are_asked_at_every_relaxation():
    def stretched(snapshot):
        return snapshot.position[3, 0] > 0.0399

    network, plan = drawn_out(triggers=[when(stretched, event(0.0, "fix hand", DRAWN))])
    outcome, _ = carry_out(network, plan)
    (fired,) = [t for t, h in outcome.logged_events if h.kind == "trigger"]
    assert fired == pytest.approx(0.5)


def test_what_hangs_is_balanced():
    network, plan = drawn_out(gravity=DOWN)
    outcome, _ = carry_out(network, plan)
    assert outcome.kind == "done"
    assert residual(outcome.state) < 1e-8


def test_a_net_that_nothing_holds_gets_stuck_at_a_node():
    network = chain(3, spacing=0.01, stiffness=40.0, mass=0.01)
    plan = make_plan(
        network, 1.0, gravity=DOWN, integrator="relaxation", tolerance=None, step=0.5
    )
    outcome, _ = carry_out(network, plan)
    assert outcome.kind == "stuck"
    assert "no support balances" in outcome.message
    assert "node 100 of net" in outcome.message


def swept(threshold):
    """Return places of two nodes between a nail and a hand 3 cm apart, and sweeps, by hand.

    The node of the greatest force comes first, then its neighbour; each moves by F / 80 N/m.
    A sweep begins ahead of where the last one ended (Nesterov), unless that leads uphill.
    """
    c, at = 40.0, np.array([0.01, 0.02, 0.05])  # the hand was drawn by 2 cm

    def force(x):
        left = np.array([0.0, x[0], x[1]])
        pull = c * (np.array([x[0], x[1], at[2]]) - left - 0.01)
        return pull[1:] - pull[:-1]

    def energy(x):
        return 0.5 * c * ((np.diff([0.0, *x, at[2]]) - 0.01) ** 2).sum()

    x, pace = at[:2].copy(), 1.0
    ahead, before = x, force(x)
    urge = np.abs(before)
    for sweep in range(1, 1000):
        there, first = ahead.copy(), int(np.argmax(urge))
        for node in (first, 1 - first):
            there[node] += force(there)[node] / (2.0 * c)
        if energy(there) > energy(x) and pace > 1.0:
            ahead, pace = x, 1.0
            continue
        if np.dot(ahead - there, there - x) > 0.0:
            pace = 1.0
        faster = 0.5 * (1.0 + np.sqrt(1.0 + 4.0 * pace * pace))
        ahead = there + (pace - 1.0) / faster * (there - x)
        x, pace, urge, before = there, faster, np.abs(force(there) - before), force(there)
        if urge.max() <= threshold:
            return x, sweep
    raise AssertionError


@pytest.mark.parametrize("threshold", [0.3, 0.1, 3e-3, 1e-5])
def test_the_threshold_says_how_often_the_net_is_swept(threshold):
    network = chain(4, spacing=0.01, stiffness=40.0, mass=0.01)
    orders = [
        event(0.0, "fix nail", DRAWN),
        event(0.0, "move hand", DRAWN, by=(0.02, 0, 0), using=(table([0.0, 1.0], [0.0, 1.0]),),
              duration=1.0),
    ]  # fmt: skip
    plan = make_plan(
        network, 1.0, orders, integrator="relaxation", tolerance=None, step=1.0, every=1.0,
        choices=RelaxationChoices(threshold=threshold),
    )  # fmt: skip
    outcome, recording = carry_out(network, plan)
    expected, sweeps = swept(threshold)
    assert recording.frame_arrays()[1][-1, 1:3, 0] == pytest.approx(expected, abs=1e-12)
    # As it is drawn, the net is balanced, and found so by one sweep.
    assert outcome.statistics.evaluations == sweeps + 1


def test_activities_are_velocities_of_the_way_that_nodes_have_come():
    network, plan = drawn_out(choices=RelaxationChoices(activities="velocities"))
    outcome, recording = carry_out(network, plan)
    time, position, velocity, *_ = recording.frame_arrays()
    assert position[:, :, 0] == pytest.approx(
        np.arange(4) * (0.01 + 0.02 * time[:, None] / 3), abs=1e-10
    )
    speed = 0.02 / 3.0 * np.arange(4)
    assert velocity[1:, 1, 0] == pytest.approx(speed[1], abs=1e-8)
    assert velocity[1:, 2, 0] == pytest.approx(speed[2], abs=1e-8)
    _, rows = recording.energy_arrays()
    kinetic, elastic, _, work, lost = rows.T[:5]
    assert kinetic[1:] == pytest.approx(0.5 * 0.01 * (speed[1:3] ** 2).sum(), rel=1e-6)
    assert work - lost == pytest.approx(kinetic + elastic - kinetic[0] - elastic[0], abs=1e-12)
    # The next way begins where velocities lead, which is all the way here.
    still, _ = carry_out(*drawn_out())
    assert outcome.statistics.evaluations < 0.5 * still.statistics.evaluations


SLACK = {
    "toe": ({"strain": 0.03}, lambda e: 40.0 * (e * e / 6e-4 if e < 3e-4 else e - 1.5e-4)),
    "tension only": ({}, lambda e: 40.0 * e),
    "dead band": ({"slack": 2e-3}, lambda e: 40.0 * (e - 2e-3)),
    "exponential": ({"stiffening": 40.0}, lambda e: 0.01 * (np.exp(4e3 * e) - 1.0)),
}


@pytest.mark.parametrize("drawn", [0.01, 0.007], ids=["at rest length", "slack"])
@pytest.mark.parametrize("name", SLACK)
def test_what_hangs_by_a_spring_without_stiffness_falls_until_it_is_borne(name, drawn):
    """Slopes as drawn say nothing of what a law resists with; no number overflows."""
    entries, pull = SLACK[name]
    law = Law(name, SPRING_LAWS[name](**entries).force(), LINEAR.viscous)
    network = make_net(
        [[0, 0, 0], [0, 0, -drawn]], [[0, 1]], mass=0.02, stiffness=40.0, rest=0.01, law=law
    )
    plan = make_plan(
        network, 1.0, [event(0.0, "fix nail", {"nail": [0], "net": [0, 1]})], gravity=DOWN,
        integrator="relaxation", tolerance=None, step=1.0, every=1.0,
    )  # fmt: skip
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        outcome, recording = carry_out(network, plan)
    assert outcome.kind == "done"
    e = brentq(lambda e: pull(e) - 0.02 * 9.81, 1e-6, 0.02, xtol=1e-16)
    assert recording.frame_arrays()[1][-1, 1, 2] == pytest.approx(-0.01 - e, abs=1e-9)
    assert outcome.statistics.evaluations < 500


@pytest.mark.parametrize("activities", ["none", "velocities"])
@pytest.mark.parametrize("count", [1, 4, 9])
def test_a_run_that_is_resumed_gives_the_same_bytes(count, activities):
    network, plan = drawn_out(
        expectations=[expect(lambda snapshot: True, 0.0, 1.0)],
        choices=RelaxationChoices(activities=activities),
    )
    _, undisturbed = carry_out(network, plan)
    first, before = carry_out(network, plan, interrupt=AfterAsking(count))
    assert first.kind == "interrupted"
    recording = MemoryRecording()
    second = run(network, plan, Recorder(network, plan, recording), resume=before.state)
    assert second.kind == "done"
    whole = [undisturbed.frame_arrays()[1], undisturbed.energy_arrays()[1]]
    parts = [
        np.concatenate([get(before), get(recording)])
        for get in (lambda r: r.frame_arrays()[1], lambda r: r.energy_arrays()[1])
    ]
    for one, other in zip(whole, parts, strict=True):
        assert np.array_equal(one, other)
