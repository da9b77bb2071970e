"""Forces of contact, of every shape at once, against reaction, derivatives and losses."""

from functools import partial

import numpy as np
import pytest

from tests.contact.scenes import MEETING, by_loops, contact_of, meeting
from tests.derivatives import forces, slopes, stiffness
from tests.validate.scenes import compiled_scene
from tissuec.mechanics.state import State

COUNT = 100  # points of the cloud
STATES = range(3)
# For what takes differences along every axis of every node.
FEW_STATES = [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in STATES[1:])]


def cloud(friction="0", damping="0 s/m"):
    """Return contact and network of a cloud of points that every kind of shape reaches into."""
    compiled = compiled_scene(meeting(COUNT, friction=friction, damping=damping))
    return contact_of(compiled), compiled.network


def random_state(network, seed, *, moving=True):
    """Return positions and velocities near those drawn; bristles are bent by 0.4 mm or so."""
    random = np.random.default_rng(seed)
    position, velocity = network.position.copy(), np.zeros((network.row_count, 3))
    position += 1e-4 * random.normal(size=position.shape)
    if moving:
        velocity = 0.3 * random.normal(size=velocity.shape)
    return position, velocity


def test_the_cloud_is_touched_by_every_tool_and_by_two_at_once():
    contact, network = cloud()
    assert {tool.name for tool in network.tools} == set(MEETING)
    found = forces(contact, random_state(network, 0)[0])
    for tool in network.tools:
        assert np.abs(found[tool.nodes]).max() > 0.01, tool.name
    pressed = np.abs(found[: network.body_nodes]).max(axis=1) > 0.0
    assert COUNT / 4 < pressed.sum() < COUNT
    alone = 0
    for name, entries in MEETING.items():
        one = compiled_scene(meeting(COUNT, tools={name: entries}))
        single = forces(contact_of(one), random_state(network, 0)[0][: one.network.node_count])
        alone += (np.abs(single[: network.body_nodes]).max(axis=1) > 0.0).sum()
    assert alone > pressed.sum() + 2


@pytest.mark.parametrize("friction", ["0", "0.4"])
@pytest.mark.parametrize("seed", STATES)
def test_action_is_reaction(seed, friction):
    contact, network = cloud(friction, "0.5 s/m")
    found = forces(contact, *random_state(network, seed))
    # Some forty roundings of forces and of their shares; the ball, whose ends the state draws
    # 0.1 mm apart, is turned by couples of forces that are up to 50 times as large.
    assert np.abs(found.sum(axis=0)).max() < 1e-13 * np.abs(found).sum()


@pytest.mark.parametrize("seed", STATES)
def test_pressure_turns_nothing_as_a_whole(seed):
    contact, network = cloud("0", "0.5 s/m")
    position, velocity = random_state(network, seed)
    found = forces(contact, position, velocity)
    turning = np.cross(position, found)
    assert np.abs(turning.sum(axis=0)).max() < 1e-14 * np.abs(turning).sum()


@pytest.mark.parametrize("seed", FEW_STATES)
def test_forces_on_bodies_and_tools_are_minus_the_derivative_of_the_energy(seed):
    contact, network = cloud()
    position, h = random_state(network, seed)[0], 1e-8
    found = forces(contact, position)
    nodes = range(network.node_count)
    expected = slopes(partial(contact.energy, 0.0), position, nodes, h)
    # Energies of 1 mJ are known to 1e-19 J, differences over 20 nm to 1e-11 N.
    assert found[nodes] == pytest.approx(expected, abs=1e-6 * np.abs(found).max())


@pytest.mark.parametrize("seed", FEW_STATES)
def test_matrix_is_minus_the_derivative_of_the_forces(seed):
    contact, network = cloud()
    position, h, count = random_state(network, seed)[0], 1e-7, network.body_nodes
    number = np.full(network.node_count, -1)
    number[:count] = np.arange(count)
    matrix = contact.matrix(0.0, position, number, count).toarray()
    assert np.abs(matrix - matrix.T).max() < 1e-12 * np.abs(matrix).max()
    for column in range(3 * count):
        # Third derivatives of distances, and the kink of the law where the layer ends.
        slope = stiffness(contact, position, column, h)[: 3 * count]
        assert matrix[:, column] == pytest.approx(slope, abs=1e-4 * np.abs(matrix).max())


@pytest.mark.parametrize("seed", STATES)
def test_simpler_matrix_is_stiffer_by_no_more_than_the_weakening(seed):
    contact, network = cloud()
    position, count = random_state(network, seed)[0], network.body_nodes
    number = np.full(network.node_count, -1)
    number[:count] = np.arange(count)
    exact, simple = (
        contact.matrix(0.0, position, number, count, exact=exact).toarray()
        for exact in (True, False)
    )
    assert np.linalg.eigvalsh(simple)[0] > -1e-9
    taken = np.linalg.eigvalsh(simple - exact)
    weakening = contact.weakening(0.0, position, number, count)
    assert taken[0] > -1e-9
    # A node in two shapes at once loses by both.
    assert 0.0 < taken[-1] <= 2.0 * weakening


