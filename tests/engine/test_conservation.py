"""Momentum, angular momentum and the energy ledger."""

import numpy as np
import pytest

from tests.engine.running import TIERS, Bench, block, lifted_tube
from tissuec.courses import Course

METHODS = ("dop853", "velocity verlet")


@pytest.mark.parametrize("tier", TIERS)
@pytest.mark.parametrize("method", METHODS)
def test_free_body_keeps_momentum_and_angular_momentum(method, tier):
    net = block(shrink=0.97, damping=1e-3, spin=(3.0, 7.0, 1.0))
    tolerance = 1e-12 if method == "dop853" else 1e-5
    ran = Bench(net, 0.2, method=method, tolerance=tolerance, tier=tier).run()
    momentum = np.einsum("n,tnk->tk", net.mass, ran.velocity)
    scale = np.abs(net.mass[:, None] * ran.velocity[0]).sum()
    assert np.abs(momentum - momentum[0]).max() < 1e-12 * scale
    spin = np.einsum("n,tnk->tk", net.mass, np.cross(ran.position, ran.velocity))
    # Central forces keep it up to the error of the method.
    allowed = 1e-12 if method == "dop853" else 1e-5
    assert np.abs(spin - spin[0]).max() < allowed * np.linalg.norm(spin[0])


def energy(ran):
    """Return kinetic energy of free nodes + elastic energy - weight's work, shape (sample,)."""
    situation, net = ran.situation, ran.situation.network
    mass = np.where(situation.held, 0.0, situation.mass)
    kinetic = 0.5 * np.einsum("n,tnk,tnk->t", mass, ran.velocity, ran.velocity)
    r = ran.position[:, net.ends[:, 1]] - ran.position[:, net.ends[:, 0]]
    stretch = np.linalg.norm(r, axis=2) - situation.rest
    elastic = 0.5 * (situation.stiffness * stretch**2).sum(axis=1)
    weight = np.einsum("n,tnk,k->t", mass, ran.position, situation.gravity)
    return kinetic + elastic - weight


def pushed_block(**asked):
    net = block(stiffness=50.0, damping=5e-3, shrink=0.98, spin=(1.0, 2.0, 3.0))
    bench = Bench(net, 0.5, gravity=(0.0, 0.0, -9.81), drag=2e-3, ledger=True, **asked)
    bench.situation.holders["fix"] = np.array([0, 1])
    bench.move([26, 25], [0.0, 0.004, 0.002], Course("sine", 0.0, np.inf, frequency=5.0))
    bench.push([13, 14, 0], [0.01, 0.0, 0.02])
    loads = dict(bench.situation.loads)
    bench.push([4, 5], [0.02, 0.01, 0.0], Course("ramp", 0.1, 0.4))
    bench.situation.loads["steady"] = loads["push"]
    return bench


@pytest.mark.parametrize("tier", TIERS)
@pytest.mark.parametrize(("method", "tolerance"), [("dop853", 1e-9), ("velocity verlet", 1e-4)])
def test_energy_changes_by_work_minus_dissipation(method, tolerance, tier):
    ran = pushed_block(method=method, tolerance=tolerance, tier=tier).run()
    change = energy(ran) - energy(ran)[0]
    gap = change - (ran.work - ran.dissipated)
    assert ran.dissipated[-1] > 0.0
    assert np.abs(ran.work).max() > 0.0
    assert np.abs(gap).max() < 10.0 * tolerance * np.abs(ran.work).max()
    assert (np.diff(ran.dissipated) >= 0.0).all()


@pytest.mark.parametrize(("method", "order"), [("velocity verlet", 2), ("dop853", 8)])
def test_ledger_closes_at_the_order_of_the_method(method, order):
    steps = np.array([8e-4, 4e-4, 2e-4]) if order == 2 else np.array([8e-3, 6e-3, 4.5e-3])
    gaps = []
    for step in steps:
        ran = pushed_block(method=method, step=step, tier="compiled", times=[0.0, 0.5]).run()
        change = energy(ran)[-1] - energy(ran)[0]
        gaps.append(abs(change - (ran.work[-1] - ran.dissipated[-1])))
    observed = np.polyfit(np.log(steps), np.log(gaps), 1)[0]
    assert observed > order - 0.5


def test_ledger_goes_on_across_restarts_and_stops():
    whole = lifted_tube(0.4, tolerance=1e-8, ledger=True, tier="compiled").run()
    stopped = lifted_tube(0.4, tolerance=1e-8, ledger=True, tier="compiled")
    stopped.advance(0.2)
    stopped.engine.restart(stopped.situation)
    ran = stopped.run(0.3)
    assert ran.work == pytest.approx(whole.work, rel=1e-6, abs=1e-6 * np.abs(whole.work).max())


def test_undamped_verlet_keeps_the_energy_over_many_periods():
    net = block(stiffness=50.0, spin=(1.0, 2.0, 3.0))
    ran = Bench(net, 20.0, method="velocity verlet", step=1e-3, tier="compiled").run()
    total = energy(ran)
    # No drift: the second half is as far off as the first.
    halves = [np.abs(part - total[0]).max() for part in np.array_split(total, 2)]
    assert halves[1] < 1.5 * halves[0] + 1e-9 * total[0]
