"""Every law of a solid: at rest it is that of its shear modulus, and the reference agrees."""

import numpy as np
import pytest

from tissuec.autodiff.derivatives import gradient
from tissuec.autodiff.evaluation import evaluate
from tissuec.autodiff.graph import Graph
from tissuec.laws import derivatives
from tissuec.laws.formula import Variable, exp
from tissuec.laws.principal import PrincipalSum, power_sum, squared_logarithms
from tissuec.laws.solid import SOLID_LAWS
from tissuec.laws.solid.volume import is_whole
from tissuec.laws.tracing import traced
from tissuec.laws.uniaxial import OfTension
from tissuec.validate.forces.solid_laws import derived, slopes_of

SAMPLES = {
    "neo hookean": {},
    "coupled neo hookean": {},
    "mooney rivlin": {"share": 0.3},
    "yeoh": {"second": 0.6, "third": 1.8},
    "exponential": {"stiffening": 0.4},
    "veronda westmann": {"stiffening": 0.3},
    "arruda boyce": {"segments": 4.0},
    "saint venant kirchhoff": {},
    "holmes mow": {"exponent": 0.6},
    "unconstrained ogden": {
        "exponent": 5.3,
        "second_exponent": -3.1,
        "second_share": 0.4,
        "third_exponent": 1.7,
        "third_share": 0.2,
    },
    "hencky": {},
    "ogden": {
        "exponent": 8.7,
        "second_exponent": -3.1,
        "second_share": 0.4,
        "third_exponent": 1.3,
        "third_share": 0.1,
    },
}
#: Without those of ``test_whole_laws``.
KEEPING = {
    name: each for name, each in SAMPLES.items() if not is_whole(SOLID_LAWS[name](**each))
}
FIRST, SECOND = np.array([3.0, 3.05, 3.4, 4.1]), np.array([3.0, 3.04, 3.5, 4.3])


def test_every_law_has_a_sample():
    assert set(SAMPLES) == set(SOLID_LAWS)


@pytest.mark.parametrize("name", KEEPING)
def test_at_rest_a_law_has_its_shear_modulus(name):
    law, rest = SOLID_LAWS[name](**SAMPLES[name]), {"i1": 3.0, "i2": 3.0, "trace": 3.0}
    assert law.energy().at(rest) == pytest.approx(0.0, abs=1e-15)
    # Near rest, I1 and I2 grow alike, so that both count for the shear modulus.
    slopes = derivatives.by_first(law).at(rest) + derivatives.by_second(law).at(rest)
    assert slopes == pytest.approx(0.5, rel=1e-14)


@pytest.mark.parametrize("name", KEEPING)
def test_the_reference_has_the_same_slopes(name):
    law = SOLID_LAWS[name](**SAMPLES[name])
    values = {"i1": FIRST, "i2": SECOND}
    own = slopes_of(law)(FIRST, SECOND)
    for mine, theirs in zip((derivatives.by_first, derivatives.by_second), own, strict=True):
        np.testing.assert_allclose(mine(law).at(values) + 0.0 * FIRST, theirs, rtol=1e-12)


#: Squares of stretches, of which two or all are the same, or nearly.
ALIKE = [
    (1.0, 1.0),
    (1.0, 1.0 + 1e-9),
    (1.7, 1.7),
    (1.7, 1.7 + 1e-7),
    (0.3, 0.3),
    (0.5, 2.0),
    (9.0, 0.2),
]


@pytest.mark.parametrize(
    "exponent", [-15.3, -2.0, 0.0, 0.3, 1.0, 2.0, 3.0 + 1e-9, 4.0, 8.7, 20.0]
)
@pytest.mark.parametrize("squares", ALIKE)
def test_sums_of_stretches_have_slopes_where_stretches_coincide(squares, exponent):
    """Against means of differences: D[h] is the mean of h''/2 over a triangle."""
    x = np.array([*squares, 1.0 / np.prod(squares)])
    values = {"i1": x.sum(), "i2": (1.0 / x).sum()}
    tree, p = PrincipalSum(exponent), 0.5 * exponent
    places, weights = np.polynomial.legendre.leggauss(150)
    u, v = np.meshgrid(0.5 + 0.5 * places, 0.5 + 0.5 * places)
    weight = 0.25 * np.outer(weights, weights) * u
    # Hermite and Genocchi: the triangle by its sides, of which the inner one shrinks with u.
    at = x[0] + u * (x[1] - x[0]) + u * v * (x[2] - x[1])

    def difference(bend):
        return float((weight * bend(at)).sum())

    if exponent == 0.0:
        expected = difference(lambda z: 0.5 / z), difference(lambda z: 0.5 / z**2)
    else:
        expected = (
            p * (p + 1.0) * p * difference(lambda z: z ** (p - 1.0)),
            -p * p * (p - 1.0) * difference(lambda z: z ** (p - 2.0)),
        )
    found = [float(tree.slope(name).at(values)) for name in ("i1", "i2")]
    np.testing.assert_allclose(
        found, expected, rtol=1e-10, atol=1e-12 * max(map(abs, expected))
    )
    energy = float(tree.at(values))
    stretch = np.sqrt(x)
    own = np.log(stretch) ** 2 if exponent == 0.0 else stretch**exponent - 1.0
    assert energy == pytest.approx(own.sum(), rel=1e-12, abs=1e-14)


