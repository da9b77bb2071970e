"""Every member keeps its tolerance on motions that are known in closed form."""

import numpy as np
import pytest

from tests.engine.members import MEMBERS, affordable, viscosities
from tests.engine.running import Bench, chain, pair
from tests.engine.test_closed_forms import relaxation
from tests.hand_net import make_net

OMEGA = np.sqrt(200.0)  # of the pair


def kept(ran, error, method):
    """Tell whether an error [m] of each sample is within the tolerance of the motion so far."""
    assert ran.end.kind == "reached"
    worst = (error[1:] / ran.largest_displacement[1:]).max()
    return worst < affordable(method)


@pytest.mark.parametrize(("method", "ratio"), viscosities(0.0, 0.1, 1.0, 3.0, 30.0))
def test_oscillator_of_any_damping(method, ratio):
    net = pair(damping=ratio * OMEGA)
    ran = Bench(net, 1.0, method=method, tolerance=affordable(method)).run()
    expected = 0.1 * (1.0 - relaxation(ratio, OMEGA, ran.time))
    assert kept(ran, np.abs(ran.position[:, 0, 0] - expected), method)


@pytest.mark.parametrize("mode", [1, 8])
@pytest.mark.parametrize(("method", "tau"), viscosities(0.0, 1e-3))
def test_mode_of_a_chain(method, tau, mode):
    count, stiffness, mass, amplitude = 8, 100.0, 0.01, 1e-4
    omega = 2.0 * np.sqrt(stiffness / mass) * np.sin(mode * np.pi / (2.0 * (count + 1)))
    shape = np.sin(mode * np.pi * np.arange(count + 2) / (count + 1))
    velocity = np.outer(amplitude * omega * shape, [1.0, 0.0, 0.0])
    net = chain(
        count, stiffness=stiffness, mass=mass, damping=tau * stiffness, velocity=velocity
    )
    tolerance, duration = affordable(method), 6.0 / omega
    ran = Bench(net, duration, method=method, tolerance=tolerance, fixed=[0, count + 1]).run()
    rate = 0.5 * tau * omega**2
    damped = np.sqrt(omega**2 - rate**2)
    swing = amplitude * omega / damped * np.exp(-rate * ran.time) * np.sin(damped * ran.time)
    moved = ran.position[:, :, 0] - net.position[:, 0]
    assert kept(ran, np.abs(moved - swing[:, None] * shape).max(axis=1), method)


@pytest.mark.parametrize(("method", "damping"), viscosities(0.0, 1e3))
def test_rotation_that_no_dashpot_brakes(method, damping):
    spin, stiffness = 2.0, 100.0
    distance = stiffness / (stiffness - 0.5 * spin**2)
    velocity = 0.5 * spin * distance * np.array([[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]])
    net = pair(stretch=distance - 1.0, damping=damping, velocity=velocity)
    ran = Bench(net, 1.5, method=method, tolerance=affordable(method)).run()
    arm = ran.position[:, 1] - ran.position[:, 0]
    turned = np.stack([np.cos(spin * ran.time), np.sin(spin * ran.time)], axis=1)
    error = 0.5 * np.abs(arm[:, :2] - distance * turned).max(axis=1)
    assert kept(ran, error, method)


@pytest.mark.parametrize(("method", "ratio"), viscosities(0.0, 20.0))
def test_creep_under_a_load_as_by_kelvin_and_voigt(method, ratio):
    stiffness, omega = 100.0, 10.0
    net = pair(stretch=0.0, damping=2.0 * ratio * omega)
    bench = Bench(net, 2.0, method=method, tolerance=affordable(method), fixed=[0])
    bench.push([1], [1.0, 0.0, 0.0])
    ran = bench.run()
    expected = (1.0 - relaxation(ratio, omega, ran.time)) / stiffness
    assert kept(ran, np.abs(ran.position[:, 1, 0] - 1.0 - expected), method)


@pytest.mark.parametrize("method", MEMBERS)
def test_chain_that_falls_into_its_swing_about_the_stretched_length(method):
    count, mass, c, rest, gravity = 4, 0.01, 60.0, 0.1, 9.81
    position = np.zeros((count + 1, 3))
    position[:, 2] = -rest * np.arange(count + 1)
    net = make_net(position, [[k, k + 1] for k in range(count)], mass=mass, stiffness=c)
    ran = Bench(
        net, 0.4, method=method, tolerance=affordable(method), gravity=(0.0, 0.0, -gravity),
        fixed=[0],
    ).run()  # fmt: skip
    matrix = np.diag([2.0] * (count - 1) + [1.0]) - np.eye(count, k=1) - np.eye(count, k=-1)
    values, shapes = np.linalg.eigh(c * matrix / mass)
    sag = np.cumsum(mass * gravity / c * np.arange(count, 0, -1))
    swing = np.cos(np.outer(ran.time, np.sqrt(values))) * (shapes.T @ -sag) @ shapes.T
    moved = position[1:, 2] - ran.position[:, 1:, 2]
    assert kept(ran, np.abs(moved - sag - swing).max(axis=1), method)
