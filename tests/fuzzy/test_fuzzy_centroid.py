"""The centre of gravity: closed forms, symmetries, bells, and extremes."""

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy import integrate, optimize

from tissuec.fuzzy.centroid import centre_of_gravity, weighted_mean
from tissuec.fuzzy.sets import Gaussian, Powered, points, trapezoid, triangle

IMPLICATIONS = ["minimum", "product"]


def placed(*terms, low=0.0, high=1.0):
    return [(shape.within(low, high), weight) for shape, weight in terms]


@pytest.mark.parametrize("w", [1e-90, 1e-9, 0.1, 0.5, 1.0])
def test_a_clipped_trapezoid_has_the_centre_of_its_textbook_formula(w):
    a, b, c, d = 0.1, 0.2, 0.5, 0.9
    rise, fall = b - a, d - c
    area = (d - a) - w * (rise + fall) / 2
    first = d * d - a * a - w * (d * fall + a * rise)
    moment = (first + w * w * (fall * fall - rise * rise) / 3) / 2
    found = centre_of_gravity(placed((trapezoid(a, b, c, d), w)), 0.0, 1.0)
    assert found == pytest.approx(moment / area, rel=1e-14, abs=0)


@pytest.mark.parametrize("w", [1e-90, 1e-9, 0.1, 0.5, 1.0])
def test_a_scaled_triangle_keeps_its_centre(w):
    terms = placed((triangle(0.1, 0.3, 0.8), w))
    found = centre_of_gravity(terms, 0.0, 1.0, implication="product")
    assert found == pytest.approx((0.1 + 0.3 + 0.8) / 3, rel=1e-14, abs=0)


def test_a_sharp_box_has_its_centre_in_the_middle():
    terms = placed((points([(0.2, 0), (0.2, 1), (0.6, 1), (0.6, 0)]), 0.7))
    assert centre_of_gravity(terms, 0.0, 1.0) == pytest.approx(0.4, rel=1e-15, abs=0)


def test_what_lies_below_another_set_adds_nothing():
    wide = trapezoid(0.0, 0.1, 0.9, 1.0)
    alone = centre_of_gravity(placed((wide, 0.8)), 0.0, 1.0)
    both = centre_of_gravity(placed((wide, 0.8), (triangle(0.2, 0.3, 0.4), 0.5)), 0.0, 1.0)
    assert both == pytest.approx(alone, rel=1e-15, abs=0)


@pytest.mark.parametrize("implication", IMPLICATIONS)
def test_repeating_a_term_or_reordering_terms_changes_nothing(implication):
    terms = placed((triangle(0, 0.2, 0.7), 0.6), (triangle(0.1, 0.8, 0.9), 0.9))
    first = centre_of_gravity(terms, 0.0, 1.0, implication=implication)
    again = centre_of_gravity(terms[::-1] + terms, 0.0, 1.0, implication=implication)
    assert again == pytest.approx(first, rel=1e-15, abs=0)


SHAPES = [
    (trapezoid(0.0, 0.0, 0.125, 0.5), 0.4),
    (triangle(0.25, 0.5, 0.875), 0.8),
    (points([(0.5, 0), (0.5, 0.75), (0.75, 0.25), (1, 1)]), 0.6),
    (Gaussian(0.3, 0.08), 0.7),
    (Gaussian(0.6, 0.2), 0.5),
]


def stretched(shape, low, width):
    if isinstance(shape, Gaussian):
        return Gaussian(low + width * shape.mean, abs(width) * shape.sigma)
    pairs = [(low + width * x, y) for x, y in zip(shape.xs, shape.ys, strict=True)]
    return points(pairs if width > 0 else pairs[::-1])


@pytest.mark.parametrize("implication", IMPLICATIONS)
@pytest.mark.parametrize(
    ("low", "width"), [(0.0, 1e-7), (0.0, 1e9), (1000.0, 1.0), (-5.0, 3.0), (3.0, -2.0)]
)
def test_the_centre_moves_with_the_scale(low, width, implication):
    terms = placed(*SHAPES)
    ends = sorted((low, low + width))
    moved = [(stretched(shape, low, width).within(*ends), w) for shape, w in terms]
    expected = low + width * centre_of_gravity(terms, 0.0, 1.0, implication=implication)
    found = centre_of_gravity(moved, *ends, implication=implication)
    assert abs(found - expected) <= 1e-12 * abs(width)  # corners on 1000 … 1001 are rounded


@pytest.mark.parametrize("implication", IMPLICATIONS)
def test_a_symmetric_union_has_its_centre_in_the_middle(implication):
    one = [(triangle(0, 0.1, 0.7), 0.3), (Gaussian(0.3, 0.1), 0.8)]
    other = [(triangle(0.3, 0.9, 1), 0.3), (Gaussian(0.7, 0.1), 0.8)]
    found = centre_of_gravity(placed(*one, *other), 0.0, 1.0, implication=implication)
    assert found == pytest.approx(0.5, rel=1e-14, abs=0)


def test_powers_and_silence_have_no_centre():
    squared = Powered(triangle(0, 0.5, 1), 2.0)
    for number in (centre_of_gravity, weighted_mean):
        with pytest.raises(ValueError, match="power hedge"):
            number([(squared, 1.0)], 0.0, 1.0)
        with pytest.raises(ValueError, match="no word fires"):
            number(placed((triangle(0, 0.5, 1), 0.0)), 0.0, 1.0)


