"""Fixed steps stay bounded up to the limit that a member declares, and grow above it."""

import numpy as np
import pytest

from tests.engine.members import MEMBERS, brakes, those
from tests.engine.running import Bench, chain, pair
from tests.hand_net import make_net
from tissuec.engine.integrators import INTEGRATORS

OMEGA = np.sqrt(200.0)  # of the pair
FINITE = [name for name in MEMBERS if np.isfinite(INTEGRATORS[name].stability_limit(1.0, 2.0))]


def grown(name, ratio, step, count):
    """Return the length of a pair after so many steps, over that at the start.

    Its spring has no rest length, so that the force is linear wherever a step may lead.
    """
    net = make_net(
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]],
        [[0, 1]],
        stiffness=100.0,
        damping=ratio * OMEGA,
        rest=0.0,
    )
    bench = Bench(net, count * step, method=name, step=step, times=[])
    if bench.advance(bench.duration).kind != "reached":
        return np.inf
    return abs(np.diff(bench.state.position[:, 0])[0])


def ratios(name):
    if INTEGRATORS[name].conservative:
        return (0.0,)
    # A stabilised method is for what is braked: its limit is one of overdamped motions. Its
    # stages grow with the step; only where they are at their most is there a limit above.
    return (1.0, 2.0, 100.0) if INTEGRATORS[name].stabilised else (0.0, 0.3, 2.0)


CASES = [(name, ratio) for name in FINITE for ratio in ratios(name)]


@pytest.mark.parametrize(("name", "ratio"), CASES)
def test_steps_just_below_the_declared_limit_stay_bounded(name, ratio):
    limit = INTEGRATORS[name].stability_limit(OMEGA, ratio)
    # Near a limit, position and velocity may well lend to one another before they stay.
    assert grown(name, ratio, 0.97 * limit, 60 if ratio > 50.0 else 400) < 5.0


@pytest.mark.parametrize(
    ("name", "ratio"),
    [(n, r) for n, r in CASES if not INTEGRATORS[n].stabilised or r > 75.0],
)
def test_steps_above_the_declared_limit_grow(name, ratio):
    limit = INTEGRATORS[name].stability_limit(OMEGA, ratio)
    assert grown(name, ratio, 1.2 * limit, 60 if ratio > 50.0 else 400) > 1e3


@pytest.mark.parametrize("ratio", [0.0, 0.3, 2.0, 100.0])
@pytest.mark.parametrize("name", those(implicit=True))
def test_implicit_steps_a_thousand_times_too_large_stay_bounded(name, ratio):
    assert INTEGRATORS[name].stability_limit(OMEGA, ratio) == np.inf
    for size in (10.0, 1e3):
        assert grown(name, ratio, size / OMEGA, 50) < 1.0


@pytest.mark.parametrize("name", those(implicit=True))
def test_implicit_steps_far_above_the_fastest_swing_follow_the_slowest(name):
    # Springs in turn soft and a million times harder; only the soft ones' swing is followed.
    stiffness = np.where(np.arange(9) % 2, 1e6, 1.0)
    velocity = np.r_[0.0, 1e-4 * np.sin(np.pi * np.arange(1, 9) / 9), 0.0]
    net = chain(8, stiffness=stiffness, mass=0.01, velocity=velocity[:, None] * [1.0, 0.0, 0.0])
    asked = {"fixed": [0, 9], "tolerance": 1e-9}
    exact = Bench(net, 1.0, method="dop853", **asked).run()
    ran = Bench(net, 1.0, method=name, step=2e-3, **asked).run()
    assert 2e-3 * np.sqrt(2e6 / 0.01) > 25.0
    off = np.abs(ran.position - exact.position).max()
    assert off < 0.05 * np.abs(exact.position - exact.position[0]).max()


@pytest.mark.parametrize("name", those(stabilised=True))
@pytest.mark.parametrize("ratio", [2.0, 100.0])
def test_stages_of_a_stabilised_step_grow_as_the_root_of_its_size(name, ratio):
    limit = INTEGRATORS[name].stability_limit(OMEGA, ratio)
    counts = []
    for part in (0.1, 0.4):
        step = part * limit
        bench = Bench(pair(damping=ratio * OMEGA), 20 * step, method=name, step=step, times=[0])
        assert bench.run().end.kind == "reached"
        counts.append(bench.engine.statistics.evaluations)
    # Twice as many but for rounding up.
    assert 1.0 < counts[1] / counts[0] < 2.3


@pytest.mark.parametrize("name", MEMBERS)
def test_limits_fall_with_the_frequency_and_are_infinite_without_springs(name):
    limit = INTEGRATORS[name].stability_limit
    for ratio in {0.0, brakes(name, 0.5), brakes(name, 5.0)}:
        assert limit(0.0, 0.0) == np.inf
        if np.isfinite(limit(1.0, ratio)):
            assert limit(10.0, ratio) == pytest.approx(limit(1.0, ratio) / 10.0)
