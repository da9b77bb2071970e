"""Motions under laws that are not linear, against closed forms."""

import numpy as np
import pytest
from scipy.special import ellipj

from tests.engine.members import MEMBERS, affordable, viscosities
from tests.engine.running import Bench
from tests.hand_net import make_net
from tissuec.engine.integrators import INTEGRATORS
from tissuec.engine.kernel_inputs import KernelInputs
from tissuec.laws import LINEAR, SPRING_LAWS, VISCOSITY_LAWS, Law
from tissuec.mechanics.state import State

MASS, C, REST = 0.01, 4.0, 1.0
TIGHT = 1e-10
CLOSE = 1e-8  # of the largest displacement
# Every law is compiled anew; the first one stands for all by default.


def spring(name, **entries):
    return Law(name, SPRING_LAWS[name](**entries).force(), LINEAR.viscous)


def bob(elongation, law, **more):
    """Return a mass on a spring along x, whose other end is to be held."""
    return make_net(
        [[0.0, 0.0, 0.0], [REST + elongation, 0.0, 0.0]],
        [[0, 1]],
        mass=MASS,
        stiffness=C,
        rest=REST,
        law=law,
        **more,
    )


def elongation(net, duration, *, tolerance=TIGHT, **asked):
    """Return times and the elongation of the spring."""
    ran = Bench(net, duration, fixed=[0], tolerance=tolerance, **asked).run()
    assert ran.end.kind == "reached"
    return ran.time, np.linalg.norm(ran.position[:, 1], axis=1) - REST


def test_oscillator_of_duffing():
    size, cube = 0.3, 30.0
    time, found = elongation(bob(size, spring("polynomial", cube=cube)), 2.0)
    omega = np.sqrt((C + cube * size**2) / MASS)
    cn = ellipj(omega * time, cube * size**2 / (2.0 * (C + cube * size**2)))[1]
    assert found == pytest.approx(size * cn, abs=CLOSE * 2.0 * size)


def test_oscillator_of_helmholtz():
    size, square = 0.3, 6.0
    time, found = elongation(bob(size, spring("polynomial", square=square)), 2.0)
    # ½ m e'² = energy - ½ c e² - a/3 e³ vanishes at three places; it swings between two.
    energy = 0.5 * C * size**2 + square / 3.0 * size**3
    low, middle, high = np.sort(np.roots([-square / 3.0, -0.5 * C, 0.0, energy]).real)
    omega = np.sqrt(square * (high - low) / (6.0 * MASS))
    sn = ellipj(omega * time, (high - middle) / (high - low))[0]
    assert found == pytest.approx(high - (high - middle) * sn**2, abs=CLOSE * 2.0 * size)


@pytest.mark.parametrize("method", MEMBERS)
def test_every_member_follows_a_stiffening_spring(method):
    size, cube = 0.3, 30.0
    tolerance = affordable(method)
    law = spring("polynomial", cube=cube)
    time, found = elongation(bob(size, law), 0.5, method=method, tolerance=tolerance)
    omega = np.sqrt((C + cube * size**2) / MASS)
    cn = ellipj(omega * time, cube * size**2 / (2.0 * (C + cube * size**2)))[1]
    assert np.abs(found - size * cn).max() < tolerance * 2.0 * size


def thread(time, size):
    """Return where a mass is that a thread of length 1 pulls back from either side."""
    omega = np.sqrt(C / MASS)
    taut, slack = np.pi / omega, 2.0 * REST / (size * omega)
    phase = np.mod(time + 0.5 * taut, taut + slack)
    half = np.floor((time + 0.5 * taut) / (taut + slack))
    out = np.where(
        phase < taut,
        REST + size * np.sin(omega * phase),
        REST - size * omega * (phase - taut),
    )
    return (-1.0) ** half * out


def test_thread_goes_slack_and_taut():
    net = bob(0.3, spring("tension only"))
    ran = Bench(net, 2.0, fixed=[0], tolerance=TIGHT).run()
    expected = thread(ran.time, 0.3)
    assert ran.position[:, 1, 0] == pytest.approx(expected, abs=CLOSE * 2.6)


