"""Derivatives of numbers of graphs, against complex steps and against their own formulas."""

import math

import numpy as np
import pytest

from tests.autodiff.graphs import by_complex_steps, formula, random_number
from tests.every import every
from tests.forces.test_fields import POTENTIALS
from tissuec.autodiff import (
    Angle,
    Vector,
    along,
    cos,
    exp,
    gradient,
    hessian,
    log,
    norm,
    sin,
    sqrt,
)
from tissuec.autodiff.evaluation import evaluate
from tissuec.autodiff.graph import Graph, Number

NAMES = ("a", "b", "c")
#: Of derivatives relative to the largest: tens of operations are rounded once each.
ROUNDING = 1e-13


def inputs_of(graph):
    return [graph.input(name) for name in NAMES]


def values(seed):
    return dict(zip(NAMES, np.random.default_rng(seed).uniform(-1.5, 1.5, 3), strict=True))


@every("seed", range(40))
def test_gradients_changes_and_second_derivatives_agree_with_complex_steps(seed):
    inputs, here = inputs_of(Graph()), values(seed)
    number = random_number(inputs, seed)
    slopes, entries = gradient(number, inputs), hessian(number, inputs)
    assert set(entries) == {(i, j) for i in range(3) for j in range(i + 1)}
    found = np.array(evaluate(slopes, here))
    assert np.isfinite(found).all()
    by_steps = [by_complex_steps([number, *slopes], here, name) for name in NAMES]
    expected = np.array([each[0] for each in by_steps])
    second = np.array([each[1:] for each in by_steps])
    assert found == pytest.approx(expected, abs=ROUNDING * np.abs(expected).max())
    # Forwards and backwards are transposes of each other.
    rates = (0.3, -1.0, 0.7)
    (change,) = evaluate(along([number], dict(zip(inputs, rates, strict=True))), here)
    assert change == pytest.approx(found @ rates, abs=ROUNDING * np.abs(found).max())
    allowed = ROUNDING * np.abs(second).max()
    assert second == pytest.approx(second.T, abs=allowed)
    for (i, j), entry in entries.items():
        assert evaluate([entry], here)[0] == pytest.approx(second[j, i], abs=allowed)


#: Functions, and their derivatives at a.
KNOWN = {
    "sum": (lambda a, b: 3.0 * a + b, lambda a, b: 3.0),
    "product": (lambda a, b: a * b * b, lambda a, b: b * b),
    "quotient": (lambda a, b: b / a, lambda a, b: -b / a**2),
    "cube": (lambda a, b: a**3, lambda a, b: 3.0 * a**2),
    "inverse square": (lambda a, b: a**-2, lambda a, b: -2.0 / a**3),
    "power": (lambda a, b: a**b, lambda a, b: b * a ** (b - 1.0)),
    "exponent": (lambda a, b: b**a, lambda a, b: b**a * math.log(b)),
    "root": (lambda a, b: sqrt(a), lambda a, b: 0.5 / math.sqrt(a)),
    "exp": (lambda a, b: exp(b * a), lambda a, b: b * math.exp(a * b)),
    "log": (lambda a, b: log(b * a), lambda a, b: 1.0 / a),
    "sin": (lambda a, b: sin(b * a), lambda a, b: b * math.cos(a * b)),
    "cos": (lambda a, b: cos(b * a), lambda a, b: -b * math.sin(a * b)),
    "norm": (lambda a, b: norm(Vector((a, b, b))), lambda a, b: a / math.hypot(a, b, b)),
    "constant": (lambda a, b: a - a + b, lambda a, b: 0.0),
}


@every("name", KNOWN)
def test_derivatives_have_their_closed_forms(name):
    written, slope = KNOWN[name]
    graph = Graph()
    a, b = graph.input("a"), graph.input("b")
    (found,) = evaluate(gradient(written(a, b), [a]), {"a": 0.7, "b": 1.9})
    assert found == pytest.approx(slope(0.7, 1.9), rel=1e-15, abs=0.0)


def test_what_is_fixed_and_what_an_output_does_not_need_has_no_derivative():
    graph = Graph()
    a, b = graph.input("a"), graph.input("b")
    square = a * a
    by_a, by_b = gradient(square * b, [a, b], fixed=[square])
    assert by_a.value == 0.0 and by_b == square
    assert along([square], {b: 1.0})[0].value == 0.0


def rules_of(name):
    """Yield the results in the potential of a field that have rules, and an inner state."""
    item = POTENTIALS[name]().field.traced
    graph = item.graph
    # Second derivatives meet rules of derivatives, too.
    reached = graph.reached([item.energy, item.dissipation, *item.forces], by_rules=False)
    for place in reached:
        number = Number(graph, place)
        if number.operation.name == "ruled" and formula(number).value is None:
            yield item, number


@every("name", POTENTIALS)
def test_every_rule_is_the_derivative_of_its_formula(name):
    """The value of an angle of which no arc is computed means nothing: its rule has no formula.

    Its cosine and sine have one.
    """
    found = list(rules_of(name))
    chance = np.random.default_rng(1)
    for item, number in found:
        inputs = [*item.x, *item.v, *item.numbers]
        names = [str(each.operation.detail) for each in inputs]
        own = formula(number)
        at = {name: chance.uniform(0.5, 1.5) for name in names}
        expected = np.array(evaluate(gradient(own, [own.graph.input(n) for n in names]), at))
        slopes = np.array(evaluate(gradient(number, inputs), at))
        assert slopes == pytest.approx(expected, abs=1e-11 * np.abs(expected).max()), number


def test_a_norm_has_no_direction_where_it_is_zero():
    graph = Graph()
    components = [graph.input(name) for name in NAMES]
    length = norm(Vector(components))
    at = dict.fromkeys(NAMES, 0.0)
    assert np.array_equal(evaluate(gradient(length, components), at), np.zeros(3))
    assert np.isfinite(evaluate(list(hessian(length, components).values()), at)).all()


def test_versines_of_small_angles_have_all_digits():
    graph = Graph()
    angle = graph.input("angle")
    at = np.array([1e-9, 1e-4, 0.5, 2.0, 3.1])
    (found,) = evaluate([Angle.written(angle).versine], {"angle": at})
    assert found == pytest.approx(2.0 * np.sin(0.5 * at) ** 2, rel=1e-15)
