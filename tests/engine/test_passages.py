"""Nodes that run through each other: the force of their spring jumps, and nothing is lost."""

import numpy as np
import pytest

from tests.engine.members import MEMBERS, ON_BACKENDS
from tests.engine.running import Bench
from tests.engine.test_conservation import energy
from tests.hand_net import make_net
from tissuec.engine.integrators import INTEGRATORS
from tissuec.engine.kernel_inputs import KernelInputs
from tissuec.forces.springs.springs_kernel import slack
from tissuec.mechanics.state import State

MASS, STIFFNESS, REST, SPEED = 1e-3, 400.0, 0.01, 20.0
OMEGA = np.sqrt(2.0 * STIFFNESS / MASS)
SWING = SPEED / OMEGA  # of the length, about the rest length
DURATION = 0.02


def through(time):
    """Return the distance along x of two masses that set out towards each other.

    The length is REST + SWING cos θ with θ' = OMEGA, from θ = π/2. Where it vanishes, both
    change sides, and θ begins again from minus the angle that it had.
    """
    last = np.arccos(-REST / SWING)
    theta = np.pi / 2.0 + OMEGA * time
    sides = np.ceil((theta - last) / (2.0 * last))
    return (-1.0) ** sides * (REST + SWING * np.cos(theta - 2.0 * last * sides))


def bench(offset=0.0, **asked):
    return Bench(
        make_net(
            [[0.0, 0.0, 0.0], [REST, offset, 0.0]],
            [[0, 1]],
            mass=MASS,
            stiffness=STIFFNESS,
            rest=REST,
            velocity=[[0.0, 0.0, 0.0], [-SPEED, 0.0, 0.0]],
        ),
        DURATION,
        **asked,
    )


@pytest.mark.parametrize(("method", "backend"), ON_BACKENDS)
def test_masses_swing_through_each_other(method, backend):
    tolerance = 1e-3 if INTEGRATORS[method].order < 4 else 1e-5
    ran = bench(method=method, tolerance=tolerance, backend=backend).run()
    apart = ran.position[:, 1, 0] - ran.position[:, 0, 0]
    expected = through(ran.time)
    assert (np.diff(np.sign(expected)) != 0.0).sum() >= 3
    assert np.abs(apart - expected)[1:].max() < tolerance * ran.largest_displacement[-1]


@pytest.mark.parametrize("offset", [0.0, 1e-9, 1e-7, 1e-5, 1e-3])
@pytest.mark.parametrize("method", MEMBERS)
def test_energy_is_kept_where_masses_pass_close_by(method, offset):
    tolerance = 1e-3 if INTEGRATORS[method].order < 4 else 1e-4
    ran = bench(offset, method=method, tolerance=tolerance, ledger=True).run()
    found = energy(ran)
    assert np.abs(found / found[0] - 1.0).max() < tolerance


def lengths(network, position):
    return position[network.springs.ends[:, 1]] - position[network.springs.ends[:, 0]]


def test_slack_tells_how_far_nodes_may_move():
    rng = np.random.default_rng(5)
    seen = []
    for _ in range(200):
        ends = [[0, 1], [1, 2], [2, 3], [0, 3], [1, 3]]
        rest = np.where(rng.random(5) < 0.2, 0.0, 1.0)
        net = make_net(rng.normal(size=(4, 3)), ends, rest=rest)
        after = net.position + rng.normal(size=(4, 3)) * rng.choice([0.05, 0.8])
        state = State.start(net, gravity=np.zeros(3), drag=0.0)
        inputs = KernelInputs(net, watched=False, ledger=False)
        inputs.update(state)
        states = inputs.inwards(net.position), inputs.inwards(after)
        found = slack(*states, inputs.net(INTEGRATORS["dop853"]))
        r, r_after = lengths(net, net.position)[rest > 0.0], lengths(net, after)[rest > 0.0]
        along = np.einsum("sk,sk->s", r, r_after)
        longest = np.maximum((r**2).sum(axis=1), (r_after**2).sum(axis=1))
        if (along < 0.1 * longest).any():
            assert found == -1.0
        else:
            shortest = np.linalg.norm(r_after, axis=1).min(initial=np.inf)
            assert found == pytest.approx(0.45 * shortest, rel=1e-14)
        seen.append(found == -1.0)
    assert 20 < sum(seen) < 180
