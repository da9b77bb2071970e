"""Settled nets balance, by closed forms, by long damped runs and by relaxation."""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from tests.engine.running import EVERLASTING, Bench, block, tube
from tests.hand_net import chain, make_net, span, start
from tests.validate.scenes import compiled_scene
from tissuec.compiler.script.initial_state import state_at_start
from tissuec.forces.acting.load import Load, LoadTerm
from tissuec.mechanics import newton
from tissuec.mechanics.balance import Balance
from tissuec.mechanics.newton import greatest
from tissuec.mechanics.relaxation import Layers, relax
from tissuec.mechanics.rigid import NeutralMotions
from tissuec.mechanics.settling import Unsettled, settle
from tissuec.mechanics.state import State
from tissuec.validate.resting import rest

DOWN = (0.0, 0.0, -9.81)


def every(state):
    return np.ones(state.network.node_count, dtype=bool)


def held(network, fixed=(), **surroundings):
    state = start(network, **surroundings)
    if len(fixed):
        state.holders["fix"] = np.array(fixed)
    return state


def push(state, nodes, vector):
    terms = (LoadTerm(np.array(vector, float), EVERLASTING),)
    state.loads["push"] = Load(np.array(nodes), terms, span())


def residual(state):
    """Return the largest force left on a free node over the largest of a spring or load."""
    balance = Balance(state, every(state))
    bars = balance.bars(state.position[balance.free])
    return greatest(balance.force(bars)) / balance.largest(bars)


@pytest.mark.parametrize("count", [2, 6, 200])
@pytest.mark.parametrize("drawn", ["down", "sideways", "up"])
def test_a_hanging_chain_is_as_long_as_known(count, drawn):
    """N springs under N masses: N L0 + m g / k N (N + 1) / 2."""
    stiffness, mass, rest = 40.0, 0.01 / count, 0.02
    along = {"down": (0, 0, -1), "sideways": (1, 0, 0), "up": (0.01, 0, 1)}[drawn]
    position = rest * np.arange(count + 1)[:, None] * np.array(along, float)
    ends = np.stack([np.arange(count), np.arange(1, count + 1)], axis=1)
    net = make_net(position, ends, stiffness=stiffness, mass=mass, rest=rest)
    state = held(net, [0], gravity=np.array(DOWN))
    settle(state, every(state))
    length = count * rest + mass * 9.81 / stiffness * count * (count + 1) / 2
    assert state.position[-1] == pytest.approx([0.0, 0.0, -length], abs=1e-10 * length)


def test_a_hanging_rope_is_the_discrete_catenary():
    """Each spring carries the same pull sideways, and the weight of what hangs below it."""
    count, rest, stiffness, weight, span_ = 20, 0.01, 60.0, 0.02, 0.16

    def shape(pull):
        lift = weight * (np.arange(count) - 0.5 * (count - 1))
        force = np.hypot(pull, lift)
        return (rest + force / stiffness) / force * np.array([np.full(count, pull), lift])

    pull = brentq(lambda p: shape(p)[0].sum() - span_, 1e-6, 10.0, xtol=1e-15)
    expected = np.concatenate([np.zeros((2, 1)), np.cumsum(shape(pull), axis=1)], axis=1).T
    line = np.linspace(0.0, span_, count + 1)[:, None] * np.array([1.0, 0.0, 0.0])
    ends = np.stack([np.arange(count), np.arange(1, count + 1)], axis=1)
    net = make_net(line, ends, stiffness=stiffness, mass=weight / 9.81, rest=rest)
    state = held(net, [0, count], gravity=np.array(DOWN))
    settle(state, every(state))
    assert state.position[:, [0, 2]] == pytest.approx(expected, abs=1e-11)


def test_a_settled_net_stays_at_rest():
    net = tube(damping=0.02)
    fixed = [*range(10), *range(150, 160)]
    bench = Bench(net, 0.5, tolerance=1e-6, gravity=DOWN, fixed=fixed)
    settle(bench.state, every(bench.state))
    assert residual(bench.state) < 1e-11
    before = bench.state.position.copy()
    moved = np.linalg.norm(before - net.position, axis=1).max()
    bench.run()
    assert np.abs(bench.state.position - before).max() < 1e-9 * moved


