"""Momentum, angular momentum and the energy ledger."""

import numpy as np
import pytest

from tests.engine.members import MEMBERS, ON_BACKENDS, affordable, brakes, those
from tests.engine.running import Bench, block, lifted_tube, pair
from tissuec.engine.integrators import INTEGRATORS
from tissuec.model.profiles import TimeProfile


@pytest.mark.parametrize("method", MEMBERS)
def test_free_body_keeps_momentum_and_angular_momentum(method):
    net = block(shrink=0.97, damping=brakes(method, 1e-3), spin=(3.0, 7.0, 1.0))
    tolerance = affordable(method)
    ran = Bench(net, 0.05, method=method, tolerance=tolerance).run()
    momentum = np.einsum("n,tnk->tk", net.mass, ran.velocity)
    scale = np.abs(net.mass[:, None] * ran.velocity[0]).sum()
    assert np.abs(momentum - momentum[0]).max() < 1e-12 * scale
    spin = np.einsum("n,tnk->tk", net.mass, np.cross(ran.position, ran.velocity))
    # Central forces keep it up to the error of the method.
    assert np.abs(spin - spin[0]).max() < tolerance * np.linalg.norm(spin[0])


@pytest.mark.parametrize("method", those(symplectic=True))
def test_symplectic_members_run_backwards_to_where_they_came_from(method):
    net = block(shrink=0.97, spin=(3.0, 7.0, 1.0))
    bench = Bench(net, 0.4, method=method, step=1e-3, times=[])
    start, speed = bench.state.position.copy(), bench.state.velocity.copy()
    bench.advance(0.2)
    moved = np.abs(bench.state.position - start).max()
    bench.state.velocity *= -1.0
    bench.engine.restart(bench.state)
    bench.advance(0.4)
    # 400 steps of rounding, which the tumbling enlarges.
    assert np.abs(bench.state.position - start).max() < 1e-12 * moved
    assert np.abs(bench.state.velocity + speed).max() < 1e-11 * np.abs(speed).max()


def long_energy(method, part, periods):
    """Return the energy of a pair that swings and turns, over that at the start, minus 1."""
    omega = np.sqrt(200.0)
    duration = periods * 2.0 * np.pi / omega
    ran = Bench(
        pair(velocity=[[0.0, 0.5, 0.0], [0.0, -0.5, 0.0]]),
        duration,
        method=method,
        step=part * INTEGRATORS[method].stability_limit(omega, 0.0),
        times=np.linspace(0.0, duration, 2001),
    ).run()
    assert ran.end.kind == "reached"
    found = energy(ran)
    return np.abs(found / found[0] - 1.0)


@pytest.mark.parametrize("method", those(symplectic=True))
@pytest.mark.parametrize("periods", [100, 10_000])
def test_energy_of_symplectic_members_oscillates_and_does_not_drift(method, periods):
    order = INTEGRATORS[method].order
    quarters = [np.max(q) for q in np.array_split(long_energy(method, 0.1, periods), 4)]
    # What oscillates is seen at other phases in each quarter.
    assert max(quarters) < 1.1 * quarters[0] + 1e-11
    # And falls with the step at the order of the method.
    finer = long_energy(method, 0.05, periods).max()
    assert np.log2(max(quarters) / finer) > order - 0.5


def energy(ran):
    """Return kinetic energy of free nodes + elastic energy - weight's work, shape (sample,)."""
    state, net = ran.state, ran.state.network
    mass = np.where(state.held, 0.0, state.mass)
    kinetic = 0.5 * np.einsum("n,tnk,tnk->t", mass, ran.velocity, ran.velocity)
    r = ran.position[:, net.springs.ends[:, 1]] - ran.position[:, net.springs.ends[:, 0]]
    stretch = np.linalg.norm(r, axis=2) - state.springs.rest
    elastic = 0.5 * (state.springs.stiffness * stretch**2).sum(axis=1)
    weight = np.einsum("n,tnk,k->t", mass, ran.position, state.gravity)
    return kinetic + elastic - weight


