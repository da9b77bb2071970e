"""Dashpots of elongation and speed: motions against SciPy's, with a rate of our own."""

from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.engine.integrators.test_orders import COUNTS, EXACTLY, slope
from tests.engine.members import affordable, order_under, those
from tests.engine.running import Bench
from tests.hand_net import make_net
from tissuec.laws import LINEAR, REST, D, E, Law, W
from tissuec.laws.formula import apply

MASS, C, VISCOSITY, LENGTH, K = 0.01, 4.0, 0.04, 1.0, 6.0
DURATION = 0.8
TIMES = np.linspace(0.0, DURATION, 9)
START = np.array([1.3, 0.0, 0.0, 4.0])  # place and velocity in a plane: it swings and turns
BRAKING = those(conservative=False)
#: Formula, and the same as a function of e and w.
DASHPOTS = {
    "thickening": (D * (1.0 + K * E / REST) * W, lambda e, w: VISCOSITY * (1 + K * e) * w),
    "stretched only": (
        D * K * apply("max", (E / REST, 0.0 * E / REST)) * W,
        lambda e, w: VISCOSITY * K * max(e, 0.0) * w,
    ),
}


@cache
def exact(name):
    """Return places, velocities and losses at the times, shape (time, 5)."""
    brake = DASHPOTS[name][1]

    def rate(t, y):
        length = np.hypot(y[0], y[1])
        e, w = length - LENGTH, (y[0] * y[2] + y[1] * y[3]) / length
        fall = -(C * e + brake(e, w)) / MASS / length
        return [y[2], y[3], fall * y[0], fall * y[1], brake(e, w) * w]

    # Corners are met with steps as small as the tolerance asks for.
    run = solve_ivp(
        rate, (0.0, DURATION), np.append(START, 0.0), method="DOP853", rtol=1e-13, atol=1e-15,
        t_eval=TIMES,
    )  # fmt: skip
    return run.y.T


def net(name="thickening"):
    law = Law(name, LINEAR.elastic, DASHPOTS[name][0])
    place, speed = np.zeros((2, 3)), np.zeros((2, 3))
    place[1, :2], speed[1, :2] = START[:2], START[2:]
    return make_net(
        place, [[0, 1]], mass=MASS, stiffness=C, damping=VISCOSITY, rest=LENGTH, law=law,
        velocity=speed,
    )  # fmt: skip


def swung(name="thickening", **asked):
    ran = Bench(net(name), DURATION, fixed=[0], times=TIMES, **asked).run()
    assert ran.end.kind == "reached"
    return ran


def apart(ran, name="thickening"):
    return np.linalg.norm(ran.position[:, 1, :2] - exact(name)[:, :2], axis=1)


@pytest.mark.parametrize("method", BRAKING)
def test_every_member_follows_a_dashpot_of_elongation_and_speed(method):
    tolerance = affordable(method)
    ran = swung(method=method, tolerance=tolerance)
    assert (apart(ran) <= tolerance * ran.largest_displacement).all()


def test_energy_that_such_a_dashpot_takes_is_booked():
    ran = swung(tolerance=1e-10, ledger=True)
    lost = exact("thickening")[:, 4]
    assert ran.dissipated == pytest.approx(lost, abs=1e-8 * lost[-1])
    e = np.linalg.norm(ran.position[:, 1], axis=1) - LENGTH
    total = 0.5 * C * e**2 + 0.5 * MASS * (ran.velocity**2).sum(axis=(1, 2)) + ran.dissipated
    assert total == pytest.approx(total[0], rel=1e-8)


@pytest.mark.parametrize("method", BRAKING)
def test_errors_under_such_a_dashpot_fall_at_the_declared_order(method):
    order = order_under(method, VISCOSITY)
    counts = COUNTS[order]
    found = [swung(method=method, step=DURATION / count, tolerance=EXACTLY) for count in counts]
    errors = [apart(ran)[-1] for ran in found]
    assert slope(counts, errors) == pytest.approx(order, abs=0.15 if order < 6 else 0.6)


@pytest.mark.parametrize("tolerance", [1e-5, 1e-9])
def test_a_corner_in_elongation_of_a_dashpot_is_landed_on(tolerance):
    """Steps across the corner leave 9 and 83 % of what is allowed; landed on, a fraction."""
    ran = swung("stretched only", tolerance=tolerance)
    assert ran.engine.stepper.inputs.features.cornered
    allowed = 0.01 * tolerance * ran.largest_displacement
    assert (apart(ran, "stretched only") <= allowed).all()


def test_a_spring_breaks_by_what_such_a_dashpot_adds():
    """Drawn at a constant speed, c e + d (1 + k e) w reaches the limit at a known time."""
    law, speed, limit = Law("free", LINEAR.elastic, DASHPOTS["thickening"][0]), 0.5, 0.3
    pair = make_net(
        [[0, 0, 0], [LENGTH, 0, 0]], [[0, 1]], mass=1e6, stiffness=C, damping=VISCOSITY,
        rest=LENGTH, law=law, velocity=[[0, 0, 0], [speed, 0, 0]], strength=limit,
    )  # fmt: skip
    bench = Bench(pair, 1.0, fixed=[0], tolerance=1e-9, ruptures=True)
    end = bench.advance(1.0)
    # So heavy a mass keeps its speed to 1e-7 of it.
    expected = (limit - VISCOSITY * speed) / (C + VISCOSITY * K * speed) / speed
    assert end.kind == "ruptured"
    assert bench.state.time == pytest.approx(expected, rel=1e-6)
