"""The matrix of implicit steps: entries and solutions against dense NumPy.

The kernels run as the plain Python that they are written in.
"""

import numpy as np
import pytest

from tests.engine.running import Bench, block, chain
from tests.every import every
from tests.hand_net import make_net
from tissuec.core.structs import replace
from tissuec.engine import unknowns
from tissuec.engine.integrators import INTEGRATORS, banded, iterative
from tissuec.engine.kernel_inputs import KernelInputs
from tissuec.forces.springs import springs_kernel
from tissuec.laws import LINEAR, REST, SPRING_LAWS, VISCOSITY_LAWS, E, Law, code
from tissuec.laws.formula import exp
from tissuec.mechanics.state import State

MEMBER = INTEGRATORS["trbdf2"]  # nets ask for one to know what is near


def random_net(seed, nodes=14, springs=30):
    """Return a net without order: pressed and drawn springs, masses far apart."""
    rng = np.random.default_rng(seed)
    pairs = np.array([(i, j) for i in range(nodes) for j in range(i + 1, nodes)])
    ends = pairs[rng.choice(len(pairs), springs, replace=False)]
    position = rng.normal(size=(nodes, 3))
    drawn = np.linalg.norm(position[ends[:, 1]] - position[ends[:, 0]], axis=1)
    return make_net(
        position,
        np.where(rng.random((springs, 1)) < 0.5, ends, ends[:, ::-1]),
        mass=10.0 ** rng.uniform(-2.0, 1.0, nodes),
        stiffness=10.0 ** rng.uniform(-1.0, 3.0, springs),
        damping=rng.uniform(0.0, 3.0, springs),
        rest=drawn * rng.uniform(0.6, 1.4, springs),
    )


def with_zeros(seed):
    """Return a net with springs of no length, of no rest length, and of no constant."""
    net = random_net(seed)
    arrays = {name: net.array(name).copy() for name in ("stiffness", "damping", "rest")}
    position = net.position.copy()
    position[net.springs.ends[0, 1]] = position[net.springs.ends[0, 0]]
    arrays["rest"][:3] = 0.3, 0.0, 0.0
    arrays["stiffness"][2] = arrays["damping"][3] = 0.0
    return make_net(position, net.springs.ends, mass=net.mass, **arrays)


def coincident():
    return make_net(np.zeros((2, 3)), [[0, 1]], stiffness=5.0, damping=1.0, rest=0.0)


def curved(seed):
    """Return a net whose springs stiffen, as do dashpots with speed and stretch, in motion."""
    spring = SPRING_LAWS["exponential"](stiffening=3.0).force()
    dashpot = VISCOSITY_LAWS["power"](exponent=1.7, speed=0.5).force() * exp(E / REST)
    net = random_net(seed)
    law = np.random.default_rng(seed).integers(0, 2, net.spring_count).astype(np.int32)
    laws = LINEAR, Law("curved", spring, dashpot)
    return replace(
        net,
        springs=replace(net.springs, law=law, laws=laws),
        velocity=np.random.default_rng(seed).normal(size=net.position.shape),
    )


def dragged(seed):
    net = random_net(seed)
    return replace(net, drag=np.random.default_rng(seed).uniform(0.0, 2.0, net.node_count))


SCENES = {
    "laws": (curved(11), (0, 5), 0.3),
    "random": (random_net(1), (), 0.0),
    "another, held and with drag": (random_net(2), (0, 3, 4, 13), 0.7),
    "each node with a drag of its own": (dragged(8), (2,), 0.1),
    "dense": (random_net(3, 9, 36), (8,), 0.1),
    "springs without length": (with_zeros(4), (1,), 0.0),
    "drawn together": (coincident(), (), 0.0),
    "one free node": (random_net(5), tuple(range(13)), 0.2),
    "no free node": (random_net(6), tuple(range(14)), 0.2),
    "several pieces and single nodes": (random_net(7, 20, 9), (2,), 0.0),
    "no springs": (make_net(np.eye(3), [], mass=[1.0, 2.0, 3.0]), (), 0.5),
    "chain": (chain(9, damping=0.3), (0,), 0.0),
    "block": (block(3, shrink=0.95, damping=0.01), (0, 1, 2), 0.0),
}


