"""Enclosed volumes: geometry, forces and stiffness against differences and closed forms."""

from functools import partial

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.derivatives import forces, slopes, stiffness
from tests.engine.running import Bench
from tests.hand_net import make_net, span
from tissuec.core.structs import replace
from tissuec.engine.stability import spectral_radius
from tissuec.forces.enclosed.volume import Enclosure, open_edges
from tissuec.forces.pooled_fields import LARGE
from tissuec.mechanics import observables
from tissuec.mechanics.balance import Balance
from tissuec.mechanics.settling import settle
from tissuec.mechanics.state import State
from tissuec.meshes.generators import MESHES
from tissuec.model.profiles import TimeProfile

RADIUS, MODULUS = 0.02, 1e4


def ball(subdivisions=1, **more):
    """Return a sphere's net, and what it encloses."""
    mesh = MESHES["sphere"](centre=(0.0, 0.0, 0.0), radius=RADIUS, subdivisions=subdivisions)
    built = mesh.build()
    net = replace(make_net(built.position, built.ends, **more), skin=built.skin)
    return net, Enclosure.of(net, "net", MODULUS, span())


def shaken(net, size=0.1):
    noise = np.random.default_rng(3).normal(size=net.position.shape)
    return net.position + size * RADIUS * noise


def test_volume_of_an_icosahedron_and_of_it_stretched():
    net, enclosure = ball(0)
    edge = RADIUS / np.sin(2.0 * np.pi / 5.0)
    expected = 5.0 * (3.0 + np.sqrt(5.0)) / 12.0 * edge**3
    assert enclosure.drawn == pytest.approx([expected])
    elsewhere = net.position * [1.0, 2.0, 3.0] + [5.0, -7.0, 2.0]
    assert enclosure.volumes(elsewhere) == pytest.approx([6.0 * expected])
    assert enclosure.volumes(np.stack([net.position, elsewhere])).shape == (2, 1)


def test_finer_spheres_come_to_the_volume_of_a_sphere():
    wrong = [1.0 - ball(n)[1].drawn[0] / (4.0 / 3.0 * np.pi * RADIUS**3) for n in (1, 2, 3)]
    assert wrong[1] / wrong[2] == pytest.approx(4.0, rel=0.1)
    assert wrong[2] < 0.02


def test_a_surface_that_faces_inwards_is_turned():
    net, enclosure = ball()
    inwards = Enclosure.of(replace(net, skin=net.skin[:, ::-1]), "net", MODULUS, span())
    assert inwards.drawn == pytest.approx(enclosure.drawn)
    assert forces(inwards, shaken(net)) == pytest.approx(forces(enclosure, shaken(net)))


def test_forces_are_minus_the_derivative_of_the_energy_and_push_nothing_as_a_whole():
    net, enclosure = ball()
    position, h = shaken(net), 1e-8
    found = forces(enclosure, position)
    assert np.abs(found.sum(axis=0)).max() < 1e-14 * np.abs(found).sum()
    spin = np.cross(position, found).sum(axis=0)
    assert np.abs(spin).max() < 1e-14 * np.abs(found).sum()
    nodes = [0, 7, 20]
    expected = slopes(partial(enclosure.energy, 0.0), position, nodes, h)
    assert found[nodes] == pytest.approx(expected, rel=1e-5)


def test_stiffness_is_minus_the_derivative_of_the_forces():
    net, enclosure = ball()
    position, h = shaken(net), 1e-7
    count = net.node_count
    matrix = enclosure.matrix(0.0, position, np.arange(count), count).toarray()
    assert matrix == pytest.approx(matrix.T)
    for column in (0, 13, 40):
        slope = stiffness(enclosure, position, column, h)
        assert matrix[:, column] == pytest.approx(slope, abs=1e-7 * np.abs(matrix).max())


def test_a_ball_without_springs_breathes_as_one_mass():
    mass, stretch = 1e-3, 1.05
    net, _ = ball(0, mass=mass, stiffness=0.0)
    drawn = float(Enclosure.of(net, "net", MODULUS, span()).drawn[0])
    bench = Bench(net, 0.05, tolerance=1e-9, ledger=True)
    bench.state.put(Enclosure.of(net, "net", MODULUS, span()).block)
    bench.state.position *= stretch
    ran = bench.run()

    def fall(_, y):
        size = y[0] / RADIUS
        return [y[1], -MODULUS * drawn * (size**3 - 1.0) * 3.0 * size**2 / (12 * mass * RADIUS)]

    exact = solve_ivp(
        fall, (0.0, 0.05), [stretch * RADIUS, 0.0], "DOP853", ran.time, rtol=1e-12, atol=1e-15
    )
    found = np.linalg.norm(ran.position, axis=2)
    assert (np.diff(np.sign(np.diff(exact.y[0]))) != 0).sum() > 3
    assert np.abs(found - exact.y[0][:, None]).max() < 1e-8 * RADIUS * stretch
    kinetic = 0.5 * mass * (ran.velocity**2).sum(axis=(1, 2))
    stored = bench.state.enclosures["net"].energy(ran.time, ran.position)
    assert np.ptp(kinetic + stored) < 1e-8 * stored[0]


