"""Errors fall at the order that a member declares, at the end of steps and within them."""

from functools import cache

import numpy as np
import pytest

from tests.engine.members import MEMBERS, brakes, order_under, viscosities
from tests.engine.running import Bench, pair
from tests.engine.test_closed_forms import relaxation
from tests.hand_net import make_net
from tissuec.engine.integrators import INTEGRATORS
from tissuec.engine.run_arrays import slopes

OMEGA = np.sqrt(200.0)  # of the pair
WITHIN = np.linspace(0.0, 1.0, 58)[1:]
# Steps in 1 s at which the leading term of the error prevails and rounding does not show.
COUNTS = {
    2: (256, 512, 1024), 3: (192, 384, 768), 4: (48, 96, 192), 6: (24, 32, 48), 8: (16, 24, 32),
}  # fmt: skip
# Equations of implicit steps are solved to a part of the tolerance, also where steps are fixed.
EXACTLY = 1e-12


def triangle(damping):
    """Return three unequal masses that swing and tumble: forces are not linear, nor planar."""
    return make_net(
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.3, 1.1, 0.0]],
        [[0, 1], [1, 2], [0, 2]],
        mass=[1.0, 1.5, 0.7],
        stiffness=[100.0, 80.0, 60.0],
        damping=damping,
        rest=[0.9, 1.0, 1.2],
        velocity=[[1.0, 0.0, 0.4], [0.0, 2.0, 0.0], [-0.5, 0.3, -1.0]],
    )


def ran(net, name, count, times):
    asked = {"method": name, "step": 1.0 / count, "tolerance": EXACTLY, "times": times}
    found = Bench(net, 1.0, **asked).run()
    assert found.end.kind == "reached"
    return found


@cache
def reference(damping, within):
    times = WITHIN if within else [1.0]
    exact = ran(triangle(damping), "dop853", 200, times)
    return exact.position, exact.velocity


def slope(counts, errors):
    """Return the observed order; the finest errors must stand clear of rounding."""
    assert min(errors) > 2e-12
    return -np.polyfit(np.log(counts), np.log(errors), 1)[0]


@pytest.mark.parametrize(("name", "ratio"), viscosities(0.0, 0.2))
def test_error_of_an_oscillator_falls_at_the_declared_order(name, ratio):
    order = order_under(name, ratio)
    # A quarter of a period apart: amplitudes do not show at one time, phases not at another.
    times = np.array([0.875, 1.0])
    exact = 0.1 * (1.0 - relaxation(ratio, OMEGA, times))
    found = [ran(pair(damping=ratio * OMEGA), name, n, times) for n in COUNTS[order]]
    errors = [np.abs(one.position[:, 0, 0] - exact).max() for one in found]
    # At order 8 a digit of the error is a fifteenth of the range of steps above rounding.
    assert slope(COUNTS[order], errors) == pytest.approx(order, abs=0.1 if order < 8 else 0.2)


@pytest.mark.parametrize(("name", "damping"), viscosities(0.0, 1.0))
def test_errors_of_a_tumbling_triangle_fall_at_the_declared_order(name, damping):
    # Forces that are not linear see all conditions of order, not those of oscillators only.
    order = order_under(name, damping)
    exact = reference(damping, False)
    found = [ran(triangle(damping), name, n, [1.0]) for n in COUNTS[order]]
    for errors in (
        [np.abs(one.position - exact[0]).max() for one in found],
        [np.abs(one.velocity - exact[1]).max() for one in found],
    ):
        # The largest of nine errors changes its place now and then.
        margin = 0.1 if order < 6 else 0.4
        assert slope(COUNTS[order], errors) == pytest.approx(order, abs=margin)


@pytest.mark.parametrize(("name", "damping"), viscosities(0.0, 1.0))
def test_dense_output_is_at_most_one_order_less_exact_than_the_steps(name, damping):
    order = order_under(name, damping)
    exact = reference(damping, True)
    found = [ran(triangle(damping), name, n, WITHIN) for n in COUNTS[order]]
    for errors in (
        [np.abs(one.position - exact[0]).max() for one in found],
        [np.abs(one.velocity - exact[1]).max() for one in found],
    ):
        assert slope(COUNTS[order], errors) > order - 1.1
    ends = reference(damping, False)
    at_ends = np.abs(ran(triangle(damping), name, COUNTS[order][0], [1.0]).position - ends[0])
    within = np.abs(found[0].position - exact[0])
    # And not much worse in size.
    assert within.max() < 20.0 * at_ends.max()


@pytest.mark.parametrize("name", MEMBERS)
def test_dense_output_joins_both_ends_of_each_step(name):
    # One step; samples a rounding off its ends are looked up within it.
    step, sliver = 0.02, 1e-9
    net = triangle(brakes(name, 1.0))
    times = [0.0, sliver * step, (1.0 - sliver) * step, step]
    bench = Bench(net, 1.0, method=name, step=step, tolerance=EXACTLY, times=times)
    bench.advance(step)
    bench.engine.finish(bench.state)
    assert bench.engine.statistics.accepted == 1
    found = bench.ran(None)
    for near, end in ((1, 0), (2, 3)):
        # What moves within the sliver is 1e-9 of the step: velocity 2, acceleration 100.
        assert np.abs(found.position[near] - found.position[end]).max() < 1e-9 * step * 3.0
        assert np.abs(found.velocity[near] - found.velocity[end]).max() < 1e-9 * step * 300.0


def test_positions_within_steps_of_dop853_are_the_integral_of_velocities():
    member = INTEGRATORS["dop853"]
    derivative = member.dense_x * np.arange(1.0, 9.0)[:, None]  # in powers 0 to 7 of the part
    assert derivative[1:] == pytest.approx(member.dense_v, abs=1e-12)
    # Which leads to the result without being told so.
    result = member.tableau.for_x[member.tableau.result]
    assert member.dense_x.sum(axis=0) == pytest.approx(result, abs=1e-12)
    # The other polynomial has the same ends, and speeds there.
    assert member.embedded_x.sum(axis=0) == pytest.approx(0.0, abs=1e-12)
    assert member.embedded_x[0] == pytest.approx(0.0, abs=1e-12)
    assert np.arange(1.0, 9.0) @ member.embedded_x == pytest.approx(0.0, abs=1e-11)
    derivative = member.embedded_x * np.arange(1.0, 9.0)[:, None]
    assert derivative[1:] == pytest.approx(slopes(member.embedded_x), abs=1e-11)


@pytest.mark.parametrize("name", MEMBERS)
def test_dense_weights_of_the_start_are_the_state_there(name):
    # Powers of the step's part: the first is what grows in proportion at the start.
    member = INTEGRATORS[name]
    assert member.dense_x.shape[1] == member.dense_v.shape[1] == member.rows
    rate = np.zeros(member.rows)
    rate[0] = 1.0
    assert np.array_equal(member.dense_x[0], rate)
    rate = np.zeros(member.rows)
    rate[1] = 1.0
    assert member.dense_v[0] == pytest.approx(rate, abs=1e-14)


@pytest.mark.parametrize("name", MEMBERS)
def test_members_describe_themselves(name):
    member = INTEGRATORS[name]
    assert member.order in COUNTS, "say here at which steps this order is to be observed"
    assert len(member.__doc__.split()) > 30
    for flag in ("symplectic", "implicit", "conservative", "stabilised", "promises"):
        assert isinstance(getattr(member, flag), bool)
    assert 1 < member.end_row < member.rows
    assert 1.0 <= member.control_order <= member.order
