"""Hinges: forces against derivatives, conservation laws, energy in motion, and tears."""

from functools import partial

import numpy as np
import pytest

from tests.derivatives import forces, slopes, stiffness
from tests.engine.running import Bench
from tests.hand_net import make_net, start
from tissuec.core.structs import replace
from tissuec.engine.stability import damping_radius, spectral_radius
from tissuec.forces.surfaces.bending import folds, hinges_at
from tissuec.mechanics.observables import inner_forces
from tissuec.mechanics.settling import settle
from tissuec.meshes.generators.joining import around_edges
from tissuec.meshes.generators.tube import Tube
from tissuec.model.topology import PairIndex
from tissuec.validate.forces.bending import Folding, turned_hinges

SIZE = 0.01
TUBE = Tube(
    axis=((0.0, 0.0, 0.0), (4 * SIZE, 0.0, 0.0)),
    radius=SIZE, rings=5, sides=8, diagonals="both",
)  # fmt: skip


def shell(stiffness=1e-4, damping=0.0, **more):
    """Return the net of a tube that resists bending, with unlike hinges."""
    mesh = TUBE.build()
    nodes = around_edges(mesh.skin)
    sides = np.array([[0, 1], [0, 2], [0, 3], [1, 2], [1, 3]])
    walls, which = PairIndex(mesh.ends).between(nodes[:, sides].reshape(-1, 2))
    uneven = 1.0 + 0.2 * np.sin(np.arange(len(nodes)))
    hinges = hinges_at(
        mesh.position,
        nodes,
        stiffness * uneven,
        damping * uneven,
        walls,
        which // len(sides),
    )
    net = make_net(mesh.position, mesh.ends, **({"mass": 1e-4, "stiffness": 5.0} | more))
    return replace(net, skin=mesh.skin).with_blocks(hinges.block)


def shaken(net, size=0.15):
    noise = np.random.default_rng(3).normal(size=net.position.shape)
    return net.position + size * SIZE * noise


def test_a_fold_is_the_angle_between_two_faces_whichever_way_it_goes():
    for angle in (-3.0, -1.0, 0.0, 0.5, 3.0):
        tip = [0.3, np.cos(angle), np.sin(angle)]
        corners = np.array([[0, 0, 0], [1, 0, 0], tip, [0.6, -2.0, 0.0]])
        assert folds(corners[None]) == pytest.approx([angle])
        # The other way round the edge, and seen from the other end.
        assert folds(corners[None, [1, 0, 3, 2]]) == pytest.approx([angle])


def test_forces_are_minus_the_derivative_of_the_energy_and_move_nothing_as_a_whole():
    hinges = shell().hinges
    position, h = shaken(shell()), 1e-8
    velocity = np.random.default_rng(4).normal(size=position.shape)
    found = forces(hinges, position)
    for whole in (found, forces(replace(hinges, damping=hinges.stiffness), position, velocity)):
        assert np.abs(whole.sum(axis=0)).max() < 1e-13 * np.abs(whole).sum()
        spin = np.cross(position, whole).sum(axis=0)
        assert np.abs(spin).max() < 1e-13 * np.abs(whole).sum() * SIZE
    nodes = [0, 9, 20]
    expected = slopes(partial(hinges.energy, 0.0), position, nodes, h)
    # Differences of energies have 1e-16 E / h of rounding.
    assert found[nodes] == pytest.approx(expected, abs=1e-6 * np.abs(found).max())


def test_stiffness_is_minus_the_derivative_of_the_forces():
    net = shell()
    position, h = shaken(net), 1e-7 * SIZE
    matrix = net.hinges.matrix(0.0, position, np.arange(40), 40).toarray()
    assert matrix == pytest.approx(matrix.T, abs=1e-12 * np.abs(matrix).max())
    for column in (0, 13, 70):
        slope = stiffness(net.hinges, position, column, h)
        assert matrix[:, column] == pytest.approx(slope, abs=1e-6 * np.abs(matrix).max())


def test_the_reference_folds_by_formulas_of_its_own():
    net = shell(damping=1e-6)
    position = shaken(net)
    velocity = np.random.default_rng(4).normal(size=position.shape)
    own, ours = Folding(net.hinges), net.hinges
    found, expected = (
        np.zeros_like(position),
        forces(net.hinges, position, velocity),
    )
    own.add_forces(0.0, position, velocity, found)
    assert found == pytest.approx(expected, abs=1e-12 * np.abs(expected).max())
    assert own.energy(0.0, position) == pytest.approx(float(net.hinges.energy(0.0, position)))
    lost = ours.powers(0.0, position, velocity)[1]
    assert own.dissipated(0.0, position, velocity) == pytest.approx(lost)
    power = np.vdot(forces(net.hinges, position) - expected, velocity)
    assert lost == pytest.approx(power)
    matrices = (one.matrix(0.0, position, np.arange(40), 40) for one in (own, net.hinges))
    one, other = (matrix.toarray() for matrix in matrices)
    assert one == pytest.approx(other, abs=1e-10 * np.abs(other).max())


