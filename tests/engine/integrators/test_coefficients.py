"""Coefficients fulfil the conditions of order and of stability that their sources state.

Conditions of order are one per rooted tree (E. Hairer, S. P. Nørsett, G. Wanner, Solving
Ordinary Differential Equations I, 1993): theorem II.2.13 for Runge-Kutta methods, II.14.10 for
x'' = a(x), where only trees count whose every other vertex on a way is a velocity. A tree here
is the tuple of what grows from its root.
"""

import numpy as np
import pytest
from scipy.integrate._ivp import dop853_coefficients as published

from tests.engine.members import those
from tests.engine.running import Bench
from tests.hand_net import make_net
from tissuec.engine.backends import interpreter
from tissuec.engine.integrators import (
    INTEGRATORS,
    dop853_coefficients,
    esdirk43,
    rkc2,
    rkn4,
    srkn11,
    trbdf2,
)
from tissuec.engine.operations import OPERATIONS


def forests(size, sizes):
    """Yield all multisets of items whose sizes add up; ``sizes`` holds (size, item)."""

    def grow(start, left, chosen):
        if left == 0:
            yield tuple(chosen)
        for k in range(start, len(sizes)):
            if sizes[k][0] <= left:
                yield from grow(k, left - sizes[k][0], [*chosen, sizes[k][1]])

    return grow(0, size, [])


def trees(order):
    """Return all rooted trees with so many vertices."""
    smaller = [(n, tree) for n in range(1, order) for tree in trees(n)]
    return list(forests(order - 1, smaller))


def size(tree):
    return 1 + sum(map(size, tree))


def density(tree):
    """Return γ: the product of the sizes of all subtrees."""
    return size(tree) * int(np.prod([density(part) for part in tree], dtype=object))


def stage_sums(tree, a):
    """Return the elementary weight of a tree at each stage."""
    value = np.ones(len(a))
    for part in tree:
        value = value * (a @ stage_sums(part, a))
    return value


def defects(weights, a, order):
    """Return by how much the conditions of one order are violated."""
    return [abs(weights @ stage_sums(tree, a) - 1.0 / density(tree)) for tree in trees(order)]


def nystrom_trees(order):
    """Return the trees of x'' = a(x); None stands for a branch that ends in a velocity."""
    branches = [(1, None)]
    branches += [(1 + n, tree) for n in range(1, order - 1) for tree in nystrom_trees(n)]
    return list(forests(order - 1, branches))


def nystrom_size(tree):
    return 1 + sum(1 if part is None else 1 + nystrom_size(part) for part in tree)


def nystrom_density(tree):
    below = [(nystrom_size(p) + 1) * nystrom_density(p) for p in tree if p is not None]
    return nystrom_size(tree) * int(np.prod(below, dtype=object))


def nystrom_sums(tree, a, c):
    value = np.ones(len(c))
    for part in tree:
        value = value * (c if part is None else a @ nystrom_sums(part, a, c))
    return value


def worst_of_nystrom(of_x, of_v, a, c, order):
    """Return the largest defect of the conditions of one order for x'' = a(x).

    Positions are of the same order if velocities are: those conditions are of one less.
    """
    of_velocity = [
        abs(of_v @ nystrom_sums(tree, a, c) - 1.0 / nystrom_density(tree))
        for tree in nystrom_trees(order)
    ]
    of_position = [
        abs(of_x @ nystrom_sums(tree, a, c) - 1.0 / (order * nystrom_density(tree)))
        for tree in nystrom_trees(order - 1)
    ]
    return max([*of_velocity, *of_position])


def test_trees_are_as_many_as_tables_say():
    # Hairer, Nørsett & Wanner 1993, tables II.2.3 and II.14.3.
    assert [len(trees(n)) for n in range(1, 8)] == [1, 1, 2, 4, 9, 20, 48]
    assert [len(nystrom_trees(n)) for n in range(1, 8)] == [1, 1, 2, 3, 6, 10, 20]


def test_srkn11_fulfils_all_conditions_up_to_order_6_and_no_further():
    # Blanes & Moan 2002, table 3: coefficients of 15 digits, hence 1e-13.
    kicks, drifts = srkn11.coefficients()
    c = np.append(0.0, np.cumsum(drifts))
    a = np.tril(c[:, None] - c[None, :], -1) * kicks

    def worst(order):
        return worst_of_nystrom(kicks * (1.0 - c), kicks, a, c, order)

    assert max(worst(order) for order in range(2, 7)) < 1e-13
    assert worst(7) > 1e-6


