"""Runs by relaxation are in equilibrium at every time that they show."""

import numpy as np
import pytest

from tests.hand_net import chain, table
from tests.hand_plan import carry_out, event, expect, make_plan, when
from tests.statics.test_settling import residual
from tests.whole_runs import AfterAsking
from tissuec.running.memory import MemoryRecording
from tissuec.running.recording import Recorder
from tissuec.running.run import run

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
    torn = [(t, h) for t, h in outcome.happenings if h.kind == "rupture"]
    # 0.2 N are reached at 0.75 s; all three springs carry the same, up to rounding.
    assert torn[0][0] in (pytest.approx(0.75), pytest.approx(0.8))


def test_conditions_are_asked_at_every_relaxation():
    def stretched(moment):
        return moment.position[3, 0] > 0.0399

    network, plan = drawn_out(triggers=[when(stretched, event(0.0, "fix hand", DRAWN))])
    outcome, _ = carry_out(network, plan)
    (fired,) = [t for t, h in outcome.happenings if h.kind == "trigger"]
    assert fired == pytest.approx(0.5)


def test_what_hangs_is_balanced():
    network, plan = drawn_out(gravity=DOWN)
    outcome, _ = carry_out(network, plan)
    assert outcome.kind == "done"
    assert residual(outcome.situation) < 1e-8


def test_a_net_that_nothing_holds_gets_stuck_at_a_node():
    network = chain(3, spacing=0.01, stiffness=40.0, mass=0.01)
    plan = make_plan(
        network, 1.0, gravity=DOWN, integrator="relaxation", tolerance=None, step=0.5
    )
    outcome, _ = carry_out(network, plan)
    assert outcome.kind == "stuck"
    assert "no support balances" in outcome.message
    assert "node 100 of net" in outcome.message


@pytest.mark.parametrize("count", [1, 4, 9])
def test_a_run_that_is_resumed_gives_the_same_bytes(count):
    network, plan = drawn_out(expectations=[expect(lambda moment: True, 0.0, 1.0)])
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
