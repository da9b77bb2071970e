"""Sums in chunks of nodes are those of springs one by one."""

import numpy as np
import pytest

from tests.hand_net import make_net
from tissuec.engine import threads
from tissuec.engine.integrators import INTEGRATORS, iterative
from tissuec.engine.kernel_inputs import KernelInputs
from tissuec.forces.springs import springs_kernel
from tissuec.forces.springs.pairs_kernel import ROOM
from tissuec.mechanics.state import State

NODES, SPRINGS = 2600, 8000
ESDIRK = INTEGRATORS["esdirk43"]


@pytest.fixture
def few(monkeypatch):
    """Let chunks have few nodes."""
    monkeypatch.setattr(threads, "NODES", 512)


@pytest.fixture(params=[1, 2, 7])
def parts(request, monkeypatch):
    """Let loops have several parts, the last one first."""

    def share(team, function, arguments):
        for part in reversed(range(request.param)):
            function(part, request.param, *arguments)

    for module in (springs_kernel, iterative):
        monkeypatch.setattr(module, "share", share)


def acting(rng):
    """Return a net in which any nodes are joined, some of them held, and a state."""
    ends = np.sort(rng.integers(0, NODES, (SPRINGS, 2)), axis=1)
    ends = np.unique(ends[ends[:, 0] != ends[:, 1]], axis=0)
    network = make_net(
        rng.normal(size=(NODES, 3)),
        ends,
        mass=rng.uniform(1.0, 2.0, NODES),
        stiffness=rng.uniform(1.0, 3.0, len(ends)),
        damping=rng.uniform(0.1, 1.0, len(ends)),
        rest=rng.uniform(0.5, 2.0, len(ends)),
        strength=np.full(len(ends), 1e3),
    )
    state = State.start(network, gravity=np.zeros(3), drag=0.3)
    state.holders["fix"] = np.arange(0, NODES, 9)
    layout = KernelInputs(network, watched=True, ledger=True)
    layout.update(state)
    return layout, rng.normal(size=3 * NODES), rng.normal(size=3 * NODES)


def forces(layout, x, v):
    net, found, power = layout.net(ESDIRK), np.ones(3 * NODES), np.zeros(2)
    scratch = np.full((7, ROOM), np.nan)
    net = net._replace(team=net.team._replace(each=scratch))
    assert not springs_kernel.springs(x, v, found, power, net)
    return len(net.chunks.node) - 1, found, power[1]


@pytest.mark.parametrize("of_laws", [True, False])
def test_forces_and_losses_are_the_same(few, parts, of_laws, monkeypatch):
    monkeypatch.setattr(springs_kernel, "OF_LAWS", of_laws)
    layout, x, v = acting(np.random.default_rng(1))
    count, found, lost = forces(layout, x, v)
    assert count == 6  # the last one has few nodes
    monkeypatch.undo()
    whole, expected, all_lost = forces(acting(np.random.default_rng(1))[0], x, v)
    assert whole == 1
    assert found == pytest.approx(expected, abs=1e-13 * np.abs(expected).max())
    assert lost == pytest.approx(all_lost, rel=1e-13)


def solved(layout, x, v, right):
    net, solver = layout.net(ESDIRK), layout.solver()
    solver = solver._replace(
        scratch=np.zeros((4, 3 * NODES)),
        bar=np.zeros((len(net.rest), 5)),
        block=np.zeros((NODES, 6)),
    )
    assert iterative.assemble(0.1, x, v, net, solver)
    solver.made[0] = 0.1
    found = right.copy()
    assert iterative.solve(found, net, solver)
    return found


def test_solutions_of_implicit_steps_are_the_same(few, parts, monkeypatch):
    layout, x, v = acting(np.random.default_rng(2))
    right = np.random.default_rng(3).normal(size=3 * NODES)
    found = solved(layout, x, v, right)
    monkeypatch.undo()
    expected = solved(acting(np.random.default_rng(2))[0], x, v, right)
    assert found == pytest.approx(expected, abs=1e-10 * np.abs(expected).max())
