"""Springs rupture at the very time at which their tension reaches their strength."""

from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from tests.engine.members import MEMBERS, ON_BACKENDS, affordable, those
from tests.engine.running import Bench, block, chain, pair
from tests.hand_net import make_net
from tissuec.engine import step_events
from tissuec.engine.backends import BACKENDS
from tissuec.engine.step_events import AcceptedStep
from tissuec.model.profiles import TimeProfile


def break_and_go_on(bench, until):
    """Advance with every rupture carried out; return their times and springs."""
    found = []
    while True:
        end = bench.advance(until)
        if end.kind != "ruptured":
            assert end.kind == "reached"
            return found
        found.append((end.time, end.springs.tolist()))
        bench.state.alive[end.springs] = False
        bench.engine.restart(bench.state)


@pytest.mark.parametrize(("method", "backend"), ON_BACKENDS)
def test_swinging_pair_breaks_when_its_tension_reaches_the_strength(method, backend):
    # Drawn 10 % pressed, T = -10 N cos(w t) reaches 6 N at a known time.
    omega = np.sqrt(200.0)
    tolerance = affordable(method)
    bench = Bench(
        pair(stretch=-0.1, strength=6.0),
        1.0,
        method=method,
        tolerance=tolerance,
        ruptures=True,
        backend=backend,
    )
    end = bench.advance(1.0)
    exact = np.arccos(-0.6) / omega
    assert (end.kind, end.springs.tolist()) == ("ruptured", [0])
    # Twice the position error of 0.1 m over the speed of the elongation there, 1.1 m/s.
    assert end.time == pytest.approx(exact, abs=0.2 * tolerance + 1e-12)
    assert bench.state.time == end.time
    length = np.diff(bench.state.position[:, 0])[0]
    assert 100.0 * (length - 1.0) == pytest.approx(6.0, rel=1e-9)


@pytest.mark.parametrize(("method", "backend"), ON_BACKENDS)
def test_swinging_pair_is_crushed_when_its_pressure_reaches_the_limit(method, backend):
    # Drawn 10 % stretched, T = 10 N cos(w t) falls to -6 N at a known time.
    tolerance = affordable(method)
    bench = Bench(
        pair(stretch=0.1, crush=6.0, strength=11.0),
        1.0,
        method=method,
        tolerance=tolerance,
        ruptures=True,
        backend=backend,
    )
    end = bench.advance(1.0)
    exact = np.arccos(-0.6) / np.sqrt(200.0)
    assert (end.kind, end.springs.tolist()) == ("ruptured", [0])
    # As above: twice the position error of 0.1 m over the speed of the elongation.
    assert end.time == pytest.approx(exact, abs=0.2 * tolerance + 1e-12)
    length = np.diff(bench.state.position[:, 0])[0]
    assert 100.0 * (length - 1.0) == pytest.approx(-6.0, rel=1e-9)


def test_crushing_is_located_to_1e_8_of_the_period():
    bench = Bench(pair(stretch=0.1, crush=6.0), 1.0, tolerance=1e-9, ruptures=True)
    exact = np.arccos(-0.6) / np.sqrt(200.0)
    assert bench.advance(1.0).time == pytest.approx(exact, rel=1e-8)


@pytest.mark.parametrize(("tension", "pressure"), [(6.0, 5.0), (8.0, 6.0), (7.0, 7.0)])
def test_whichever_limit_is_reached_first_breaks_the_spring(tension, pressure):
    # T = 10 N sin(w t): first the tension, a half period later the pressure.
    velocity = [[-1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
    net = pair(stretch=0.0, velocity=velocity, strength=tension, crush=pressure)
    omega = np.sqrt(200.0)
    top = 100.0 / omega
    end = Bench(net, 1.0, tolerance=1e-8, ruptures=True).advance(1.0)
    swing = np.arcsin(tension / top) if tension < top else np.pi + np.arcsin(pressure / top)
    assert end.kind == "ruptured"
    assert end.time == pytest.approx(swing / omega, rel=1e-6)


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0), (1, 0, 2)])
def test_the_first_of_springs_that_rupture_within_a_moment_is_found(order):
    # T = c / w sin(w t), by 1e-5 of the time later from one spring to the next.
    position, velocity = np.zeros((2, 6, 3))
    position[:, 0], position[:, 1] = [0, 1, 0, 1, 0, 1], [0, 0, 5, 5, 9, 9]
    velocity[::2, 0] = -1.0
    strength = 5.0 * (1.0 + 1e-5 * np.array(order))
    ends = [[0, 1], [2, 3], [4, 5]]
    net = make_net(position, ends, stiffness=100.0, velocity=velocity, strength=strength)
    end = Bench(net, 1.0, tolerance=1e-8, ruptures=True).advance(1.0)
    omega = np.sqrt(200.0)
    assert (end.kind, end.springs.tolist()) == ("ruptured", [order.index(0)])
    assert end.time == pytest.approx(np.arcsin(5.0 * omega / 100.0) / omega, rel=1e-6)


