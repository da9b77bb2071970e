"""Forces against energies, and energies against hand numbers."""

import numpy as np
import pytest

from tests.hand_net import chain, make_net, start
from tissuec.mechanics import observables


def spring_forces(state, position, velocity):
    """Return the forces on nodes of a net without fields [N]."""
    return observables.inner_forces(state, 0.0, position, velocity).node


def random_net(seed=0, **parameters):
    random = np.random.default_rng(seed)
    pairs = np.array([(a, b) for a in range(8) for b in range(a)])[::2]
    count = len(pairs)
    given = {
        "stiffness": random.uniform(1, 9, count),
        "damping": random.uniform(0, 2, count),
        "rest": random.uniform(0.2, 2, count),
        "mass": random.uniform(1, 4, 8),
    }
    network = make_net(random.normal(size=(8, 3)), pairs, **(given | parameters))
    return network, random.normal(size=(8, 3)), random.normal(size=(8, 3))


def test_tension_is_stiffness_times_stretch_plus_damping_times_closing_speed():
    network = make_net([(0, 0, 0), (3, 4, 0)], [(0, 1)], stiffness=10, damping=2, rest=4)
    velocity = np.array([[1.0, 0, 0], [0, 5.0, 9.0]])
    # u = (0.6, 0.8, 0), w = 0.6 (-1) + 0.8 · 5 = 3.4
    tension = observables.tension(start(network), network.position, velocity)
    assert tension == pytest.approx([10 * 1 + 2 * 3.4])


def test_springs_that_are_dead_or_have_no_length_do_not_pull():
    network = make_net([(0, 0, 0), (0, 0, 0), (2, 0, 0)], [(0, 1), (1, 2)], rest=1, damping=1)
    state = start(network)
    state.alive = np.array([True, False])
    force = spring_forces(state, network.position, np.ones((3, 3)))
    assert np.all(force == 0.0)


def test_elastic_forces_are_minus_the_gradient_of_the_elastic_energy():
    network, position, velocity = random_net(damping=0.0)
    state = start(network)
    force = spring_forces(state, position, np.zeros_like(position))
    step = 1e-5
    for node in range(8):
        for axis in range(3):
            shift = np.zeros_like(position)
            shift[node, axis] = step
            ahead = observables.elastic_energy(state, position + shift, velocity)
            behind = observables.elastic_energy(state, position - shift, velocity)
            # Central difference: step² times a third derivative, and rounding over the step.
            slope = (ahead - behind) / (2 * step)
            assert force[node, axis] == pytest.approx(-slope, abs=1e-7)


def test_spring_forces_have_no_sum_and_no_moment():
    network, position, velocity = random_net()
    force = spring_forces(start(network), position, velocity)
    assert force.sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-13)
    assert np.cross(position, force).sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-12)


def test_a_rigid_rotation_meets_no_viscous_force():
    network, position, _ = random_net(stiffness=0.0)
    velocity = np.cross([0.3, -1.0, 2.0], position)
    force = spring_forces(start(network), position, velocity)
    assert force == pytest.approx(np.zeros((8, 3)), abs=1e-13)


def test_a_batch_gives_what_each_of_its_states_gives_to_the_last_bit():
    network, position, velocity = random_net()
    state = start(network, gravity=(0, 1, -9))
    state.holders["fix"] = np.array([2])
    batch = np.stack([position, 2 * position, position + velocity]), np.stack([velocity] * 3)
    forces = spring_forces(state, *batch)
    energies = observables.energies(state, 0.0, *batch)
    on = observables.pull_on(state, *batch, np.array([1, 5]))
    for sample in range(3):
        motion = batch[0][sample], batch[1][sample]
        assert np.array_equal(forces[sample], spring_forces(state, *motion))
        single = observables.energies(state, 0.0, *motion)
        assert [e[sample] for e in energies] == pytest.approx(list(single), rel=1e-15)
        assert on[sample] == pytest.approx(
            observables.pull_on(state, *motion, np.array([1, 5]))
        )