def test_settling_comes_where_a_long_damped_run_comes_to():
    net = tube(damping=0.05)
    fixed = [*range(10), *range(150, 160)]
    more = {"gravity": DOWN, "fixed": fixed, "drag": 2e-3}
    bench = Bench(net, 4.0, tolerance=1e-7, times=[], **more)
    push(bench.state, range(80, 90), (1e-4, 3e-4, 2e-4))
    settled = held(net, fixed, gravity=np.array(DOWN))
    push(settled, range(80, 90), (1e-4, 3e-4, 2e-4))
    settle(settled, every(settled))
    assert bench.advance(4.0).kind == "reached"
    moved = np.abs(settled.position - net.position).max()
    assert np.abs(bench.state.position - settled.position).max() < 1e-6 * moved


def prestressed():
    """Return a sheet under tension, which its load bends: its energy is convex nearby."""
    grid = np.stack(np.meshgrid(np.arange(6.0), np.arange(5.0), [0.0], indexing="ij"), -1)
    position = 0.01 * grid.reshape(-1, 3)
    apart = np.linalg.norm(position[:, None] - position[None], axis=2)
    ends = np.argwhere(np.triu((apart > 0.0) & (apart < 0.0145)))
    rest = 0.9 * apart[ends[:, 0], ends[:, 1]]
    net = make_net(position, ends, stiffness=50.0, mass=1e-3, rest=rest)
    edge = (grid.reshape(-1, 3)[:, :2] % [5.0, 4.0] == 0.0).any(axis=1)
    return held(net, np.flatnonzero(edge), gravity=np.array(DOWN))


def test_relaxation_comes_to_the_same_minimum():
    state = prestressed()
    balance = Balance(state, every(state))
    largest = balance.largest(balance.bars(balance.start))
    found, sweeps, _ = relax(balance, balance.start, threshold=1e-13 * largest, most=3000)
    assert 1 < sweeps < 3000
    settle(state, every(state))
    moved = np.abs(state.position[balance.free] - balance.start).max()
    assert np.abs(found - state.position[balance.free]).max() < 1e-9 * moved


@pytest.mark.parametrize("threshold", [1e-4, 1e-6])
def test_relaxation_ends_where_forces_change_by_less_than_the_threshold(threshold):
    balance = Balance(state := prestressed(), every(state))
    _, sweeps, change = relax(balance, balance.start, threshold=threshold, most=1000)
    assert 0.01 * threshold < change <= threshold
    assert sweeps > 1
    earlier = relax(balance, balance.start, threshold=threshold, most=sweeps - 1)
    assert earlier.change > threshold


def test_the_force_on_some_nodes_is_that_of_the_whole_net_there():
    rng = np.random.default_rng(8)
    state = held(block(3, stiffness=50.0), [0, 5], gravity=np.array(DOWN))
    state.position += 0.002 * rng.normal(size=state.position.shape)
    balance = Balance(state, every(state))
    x, nodes = balance.start, np.array([3, 7, 20])
    whole = balance.force(balance.bars(x))[nodes]
    assert balance.force_on(balance.star(nodes), x) == pytest.approx(whole, abs=1e-15)


def test_energy_falls_in_every_sweep_also_far_from_equilibrium():
    rng = np.random.default_rng(5)
    net = block(3, stiffness=50.0)
    state = held(net, [0, 5, 20], gravity=np.array(DOWN))
    state.position += 0.01 * rng.normal(size=state.position.shape)
    balance = Balance(state, every(state))
    x = balance.start
    energies = [balance.energy(x, balance.bars(x))[0]]
    for _ in range(50):
        x = relax(balance, x, threshold=0.0, most=1).x
        energies.append(balance.energy(x, balance.bars(x))[0])
    assert (np.diff(energies) < 0.0).all()


def test_layers_go_outwards_from_the_node_of_the_greatest_force():
    state = held(chain(6), [5])
    layers = Layers(Balance(state, every(state)))
    urge = np.array([0.0, 0.0, 3.0, 1.0, 0.0])
    order = [layer.star.nodes.tolist() for layer in layers.beginning_with(urge)]
    assert order == [[2], [1, 3], [0, 4]]


CUBE = """language 1
tissue gel { Young's modulus = 5 kPa; density = 1000 kg/m^3 }
body cube {
  mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (10, 10, 10) mm }; tissue is gel
  made of elements
}
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 1 ms }
"""