@pytest.mark.parametrize("backend", BACKENDS)
def test_lowest_pressure_between_two_ends_of_a_step_is_not_missed(backend):
    for limit, expected in (
        (10.0 * (1.0 - 1e-4), "ruptured"),
        (10.0 * (1.0 + 1e-4), "reached"),
    ):
        net = pair(stretch=0.1, crush=limit)
        bench = Bench(net, 1.0, tolerance=2e-5, ruptures=True, backend=backend)
        bench.advance(0.035)
        assert bench.advance(0.25).kind == expected


def test_spring_above_its_crushing_force_at_the_start_breaks_at_once():
    bench = Bench(pair(stretch=-0.2, crush=6.0), 1.0, tolerance=1e-6, ruptures=True)
    end = bench.advance(1.0)
    assert (end.kind, end.time, end.springs.tolist()) == ("ruptured", 0.0, [0])


def test_nets_that_are_not_crushed_are_stepped_without_looking_for_it():
    torn = Bench(pair(strength=60.0), 1.0, tolerance=1e-6, ruptures=True)
    torn.advance(0.01)
    assert torn.engine.stepper.inputs.features.watched
    assert not torn.engine.stepper.inputs.features.crushed
    both = Bench(pair(crush=60.0), 1.0, tolerance=1e-6, ruptures=True)
    both.advance(0.01)
    assert both.engine.stepper.inputs.features.crushed


@pytest.mark.parametrize("method", those(conservative=False))
def test_dashpot_counts_towards_the_tension(method):
    # At constant speed the tension c v t + d v reaches the strength at (F - d v) / (c v).
    net = pair(stretch=0.0, damping=20.0, strength=6.0)
    tolerance = affordable(method)
    bench = Bench(net, 2.0, method=method, tolerance=tolerance, ruptures=True, fixed=[0])
    bench.move([1], [0.2, 0.0, 0.0], TimeProfile("ramp", 0.0, 2.0))
    end = bench.advance(2.0)
    assert end.kind == "ruptured"
    assert end.time == pytest.approx((6.0 - 20.0 * 0.1) / (100.0 * 0.1), rel=1e-11)


@pytest.mark.parametrize("method", MEMBERS)
def test_peak_between_two_ends_of_a_step_is_not_missed(method):
    # The largest tension is 10 N; strengths just below and just above it decide differently.
    for strength, expected in (
        (10.0 * (1.0 - 1e-4), "ruptured"),
        (10.0 * (1.0 + 1e-4), "reached"),
    ):
        for shift in (0.0, 0.17, 0.4):
            net = pair(stretch=-0.1, strength=strength)
            tolerance = min(2e-5, affordable(method))
            bench = Bench(net, 1.0, method=method, tolerance=tolerance, ruptures=True)
            bench.advance(0.001 + 0.2 * shift)
            assert bench.advance(0.25).kind == expected


def test_springs_that_hardly_swing_are_followed_only_close_to_their_limit(monkeypatch):
    """A chain that is pulled slowly tears as if every near spring were followed."""

    def broken(swings):
        looks, pulls = [], AcceptedStep.tensions
        monkeypatch.setattr(
            AcceptedStep, "tensions", lambda self, when: looks.append(when) or pulls(self, when)
        )
        monkeypatch.setattr(step_events, "SWINGS", swings)
        net = chain(4, stiffness=80.0, damping=0.05, mass=1e-3, strength=0.1)
        bench = Bench(net, 10.0, method="velocity verlet", step=1e-4, fixed=[0], ruptures=True)
        bench.move([5], (0.02, 0.0, 0.0), TimeProfile("ramp", 0.0, 10.0))
        end = bench.advance(10.0)
        monkeypatch.setattr(AcceptedStep, "tensions", pulls)
        return end.kind, end.time, end.springs.tolist(), bench.state.position, len(looks)

    usual, every = broken(step_events.SWINGS), broken(np.inf)
    assert usual[0] == "ruptured"
    assert usual[:3] == every[:3]
    assert np.array_equal(usual[3], every[3])
    assert usual[4] < 0.6 * every[4]


def test_broken_pair_flies_apart_at_the_speed_it_had():
    bench = Bench(pair(stretch=-0.1, strength=6.0), 1.0, tolerance=1e-9, ruptures=True)
    ((time, _),) = break_and_go_on(bench, 1.0)
    bench.engine.finish(bench.state)
    ran = bench.ran(None)
    omega = np.sqrt(200.0)
    speed = 0.1 * omega * np.sin(np.arccos(-0.6))  # of the length
    later = ran.time > time
    length = 1.06 + speed * (ran.time - time)
    assert np.diff(ran.position[later, :, 0])[:, 0] == pytest.approx(length[later], abs=1e-9)