def test_the_pull_on_a_group_is_the_sum_of_the_forces_on_its_nodes():
    network, position, velocity = random_net()
    state = start(network)
    state.alive = np.arange(network.spring_count) % 3 > 0
    nodes = np.array([0, 3, 4])
    forces = spring_forces(state, position, velocity)
    pull = observables.pull_on(state, position, velocity, nodes)
    assert pull == pytest.approx(forces[nodes].sum(axis=0))


def test_energies_of_a_hanging_chain_count_free_nodes_and_live_springs_only():
    network = chain(3, mass=[2, 3, 4], stiffness=10, rest=0.5)
    state = start(network, gravity=(-10, 0, 0))
    state.holders["fix"] = np.array([0])
    state.alive = np.array([True, False])
    velocity = np.ones((3, 3))
    energies = observables.energies(state, 0.0, network.position, velocity)
    assert float(energies.kinetic) == pytest.approx(0.5 * (3 + 4) * 3)
    assert float(energies.elastic) == pytest.approx(0.5 * 10 * 0.25)
    assert float(energies.gravity) == pytest.approx(10 * (3 * 1 + 4 * 2))
    assert float(energies.total) == pytest.approx(10.5 + 1.25 + 110)
    both = observables.elastic_energy(
        state, network.position, network.velocity, np.array([0, 1])
    )
    assert float(both) == pytest.approx(1.25)


def test_weight_is_minus_the_gradient_of_the_gravity_energy():
    network, position, _ = random_net()
    state = start(network, gravity=(1.0, 2.0, -9.81))
    lifted = position + np.array([0.0, 0.0, 0.5])
    (weight,) = state.outer
    work = weight.energy(0.0, lifted) - weight.energy(0.0, position)
    assert work == pytest.approx(9.81 * 0.5 * network.mass.sum())


def test_a_net_without_springs_or_nodes_has_no_forces_and_no_energy():
    for nodes in (0, 3):
        state = start(make_net(np.zeros((nodes, 3)), []))
        motion = state.position, state.velocity
        assert spring_forces(state, *motion).shape == (nodes, 3)
        assert float(observables.energies(state, 0.0, *motion).total) == 0.0


def test_energies_of_a_sample_do_not_depend_on_the_others():
    network, position, velocity = random_net()
    state = start(network)
    state.holders["fix"] = np.array([3])
    state.gravity = np.array([0.1, 0.2, -9.81])
    random = np.random.default_rng(1)
    many = position + random.normal(size=(37, 8, 3)), velocity + random.normal(size=(37, 8, 3))
    together = observables.energies(state, 0.0, *many)
    for sample in range(37):
        alone = observables.energies(state, 0.0, many[0][sample], many[1][sample])
        for part, whole in zip(alone, together, strict=True):
            assert part == whole[sample]


def test_forces_are_the_same_however_many_springs_are_looked_at_at_once(monkeypatch):
    """Sums of several parts differ by rounding; tensions of springs not at all."""
    network, position, velocity = random_net()
    states = np.stack([position, position + 0.1]), np.stack([velocity, 2.0 * velocity])
    whole = observables.inner_forces(start(network), 0.0, *states)
    monkeypatch.setattr(observables, "TOGETHER", 5)
    assert network.spring_count > 5
    parts = observables.inner_forces(start(network), 0.0, *states)
    assert parts.tension.tobytes() == whole.tension.tobytes()
    assert np.abs(parts.node - whole.node).max() < 1e-14 * np.abs(whole.tension).max()
    some = np.arange(1, network.spring_count, 2)
    tension = observables.tension(start(network), *states, some)
    assert tension.tobytes() == whole.tension[:, some].tobytes()
    assert observables.tension(start(network), *states, some[:0]).shape == (2, 0)