def test_the_weighted_mean_weighs_the_middles_of_cores():
    terms = placed((trapezoid(0, 0, 0.2, 0.5), 0.25), (triangle(0.5, 0.9, 1), 0.75))
    assert weighted_mean(terms, 0.0, 1.0) == pytest.approx(
        0.25 * 0.1 + 0.75 * 0.9, rel=1e-15, abs=0
    )


# --- bells, against adaptive quadrature between kinks found on a fine grid ---


def by_quadrature(terms, low, high, implication):
    def height(x, shape, w):
        return min(w, shape.degree(x)) if implication == "minimum" else w * shape.degree(x)

    def union(x):
        return max(height(x, *term) for term in terms)

    kinks = {low, high}
    grid = np.linspace(low, high, 4001)
    for one, w in terms:
        kinks |= {x for x in one.corners if low < x < high}
        values = [(lambda x, s=one, v=w: s.degree(x) - v)]
        values += [
            (lambda x, s=one, v=w, t=t, u=u: height(x, s, v) - height(x, t, u))
            for t, u in terms
        ]
        for f in values:
            signs = np.sign([f(x) for x in grid])
            for i in np.flatnonzero(signs[:-1] * signs[1:] < 0):
                kinks.add(optimize.brentq(f, grid[i], grid[i + 1], xtol=1e-15))
    area = moment = 0.0
    for a, b in pairwise(sorted(kinks)):
        if b - a > 1e-13:  # else one kink, found twice
            area += integrate.quad(union, a, b, epsabs=1e-14, epsrel=1e-13)[0]
            moment += integrate.quad(lambda x: x * union(x), a, b, epsabs=1e-14, epsrel=1e-13)[
                0
            ]
    return moment / area


BELLS = {
    "one": [(Gaussian(0.3, 0.1), 1.0)],
    "one, clipped below its inflection": [(Gaussian(0.3, 0.1), 0.4)],
    "one, clipped above its inflection": [(Gaussian(0.3, 0.1), 0.9)],
    "one, faint": [(Gaussian(0.2, 0.05), 1e-9)],
    "one as wide as the range": [(Gaussian(0.1, 1.0), 0.95)],
    "one at the end": [(Gaussian(0.0, 0.3), 0.8)],
    "equal widths": [(Gaussian(0.3, 0.1), 0.7), (Gaussian(0.6, 0.1), 0.4)],
    "nearly equal widths": [(Gaussian(0.3, 0.1), 0.7), (Gaussian(0.6, 0.1 + 1e-9), 0.4)],
    "one inside another": [(Gaussian(0.5, 0.3), 0.4), (Gaussian(0.5, 0.05), 1.0)],
    "two crossings": [(Gaussian(0.4, 0.3), 0.5), (Gaussian(0.5, 0.05), 0.9)],
    "with a triangle": [(Gaussian(0.3, 0.1), 0.7), (triangle(0.2, 0.6, 1.0), 0.8)],
    "with a faint plateau": [(Gaussian(0.5, 0.1), 1.0), (trapezoid(0, 0, 1, 1), 0.05)],
    "with a line it crosses twice": [
        (Gaussian(0.5, 0.15), 1.0),
        (points([(0, 0.5), (0.5, 0.625), (1, 0.75)]), 0.75),
    ],
    "with everything": SHAPES,
}


@pytest.mark.parametrize("implication", IMPLICATIONS)
@pytest.mark.parametrize("name", BELLS)
def test_unions_with_bells_agree_with_quadrature(name, implication):
    terms = placed(*BELLS[name])
    found = centre_of_gravity(terms, 0.0, 1.0, implication=implication)
    assert found == pytest.approx(by_quadrature(terms, 0.0, 1.0, implication), abs=1e-12)


def test_random_unions_of_bells_and_triangles_agree_with_quadrature():
    random = np.random.default_rng(5)
    for _ in range(3):
        bells = [(Gaussian(*random.uniform((0, 0.02), (1, 0.5))), w) for w in random.random(2)]
        words = [(triangle(*np.sort(random.random(3))), w) for w in random.random(2)]
        terms = placed(*bells, *words)
        for implication in IMPLICATIONS:
            found = centre_of_gravity(terms, 0.0, 1.0, implication=implication)
            expected = by_quadrature(terms, 0.0, 1.0, implication)
            assert found == pytest.approx(expected, abs=1e-12)


def test_a_faint_bell_keeps_its_digits():
    # Clipped at w, a bell is a box of half width s·sqrt(-2 ln w) with tails. Cut by the range
    # at its mean, area and moment (divided by w) follow from erfc and exp of one number.
    w, sigma = 1e-60, 0.02
    z = math.sqrt(-2 * math.log(w))
    box, tail = z * sigma, sigma * math.sqrt(math.pi / 2) * math.erfc(z / math.sqrt(2)) / w
    expected = (box * box / 2 + sigma**2) / (box + tail)
    found = centre_of_gravity([(Gaussian(0.0, sigma), w)], 0.0, 1.0)
    assert found == pytest.approx(expected, rel=1e-13, abs=0)
