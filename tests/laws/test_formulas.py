"""Formulas: derivatives, code and what they read back as, against one another and NumPy."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.examples import examples
from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.laws import LINEAR, Law, code
from tissuec.laws.formula import (
    Applied,
    Choice,
    Constant,
    Formula,
    Spline,
    Variable,
    apply,
    kinks,
    values_at,
)
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

X, Y = Variable("e"), Variable("c")
PIECES = ((0.0, 1.0, 2.0, -1.0), (2.0, 1.5, 0.0, 0.0))
NUMBERS = st.floats(-3.0, 3.0).map(lambda x: round(x, 3))


def trees():
    leaves = st.one_of(st.just(X), st.just(Y), NUMBERS.map(Constant))

    def larger(inner):
        pair = st.tuples(inner, inner)
        return st.one_of(
            pair.map(lambda two: two[0] + two[1]),
            pair.map(lambda two: two[0] - two[1]),
            pair.map(lambda two: two[0] * two[1]),
            pair.map(lambda two: two[0] / (2.0 + two[1] * two[1])),
            inner.map(lambda one: (1.5 + one * one) ** 1.5),
            inner.map(lambda one: one**3),
            inner.map(lambda one: Applied("sin", one)),
            inner.map(lambda one: Applied("cos", one)),
            inner.map(lambda one: Applied("exp", Applied("sin", one))),
            inner.map(lambda one: Applied("sqrt", 1.0 + one * one)),
            inner.map(lambda one: Applied("log", 1.0 + one * one)),
            st.tuples(inner, inner, inner).map(lambda three: Choice(*three)),
            pair.map(lambda two: apply("max", two)),
            inner.map(lambda one: apply("abs", (one,))),
            inner.map(lambda one: Spline(one, (0.0, 1.0), PIECES, -0.5)),
        )  # fmt: skip

    return st.recursive(leaves, larger, max_leaves=8)


def near(test, x, y):
    """Tell whether a place is so near to a kink that a difference sees both sides."""
    values = [float(test.at({"e": z, "c": y})) for z in (x - 1e-5, x, x + 1e-5)]
    return min(values) <= 0.0 <= max(values)


@settings(max_examples=examples(150))
@given(trees(), st.floats(-2.0, 2.0), st.floats(-2.0, 2.0))
def test_derivatives_are_limits_of_differences(tree, x, y):
    if any(near(test, x, y) for test in kinks(tree, "e")):
        return

    def at(z):
        return float(tree.at({"e": z, "c": y}))

    slope = float(tree.slope("e").at({"e": x, "c": y}))
    steep = abs(float(tree.slope("e").slope("e").at({"e": x, "c": y})))
    if abs(at(x)) > 1e6 or steep > 1e6:
        return
    h = 1e-6
    difference = (at(x + h) - at(x - h)) / (2.0 * h)
    assert slope == pytest.approx(difference, rel=1e-4, abs=1e-4 * (1.0 + steep))


@settings(max_examples=examples(150))
@given(trees(), st.floats(-2.0, 2.0), st.floats(-2.0, 2.0))
def test_code_means_what_arrays_give_and_reads_back(tree, x, y):
    expected = float(tree.at({"e": x, "c": y}))
    names = {**vars(math), "spline": code.spline}
    assert eval(tree.code(), names, {"e": x, "c": y}) == pytest.approx(expected, rel=1e-12)
    again = code.parse(tree.code())
    assert float(again.at({"e": x, "c": y})) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    "text", ["__import__('os')", "e.real", "[1]", "e if e else c", "e > 1"]
)
def test_nothing_else_is_read_as_a_formula(text):
    with pytest.raises((ValueError, KeyError)):
        code.parse(text)


def test_functions_of_a_net_choose_by_number_and_are_named_by_what_they_do():
    cubic = Law("cubic", Y * X + 3.0 * X**3, LINEAR.viscous)
    other = Law("other", Y * X + 4.0 * X**3, LINEAR.viscous)
    made = code.functions((LINEAR, cubic))
    assert made["pull"](0, 2.0, 5.0, 1.0) == 10.0
    assert made["pull"](1, 2.0, 5.0, 1.0) == 34.0
    assert made["slope"](1, 2.0, 5.0, 1.0) == 41.0
    assert made["brake"](1, 7.0, 2.0, 5.0, 1.0) == 10.0
    assert made["brake_by_e"](1, 7.0, 2.0, 5.0, 1.0) == 0.0
    again = code.functions((LINEAR, other))
    assert made["pull"].__name__ != again["pull"].__name__
    assert made["brake"].__name__ == code.functions((LINEAR,))["brake"].__name__


def test_what_is_zero_or_one_is_left_out():
    assert (X * 0.0).code() == "(0.0)"
    assert (X * 1.0 + 0.0).code() == "e"
    assert (X**1.0 / 1.0).code() == "e"
    assert np.asarray((X**0.0).at({"e": 3.0})) == 1.0


LONG_LAW = """language 1
tissue cord {{ spring constant = 40 N/m; viscosity = 5 mN*s/m; mass = 10 g
  spring force of e = {}
}}
body rope {{ mesh is explicit; tissue is cord }}
table nodes of rope in mm with columns "id x" {{ 0 0; 1 10; 2 21 }}
table springs of rope with columns "a b" {{ 0 1; 1 2 }}
environment {{ gravity = (0, 0, 0) m/s^2 }}
simulate {{ duration = 1 ms }}
"""


def compiled(formula):
    source = Source("cord.tis", LONG_LAW.format(formula))
    return compile_request(Request(source))[0]


@pytest.mark.parametrize("sign", ["+", "-"])
def test_a_law_of_hundreds_of_terms_is_their_sum_and_runs(sign):
    found = compiled(f" {sign} ".join(f"{k} N/m * e" for k in range(1, 400)))
    law, e = found.network.springs.laws[1], np.array([-0.3, 0.01, 0.2])
    total = sum(range(2, 400)) * (1.0 if sign == "+" else -1.0) + 1.0
    # Each of 400 terms rounds once.
    np.testing.assert_allclose(law.elastic.at({"e": e}), total * e, rtol=400 * 2.0**-52)
    pull = code.functions(tuple(found.network.springs.laws))["pull"]
    np.testing.assert_allclose(pull(1, 0.01, 40.0, 0.01), 0.01 * total, rtol=400 * 2.0**-52)


def test_a_law_of_many_factors_is_their_product():
    law = compiled("1 N" + " * (e / 1 m) / (2 + e / 1 m)" * 30).network.springs.laws[1]
    e = np.array([-0.3, 0.01, 0.2])
    np.testing.assert_allclose(law.elastic.at({"e": e}), (e / (2 + e)) ** 30, rtol=1e-13)


@pytest.mark.parametrize("function", ["max", "min"])
def test_the_extreme_of_many_is_that_of_all(function):
    of = ", ".join(f"{k} mm - {k % 3} * e" for k in range(1, 12))
    law = compiled(f"1 N/m * {function}({of})").network.springs.laws[1]
    e = np.linspace(-0.1, 0.1, 41)
    wanted = [getattr(np, function)([1e-3 * k - k % 3 * x for k in range(1, 12)]) for x in e]
    np.testing.assert_allclose(law.elastic.at({"e": e}), wanted, rtol=1e-14)


TOO_LONG = {
    "terms": " + ".join(f"{k} N/m * e" for k in range(1, 3000)),
    "nested choices": "1 N/m * " + "abs(1 mm - " * 40 + "e" + ")" * 40,
    "nested functions": "1 N * " + "exp(1 + e / 1 m * " * 45 + "1" + ")^2" * 45,
    "extremes": f"1 N/m * max({', '.join(f'abs({k} mm - e)' for k in range(99))})",
}


@pytest.mark.parametrize("name", TOO_LONG)
def test_a_law_that_cannot_be_compiled_is_refused(name):
    with pytest.raises(CompileError) as failure:
        compiled(TOO_LONG[name])
    assert [one.code for one in failure.value.diagnostics] == ["TIS116"]


@pytest.mark.parametrize(
    "formula",
    [
        "1 N * " + "exp(e / 1 m * (1 + e / 1 m) * " * 45 + "1" + ")" * 45,
        "1 N * " + "1 / (1 + e / 1 m * " * 48 + "2" + ")" * 48,
    ],
)
def test_a_law_as_deep_as_is_allowed_compiles(formula):
    code.functions(tuple(compiled(formula).network.springs.laws))


class Counted(Formula, frozen=True):
    """A variable that counts how often it is evaluated."""

    calls: list[int]

    def from_parts(self, values, of):
        self.calls.append(1)
        return values["e"]


def test_what_formulas_share_is_evaluated_once():
    shared = Applied("exp", Counted([]))
    one, other = values_at([shared * shared, shared + 1.0], {"e": np.array([0.0, 1.0])})
    assert len(shared.argument.calls) == 1
    assert one.tolist() == (np.exp([0.0, 1.0]) * np.exp([0.0, 1.0])).tolist()
    assert other.tolist() == (np.exp([0.0, 1.0]) + 1.0).tolist()