def test_forces_do_not_jump_where_faces_are_folded_onto_each_other():
    hinge = single()

    def pull(angle):
        position = CORNERS.copy()
        position[2] = [0.5, np.cos(angle), np.sin(angle)]
        return forces(hinge, position)

    # k sin θ goes through zero at π.
    assert np.abs(pull(np.pi - 1e-9) - pull(np.pi + 1e-9)).max() < 1e-8


def test_forces_stay_finite_where_triangles_collapse():
    hinge = single()
    largest = []
    for height in (1e-1, 1e-3, 1e-6, 1e-9):
        position = CORNERS.copy()
        position[2] = [0.5, height * np.cos(1.0), height * np.sin(1.0)]
        largest.append(np.abs(forces(hinge, position, np.ones((4, 3)) * [0, 0, 1])).max())
    # Of order k / (√ε h0), as E rises from zero to k over the height √ε h0
    assert max(largest) < 10.0 and largest[-1] < 1e-6


CORNERS = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 1.0, 0.0], [0.5, -1.0, 0.0]])


def single():
    nodes, none = np.array([[0, 1, 2, 3]]), np.zeros(0, dtype=int)
    return hinges_at(CORNERS, nodes, np.ones(1), np.zeros(1), none, none)


def test_a_shell_that_is_shaken_keeps_its_ledger_and_its_momentum():
    net = shell(damping=1e-7)
    bench = Bench(net, 0.01, tolerance=1e-9, ledger=True)
    bench.state.position = shaken(net, 0.05)
    bench.state.velocity[0, 2] = 0.1
    ran = bench.run()
    r = ran.position[:, net.springs.ends[:, 1]] - ran.position[:, net.springs.ends[:, 0]]
    stretch = np.linalg.norm(r, axis=2) - net.springs.rest
    stored = 2.5 * (stretch**2).sum(axis=1) + net.hinges.energy(ran.time, ran.position)
    kinetic = 0.5e-4 * (ran.velocity**2).sum(axis=(1, 2))
    assert ran.dissipated[-1] > 1e-3 * stored[0]
    total = stored + kinetic + ran.dissipated
    assert np.ptp(total) < 1e-7 * total[0]
    momentum = ran.velocity.sum(axis=1)
    assert np.abs(momentum - momentum[0]).max() < 1e-12 * np.abs(ran.velocity).max() * 40


def test_bounds_of_rates_cover_the_hinges():
    net = shell(stiffness=1.0, damping=1e-3)
    state = start(net)
    hinges = net.hinges
    drawn = net.position[hinges.nodes]
    _, _, slopes, _ = turned_hinges(drawn, hinges.drawn, hinges.squares)
    for part, found, power in (
        (hinges.stiffness, spectral_radius(state), 0.5),
        (hinges.damping, damping_radius(state), 1.0),
    ):
        ways = np.zeros((len(part), *net.position.shape))
        each = np.sqrt(part)[:, None, None] * slopes
        np.add.at(ways, (np.arange(len(part))[:, None], hinges.nodes), each)
        ways = ways.reshape(len(part), -1)
        fastest = np.linalg.eigvalsh(ways.T @ ways / 1e-4)[-1] ** power
        assert fastest < found < 1.1 * fastest


def test_a_shell_settles_where_all_forces_balance():
    net = shell()
    state = start(net, gravity=(0.0, 0.0, -9.81))
    state.holders["fix"] = np.arange(16)
    settle(state, np.ones(net.node_count, dtype=bool))
    left = inner_forces(state, 0.0, state.position, np.zeros_like(net.position)).node
    left += state.mass[:, None] * state.gravity
    assert np.abs(left[16:]).max() < 1e-9 * 9.81e-4
    assert np.abs(forces(net.hinges, state.position)).max() > 1e-4


def test_a_hinge_gives_way_where_a_spring_is_missing_and_others_stay():
    net = shell()
    hinges = net.hinges
    alive = np.ones(net.entity_count, dtype=bool)
    assert hinges.intact(alive) is hinges
    alive[20] = False
    left = hinges.intact(alive)
    torn = {
        hinge for hinge, wall in zip(hinges.walled, hinges.walls, strict=True) if wall == 20
    }
    kept = [k for k in range(len(hinges.nodes)) if k not in torn]
    assert 0 < len(torn) < len(hinges.nodes)
    assert (left.nodes == hinges.nodes[kept]).all()
    assert 20 not in left.walls
    assert (left.nodes[left.walled] == hinges.nodes[kept][left.walled]).all()
    alive[:] = False
    assert forces(hinges.intact(alive), shaken(net)) == pytest.approx(0.0)