def dense(state, q):
    """Return S = M + q (D + drag) + q² K over all nodes, shape (3 node, 3 node)."""
    net, count = state.network, state.network.node_count
    matrix = np.diag(np.repeat(state.mass + q * state.braking, 3))
    for s, (a, b) in enumerate(net.springs.ends):
        r = state.position[b] - state.position[a]
        length = np.linalg.norm(r)
        n = r / length if length else np.zeros(3)
        spring = state.springs.some(np.array([s])).behaviour
        e = np.array([length - state.springs.rest[s]])
        w = np.array([n @ (state.velocity[b] - state.velocity[a])])
        steep = max(float(spring.slope(e)[0] + spring.brake_by_e(e, w)[0]), 0.0)
        along = q * float(spring.brake_slope(e, w)[0]) + q * q * steep
        # Of tension over length only what is not negative; without rest length it is c.
        share = spring.pull(e)[0] / length if length else steep * (state.springs.rest[s] == 0.0)
        across = q * q * max(float(share), 0.0)
        k = along * np.outer(n, n) + across * (np.eye(3) - np.outer(n, n))
        for i, j, sign in ((a, a, 1), (b, b, 1), (a, b, -1), (b, a, -1)):
            matrix[3 * i : 3 * i + 3, 3 * j : 3 * j + 3] += sign * k
    assert len(matrix) == 3 * count
    return matrix


@pytest.fixture(autouse=True)
def _laws(monkeypatch):
    """Give the kernels the laws that binding would give them."""
    for name, function in code.functions(SCENES["laws"][0].springs.laws).items():
        monkeypatch.setattr(springs_kernel, name, function)


class Prepared:
    """A net with the matrix of a step."""

    def __init__(self, scene, *, iterate=False, monkeypatch=None, q=0.07):
        net, held, drag = SCENES[scene]
        if iterate:
            monkeypatch.setattr(unknowns, "LARGEST_FACTOR", -1.0)
        self.state = State.start(net, gravity=np.zeros(3), drag=drag)
        self.state.holders["fix"] = np.array(held, dtype=np.int64)
        self.layout = KernelInputs(net, watched=False, ledger=False)
        self.layout.update(self.state)
        self.solver = self.layout.solver()
        self.solver.made[0] = self.q = q
        self.x = self.layout.inwards(self.state.position)
        self.v = self.layout.inwards(self.state.velocity)
        self.free = np.repeat(~self.state.held, 3)

    def solved(self, kernels, net, seed=0):
        """Return S⁻¹ M r of random r in the order of the network, and r, both flat."""
        assert kernels.assemble(self.q, self.x, self.v, net, self.solver)
        right = np.random.default_rng(seed).normal(size=(len(self.state.mass), 3))
        vector = self.layout.inwards(right)
        assert kernels.solve(vector, net, self.solver)
        return self.layout.outwards(vector).ravel(), right.ravel()

    def expected(self, right):
        matrix = dense(self.state, self.q)
        out = np.zeros_like(right)
        held = np.ix_(self.free, self.free)
        mass = np.repeat(self.state.mass, 3)
        out[self.free] = np.linalg.solve(matrix[held], (mass * right)[self.free])
        return out


@every("scene", SCENES)
def test_band_solves_as_the_dense_matrix(scene):
    made = Prepared(scene)
    assert not made.solver.scratch.size
    found, right = made.solved(banded, made.layout.net(MEMBER))
    assert found == pytest.approx(made.expected(right), rel=1e-10, abs=1e-11)
    assert np.array_equal(found[~made.free], np.zeros(np.count_nonzero(~made.free)))


