"""Every law by name: force, stiffness and energy belong together; each has its own shape."""

import warnings

import numpy as np
import pytest
from scipy.integrate import quad

from tissuec.laws import LINEAR, SPRING_LAWS, STRAIN, VISCOSITY_LAWS, Law, with_modulus
from tissuec.laws.evaluation import Behaviour
from tissuec.laws.formula import Variable, apply, exp
from tissuec.laws.uniaxial import OfTension

C, D, REST = 20.0, 0.3, 0.01
MODULUS = 10e3
SPRING = {
    "linear": {},
    "polynomial": {"square": 3e3, "cube": 4e5},
    "exponential": {"stiffening": 12.0},
    "toe": {"strain": 0.03},
    "tension only": {},
    "dead band": {"slack": 4e-4},
    "stress curve": {
        "strains": (-0.1, 0.0, 0.1, 0.2, 0.3),
        "stresses": (-5e3, 0.0, 1e3, 15e3, 15.5e3),
    },
    "curve": {
        "elongations": (-1e-3, 0.0, 1e-3, 2e-3, 3e-3),
        "forces": (-0.1, 0.0, 0.02, 0.3, 0.31),
    },
}  # fmt: skip
VISCOUS = {"linear": {}, "power": {"exponent": 1.5, "speed": 0.1}}
PLACES = np.array([-4e-3, -7e-4, -3e-4, 0.0, 2e-4, 7e-4, 1.3e-3, 2.6e-3, 5e-3])


def law_of(name):
    force = with_modulus(SPRING_LAWS[name](**SPRING[name]).force(), MODULUS)
    return Law(name, force, LINEAR.viscous)


def behaviour(law, count):
    return Behaviour(
        (LINEAR, law),
        np.ones(count, dtype=np.int32),
        np.full(count, C),
        np.full(count, D),
        np.full(count, REST),
    )


def test_every_law_is_tried_here():
    assert set(SPRING) == set(SPRING_LAWS)
    assert set(VISCOUS) == set(VISCOSITY_LAWS)


@pytest.mark.parametrize("name", SPRING)
def test_stiffness_is_the_derivative_of_the_force(name):
    law = law_of(name)
    springs, h = behaviour(law, len(PLACES)), 1e-9
    inside = PLACES + 1e-5  # off the kinks
    difference = (springs.pull(inside + h) - springs.pull(inside - h)) / (2.0 * h)
    assert springs.slope(inside) == pytest.approx(difference, rel=1e-5, abs=1e-5)


@pytest.mark.parametrize("name", SPRING)
def test_energy_is_the_work_of_the_force(name):
    law = law_of(name)
    springs = behaviour(law, 1)
    bends = [-1e-3, -4e-4, 3e-4, 4e-4, 1e-3, 2e-3, 3e-3]
    for place in PLACES:
        within = [b for b in bends if min(place, 0.0) < b < max(place, 0.0)]

        def pull(e):
            return float(springs.pull(np.array([e]))[0])

        work = quad(pull, 0.0, place, points=within or None, epsabs=1e-17, epsrel=1e-13)[0]
        found = float(springs.energy(np.array([place]))[0])
        assert found == pytest.approx(work, rel=1e-11, abs=1e-18)


@pytest.mark.parametrize("power", [0.5, 1.5, 2.5, 1.0 / 3.0])
def test_energies_of_broken_powers_are_exact_to_rounding(power):
    e = Variable("e")
    size = apply("abs", (e,)) ** power
    law = Law("root", size * e, LINEAR.viscous)
    found = behaviour(law, len(PLACES)).energy(PLACES)
    assert found == pytest.approx(np.abs(PLACES) ** (power + 2.0) / (power + 2.0), rel=1e-11)


@pytest.mark.parametrize(("period", "places"), [(3e-4, (1e-3, -4e-2)), (3e-6, (2e-4, 0.01))])
def test_energies_of_waves_are_as_exact_as_their_arguments(period, places):
    """Up to 3000 periods: some hundred points of quadrature would miss them."""
    law = Law("wave", apply("sin", (Variable("e") * (2.0 * np.pi / period),)), LINEAR.viscous)
    phase = 2.0 * np.pi * np.array(places) / period
    found = behaviour(law, len(places)).energy(np.array(places))
    largest = period / np.pi
    assert np.abs(found - 0.5 * largest * (1.0 - np.cos(phase))).max() < 1e-11 * largest


def test_energies_of_a_narrow_peak_are_exact():
    e, width = Variable("e"), 1e-6
    law = Law("peak", e / (1.0 + (e / width) ** 2) ** 2, LINEAR.viscous)
    exact = 0.5 * width**2 * (1.0 - 1.0 / (1.0 + (PLACES / width) ** 2))
    assert behaviour(law, len(PLACES)).energy(PLACES) == pytest.approx(exact, rel=1e-11)


