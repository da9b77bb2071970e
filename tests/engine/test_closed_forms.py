"""Motions that are known exactly, on both backends."""

import numpy as np
import pytest

from tests.engine.running import Bench, chain, pair
from tests.hand_net import make_net
from tissuec.engine.backends import BACKENDS
from tissuec.model.profiles import TimeProfile


def relaxation(ratio, omega, time):
    """Return x(t)/x(0) of x'' + 2 ζ ω x' + ω² x = 0 from rest."""
    rate = ratio * omega
    if ratio == 1.0:
        return np.exp(-rate * time) * (1.0 + rate * time)
    root = np.sqrt(complex(rate * rate - omega * omega))
    fast, slow = -rate - root, -rate + root
    return np.real((slow * np.exp(fast * time) - fast * np.exp(slow * time)) / (slow - fast))


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("ratio", [0.0, 0.1, 1.0, 3.0])
def test_two_masses_swing_and_creep_as_the_damped_oscillator(ratio, backend):
    omega = np.sqrt(2.0 * 100.0)  # reduced mass of two times 1 kg
    ran = Bench(pair(damping=ratio * omega), 3.0, tolerance=1e-9, backend=backend).run()
    expected = 1.0 + 0.2 * relaxation(ratio, omega, ran.time)
    length = ran.position[:, 1, 0] - ran.position[:, 0, 0]
    # 1e-8 of the motion, which is 0.1 m for each mass.
    assert length == pytest.approx(expected, abs=2e-9)


@pytest.mark.parametrize("mode", [1, 4, 8])
@pytest.mark.parametrize("tau", [0.0, 1e-3])
def test_chain_swings_in_its_normal_modes(mode, tau):
    count, stiffness, mass, amplitude = 8, 100.0, 0.01, 1e-4
    omega = 2.0 * np.sqrt(stiffness / mass) * np.sin(mode * np.pi / (2.0 * (count + 1)))
    shape = np.sin(mode * np.pi * np.arange(count + 2) / (count + 1))
    velocity = np.zeros((count + 2, 3))
    velocity[:, 0] = amplitude * omega * shape
    net = chain(
        count, stiffness=stiffness, mass=mass, damping=tau * stiffness, velocity=velocity
    )
    ran = Bench(net, 0.5, tolerance=1e-9, fixed=[0, count + 1]).run()
    rate = 0.5 * tau * omega**2
    damped = np.sqrt(omega**2 - rate**2)
    swing = amplitude * omega / damped * np.exp(-rate * ran.time) * np.sin(damped * ran.time)
    moved = ran.position[:, :, 0] - net.position[:, 0]
    assert np.abs(moved - swing[:, None] * shape).max() < 1e-8 * amplitude


def test_overdamped_pair_under_load_creeps_as_kelvin_and_voigt():
    # e = F/c (1 - exp(-c t / d)) without inertia; with it, the damped oscillator of ratio 20.
    stiffness, ratio, omega = 100.0, 20.0, 10.0
    damping = 2.0 * ratio * omega
    bench = Bench(pair(stretch=0.0, damping=damping), 10.0, tolerance=1e-9, fixed=[0])
    bench.push([1], [1.0, 0.0, 0.0])
    ran = bench.run()
    creep = ran.position[:, 1, 0] - 1.0
    assert creep == pytest.approx((1.0 - relaxation(ratio, omega, ran.time)) / 100.0, abs=1e-10)
    massless = (1.0 - np.exp(-ran.time * stiffness / damping)) / stiffness
    assert creep == pytest.approx(massless, abs=0.01 * 1.0 / (4.0 * ratio**2))


def test_hanging_chain_comes_to_rest_at_its_known_length():
    count, rest, mass, stiffness, gravity = 6, 0.01, 0.01, 100.0, 9.81
    position = np.zeros((count + 1, 3))
    position[:, 2] = -rest * np.arange(count + 1)
    ends = [[i, i + 1] for i in range(count)]
    net = make_net(position, ends, mass=mass, stiffness=stiffness, damping=2.0)
    ran = Bench(net, 30.0, tolerance=1e-8, gravity=(0.0, 0.0, -gravity), fixed=[0]).run()
    length = count * rest + mass * gravity / stiffness * count * (count + 1) / 2
    assert -ran.position[-1, -1, 2] == pytest.approx(length, rel=1e-9)


def test_uniform_strain_of_a_falling_chain_stays_uniform_until_it_is_told():
    # A free chain in free fall keeps its shape exactly: gravity acts on every node alike.
    net = chain(5)
    ran = Bench(net, 2.0, tolerance=1e-9, gravity=(0.0, 0.0, -9.81)).run()
    fall = -0.5 * 9.81 * ran.time**2
    assert np.abs(ran.position[:, :, 2] - fall[:, None]).max() < 1e-9 * 19.62
    assert np.abs(ran.position[:, :, :2] - net.position[:, :2]).max() < 1e-12