def test_layers_go_outwards_along_edges_of_elements():
    """From a corner of a cube of 2³ cells, the opposite corner is six edges away."""
    state = state_at_start(compiled_scene(CUBE))
    balance = Balance(state, every(state))
    urge = np.linalg.norm(state.position - 0.01, axis=1)
    order = [len(layer.star.nodes) for layer in Layers(balance).beginning_with(urge)]
    assert order == [1, 3, 6, 7, 6, 3, 1]


@pytest.mark.parametrize(("stretch", "longest"), [(0.5, 5e-3), (3.0, 15e-3)])
def test_steps_of_newtons_method_are_limited_by_edges_of_elements(stretch, longest):
    """As by springs: half of the longest, now or as drawn, is short enough for a step."""
    state = state_at_start(compiled_scene(CUBE))
    balance = Balance(state, every(state))
    bars = balance.bars(balance.start * [stretch, 1.0, 1.0])
    assert balance.longest(bars) == pytest.approx(longest, rel=1e-12)


def test_newton_falls_back_on_relaxation(monkeypatch):
    """Even with no step of Newton's at first, the equilibrium is found."""
    given, calls = newton.tangent_at, []

    def refusing(*asked, **more):
        calls.append(1)
        return None if len(calls) == 1 else given(*asked, **more)

    monkeypatch.setattr(newton, "tangent_at", refusing)
    state = prestressed()
    settle(state, every(state))
    assert residual(state) < 1e-11


def test_only_the_chosen_nodes_move_and_rest():
    state = held(chain(4, stiffness=10.0, velocity=1.0), [0], gravity=np.array(DOWN))
    chosen = np.array([False, True, True, False])
    before = state.position.copy()
    settle(state, chosen)
    assert np.array_equal(state.position[[0, 3]], before[[0, 3]])
    assert np.abs(state.position - before)[[1, 2], 2].min() > 0.1
    assert np.array_equal(state.velocity[:, 0], [1.0, 0.0, 0.0, 1.0])


def test_a_body_that_nothing_holds_has_no_equilibrium_and_stays_as_it_was():
    state = held(chain(4), gravity=np.array(DOWN))
    before = state.position.copy()
    with pytest.raises(Unsettled, match=r"no support balances a force of 39\.2 N") as failure:
        settle(state, every(state))
    assert failure.value.node == 0
    assert np.array_equal(state.position, before)


def test_a_free_body_without_load_settles_where_it_is_and_is_no_mechanism():
    state = held(block(3, shrink=0.9))
    (remark,) = settle(state, every(state))
    assert "nothing holds the net" in remark.message
    balance = Balance(state, every(state))
    assert np.abs(balance.bars(state.position).tension).max() < 1e-13
    middle = state.position.mean(axis=0)
    assert middle == pytest.approx([0.01, 0.01, 0.01], abs=1e-17)  # rounding of 0.01


def stretched(rng, drawn):
    """Return a free block of unequal masses, pulled apart along its first axis, and its loads.

    It is turned and moved at random; ``drawn`` is the relative size of the loads.
    """
    turn = Rotation.random(rng=rng).as_matrix()
    net = block(3, stiffness=50.0, mass=rng.uniform(0.5, 2.0, 27))
    state = held(net)
    side = np.round(100.0 * net.position[:, 0]) - 1.0
    state.position[:] = state.position @ turn.T + 0.01 * rng.normal(size=3)
    pull = drawn * 50.0 * 0.01 * turn[:, 0]
    push(state, np.flatnonzero(side > 0), pull)
    push_also(state, np.flatnonzero(side < 0), -pull)
    return state, turn[:, 0]


def push_also(state, nodes, vector):
    terms = (LoadTerm(np.array(vector, float), EVERLASTING),)
    state.loads["back"] = Load(np.array(nodes), terms, span())


@pytest.mark.parametrize("seed", range(6))
def test_a_free_body_under_balanced_loads_keeps_its_centre_of_mass_and_spins_nowhere(seed):
    rng = np.random.default_rng(seed)
    state, axis = stretched(rng, 10.0 ** rng.uniform(-4, -1))
    before, mass = state.position.copy(), state.mass
    (remark,) = settle(state, every(state))
    assert "nothing holds the net" in remark.message
    assert residual(state) < 1e-9  # loads of 1e-4 leave rounding of whole lengths
    moved = state.position - before
    size = np.abs(moved).max()
    assert np.abs(mass @ moved).max() < 1e-10 * size * mass.sum()
    arm = before - mass @ before / mass.sum()
    spin = np.cross(arm, moved).T @ mass
    assert abs(spin @ axis) < 1e-9 * size * np.abs(arm).max() * mass.sum()