def test_srkn11_is_symmetric():
    kicks, drifts = srkn11.coefficients()
    assert np.array_equal(kicks, kicks[::-1])
    assert np.array_equal(drifts, drifts[::-1])
    assert kicks.sum() == pytest.approx(1.0, abs=1e-15)
    assert drifts.sum() == pytest.approx(1.0, abs=1e-15)


def test_error_estimates_of_srkn11_vanish_up_to_their_orders():
    kicks, drifts = srkn11.coefficients()
    c = np.append(0.0, np.cumsum(drifts))
    a = np.tril(c[:, None] - c[None, :], -1) * kicks
    for estimate, order in zip(srkn11.Srkn11.tableau.error_v, (5, 4), strict=True):
        weights = estimate[1 : srkn11.KICKS + 1]
        for n in range(1, order):
            for tree in nystrom_trees(n):
                assert abs(weights @ nystrom_sums(tree, a, c)) < 1e-13
        assert max(abs(weights @ nystrom_sums(t, a, c)) for t in nystrom_trees(order)) > 1e-3


def test_rkn4_fulfils_all_conditions_up_to_order_4_and_no_further():
    a, c = rkn4.FOR_X[:, :4], rkn4.Rkn4.tableau.for_x[:4, 0]
    of_x, of_v = a[rkn4.RESULT], rkn4.FOR_V[rkn4.RESULT, :4]

    def worst(order):
        return worst_of_nystrom(of_x, of_v, a[:4], c, order)

    assert max(worst(order) for order in range(2, 5)) < 1e-15
    assert worst(5) > 1e-3


def test_velocities_of_rkn4_are_of_order_4_but_for_what_steps_begin_with():
    a, of_v = rkn4.FOR_V[:4, :4], rkn4.FOR_V[rkn4.RESULT, :4]
    assert max(max(defects(of_v, a, order)) for order in range(1, 5)) < 1e-15
    # The next step begins with the acceleration at the end of this one, where the velocity is
    # predicted: to the second order, as order 3 needs.
    assert np.array_equal(rkn4.FOR_X[3], rkn4.FOR_X[rkn4.RESULT])
    c = a.sum(axis=1)
    assert a[3].sum() == pytest.approx(1.0, abs=1e-15)
    assert a[3] @ c == pytest.approx(1.0 / 2.0, abs=1e-15)
    assert abs(a[3] @ c**2 - 1.0 / 3.0) > 0.1


def test_error_estimates_of_rkn4_vanish_up_to_their_orders():
    a, c = rkn4.FOR_X[:4, :4], rkn4.Rkn4.tableau.for_x[:4, 0]
    # For linear forces, whose a'' is that of positions alone, the larger one is of third order.
    linear = np.ones(4), c, a.sum(axis=1)
    assert max(abs(rkn4.THIRD[:4] @ sums) for sums in linear) < 1e-15
    assert rkn4.THIRD[:4] @ (a @ c) == pytest.approx(0.01 / 24.0)
    assert max(abs(rkn4.SECOND[:4] @ sums) for sums in (np.ones(4), c)) < 1e-16
    assert rkn4.SECOND[:4] @ c**2 == pytest.approx(0.018 / 2.0)


@pytest.mark.parametrize(
    ("method", "order", "embedded"),
    [(trbdf2, 2, 3), (esdirk43, 4, 3)],
    ids=["trbdf2", "esdirk43"],
)
def test_implicit_methods_fulfil_all_conditions_up_to_their_orders(method, order, embedded):
    # Hosea & Shampine 1996, section 3; Kennedy & Carpenter 2003, appendix C.
    a = method.WEIGHTS
    for weights, up_to in ((a[-1], order), (method.EMBEDDED, embedded)):
        for n in range(1, up_to + 1):
            assert max(defects(weights, a, n)) < 1e-14
        assert max(defects(weights, a, up_to + 1)) > 1e-4


@pytest.mark.parametrize("method", [trbdf2, esdirk43], ids=["trbdf2", "esdirk43"])
def test_implicit_methods_are_stable_in_the_whole_left_half_and_forget_the_fastest(method):
    a, one = method.WEIGHTS, np.ones(len(method.WEIGHTS))

    def growth(z):
        return abs(1.0 + z * a[-1] @ np.linalg.solve(np.eye(len(a)) - z * a, one))

    # Analytic in the left half plane, so that the imaginary axis bounds it.
    swings = 1j * np.logspace(-3.0, 6.0, 2000)
    assert max(map(growth, swings)) < 1.0 + 1e-13
    assert growth(-1e8) < 1e-6
    assert growth(1e8j) < 1e-6