@pytest.mark.parametrize("backend", BACKENDS)
def test_driven_mass_answers_a_sine_with_the_known_forced_motion(backend):
    # m x'' = c (A sin wt - x) from rest: x = A o (o sin wt - w sin ot) / (o² - w²), o² = c/m.
    net = pair(stretch=0.0)
    bench = Bench(net, 3.0, tolerance=1e-9, backend=backend)
    bench.move([0], [0.05, 0.0, 0.0], TimeProfile("sine", 0.0, np.inf, frequency=0.7))
    ran = bench.run()
    w, o = 2.0 * np.pi * 0.7, 10.0
    forced = 0.05 * o * (o * np.sin(w * ran.time) - w * np.sin(o * ran.time)) / (o**2 - w**2)
    reach = np.abs(forced).max()
    assert np.abs(ran.position[:, 1, 0] - 1.0 - forced).max() < 1e-8 * reach
    path = 0.05 * np.sin(w * ran.time)
    assert ran.position[:, 0, 0] == pytest.approx(path, abs=1e-15)


@pytest.mark.parametrize("damping", [0.0, 1e3])
def test_rigid_rotation_is_not_braked_by_dashpots_along_the_springs(damping):
    # Two masses at the distance at which tension and centrifugal force agree.
    spin, stiffness = 2.0, 100.0
    distance = stiffness / (stiffness - 0.5 * spin**2)
    velocity = 0.5 * spin * distance * np.array([[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]])
    net = pair(stretch=distance - 1.0, damping=damping, velocity=velocity)
    ran = Bench(net, 1.5, tolerance=1e-9).run()
    arm = ran.position[:, 1] - ran.position[:, 0]
    expected = distance * np.stack([np.cos(spin * ran.time), np.sin(spin * ran.time)], axis=1)
    assert np.abs(arm[:, :2] - expected).max() < 1e-8


@pytest.mark.parametrize("backend", BACKENDS)
def test_load_that_grows_in_time_moves_a_free_mass_by_its_double_integral(backend):
    net = make_net([[0.0, 0.0, 0.0]], [], mass=2.0)
    bench = Bench(net, 2.0, tolerance=1e-9, backend=backend)
    bench.push([0], [0.0, 3.0, 0.0], TimeProfile("ramp", 0.5, 1.5))
    ran = bench.run()
    ramp, after = np.clip(ran.time - 0.5, 0.0, 1.0), np.maximum(ran.time - 1.5, 0.0)
    expected = 1.5 * (ramp**3 / 6.0 + 0.5 * after + 0.5 * after**2)
    assert ran.position[:, 0, 1] == pytest.approx(expected, abs=1e-9 * expected.max())


def test_drag_brakes_a_free_mass_exponentially():
    net = make_net([[0.0, 0.0, 0.0]], [], mass=0.5, velocity=[1.0, 0.0, 0.0])
    ran = Bench(net, 2.0, tolerance=1e-9, drag=0.25).run()
    assert ran.position[:, 0, 0] == pytest.approx(
        2.0 * (1.0 - np.exp(-0.5 * ran.time)), abs=2e-9
    )


@pytest.mark.parametrize("backend", BACKENDS)
def test_spring_of_no_length_has_no_force_and_nothing_becomes_undefined(backend):
    asked = {"tolerance": 1e-6, "gravity": (0.0, 0.0, -1.0), "backend": backend}
    together = [[0.0, 0.0, 0.0]] * 2
    slack = make_net(together, [[0, 1]], stiffness=10.0, damping=1.0, rest=0.0)
    ran = Bench(slack, 1.0, **asked).run()
    assert np.abs(ran.position[-1] - [0.0, 0.0, -0.5]).max() < 1e-9
    # Pressed together as far as can be, the pair may leave that balance either way.
    pressed = make_net(together, [[0, 1]], stiffness=10.0, damping=1.0, rest=1.0)
    ran = Bench(pressed, 1.0, **asked).run()
    assert ran.end.kind == "reached"
    assert ran.position[-1].mean(axis=0) == pytest.approx([0.0, 0.0, -0.5], abs=1e-9)


def test_scene_at_rest_stays_at_rest():
    ran = Bench(chain(4), 10.0, tolerance=1e-9).run()
    assert np.array_equal(ran.position, np.broadcast_to(ran.position[0], ran.position.shape))


def test_net_without_nodes_and_net_without_free_nodes_run_through():
    empty = Bench(make_net(np.zeros((0, 3)), []), 1.0, tolerance=1e-6).run()
    assert empty.end.kind == "reached"
    assert empty.position.shape == (41, 0, 3)
    held = Bench(pair(), 1.0, tolerance=1e-6, fixed=[0, 1]).run()
    assert np.ptp(held.position, axis=0).max() == 0.0