def test_exponents_that_are_variables_give_the_same_as_numbers():
    """Slopes are also differentiated by the exponent: against differences in it."""
    squares = np.array(ALIKE)
    x = np.column_stack([squares, 1.0 / squares.prod(axis=1)])
    values = {"i1": x.sum(axis=1), "i2": (1.0 / x).sum(axis=1)}
    tree = PrincipalSum(Variable("a"))
    for exponent in (-15.3, -2.0, 0.3, 1.0, 2.0, 4.0, 8.7, 20.0, 40.0):
        for name in values:
            found = tree.slope(name).at(values | {"a": exponent})
            expected = PrincipalSum(exponent).slope(name).at(values) + 0.0 * found
            size = max(np.abs(expected).max(), abs(exponent))
            # Squaring eight times makes 256 roundings of one.
            np.testing.assert_allclose(found, expected, 2e-12, 2e-12 * size)

            def at(step, name=name, exponent=exponent):
                return PrincipalSum(exponent + step).slope(name).at(values)

            graph = Graph()
            inputs = {each: graph.input(each) for each in (*values, "a")}
            by = gradient(traced(tree.slope(name), inputs), [inputs["a"]])
            (found,) = evaluate(by, values | {"a": exponent})
            step = 1e-3  # differences of sixth order leave 1e-12 of rounding over 1e-3
            pairs = zip((45.0, -9.0, 1.0), (1, 2, 3), strict=True)
            terms = (part * (at(k * step) - at(-k * step)) for part, k in pairs)
            expected = sum(terms) / (60.0 * step)
            np.testing.assert_allclose(found, expected, 1e-8, 1e-8 * size)


def test_sums_of_stretches_are_known_to_the_reference():
    """A law of another package, for which the reference has no closed form."""
    tree = 0.5 * power_sum(3.3) + squared_logarithms()
    values = {"i1": FIRST, "i2": SECOND}
    for name in values:
        value, slope = derived(tree, values, name)
        np.testing.assert_allclose(value, tree.at(values), rtol=1e-12, atol=1e-14)
        np.testing.assert_allclose(slope, tree.slope(name).at(values), rtol=1e-12)


def test_the_solid_of_a_curve_is_known_to_the_reference():
    """Before rest, at rest, within the curve and behind it."""
    strain = Variable("strain")
    law = OfTension(5e3 / 3.0 * (exp(3.0 * strain) - 1.0), 5e3)
    tree, i1 = law.energy(), np.array([2.9, 3.0, 3.05, 3.4, 9.0, 30.0])
    slope, none = slopes_of(law)(i1, 0.0 * i1)
    assert not none.any()
    # At rest, the curve is that of a strain of 1e-7, with rounding over it.
    np.testing.assert_allclose(tree.slope("i1").at({"i1": i1}), slope, rtol=1e-9)
    np.testing.assert_allclose(tree.slope("i1").at({"i1": i1[2:]}), slope[2:], rtol=1e-11)
    beside = np.imag(slopes_of(law)(i1 + 1e-30j, 0.0 * i1)[0]) / 1e-30
    np.testing.assert_allclose(
        tree.slope("i1").slope("i1").at({"i1": i1[2:]}), beside[2:], 1e-10
    )
    # The energy is the integral of its slope: the curve bends, and then is straight.
    places, weights = np.polynomial.legendre.leggauss(60)
    for end in (3.05, 3.4, 9.0, 16.5, 30.0):
        last = np.sqrt(min(end, 16.5) - 3.0)
        u = last * (0.5 + 0.5 * places)  # √z, of which slopes are smooth
        whole = (
            0.5 * last * weights * 2.0 * u * tree.slope("i1").at({"i1": 3.0 + u * u})
        ).sum()
        whole += max(end - 16.5, 0.0) * float(tree.slope("i1").at({"i1": 30.0}))
        assert float(tree.at({"i1": end})) == pytest.approx(whole, rel=1e-12)


def test_chains_have_their_published_series():
    """Of N = 1, W1 = 1/2 + I1/10 + 11 I1²/350 + 19 I1³/1750 + 519 I1⁴/134750, but for μ."""
    law = SOLID_LAWS["arruda boyce"](segments=1.0)
    series = np.polynomial.Polynomial([1 / 2, 1 / 10, 11 / 350, 19 / 1750, 519 / 134750])
    found = derivatives.by_first(law).at({"i1": FIRST})
    np.testing.assert_allclose(found, 0.5 * series(FIRST) / series(3.0), rtol=1e-14)
    # Chains that are long enough are neo-Hookean.
    long = SOLID_LAWS["arruda boyce"](segments=1e9)
    np.testing.assert_allclose(derivatives.by_first(long).at({"i1": FIRST}), 0.5, rtol=1e-8)