@pytest.mark.parametrize("name", VISCOUS)
def test_dashpots_brake_either_way_and_their_viscosity_is_the_derivative(name):
    law = Law(name, LINEAR.elastic, VISCOSITY_LAWS[name](**VISCOUS[name]).force())
    speeds = np.array([-0.3, -0.01, 0.02, 0.1, 0.4])
    springs, h, e = behaviour(law, len(speeds)), 1e-8, 1e-3 * np.ones_like(speeds)
    assert (springs.brake(e, speeds) * speeds > 0.0).all()
    assert springs.brake(e, -speeds) == pytest.approx(-springs.brake(e, speeds))
    difference = (springs.brake(e, speeds + h) - springs.brake(e, speeds - h)) / (2.0 * h)
    assert springs.brake_slope(e, speeds) == pytest.approx(difference, rel=1e-5)
    assert (springs.brake(e, 0.0 * e) == 0.0).all()


def test_shapes_that_the_names_promise():
    def pull(name, e, **entries):
        law = Law(name, SPRING_LAWS[name](**entries).force(), LINEAR.viscous)
        return float(behaviour(law, 1).pull(np.array([e]))[0])

    assert pull("exponential", 1e-9, stiffening=12.0) == pytest.approx(C * 1e-9, rel=1e-5)
    assert pull("exponential", REST / 12.0, stiffening=12.0) == pytest.approx(
        C * REST / 12.0 * (np.e - 1.0)
    )
    assert pull("toe", 0.03 * REST, strain=0.03) == pytest.approx(0.5 * C * 0.03 * REST)
    assert pull("toe", -1e-3, strain=0.03) == 0.0
    assert pull("tension only", -1e-3) == 0.0
    assert pull("dead band", 3.9e-4, slack=4e-4) == 0.0
    assert pull("dead band", -1e-3, slack=4e-4) == pytest.approx(-C * 6e-4)
    assert pull("curve", 2e-3, **SPRING["curve"]) == pytest.approx(0.3)
    # Straight on behind the last point, without overshoot between the others.
    ahead = [pull("curve", e, **SPRING["curve"]) for e in (3e-3, 4e-3, 5e-3)]
    assert ahead[2] - ahead[1] == pytest.approx(ahead[1] - ahead[0])
    between = [pull("curve", e, **SPRING["curve"]) for e in np.linspace(-1e-3, 3e-3, 101)]
    assert (np.diff(between) >= 0.0).all()


@pytest.mark.parametrize(
    ("name", "entries", "word"),
    [
        ("exponential", {"stiffening": 0.0}, "stiffening"),
        ("curve", {"elongations": (0.0, 1.0), "forces": (0.0,)}, "forces"),
        ("curve", {"elongations": (1.0, 1.0), "forces": (0.0, 1.0)}, "ascend"),
    ],
)
def test_entries_that_make_no_law(name, entries, word):
    with pytest.raises(ValueError, match=word):
        SPRING_LAWS[name](**entries)


def test_a_power_below_one_is_infinitely_stiff_at_rest_and_estimates_leave_it_out():
    power = VISCOSITY_LAWS["power"](exponent=0.5, speed=0.1).force()
    springs = behaviour(Law("thinning", LINEAR.elastic, power), 1)
    with np.errstate(divide="ignore"):
        assert np.isinf(springs.brake_slope(np.zeros(1), np.zeros(1)))[0]
        assert springs.sluggishness(np.zeros(1), np.zeros(1))[0] == 0.0


def test_a_law_that_overflows_is_infinite_and_warns_nobody():
    law = Law("steep", apply("exp", (1e6 * Variable("e"),)), LINEAR.viscous)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = behaviour(law, 2)
        assert np.isinf(found.pull(np.array([1.0, 2.0]))).all()
        assert not np.isfinite(found.energy(np.array([1.0, 2.0]))).any()


@pytest.mark.parametrize("stiffening", [2.0, 8.0, 20.0])
def test_a_solid_follows_its_curve_of_tension(stiffening):
    stress = MODULUS / stiffening * (exp(stiffening * STRAIN) - 1.0)
    by_i1 = OfTension(stress, MODULUS).energy().slope("i1")
    stretch = np.linspace(1.0005, min(4.0, 1.0 + 12.0 / stiffening), 1001)
    # σ = 2 (λ - λ⁻²) μ ψ1 of an incompressible solid, μ being E/3.
    found = by_i1.at({"i1": stretch**2 + 2.0 / stretch}) * MODULUS / 3.0
    found *= 2.0 * (stretch - stretch**-2)
    expected = stress.at({"strain": stretch - 1.0})
    # The curve begins at a strain of 1e-7, which the stretch of 1.0005 adds to by 1e-10 of it.
    np.testing.assert_allclose(found, expected, rtol=1e-9)
