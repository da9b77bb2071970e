"""Orders, coefficients and stability limits that the integrators declare."""

import numpy as np
import pytest
from scipy.integrate._ivp import dop853_coefficients as published

from tests.engine.running import TIERS, Bench, pair
from tests.engine.test_closed_forms import relaxation
from tissuec.integrators import INTEGRATORS
from tissuec.kernels import tableau853


def error_at(method, step, ratio, tier="interpreted"):
    """Return the error of a damped pair at 1 s, which the steps divide."""
    omega = np.sqrt(200.0)
    bench = Bench(
        pair(damping=ratio * omega), 1.0, method=method, step=step, times=[1.0], tier=tier
    )
    ran = bench.run()
    exact = 0.1 * (1.0 - relaxation(ratio, omega, 1.0))
    return abs(ran.position[0, 0, 0] - exact)


@pytest.mark.parametrize("tier", TIERS)
@pytest.mark.parametrize("ratio", [0.0, 0.05, 0.5])
def test_velocity_verlet_is_of_second_order_also_with_viscosity(ratio, tier):
    steps = 1.0 / np.array([128, 256, 512, 1024])
    errors = [error_at("velocity verlet", step, ratio, tier) for step in steps]
    observed = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert observed == pytest.approx(INTEGRATORS["velocity verlet"].order, abs=0.1)


@pytest.mark.parametrize("ratio", [0.0, 0.05])
def test_dop853_is_of_eighth_order(ratio):
    steps = 1.0 / np.array([12, 16, 24, 32])
    errors = [error_at("dop853", step, ratio) for step in steps]
    observed = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert observed == pytest.approx(INTEGRATORS["dop853"].order, abs=0.4)
    assert min(errors) > 1e-13  # above rounding, which would flatten the slope


def test_dense_output_of_dop853_is_of_seventh_order():
    times = np.linspace(0.0, 1.0, 57)
    errors, steps = [], 1.0 / np.array([10, 14, 20])
    for step in steps:
        ran = Bench(pair(), 1.0, method="dop853", step=step, times=times).run()
        exact = 0.1 * (1.0 - relaxation(0.0, np.sqrt(200.0), ran.time))
        errors.append(np.abs(ran.position[:, 0, 0] - exact).max())
    observed = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert 6.6 < observed < 8.6


def test_coefficients_of_dop853_are_the_published_ones():
    assert np.array_equal(tableau853.A, published.A)
    assert np.abs(tableau853.C - published.C).max() < 2e-16
    assert np.array_equal(tableau853.D, published.D)
    assert tableau853.E5[:13] == pytest.approx(published.E5, abs=0.0)
    assert tableau853.E3[:13] == pytest.approx(published.E3, abs=0.0)


def test_coefficients_of_dop853_fulfil_order_conditions():
    a, b, c = tableau853.A, tableau853.B, tableau853.C
    assert a.sum(axis=1) == pytest.approx(c, abs=2e-14)  # weights up to 43 cancel here
    for power in range(8):
        assert b @ c**power == pytest.approx(1.0 / (power + 1), abs=1e-14)
    # Two of the bushy trees: Σ b c^k A c^l = 1 / ((l + 1)(k + l + 2)) up to order 8.
    for k in range(6):
        for low in range(1, 6 - k):
            expected = 1.0 / ((low + 1) * (k + low + 2))
            assert (b * c**k) @ a @ c**low == pytest.approx(expected, abs=1e-13)


@pytest.mark.parametrize("name", sorted(INTEGRATORS))
def test_dense_weights_meet_the_state_at_the_end_of_the_step(name):
    member = INTEGRATORS[name]
    # θ = 1: all powers add up; a polynomial motion x = t² has v = 2t, a = 2 at every stage.
    weights = member.dense_x.sum(axis=0), member.dense_v.sum(axis=0)
    assert weights[0][0] == pytest.approx(1.0, abs=1e-12)
    assert weights[0][1:].sum() == pytest.approx(0.5, abs=1e-11)
    assert weights[1][0] == pytest.approx(0.0, abs=1e-12)
    assert weights[1][1:].sum() == pytest.approx(1.0, abs=1e-11)


@pytest.mark.parametrize("name", sorted(n for n in INTEGRATORS if INTEGRATORS[n].promises))
@pytest.mark.parametrize("ratio", [0.0, 0.3, 2.0])
def test_steps_are_stable_just_below_the_declared_limit_and_not_far_above(name, ratio):
    omega = np.sqrt(200.0)
    limit = INTEGRATORS[name].stability_limit(omega, ratio)

    def growth(step):
        count = 400
        ran = Bench(
            pair(damping=ratio * omega), count * step, method=name, step=step, times=[0.0]
        ).run()
        if ran.end.kind != "reached":
            return np.inf
        length = np.diff(ran.situation.position[:, 0])[0]
        return abs(length - 1.0) / 0.2

    assert growth(0.97 * limit) < 5.0
    assert growth(1.2 * limit) > 1e3


@pytest.mark.parametrize("name", sorted(INTEGRATORS))
def test_members_describe_themselves(name):
    member = INTEGRATORS[name]
    assert member.order >= 1
    assert len(member.__doc__.split()) > 30
    assert isinstance(member.symplectic, bool)
    assert isinstance(member.implicit, bool)