def test_pumping_does_the_work_that_is_stored():
    net, enclosure = ball(0, mass=1e-3, stiffness=30.0, damping=0.05)
    bench = Bench(net, 0.3, tolerance=1e-8, ledger=True)
    profile = TimeProfile("smooth", 0.05, 0.2)
    bench.state.put(enclosure.swollen(0.4, profile).block)
    ran = bench.run(0.05, 0.2)
    inside = bench.state.enclosures["net"]
    r = ran.position[:, net.springs.ends[:, 1]] - ran.position[:, net.springs.ends[:, 0]]
    stretch = np.linalg.norm(r, axis=2) - net.springs.rest
    stored = 0.5 * 30.0 * (stretch**2).sum(axis=1) + inside.energy(ran.time, ran.position)
    kinetic = 0.5 * 1e-3 * (ran.velocity**2).sum(axis=(1, 2))
    assert ran.work[-1] > 1e-3 * MODULUS * enclosure.drawn[0]
    gap = stored + kinetic - (ran.work - ran.dissipated)
    assert np.abs(gap).max() < 1e-7 * ran.work[-1]
    # The walls hold back a little of what was pumped in.
    assert 1.0 < inside.volumes(ran.position[-1])[0] / inside.drawn[0] < 1.4


def test_a_torn_surface_leaks():
    net, enclosure = ball()
    state = State.start(net, gravity=np.zeros(3), drag=0.0)
    state.put(enclosure.block)
    assert state.let_leak() == []
    assert len(enclosure.walls) == net.spring_count
    state.alive = state.alive.copy()
    state.alive[5] = False
    assert state.let_leak() == [(enclosure, 1)]
    assert state.enclosures == {}


def test_open_and_empty_surfaces_are_refused():
    net, _ = ball()
    assert len(open_edges(net.skin.astype(np.int64))) == 0
    holed = replace(net, skin=net.skin[1:])
    with pytest.raises(ValueError, match="3 edges are free"):
        Enclosure.of(holed, "net", MODULUS, span())
    with pytest.raises(ValueError, match="has no surface"):
        Enclosure.of(replace(net, skin=net.skin[:0]), "net", MODULUS, span())
    flat = replace(net, position=net.position * [1.0, 1.0, 0.0])
    with pytest.raises(ValueError, match="encloses nothing"):
        Enclosure.of(flat, "net", MODULUS, span())
    with pytest.raises(ValueError, match="not a body"):
        Enclosure.of(net, "else", MODULUS, span())


def test_fastest_motion_is_that_of_springs_and_pressure_together():
    net, enclosure = ball(1, mass=1e-3, stiffness=3.0)
    state = State.start(net, gravity=np.zeros(3), drag=0.0)
    state.put(replace(enclosure, modulus=1e6).block)
    inside = state.enclosures["net"]
    count = net.node_count
    matrix = inside.matrix(0.0, net.position, np.arange(count), count, exact=False).toarray()
    for a, b in net.springs.ends:
        n = net.position[b] - net.position[a]
        n /= np.linalg.norm(n)
        block = 3.0 * np.outer(n, n)
        for i, j, sign in ((a, a, 1), (b, b, 1), (a, b, -1), (b, a, -1)):
            matrix[3 * i : 3 * i + 3, 3 * j : 3 * j + 3] += sign * block
    fastest = np.sqrt(np.linalg.eigvalsh(matrix / 1e-3)[-1])
    found = spectral_radius(state)
    assert fastest < found < 1.1 * fastest
    state.blocks = {}
    assert spectral_radius(state) < 0.5 * found


def test_a_ball_under_pressure_settles_where_all_forces_balance():
    net, enclosure = ball(1, mass=2e-3, stiffness=40.0)
    state = State.start(net, gravity=np.array([0.0, 0.0, -9.81]), drag=0.0)
    state.holders["fix"] = np.flatnonzero(net.position[:, 2] > 0.8 * RADIUS)
    state.put(enclosure.swollen(0.3, TimeProfile("constant", 0.0, np.inf)).block)
    settle(state, np.ones(net.node_count, dtype=bool))
    still = np.zeros_like(net.position)
    left = observables.inner_forces(state, 0.0, state.position, still).node
    left += state.mass[:, None] * state.gravity
    largest = np.abs(forces(state.enclosures["net"], state.position)).max()
    free = ~state.held
    assert largest > 1e-3
    assert np.abs(left[free]).max() < 1e-9 * largest
    assert np.abs(state.position - net.position)[free].max() > 1e-3 * RADIUS


@pytest.mark.parametrize("pulled", [0.0, 0.02])
def test_a_large_surface_settles_the_same_without_a_full_matrix(pulled, monkeypatch):
    """Pressed flat between its poles, too, where pressure alone keeps it from folding."""
    places = []
    for large in (LARGE, 10**9):
        monkeypatch.setattr("tissuec.forces.pooled_fields.LARGE", large)
        net, enclosure = ball(2, stiffness=20.0)
        state = State.start(net, gravity=np.zeros(3), drag=0.0)
        state.put(enclosure.swollen(0.1, TimeProfile("constant", 0.0, np.inf)).block)
        poles = np.argsort(net.position[:, 2])[[0, -1]]
        state.holders["fix"] = poles
        state.position[:, 2] *= 1.0 - pulled / (2.0 * RADIUS)
        settle(state, np.ones(net.node_count, dtype=bool))
        places.append(state.position.copy())
        if large == LARGE:
            balance = Balance(state, np.ones(net.node_count, dtype=bool))
            found = balance.matrix(balance.bars(balance.start), exact=True)
            assert found.sparse.nnz < 64 * 3 * net.node_count and found.wide.shape[1] == 1
    assert places[0] == pytest.approx(places[1], abs=1e-9 * RADIUS)