@pytest.mark.parametrize("seed", range(4))
def test_a_free_body_settles_where_the_reference_has_it(seed):
    """To 25 times the rounding of positions of 1 cm, but for a turn into line with its loads.

    Only the loads resist that turn, so that it is less certain: rounding of positions (2e-18 m)
    changes the force of a spring by 1e-16 N, and all of them, 1 cm from the middle, change the
    moment by 1e-17 N m; nine loads of 0.5 mN at either end resist with 9e-5 N m/rad.
    """
    settled, relaxed = (stretched(np.random.default_rng(seed), 1e-3)[0] for _ in range(2))
    settle(settled, every(settled))
    rest(relaxed, every(relaxed))
    apart = settled.position - relaxed.position
    arm = settled.position - settled.position.mean(axis=0)
    turned = np.linalg.solve(
        (arm**2).sum() * np.eye(3) - arm.T @ arm, np.cross(arm, apart).sum(0)
    )
    assert np.abs(turned).max() < 1e-17 / 9e-5
    assert np.abs(apart - np.cross(turned, arm)).max() < 5e-17


def test_a_free_body_out_of_line_with_its_loads_is_turned_into_line():
    """Dead loads along x at both ends of a bar turn it until it lies along x."""
    net = make_net([[0, 0, 0], [0.6, 0.8, 0]], [[0, 1]], stiffness=10.0, rest=1.0)
    state = held(net)
    push(state, [1], (2.0, 0, 0))
    push_also(state, [0], (-2.0, 0, 0))
    settle(state, every(state))
    expected = [[0.3 - 0.6, 0.4, 0.0], [0.3 + 0.6, 0.4, 0.0]]
    assert state.position == pytest.approx(np.array(expected), abs=1e-12)


def test_what_a_point_holds_is_not_turned_about_it():
    """A triangle held at a corner settles to its rest lengths without a turn."""
    net = make_net([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1], [0, 2], [1, 2]], rest=1.1)
    (remark,) = settle(state := held(net, [0]), every(state))
    assert "can rotate about its support" in remark.message
    ends = state.position
    assert np.linalg.norm(ends[1]) == pytest.approx(1.1)
    assert np.linalg.norm(ends[1] - ends[2]) == pytest.approx(1.1)
    assert np.abs(ends[:, 2]).max() < 1e-15
    # No turn about the corner would bring it closer to where it was.
    mass, before = state.mass, state.network.position
    assert mass @ np.cross(before, ends) == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)


def test_a_mechanism_in_a_free_body_is_still_told():
    """Two triangles that share a node can turn against each other."""
    corner = np.array([[0, 0, 0], [1, 0, 0], [0.5, 1, 0]])
    position = np.vstack([corner, -corner[1:]])
    ends = [[0, 1], [1, 2], [0, 2], [0, 3], [3, 4], [0, 4]]
    remarks = settle(state := held(make_net(position, ends)), every(state))
    assert [r.node is not None for r in remarks] == [False, True]
    assert "mechanism" in remarks[1].message


def test_a_pendulum_has_a_place_to_hang_and_is_not_neutral():
    state = held(chain(3, stiffness=50.0), [0], gravity=np.array(DOWN))
    assert settle(state, every(state)) == ()
    assert np.abs(state.position[:, :2] - state.position[0, :2]).max() < 1e-12


def test_a_hinge_without_load_is_told_by_its_node():
    net = make_net([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1], [1, 2]], stiffness=3.0)
    (remark,) = settle(state := held(net, [0, 2]), every(state))
    assert "mechanism" in remark.message
    assert remark.node == 1


def test_a_pressed_column_buckles_and_says_so():
    net = make_net(
        [[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1], [1, 2]], stiffness=100.0, rest=1.2
    )
    state = held(net, [0, 2])
    remarks = settle(state, every(state))
    assert "buckled" in remarks[0].message
    assert remarks[0].node == 1
    # Both springs are as long as they want to be.
    assert np.hypot(*state.position[1, 1:]) == pytest.approx(np.sqrt(1.2**2 - 1.0))


