"""Functions of our own, against numbers of 50 digits."""

import ctypes
import math
from decimal import Decimal, localcontext

import numpy as np
import pytest

from tissuec.compiled import mathematics
from tissuec.compiled.loading import machine_code

PI = Decimal("3.14159265358979323846264338327950288419716939937510582097494459")


def compiled(name):
    text = mathematics.defined()
    code = machine_code("mathematics", text.encode(), lambda: text)
    kinds = [ctypes.c_double] * (3 if name == "pow" else 2)
    return ctypes.CFUNCTYPE(*kinds)(code.get_function_address(mathematics.PREFIX + name))


def sine(x, quarters=0):
    """Return sin(x + quarters π/2) by its series."""
    x = Decimal(x) + quarters * PI / 2
    x = term = total = x.remainder_near(2 * PI)
    k = 1
    while abs(term) > Decimal("1e-45"):
        term *= -x * x / ((k + 1) * (k + 2))
        total, k = total + term, k + 2
    return total


EXACT = {
    "exp": lambda x: Decimal(x).exp(),
    "log": lambda x: Decimal(x).ln(),
    "pow": lambda x, y: (Decimal(y) * Decimal(x).ln()).exp(),
    "sin": sine,
    "cos": lambda x: sine(x, 1),
}
CHANCE = np.random.default_rng(3)
ARGUMENTS = {
    "exp": [
        CHANCE.uniform(-700.0, 709.0, 100),
        CHANCE.uniform(-1.0, 1.0, 100),
        CHANCE.normal(scale=1e-8, size=20),
    ],
    "log": [
        np.exp(CHANCE.uniform(-700.0, 700.0, 100)),
        CHANCE.uniform(0.4, 2.5, 100),
        1.0 + CHANCE.normal(scale=1e-9, size=20),
        CHANCE.uniform(1e-320, 1e-310, 20),
    ],
    # Near their zeros, too.
    "sin": [
        CHANCE.uniform(-10.0, 10.0, 100),
        CHANCE.uniform(-1e6, 1e6, 100),
        math.pi * CHANCE.integers(-300_000, 300_000, 50),
    ],
    "cos": [
        CHANCE.uniform(-10.0, 10.0, 100),
        CHANCE.uniform(-1e6, 1e6, 100),
        math.pi * (CHANCE.integers(-300_000, 300_000, 50) + 0.5),
    ],
    "pow": [
        np.stack([CHANCE.uniform(0.2, 5.0, 100), CHANCE.uniform(-5.0, 5.0, 100)], axis=1),
        np.stack([1.0 + CHANCE.normal(scale=1e-5, size=50), 1e4 * CHANCE.normal(size=50)], 1),
    ],
}


@pytest.mark.parametrize("name", mathematics.FUNCTIONS)
def test_errors_are_below_one_unit_in_the_last_place(name):
    function, worst = compiled(name), 0.0
    with localcontext(prec=60):
        for one in np.concatenate(ARGUMENTS[name]):
            arguments = np.atleast_1d(one).tolist()
            exact = EXACT[name](*arguments)
            error = abs(Decimal(function(*arguments)) - exact)
            worst = max(worst, float(error) / np.spacing(abs(float(exact))))
    assert worst < 0.8


def test_powers_near_the_largest_number():
    function, worst = compiled("pow"), 0.0
    with localcontext(prec=60):
        for x in CHANCE.uniform(0.5, 2.0, 100).tolist():
            y = float(CHANCE.uniform(600.0, 700.0)) / math.log(x)
            exact = EXACT["pow"](x, y)
            error = float(abs(Decimal(function(x, y)) - exact))
            worst = max(worst, error / np.spacing(float(exact)))
    assert worst < 40.0


def test_arguments_beyond_2_20_are_off_by_less_than_their_last_place():
    with localcontext(prec=60):
        for x in (10.0 ** CHANCE.uniform(6.1, 15.0, 50)).tolist():
            allowed = np.spacing(x) + 1e-15
            assert abs(Decimal(compiled("sin")(x)) - sine(x)) < allowed
            assert abs(Decimal(compiled("cos")(x)) - sine(x, 1)) < allowed


def test_arguments_at_the_limits():
    exp, log, power = (compiled(name) for name in ("exp", "log", "pow"))
    inf, nan = math.inf, math.nan
    assert [exp(x) for x in (0.0, -0.0, inf, -inf, 800.0, -800.0)] == [1, 1, inf, 0, inf, 0]
    assert [log(x) for x in (1.0, 0.0, -0.0, inf)] == [0.0, -inf, -inf, inf]
    undefined = [exp(nan), log(-1.0), log(nan), power(-2.0, 0.5), power(nan, 1.0)]
    undefined += [compiled("sin")(inf), compiled("cos")(nan), power(2.0, nan)]
    assert all(map(math.isnan, undefined))
    for x in (0.0, 0.5, 2.0, inf, -2.0):
        assert power(x, 0.0) == 1.0
        for y in (3.0, -3.0, 4.0, -4.0, 5000.0, -5000.0):
            try:
                expected = x**y
            except ZeroDivisionError:
                expected = inf
            except OverflowError:
                expected = inf
            assert power(x, y) == expected
    assert exp(-745.0) == 5e-324 and power(10.0, -320.0) == 1e-320