@every("scene", SCENES)
def test_band_holds_the_entries_of_the_matrix(scene):
    made = Prepared(scene)
    banded.fill(made.q, made.x, made.v, made.layout.net(MEMBER), made.solver)
    band, slot = made.solver.band, made.solver.slot
    size = len(band)
    found = np.zeros((size, size))
    for column in range(size):
        for k in range(min(band.shape[1], size - column)):
            found[column + k, column] = found[column, column + k] = band[column, k]
    # Unknowns stand in the order of their slots.
    order = np.empty(size // 3, dtype=np.int64)
    order[slot[slot >= 0]] = made.layout.layout.order[slot >= 0]
    at = (3 * order[:, None] + np.arange(3)).ravel()
    expected = dense(made.state, made.q)[np.ix_(at, at)]
    assert found == pytest.approx(expected, rel=1e-13, abs=1e-13)


@pytest.mark.parametrize("scene", SCENES)
def test_conjugate_gradients_come_to_the_dense_solution(scene, monkeypatch):
    monkeypatch.setattr(iterative, "PRECISION", 1e-12)
    made = Prepared(scene, iterate=True, monkeypatch=monkeypatch)
    found, right = made.solved(iterative, made.layout.net(MEMBER))
    expected = made.expected(right)
    # The condition of the matrix, up to 1e5 here, stands between residual and error.
    assert np.abs(found - expected).max() <= 1e-8 * np.abs(expected).max(initial=0.0)
    assert np.array_equal(found[~made.free], np.zeros(np.count_nonzero(~made.free)))


def test_conjugate_gradients_leave_no_more_than_their_precision(monkeypatch):
    made = Prepared("block", iterate=True, monkeypatch=monkeypatch)
    found, right = made.solved(iterative, made.layout.net(MEMBER))
    expected = made.expected(right)
    matrix = dense(made.state, made.q)[np.ix_(made.free, made.free)]
    off = (found - expected)[made.free]
    # In the norm of the energy, up to the root of the condition of the preconditioned matrix.
    scale = np.sqrt(expected[made.free] @ matrix @ expected[made.free])
    assert 0.0 < np.sqrt(off @ matrix @ off) < 30.0 * iterative.PRECISION * scale


def test_undefined_positions_and_indefinite_matrices_are_refused():
    made = Prepared("random")
    made.x[3] = np.nan
    net = made.layout.net(MEMBER)
    assert not banded.assemble(made.q, made.x, made.v, net, made.solver)
    negative = Prepared("random")
    negative.state.drag = -1e6
    negative.layout.update(negative.state)
    net = negative.layout.net(MEMBER)
    assert not banded.assemble(negative.q, negative.x, negative.v, net, negative.solver)


def test_narrow_order_of_a_shuffled_chain_is_that_of_the_chain():
    rng = np.random.default_rng(8)
    order = rng.permutation(40)
    low, high = order[:-1], order[1:]
    free = np.ones(40, dtype=bool)
    solver = unknowns.new_solver(low, high, free)
    assert solver.band.shape == (120, 6)
    assert sorted(solver.slot) == list(range(40))
    free[order[[0, 20]]] = False
    held = unknowns.new_solver(low, high, free)
    assert np.array_equal(held.slot < 0, ~free)
    assert held.band.shape == (114, 6)


@pytest.mark.parametrize("name", sorted(n for n in INTEGRATORS if INTEGRATORS[n].implicit))
def test_names_of_nodes_and_order_of_springs_leave_results_unchanged(name):
    net = block(3, shrink=0.97, damping=0.01, spin=(3.0, 7.0, 1.0))
    rng = np.random.default_rng(9)
    nodes, springs = rng.permutation(net.node_count), rng.permutation(net.spring_count)
    back = np.argsort(nodes)
    other = make_net(
        net.position[nodes],
        back[net.springs.ends[springs]],
        mass=net.mass[nodes],
        stiffness=net.springs.stiffness[springs],
        damping=net.springs.damping[springs],
        rest=net.springs.rest[springs],
        velocity=net.velocity[nodes],
    )
    asked = {"method": name, "step": 2e-3, "tolerance": 1e-11, "times": [0.0, 0.1]}
    one, two = Bench(net, 0.1, **asked).run(), Bench(other, 0.1, **asked).run()
    # Equations are solved to 1e-12 of the motion, in another order to another remainder.
    assert np.abs(one.position - two.position[:, back]).max() < 1e-12


@pytest.mark.parametrize("name", sorted(n for n in INTEGRATORS if INTEGRATORS[n].implicit))
def test_wide_nets_move_as_narrow_ones(name, monkeypatch):
    net = block(3, shrink=0.97, damping=0.01, spin=(3.0, 7.0, 1.0))
    asked = {"method": name, "step": 2e-3, "tolerance": 1e-11, "times": [0.0, 0.05]}
    narrow = Bench(net, 0.05, **asked).run()
    monkeypatch.setattr(unknowns, "LARGEST_FACTOR", -1.0)
    wide = Bench(net, 0.05, **asked).run()
    assert wide.engine.stepper.work.solver.scratch.size
    assert np.abs(wide.position - narrow.position).max() < 1e-12