def test_springs_of_a_symmetric_net_break_together_and_each_one_only_once():
    angle = 2.0 * np.pi * np.arange(6) / 6
    rim = np.stack([np.cos(angle), np.sin(angle), np.zeros(6)], axis=1)
    position = np.concatenate([np.zeros((1, 3)), rim])
    velocity = np.concatenate([np.zeros((1, 3)), 3.0 * rim])
    ends = [[0, i + 1] for i in range(6)]
    net = make_net(position, ends, stiffness=100.0, velocity=velocity, strength=20.0)
    bench = Bench(net, 1.0, tolerance=1e-8, ruptures=True)
    found = break_and_go_on(bench, 1.0)
    assert sorted(spring for _, springs in found for spring in springs) == list(range(6))
    times = [time for time, _ in found]
    # Rounding may tell them apart by far less than anything that could be seen.
    assert max(times) - min(times) < 1e-12
    assert times[0] == pytest.approx(np.arcsin(2.0 / 3.0) / 10.0 * 1.0, rel=1e-6)


def test_chain_tears_spring_after_spring_without_standing_still():
    net = chain(12, stiffness=100.0, mass=0.01, strength=np.linspace(0.2, 0.26, 13))
    bench = Bench(net, 1.0, tolerance=1e-6, ruptures=True, fixed=[0])
    bench.move([13], [0.2, 0.0, 0.0], TimeProfile("ramp", 0.0, 1.0))
    found = break_and_go_on(bench, 1.0)
    assert len(found) >= 1
    assert all(later > earlier for (earlier, _), (later, _) in pairwise(found))


def test_spring_above_its_strength_at_the_start_breaks_at_once():
    bench = Bench(pair(stretch=0.2, strength=6.0), 1.0, tolerance=1e-6, ruptures=True)
    end = bench.advance(1.0)
    assert (end.kind, end.time, end.springs.tolist()) == ("ruptured", 0.0, [0])


def test_samples_before_a_rupture_are_recorded_and_none_after_it():
    times = np.linspace(0.0, 1.0, 1001)
    bench = Bench(
        pair(stretch=-0.1, strength=6.0), 1.0, tolerance=1e-6, ruptures=True, times=times
    )
    end = bench.advance(1.0)
    recorded = np.concatenate([batch.time for batch in bench.batches])
    assert np.array_equal(recorded, times[times < end.time])


def test_cut_of_a_prestressed_chain_lets_the_ends_draw_apart_as_a_quarter_wave():
    # One mass on a stretched spring, let go: it swings about the rest length of the other.
    net = make_net(
        [[0, 0, 0], [0.02, 0, 0], [0.04, 0, 0]],
        [[0, 1], [1, 2]],
        mass=0.01,
        stiffness=100.0,
        rest=0.015,
    )
    bench = Bench(net, 0.2, tolerance=1e-9, fixed=[0, 2])
    bench.advance(0.05)
    bench.state.alive[1] = False
    bench.engine.restart(bench.state)
    ran = bench.run()
    after = np.maximum(ran.time - 0.05, 0.0)
    expected = 0.015 + 0.005 * np.cos(100.0 * after)
    assert ran.position[:, 1, 0] == pytest.approx(expected, abs=1e-10)


@pytest.mark.parametrize("backend", BACKENDS)
def test_few_dead_springs_are_as_good_as_gone(backend):
    net = block(4, shrink=0.97, spin=(1.0, 2.0, 3.0))
    assert net.spring_count > 100  # so that one dead spring is set to zero in place
    bench = Bench(net, 0.2, step=1e-3, backend=backend)
    bench.engine.restart(bench.state)
    bench.state.alive[7] = False
    bench.engine.restart(bench.state)
    ran = bench.run()
    fresh = Bench(net, 0.2, step=1e-3, backend=backend)
    fresh.state.alive[7] = False
    assert np.array_equal(ran.position, fresh.run().position)
    whole = Bench(net, 0.2, step=1e-3, backend=backend).run()
    assert np.abs(ran.position - whole.position).max() > 1e-5


def test_springs_between_nodes_that_keep_still_leave_the_sums():
    bench = Bench(chain(4), 1.0, step=0.01, fixed=[0, 1, 2], ruptures=True)
    bench.engine.restart(bench.state)
    assert sorted(bench.engine.stepper.inputs.springs.ids) == [2, 3, 4]


@pytest.mark.parametrize("start", [0.0, 2.0, 1e6])
def test_the_largest_load_within_the_shortest_of_steps_is_found(start):
    """Where a step is but some roundings long, halving it further would never end."""
    within = AcceptedStep.__new__(AcceptedStep)
    within.start, within.end = start, start + 8.0 * np.spacing(start)
    top = start + 3.0 * np.spacing(start)
    limit = SimpleNamespace(loads=lambda within, when: np.array([-abs(when - top)]))
    found = within._summit(within.start, within.end, limit)
    assert abs(found - top) <= 4.0 * np.spacing(start)