@pytest.mark.parametrize("exponent", [0.7, 1.5, 2.0, 3.0])
def test_dashpot_of_a_power_slows_down_as_calculated(exponent):
    speed, start, viscosity = 0.5, 2.0, 0.02
    force = VISCOSITY_LAWS["power"](exponent=exponent, speed=speed).force()
    net = make_net(
        [[0.0, 0.0, 0.0], [REST, 0.0, 0.0]],
        [[0, 1]],
        mass=MASS,
        stiffness=0.0,
        damping=viscosity,
        velocity=[[0.0, 0.0, 0.0], [start, 0.0, 0.0]],
        law=Law("power", LINEAR.elastic, force),
    )
    ran = Bench(net, 0.3, tolerance=TIGHT, ledger=True).run()
    # w' = -(2/m) d v (w/v)ⁿ for two equal masses.
    rate = 2.0 * viscosity * speed ** (1.0 - exponent) / MASS
    power = 1.0 - exponent
    w = (start**power - power * rate * ran.time) ** (1.0 / power)
    found = ran.velocity[:, 1, 0] - ran.velocity[:, 0, 0]
    assert found == pytest.approx(w, abs=CLOSE * start)
    # What is dissipated is missing from the energy of the relative motion, ½ (m/2) w².
    lost = 0.25 * MASS * (start**2 - w**2)
    assert ran.dissipated == pytest.approx(lost, abs=CLOSE * lost[-1])


def soliton(count, time, *, kappa=1.0, b=3.0):
    """Return displacements and velocities of Toda's soliton at a time, shape (mass,) each."""
    beta = np.sqrt(C / MASS) * np.sinh(kappa)
    n = np.arange(count) - count // 3
    here, before = kappa * n - beta * time, kappa * (n - 1) - beta * time
    place = (np.logaddexp(before, -before) - np.logaddexp(here, -here)) / b
    return place, beta / b * (np.tanh(here) - np.tanh(before))


def test_soliton_of_toda_keeps_its_shape():
    count, b, duration = 70, 3.0, 0.5
    apart = 10.0
    place, speed = soliton(count, 0.0, b=b)
    position, velocity = np.zeros((2, count, 3))
    position[:, 0] = apart * np.arange(count) + place
    velocity[:, 0] = speed
    net = make_net(
        position,
        [[i, i + 1] for i in range(count - 1)],
        mass=MASS,
        stiffness=C,
        rest=apart,
        law=spring("exponential", stiffening=-b * apart),
        velocity=velocity,
    )
    ran = Bench(
        net, duration, fixed=[0, count - 1], tolerance=TIGHT, times=[0.0, duration]
    ).run()
    expected, _ = soliton(count, duration, b=b)
    moved = ran.position[-1, :, 0] - apart * np.arange(count)
    # It has passed some ten masses.
    assert np.sqrt(C / MASS) * np.sinh(1.0) * duration > 10.0
    assert moved == pytest.approx(expected, abs=CLOSE * np.ptp(expected))


@pytest.mark.parametrize(("method", "damping"), viscosities(0.0, 0.05))
def test_energy_is_kept_or_booked_under_every_law_by_every_member(method, damping):
    tolerance = 1e-3 if INTEGRATORS[method].order < 4 else 1e-5
    laws = [
        spring("exponential", stiffening=4.0),
        spring("polynomial", square=1.0, cube=9.0),
        spring("curve", elongations=(-0.5, 0.0, 0.3, 0.6), forces=(-3.0, 0.0, 1.0, 4.0)),
    ]
    for law in laws:
        net = make_net(
            [[0.0, 0.0, 0.0], [1.2, 0.0, 0.0], [0.5, 1.1, 0.0], [0.4, 0.3, 0.9]],
            [[0, 1], [0, 2], [1, 2], [0, 3], [1, 3], [2, 3]],
            mass=MASS, stiffness=C, rest=REST, damping=damping, law=law,
        )  # fmt: skip
        ran = Bench(net, 0.5, method=method, tolerance=tolerance, ledger=True).run()
        assert ran.end.kind == "reached"
        springs = ran.state.springs.behaviour
        r = ran.position[:, net.springs.ends[:, 1]] - ran.position[:, net.springs.ends[:, 0]]
        stored = springs.energy(np.linalg.norm(r, axis=2) - REST).sum(axis=1)
        kinetic = 0.5 * MASS * (ran.velocity**2).sum(axis=(1, 2))
        total = stored + kinetic + ran.dissipated
        assert np.abs(total / total[0] - 1.0).max() < tolerance


def test_springs_with_laws_have_limits_though_none_may_break():
    """Code for laws looks at them in any case."""
    net = bob(0.1, spring("polynomial", cube=1.0))
    inputs = KernelInputs(net, watched=False, ledger=False)
    inputs.update(State.start(net, gravity=np.zeros(3), drag=0.0))
    found = inputs.net(INTEGRATORS["dop853"])
    assert found.near.tolist() == found.near_crush.tolist() == [np.inf]