@pytest.mark.parametrize("name", those(implicit=True))
def test_implicit_methods_have_one_diagonal_and_end_in_their_last_stage(name):
    table = INTEGRATORS[name].tableau
    weights = table.for_v[:, 1:]
    assert table.result == len(weights) - 1
    assert np.array_equal(np.triu(weights, 1), np.zeros_like(weights))
    assert weights[0, 0] == 0.0
    assert np.ptp(np.diag(weights)[1:]) < 1e-15
    assert weights[-1].sum() == pytest.approx(1.0, abs=1e-15)
    assert table.for_x[:, 1:] == pytest.approx(weights @ weights, abs=1e-15)
    assert table.for_x[:, 0] == pytest.approx(weights.sum(axis=1), abs=1e-15)


def stability_polynomial(stages):
    """Return R(z) = 1 - b T(w0) + b T(w0 + w1 z) (Sommeijer, Shampine & Verwer 1998, (2.2))."""
    basis = np.polynomial.chebyshev.Chebyshev.basis(stages)
    w0 = 1.0 + 2.0 / 13.0 / stages**2
    value, rate, second = (basis.deriv(k)(w0) if k else basis(w0) for k in range(3))
    b, w1 = second / rate**2, rate / second
    return lambda z: 1.0 - b * value + b * basis(w0 + w1 * z)


def amplified(z, reach):
    """Return what one step of 1 s makes of speeds that drag takes away at rates -z.

    Args:
        z: Not positive, shape (mass,).
        reach: The largest rate that the step is made for.
    """
    z = np.minimum(z, -1e-300)
    bench = Bench(
        make_net(np.zeros((len(z), 3)), [], mass=-1.0 / z, velocity=[1.0, 0.0, 0.0]),
        1.0,
        method="rkc2",
        drag=1.0,
        tolerance=1e-4,
    )
    bench.engine.restart(bench.state)
    work, net = bench.engine.stepper.work, bench.engine.stepper.acting()
    OPERATIONS["force"](0.0, work.x[0], work.v[0], work.a[0], work.power[1], net)
    work.rate[0] = reach
    interpreter(INTEGRATORS["rkc2"]).bind(rkc2.step)(0.0, 1.0, 0, work, net)
    return bench.engine.stepper.inputs.outwards(work.v[1])[:, 0]


REACHES = (0.0, 1.0, 3.0, 10.0, 100.0, 1000.0, 0.65 * rkc2.MOST_STAGES**2)


@pytest.mark.parametrize("reach", REACHES)
def test_rkc2_is_stable_on_the_whole_real_interval_that_its_stages_are_taken_for(reach):
    z = -np.linspace(0.0, reach, 2001)
    # One rounding per stage.
    assert np.abs(amplified(z, reach)).max() < 1.0 + 1e-12
    if reach >= 3.0:
        # Damped inside, so that no mode is kept for ever (2/3 but for the ends).
        assert (
            np.abs(amplified(-np.linspace(0.2 * reach, 0.9 * reach, 500), reach)).max() < 0.97
        )
    assert np.abs(amplified(np.array([-1.4 * reach - 10.0]), reach)).max() > 1.0


@pytest.mark.parametrize("reach", REACHES)
def test_rkc2_steps_are_the_published_polynomial_of_second_order(reach):
    stages = rkc2.stages_for(reach)
    z = -np.linspace(0.0, max(reach, 1.0), 301)
    assert amplified(z, reach) == pytest.approx(stability_polynomial(stages)(z), abs=1e-9)
    small = -np.array([1e-2, 2e-2])
    excess = amplified(small, reach) - (1.0 + small + small**2 / 2.0)
    # What is left is a multiple of z³, at most that of exp(z), 1/6, and of many stages 0.07.
    assert np.abs(excess / small**3) == pytest.approx([0.11, 0.11], abs=0.06)
    assert amplified(small, reach) == pytest.approx(np.exp(small), abs=2e-6)


def test_coefficients_of_dop853_are_the_published_ones():
    assert np.array_equal(dop853_coefficients.A, published.A)
    assert np.abs(dop853_coefficients.C - published.C).max() < 2e-16
    assert np.array_equal(dop853_coefficients.D, published.D)
    assert dop853_coefficients.E5[:13] == pytest.approx(published.E5, abs=0.0)
    assert dop853_coefficients.E3[:13] == pytest.approx(published.E3, abs=0.0)


def test_coefficients_of_dop853_fulfil_all_conditions_up_to_order_8():
    a, b, c = dop853_coefficients.A, dop853_coefficients.B, dop853_coefficients.C
    assert a.sum(axis=1) == pytest.approx(c, abs=2e-14)  # weights up to 43 cancel here
    for order in range(1, 9):
        assert max(defects(b, a, order)) < 1e-13
