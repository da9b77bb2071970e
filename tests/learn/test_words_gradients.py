"""Derivatives of what rules give by the places of words, against differences."""

import math

import numpy as np
import pytest

from tests.every import every
from tests.learn.wordy import everything, random_scene
from tissuec.fuzzy import duals
from tissuec.fuzzy.duals import Dual

SIXTH = {-3: -1 / 60, -2: 9 / 60, -1: -45 / 60, 1: 45 / 60, 2: -9 / 60, 3: 1 / 60}
FOURTH = {-2: 1 / 12, -1: -8 / 12, 1: 8 / 12, 2: -1 / 12}
STEP = 1e-3


def differences(model, theta):
    """Return central differences of the logarithms, of two orders, shape (pair, number)."""
    sixth, fourth = [], []
    for direction in STEP * np.eye(model.size):
        near = {k: model.given(theta + k * direction).values() for k in SIXTH}
        logs = {k: np.log(np.abs(list(values))) for k, values in near.items()}
        sixth.append(sum(w * logs[k] for k, w in SIXTH.items()) / STEP)
        fourth.append(sum(w * logs[k] for k, w in FOURTH.items()) / STEP)
    return np.array(sixth).T, np.array(fourth).T


def test_derivatives_of_random_vocabularies_are_those_of_differences():
    compared = left_out = telling = 0
    for seed in range(3):
        model = everything(random_scene(seed))
        theta = 0.4 * np.random.default_rng(seed).normal(size=model.size)
        pairs, found = model.jacobian(theta)
        assert pairs == model.pairs
        sixth, fourth = differences(model, theta)
        # Between the places looked at, a kink shows as differences that differ.
        smooth = np.abs(sixth - fourth) < 1e-8 * (1 + np.abs(sixth))
        compared, left_out = compared + smooth.sum(), left_out + (~smooth).sum()
        telling += (np.abs(found[smooth]) > 1e-3).sum()
        # Truncation is of the order of h^6 = 1e-18, rounding of 1e-16 / h = 1e-13.
        assert np.all(np.abs(found - sixth)[smooth] < 1e-9 * (1 + np.abs(found[smooth])))
    assert compared > 300 and telling > 60
    # Gradual rules have kinks where words become fully true as well.
    assert left_out < 0.03 * compared


@every("seed", range(12))
def test_nothing_moves_at_zero(seed):
    scene = random_scene(seed)
    given = everything(scene).given(np.zeros(everything(scene).size))
    for (tissue, quantity), value in given.items():
        assert value == scene.tissues[tissue].given[quantity].value  # bit for bit


@every("seed", range(12))
def test_values_with_derivatives_are_those_without(seed):
    model = everything(random_scene(seed))
    theta = np.random.default_rng(seed).normal(size=model.size)
    pairs, values, _ = model.linearised(theta)
    assert dict(zip(pairs, values.tolist(), strict=True)) == model.given(theta)


FUNCTIONS = {
    "sum": lambda x, y: x + y + 1.0 + (2.0 + x),
    "difference": lambda x, y: (x - y) - 1.0 - (3.0 - y),
    "product": lambda x, y: x * y * 2.0 * (3 * x),
    "quotient": lambda x, y: x / y / 2.0 + 1.0 / x,
    "power": lambda x, y: x**2 + y**0.5,
    "signs": lambda x, y: -x + abs(-y) + abs(+x),
    "exp": lambda x, y: duals.exp(x * y),
    "log": lambda x, y: duals.log(x / y),
    "sqrt": lambda x, y: duals.sqrt(x + y),
    "erfc": lambda x, y: duals.erfc(x - y),
    "fsum": lambda x, y: duals.fsum([x, y, 1.0]),
    "snapped": lambda x, y: duals.snapped(x * y, x * y) + duals.real(y),
}


@every("name", FUNCTIONS)
def test_duals_carry_slopes_through_arithmetic(name):
    function, h = FUNCTIONS[name], 1e-5
    x, y = 0.7, 1.3
    found = function(Dual(x, np.array([1.0, 0.0])), Dual(y, np.array([0.0, 1.0])))
    assert found == function(x, y) and type(function(x, y)) is float
    by_x = (function(x + h, y) - function(x - h, y)) / (2 * h)
    by_y = (function(x, y + h) - function(x, y - h)) / (2 * h)
    # Rounding of differences: 1e-16 / 1e-5.
    assert found.slopes == pytest.approx([by_x, by_y], abs=1e-9)


def test_what_is_infinitely_steep_has_no_slope():
    zero = Dual(0.0, np.array([1.0]))
    assert duals.slopes_of(duals.sqrt(zero), 1).tolist() == [0.0]
    assert duals.slopes_of(zero**0.5, 1).tolist() == [0.0]
    assert math.isfinite(zero**0.5)