def pushed_block(**asked):
    net = block(stiffness=50.0, damping=5e-3, shrink=0.98, spin=(1.0, 2.0, 3.0))
    bench = Bench(net, 0.25, gravity=(0.0, 0.0, -9.81), drag=2e-3, ledger=True, **asked)
    bench.state.holders["fix"] = np.array([0, 1])
    bench.move([26, 25], [0.0, 0.004, 0.002], TimeProfile("sine", 0.0, np.inf, frequency=5.0))
    bench.push([13, 14, 0], [0.01, 0.0, 0.02])
    loads = dict(bench.state.loads)
    bench.push([4, 5], [0.02, 0.01, 0.0], TimeProfile("ramp", 0.1, 0.2))
    bench.state.loads["steady"] = loads["push"]
    return bench


BOOKED = {"dop853": 1e-9, "velocity verlet": 1e-4} | {
    name: {2: 5e-3, 3: 1e-4, 4: 1e-5}.get(INTEGRATORS[name].order, 1e-8)
    for name in those(conservative=False)
    if name not in ("dop853", "velocity verlet")
}
BOOKED_ON_BACKENDS = [case for case in ON_BACKENDS if case.values[0] in BOOKED]


@pytest.mark.parametrize(("method", "backend"), BOOKED_ON_BACKENDS)
def test_energy_changes_by_work_minus_dissipation(method, backend):
    tolerance = BOOKED[method]
    ran = pushed_block(method=method, tolerance=tolerance, backend=backend).run()
    change = energy(ran) - energy(ran)[0]
    gap = change - (ran.work - ran.dissipated)
    assert ran.dissipated[-1] > 0.0
    assert np.abs(ran.work).max() > 0.0
    assert np.abs(gap).max() < 10.0 * tolerance * np.abs(ran.work).max()
    assert (np.diff(ran.dissipated) >= 0.0).all()


@pytest.mark.parametrize("method", sorted(BOOKED))
def test_ledger_closes_at_the_order_of_the_method(method):
    order = INTEGRATORS[method].order
    steps = {
        2: np.array([8e-4, 4e-4, 2e-4]),
        3: np.array([8e-4, 4e-4, 2e-4]),
        4: np.array([2e-3, 1.25e-3, 1e-3]),
        8: np.array([8e-3, 6e-3, 4.5e-3]),
    }[order]
    gaps = []
    for step in steps:
        ran = pushed_block(method=method, step=step, tolerance=1e-12, times=[0.0, 0.25]).run()
        change = energy(ran)[-1] - energy(ran)[0]
        gaps.append(abs(change - (ran.work[-1] - ran.dissipated[-1])))
    observed = np.polyfit(np.log(steps), np.log(gaps), 1)[0]
    assert observed > order - 0.5


@pytest.mark.parametrize("method", those(implicit=True))
def test_work_of_a_push_at_resonance_is_as_good_as_the_motion(method):
    # x'' + ω² x = f sin ωt / m from rest: x' = f t sin ωt / 2m, and the power is f sin ωt x'.
    omega, mass, push = 20.0, 0.5, 0.01
    tolerance = 1e-4 if INTEGRATORS[method].order > 2 else 1e-3
    period = 2.0 * np.pi / omega
    times = period * np.arange(11.0)
    net = pair(stretch=0.0, stiffness=mass * omega**2, mass=mass)
    bench = Bench(net, times[-1], method=method, tolerance=tolerance, times=times, ledger=True)
    bench.state.holders["fix"] = np.array([0])
    bench.push([1], [push, 0.0, 0.0], TimeProfile("sine", 0.0, np.inf, frequency=1.0 / period))
    ran = bench.run()
    due = push**2 * times**2 / (8.0 * mass)
    # The energy grows with the square of the displacement, which may be off by a tolerance.
    assert np.abs(ran.work - due).max() < 2.0 * tolerance * due[-1]
    assert np.abs(energy(ran) - energy(ran)[0] - due).max() < 2.0 * tolerance * due[-1]


def test_ledger_goes_on_across_restarts_and_stops():
    whole = lifted_tube(0.4, tolerance=1e-8, ledger=True).run()
    stopped = lifted_tube(0.4, tolerance=1e-8, ledger=True)
    stopped.advance(0.2)
    stopped.engine.restart(stopped.state)
    ran = stopped.run(0.3)
    assert ran.work == pytest.approx(whole.work, rel=1e-6, abs=1e-6 * np.abs(whole.work).max())
