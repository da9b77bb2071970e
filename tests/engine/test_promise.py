"""The tolerance is a promise: no position at any output time is further off."""

import numpy as np
import pytest

from tests.engine.running import Bench, block, chain, lifted_tube, pair
from tests.engine.test_closed_forms import relaxation
from tests.hand_net import make_net
from tissuec.engine.integrators import INTEGRATORS
from tissuec.engine.run_arrays import new_task
from tissuec.model.profiles import TimeProfile

TIMES = 400


def pair_error(ratio, **asked):
    omega = np.sqrt(200.0)
    bench = Bench(pair(damping=ratio * omega), 5.0, times=np.linspace(0.0, 5.0, TIMES), **asked)
    ran = bench.run()
    expected = 0.1 * (1.0 - relaxation(ratio, omega, ran.time))
    error = np.abs(ran.position[:, 0, 0] - expected)
    return (error[1:] / ran.largest_displacement[1:]).max()


@pytest.mark.parametrize("ratio", [0.0, 0.1, 1.0, 3.0])
@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-5, 1e-8, 1e-10])
def test_oscillators_keep_the_promise_with_dop853(ratio, tolerance):
    assert pair_error(ratio, tolerance=tolerance) < tolerance


@pytest.mark.parametrize("method", ["velocity verlet", "rkn4"])
@pytest.mark.parametrize("ratio", [0.0, 0.1, 1.0, 3.0])
@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-5])
def test_oscillators_keep_the_promise_with_coarser_methods(ratio, tolerance, method):
    assert pair_error(ratio, tolerance=tolerance, method=method) < tolerance


@pytest.mark.parametrize(("damping", "times"), [(0.0, 1.0), (0.019, 1.0), (0.021, 4.0)])
def test_more_errors_may_add_up_where_they_die_away_within_the_run(damping, times):
    # A mass of 1 kg loses its speed to a dashpot of 0.02 N s/m in 50 s.
    net = chain(3, mass=1.0, damping=damping)
    task = new_task(net, INTEGRATORS["rkn4"], 1e-3, 50.0)
    assert task.budget == pytest.approx(times * INTEGRATORS["rkn4"].safety * 1e-3 / 50.0)
    # Estimates of other methods are taken alike wherever errors go.
    task = new_task(net, INTEGRATORS["dop853"], 1e-3, 50.0)
    assert task.budget == pytest.approx(INTEGRATORS["dop853"].safety * 1e-3 / 50.0)


def hanging(**asked):
    position = np.zeros((31, 3))
    position[:, 0] = 0.01 * np.arange(31)
    net = make_net(
        position, [[i, i + 1] for i in range(30)], mass=1e-3, stiffness=200.0, damping=1e-3
    )
    return Bench(net, 0.3, gravity=(0.0, 0.0, -9.81), fixed=[0], **asked)


def tumbling(**asked):
    net = block(shrink=0.98, damping=1e-3, spin=(3.0, 7.0, 1.0))
    return Bench(net, 2.0, gravity=(0.0, 0.0, -9.81), **asked)


def lattice(**asked):
    net = block(6, stiffness=10.0, mass=1e-5, damping=1e-3)
    fixed = np.flatnonzero(net.position[:, 2] == 0.0)
    return Bench(net, 0.1, gravity=(0.0, 0.0, -9.81), fixed=fixed, **asked)


def ringing(**asked):
    velocity = np.zeros((18, 3))
    velocity[1:-1, 0] = 0.1 * (-1.0) ** np.arange(16)
    return Bench(chain(16, velocity=velocity), 1.0, fixed=[0, 17], **asked)


def lifted(**asked):
    return lifted_tube(0.5, **asked)


@pytest.mark.parametrize("scene", [hanging, tumbling, lattice, ringing, lifted])
def test_nets_keep_the_promise(scene):
    exact = scene(tolerance=1e-12).run()
    reach = exact.largest_displacement[1:]
    for method, tolerances in {
        "dop853": [1e-2, 1e-3, 1e-5, 1e-8, 1e-10],
        "velocity verlet": [1e-2, 1e-3, 1e-5],
        "rkn4": [1e-2, 1e-3, 1e-5],
    }.items():
        for tolerance in tolerances:
            ran = scene(method=method, tolerance=tolerance).run()
            off = np.linalg.norm(ran.position - exact.position, axis=2).max(axis=1)
            assert (off[1:] / reach).max() < tolerance, (method, tolerance)


def test_finer_tolerances_cost_the_seventh_root():
    counts = [
        Bench(pair(), 20.0, tolerance=tolerance).run().engine.statistics.accepted
        for tolerance in (1e-4, 1e-8)
    ]
    # Four powers of ten are a factor of 10^(4/7) = 3.7 in steps, and no more than that.
    assert counts[1] / counts[0] == pytest.approx(10 ** (4 / 7), rel=0.35)


def test_forces_that_swing_are_seen_between_steps_that_are_whole_periods():
    for method, tolerance in (("velocity verlet", 1e-3), ("dop853", 1e-6)):
        bench = Bench(pair(stiffness=0.0), 1.0, method=method, tolerance=tolerance)
        omega = 2.0 * np.pi * 1000.0
        bench.push([1], (1.0, 0.0, 0.0), TimeProfile("sine", 0.0, np.inf, frequency=1000.0))
        ran = bench.run()
        time = ran.time
        expected = time / omega - np.sin(omega * time) / omega**2
        error = np.abs(ran.position[:, 1, 0] - ran.position[0, 1, 0] - expected)
        assert error.max() < tolerance * expected.max()


@pytest.mark.parametrize("method", ["velocity verlet", "dop853"])
@pytest.mark.parametrize("stiffness", [0.0, 4.0])
def test_keeping_energies_leaves_a_run_from_rest_able_to_go_on(method, stiffness):
    steps = []
    for ledger in (False, True):
        bench = Bench(
            pair(stretch=0.0, stiffness=stiffness),
            1.0,
            method=method,
            tolerance=1e-4,
            ledger=ledger,
        )
        bench.push([0], (1.0, 0.0, 0.0), TimeProfile("sine", 0.0, np.inf, frequency=3.0))
        ran = bench.run()
        assert ran.end.kind == "reached"
        steps.append(ran.engine.statistics.accepted)
    # From rest, work that is small so far is resolved as finely as what comes later.
    assert steps[1] < 10 * steps[0]
