"""What breaks elements, against closed forms and formulas of the reference."""

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.forces.test_elements import LAWS, SHEAR, SPAN, deformed, fibres_of, mesh
from tissuec.autodiff.evaluation import evaluate
from tissuec.autodiff.graph import Graph
from tissuec.core.structs import replace
from tissuec.forces.solids.bent_elements import kind_of
from tissuec.forces.solids.element_limits import ElementLimits
from tissuec.forces.solids.elements import SolidMaterial
from tissuec.forces.solids.solid_point import grown
from tissuec.forces.solids.solid_strain import Prestretch
from tissuec.geometry.elements import SHAPES
from tissuec.laws.solid.invariants import NeoHookean, SolidExponential
from tissuec.validate.forces.elements import ElementSolid

BULK = 5e3  # [Pa]
NONE = np.inf


def breakable(name, law, *, cells=2, strain=NONE, stress=NONE, toughness=NONE, **more):
    """Return elements of one material with limits, and where their nodes are drawn."""
    position, nodes = mesh(name, cells=cells, displaced=0.2)
    count = len(nodes)
    limits = [np.full(count, limit) for limit in (strain, stress, toughness)]
    material = SolidMaterial(
        np.full(count, SHEAR), np.full(count, BULK), np.zeros(count),
        np.zeros(count, dtype=np.int64), (law,),
        limits=ElementLimits(*limits, np.zeros_like(limits[0])), **more,
    )  # fmt: skip
    return kind_of(SHAPES[name]).of(
        "cube", SHAPES[name], nodes, position, material, 0, SPAN
    ), position


def energy(law, along, across):
    """Return the energy of a bar with given stretches [Pa], in closed form."""
    j = along * across**2
    i1 = j ** (-2.0 / 3.0) * (along**2 + 2.0 * across**2)
    match law:
        case NeoHookean():
            stored = 0.5 * (i1 - 3.0)
        case SolidExponential(stiffening=k):
            stored = np.expm1(k * (i1 - 3.0)) / (2.0 * k)
    return SHEAR * stored + 0.5 * BULK * np.log(j) ** 2


def bar(law, along):
    """Return how wide a bar with free sides is, and its force per drawn section [Pa].

    Slopes of the energy are taken in the complex plane.
    """

    def slope(one, other):
        return energy(law, one + 0j, other + 0j).imag / 1e-30

    across = brentq(lambda m: slope(along, m + 1e-30j), 0.5, 1.2, xtol=1e-15, rtol=1e-15)
    return across, slope(along + 1e-30j, across)


SIZES = [("hexahedron", 1), ("hexahedron", 10), ("tetrahedron", 5), ("wedge", 8)]


@pytest.mark.parametrize("law", [NeoHookean(), SolidExponential(2.0)], ids=["line", "curve"])
@pytest.mark.parametrize(("name", "cells"), SIZES)
def test_every_element_of_a_drawn_bar_reaches_its_limits_together(name, cells, law):
    along = 1.35
    across, stress = bar(law, along)
    turn = np.linalg.qr(np.random.default_rng(8).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    limits = {
        "strain": along - 1.0,
        "stress": stress,
        "toughness": energy(law, along, across),
    }
    for what, limit in limits.items():
        made, position = breakable(name, law, cells=cells, **{what: limit})
        drawn = position @ (turn @ np.diag([along, across, across])).T
        loads = made.breakable.loads(drawn)
        due = made.volume ** (1.0 / 3.0) if what == "toughness" else np.ones(len(loads))
        np.testing.assert_allclose(loads, due, rtol=1e-9)


@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("what", ["strain", "stress", "toughness"])
def test_the_reference_finds_the_same_loads(what, name, law):
    made, position = breakable(name, law, **{what: 2.0})
    loads = made.breakable.loads(deformed(position, 1.5e-3))
    found = ElementSolid(made, position).burdens(deformed(position, 1.5e-3))
    # What is pressed from all sides bears no load.
    np.testing.assert_allclose(np.maximum(loads, 0.0), found, rtol=1e-9)
    assert len(set(loads.round(12))) > 4  # no two are strained alike


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("what", ["strain", "stress", "toughness"])
def test_fibres_and_prestretch_are_borne_as_well(what, name):
    count = len(mesh(name)[1])
    axis = np.array([0.6, 0.0, 0.8])
    stretched = Prestretch(axis, False, np.linspace(1.05, 1.2, count))
    more = {"fibres": fibres_of(count), "prestretch": stretched}
    made, position = breakable(name, LAWS[1], **{what: 2.0}, **more)
    drawn = deformed(position, 1.5e-3)
    plain = breakable(name, LAWS[1], **{what: 2.0})[0].breakable.loads(drawn)
    loads = made.breakable.loads(drawn)
    assert (np.abs(loads - plain) > 1e-3 * plain).all()
    np.testing.assert_allclose(loads, ElementSolid(made, position).burdens(drawn), rtol=1e-9)


def test_strain_counts_from_the_shape_without_stress():
    stretched = Prestretch(np.array([0.0, 0.0, 1.0]), False, np.full(8, 1.25))
    made, position = breakable("hexahedron", NeoHookean(), strain=0.25, prestretch=stretched)
    np.testing.assert_allclose(made.breakable.loads(position), 1.0, rtol=1e-12)


def test_pressure_breaks_nothing():
    made, position = breakable("hexahedron", NeoHookean(), strain=0.1, stress=1.0)
    assert (made.breakable.loads(0.7 * position) <= 0.0).all()


def test_what_has_no_limit_does_not_break():
    made, position = breakable("hexahedron", NeoHookean())
    assert made.breakable is None
    some = replace(made.limits, strain=np.where(np.arange(8) == 5, 0.2, np.inf))
    made = replace(made, limits=some, walls=np.arange(100, 108))
    assert made.breakable.broken(1.3 * position).tolist() == [105]
    assert made.breakable.broken(1.1 * position).tolist() == []


@pytest.mark.parametrize("exponent", [0.0, 1e-17, 1e-12, 1e-5, 0.01, 0.69, 0.7, 1.0, 800.0])
def test_small_exponents_lose_nothing(exponent):
    z = Graph().input("z")
    with np.errstate(over="ignore"):
        found, exact = evaluate([grown(z)], {"z": exponent})[0], np.expm1(exponent)
    assert found == pytest.approx(exact, rel=1e-15, abs=0.0)