@pytest.mark.parametrize("friction", ["0", "0.4"])
def test_what_is_lost_is_what_is_done_by_all_and_not_stored(friction):
    contact, network = cloud(friction, "0.5 s/m")
    h = 1e-7
    for seed in STATES:
        position, velocity = random_state(network, seed)
        moving = velocity[: network.node_count]
        done = np.vdot(forces(contact, position, velocity), moving)
        ahead, behind = (
            float(contact.energy(0.0, position + sign * h * moving)) for sign in (1.0, -1.0)
        )
        stored = (ahead - behind) / (2.0 * h)
        lost = contact.powers(0.0, position, velocity)[1]
        assert done + stored == pytest.approx(-lost, abs=1e-6 * abs(lost))


@pytest.mark.parametrize("tool", ["ball", "rod", "plate"])
def test_damping_alone_only_ever_loses_and_never_pulls(tool):
    text = meeting(COUNT, tools={tool: MEETING[tool]}, damping="5 s/m")
    compiled = compiled_scene(text)
    contact, network = contact_of(compiled), compiled.network
    body, pushed = slice(0, network.body_nodes), 0
    for seed in range(10):
        position, velocity = random_state(network, seed)
        steady, moving = forces(contact, position), forces(contact, position, velocity)
        assert contact.powers(0.0, position, velocity)[1] >= 0.0
        outwards = np.einsum("nk,nk->n", steady[body], moving[body])
        assert outwards.min() == 0.0  # leaving at 0.2 m/s takes all pressure away
        pushed += (outwards > 0.0).sum()
    assert pushed > 10


@pytest.mark.parametrize("friction", ["0", "0.4"])
def test_a_batch_of_moments_is_each_of_them(friction):
    contact, network = cloud(friction, "0.5 s/m")
    positions, velocities = (
        np.stack(each)
        for each in zip(*[random_state(network, s) for s in range(4)], strict=True)
    )
    total = forces(contact, positions, velocities)
    energies = contact.energy(0.0, positions)
    lost = contact.powers(0.0, positions, velocities)[:, 1]
    for i, (position, velocity) in enumerate(zip(positions, velocities, strict=True)):
        assert total[i] == pytest.approx(forces(contact, position, velocity), abs=1e-12)
        assert energies[i] == pytest.approx(contact.energy(0.0, position), rel=1e-12)
        assert lost[i] == pytest.approx(
            contact.powers(0.0, position, velocity)[1], rel=1e-9, abs=1e-12
        )


@pytest.mark.parametrize("tool", ["ball", "rod", "plate"])
def test_friction_is_never_more_than_coulomb_allows_and_lies_in_the_surface(tool):
    drawn, rubbing = {tool: MEETING[tool]}, 0
    rough, smooth = (
        compiled_scene(meeting(COUNT, tools=drawn, friction=mu)) for mu in ("0.4", "0")
    )
    network, body = rough.network, slice(0, rough.network.body_nodes)
    for seed in STATES:
        position, velocity = random_state(network, seed)
        pressed = forces(contact_of(smooth), position, velocity[: len(position)])[body]
        rubbed = forces(contact_of(rough), position, velocity)[body] - pressed
        size, friction = (np.linalg.norm(each, axis=1) for each in (pressed, rubbed))
        assert np.abs(np.einsum("nk,nk->n", pressed, rubbed)).max() <= 1e-12 * size.max() ** 2
        assert np.all(friction <= 0.4 * size * (1.0 + 1e-12))
        rubbing += (friction > 0.0).sum()
    assert rubbing >= 10


def test_nothing_happens_on_the_very_line_of_a_rod_or_in_the_centre_of_a_sphere():
    contact, network = cloud("0.4", "0.5 s/m")
    position, velocity = random_state(network, 0)
    for node, name in enumerate(("ball", "rod", "hook")):
        (tool,) = [tool for tool in network.tools if tool.name == name]
        position[node] = position[tool.nodes.start]
    found = forces(contact, position, velocity)
    assert np.all(np.isfinite(found))
    assert np.all(np.isfinite(by_loops(contact, position, velocity)[2].bent))
    number = np.arange(network.node_count)
    matrix = contact.matrix(0.0, position, number, network.node_count)
    assert np.all(np.isfinite(matrix.data))
    assert np.isfinite(contact.energy(0.0, position))


def test_a_situation_counts_contact_among_what_acts():
    compiled = compiled_scene(meeting(COUNT))
    plan = compiled.plan
    state = State.start(compiled.network, gravity=plan.gravity, drag=plan.drag)
    assert compiled.network.contact in state.fields