def test_a_column_that_hardly_buckles_leaves_its_unstable_equilibrium():
    """Props resist nearly as much as the pressure pushes, so that steps are tiny."""
    ends = [[0, 1], [1, 2], [1, 3], [1, 4], [1, 5], [1, 6]]
    place = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [1, 1, 0], [1, -1, 0], [1, 0, 1], [1, 0, -1]]
    stiffness, rest = np.array([100, 100, 19.8, 19.8, 30, 30]), np.array([1.2, 1.2, 1, 1, 1, 1])
    state = held(make_net(place, ends, stiffness=stiffness, rest=rest), [0, 2, 3, 4, 5, 6])
    state.position[1, 1] = 1e-9
    remarks = settle(state, every(state))
    assert ["buckled" in remark.message for remark in remarks] == [True]
    # 200 (1 - 1.2/L) y + 39.6 y + 60 (1 - 1/L) y = 0 with L² = 1 + y².
    assert abs(state.position[1, 1]) == pytest.approx(np.sqrt((300 / 299.6) ** 2 - 1))
    assert residual(state) < 1e-11


def test_a_single_node_turns_about_the_line_through_its_anchors():
    net = make_net([[0, 0, 0], [1, 0.3, 0.4], [2, 0, 0]], [[0, 1], [1, 2]], stiffness=1.0)
    state = held(net, [0, 2])
    balance = Balance(state, every(state))
    (freedom,) = NeutralMotions.of(balance, balance.start).freedoms
    assert np.abs(freedom.motion[:, 0]) == pytest.approx([0.0, 0.8, 0.6], abs=1e-12)


def test_springs_that_are_dead_or_of_no_length_do_not_hinder():
    position = [[0, 0, 0], [1, 0, 0], [1, 0, 0], [2, 0, 0]]
    net = make_net(position, [[0, 1], [1, 2], [2, 3], [0, 3]], stiffness=10.0, rest=0.0)
    state = held(net, [0, 3])
    state.alive[3] = False
    settle(state, every(state))
    assert state.position[:, 0] == pytest.approx([0.0, 2 / 3, 4 / 3, 2.0], abs=1e-12)


def test_stiffness_of_the_balance_is_the_derivative_of_its_force():
    rng = np.random.default_rng(2)
    state = held(block(2, shrink=0.8), [0])
    state.position += 0.002 * rng.normal(size=state.position.shape)
    balance = Balance(state, every(state))
    x, step = balance.start, 1e-8
    matrix = balance.matrix(balance.bars(x), exact=True).toarray()
    for k in range(x.size):
        nudge = np.zeros(x.size)
        nudge[k] = step
        ahead, behind = (x + sign * nudge.reshape(-1, 3) for sign in (1.0, -1.0))
        change = balance.force(balance.bars(behind)) - balance.force(balance.bars(ahead))
        assert change.ravel() / (2 * step) == pytest.approx(matrix[k], abs=1e-5)


def test_everything_held_leaves_nothing_to_do():
    state = held(chain(3), [0, 1, 2], gravity=np.array(DOWN))
    assert settle(state, every(state)) == ()
    assert isinstance(state, State)


ON_A_DESK = """language 1
tissue gel { spring constant = 10 N/m; density = 1000 kg/m^3; retardation time = 2 ms }
body block {
  mesh is lattice { kind is sodium chloride; cell = 5 mm; reach is second neighbours
                    box from (0, 0, 0) mm to (10, 10, 10) mm }
  tissue is gel
}
tool desk { kind is plane; point = (0, 0, HEIGHT) mm; normal = (0, 0, 1) }
environment { gravity = (0, 0, -9.81) m/s^2; contact is tools only }
simulate { duration = 1 s }
"""


def test_what_lies_on_a_plane_settles_and_what_hangs_above_it_is_set_down():
    state = state_at_start(compiled_scene(ON_A_DESK.replace("HEIGHT", "0.05")))
    network, bodies = state.network, state.network.body_nodes
    settle(state, np.arange(network.node_count) < bodies)
    force = np.zeros_like(state.position)
    state.touching.add_forces(0.0, state.position, np.zeros_like(force), force)
    weight = 9.81 * network.mass[:bodies].sum()
    assert force[:bodies].sum(axis=0) == pytest.approx([0.0, 0.0, weight], abs=1e-9 * weight)
    above = state_at_start(compiled_scene(ON_A_DESK.replace("HEIGHT", "-3")))
    settle(above, np.arange(network.node_count) < bodies)
    lower = above.position[:bodies] - state.position[:bodies]
    # Both are equilibria to a residual force of 1e-9 of the weight.
    assert lower == pytest.approx(np.tile([0.0, 0.0, -3.05e-3], (bodies, 1)), abs=1e-9)
