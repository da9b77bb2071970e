"""Cubes of one element follow the law of their tissue, as do closed forms of it."""

import math

import numpy as np
import pytest
from scipy.optimize import fsolve

from tests.analysis.lab.benches import bench
from tissuec.analysis.lab import homogeneous, indentation, laboratory, solid_tests
from tissuec.analysis.lab.bench import Unmeasured
from tissuec.analysis.lab.closed_form import LawCurve
from tissuec.analysis.lab.rows import curve_rows
from tissuec.scene.tissues.known_curves import (
    ACROSS,
    COMPRESSION,
    EQUIBIAXIAL,
    SHEAR,
    TENSION,
)

YOUNG = 6000.0
KEEPING = f"Young's modulus = {YOUNG} Pa; Poisson's ratio = 0.4999"
STRAINS = [1e-4, 0.1, 0.3]


def law(entries):
    return LawCurve.of(bench(entries).tissue)


# --- the closed form --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("mode", "stress"),
    [
        (TENSION, lambda s: (1 + s) - (1 + s) ** -2),
        (COMPRESSION, lambda s: (1 - s) ** -2 - (1 - s)),
        (EQUIBIAXIAL, lambda s: (1 + s) - (1 + s) ** -5),
        (SHEAR, lambda s: s),
    ],
)
def test_the_law_of_an_incompressible_neo_hookean_solid_has_a_closed_form(mode, stress):
    found = law(KEEPING).stress(mode, STRAINS)
    expected = YOUNG / 3.0 * stress(np.array(STRAINS))
    assert found == pytest.approx(expected, rel=2e-3)  # what 0.4999 is from 1/2


def _energy_of(stretches, entries):
    """Return the energy per volume of a compressible solid with fibres, by the book."""
    shear, bulk, k1, k2, spread = entries
    square, volume = stretches**2, np.prod(stretches)
    first = volume ** (-2 / 3) * square.sum()
    e = max(spread * (first - 3.0) + (1.0 - 3.0 * spread) * (square[0] - 1.0), 0.0)
    bent = 0.5 * k1 / k2 * np.expm1(k2 * e**2)
    return 0.5 * shear * (first - 3.0) + 0.5 * bulk * np.log(volume) ** 2 + bent


@pytest.mark.parametrize("mode", [TENSION, ACROSS, COMPRESSION])
def test_the_law_of_a_solid_with_fibres_is_the_slope_of_its_energy(mode):
    of_fibres = "fibre modulus = 20 kPa; fibre stiffening = 2; fibre dispersion = 0.1"
    found = law(f"Young's modulus = {YOUNG} Pa; Poisson's ratio = 0.4; {of_fibres}")
    k1 = 0.25 * (20e3 - YOUNG) / (1.0 - 0.3) ** 2
    numbers = YOUNG / 2.8, YOUNG / 0.6, k1, 2.0, 0.1
    axis, strain, step = (1 if mode == ACROSS else 0), 0.2, 1e-5
    stretch = 1.0 - strain if mode == COMPRESSION else 1.0 + strain

    def placed(along, across):
        stretches = np.insert(np.exp(across), axis, along)
        return _energy_of(stretches, numbers)

    def rest(across, along):
        return [
            placed(along, across + step * way) - placed(along, across - step * way)
            for way in np.eye(2)
        ]

    def least(along):
        across = fsolve(rest, (-0.1, -0.1), args=(along,), xtol=1e-10)
        return placed(along, across)

    slope = (least(stretch + step) - least(stretch - step)) / (2.0 * step)
    (stress,) = found.stress(mode, [strain])
    assert stress * (-1.0 if mode == COMPRESSION else 1.0) == pytest.approx(slope, rel=1e-5)


# Across them, fibres a thousand times as stiff go slack, with a corner at rest.
@pytest.mark.parametrize("dispersion", [0.0, 0.1])
def test_fibres_do_not_act_in_tension_across_them(dispersion):
    stiff = f"fibre modulus = 6 MPa; fibre dispersion = {dispersion}"
    found = law(f"{KEEPING}; {stiff}")
    plain = law(KEEPING)
    assert found.ratio(ACROSS) == pytest.approx(plain.ratio(TENSION), rel=1e-3)
    if not dispersion:  # those that are spread out are stretched
        stress = found.stress(ACROSS, STRAINS)
        assert stress == pytest.approx(plain.stress(TENSION, STRAINS), rel=1e-9)


def test_a_law_without_an_equilibrium_is_told():
    class Broken:
        def stress(self, mode, strains):
            raise ArithmeticError("no equilibrium")

    gel = bench(KEEPING)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(homogeneous.LawCurve, "of", lambda tissue: Broken())
        with pytest.raises(Unmeasured, match="no equilibrium"):
            homogeneous.loaded(gel, TENSION)


def test_a_curve_of_stress_is_its_own_law_in_tension():
    found = law("stress of strain = 2 kPa*(exp(3*strain)-1); Poisson's ratio = 0.4999")
    expected = 2e3 * np.expm1(3.0 * np.array(STRAINS))
    assert found.stress(TENSION, STRAINS) == pytest.approx(expected, rel=2e-3)


# --- cubes ------------------------------------------------------------------------------------

LAWS = {
    "compressible": f"Young's modulus = {YOUNG} Pa",
    "prestressed": f"Young's modulus = {YOUNG} Pa; prestress = 20 %",
    "exponential": f"{KEEPING}; solid law is exponential {{ stiffening = 3 }}",
    "relaxing": f"{KEEPING}; relaxing share = 40 %; relaxation time = 1 s",
    "curve": "stress of strain = 2 kPa*(exp(3*strain)-1)",
}


@pytest.mark.parametrize("mode", [TENSION, COMPRESSION, SHEAR, EQUIBIAXIAL])
@pytest.mark.parametrize("entries", LAWS.values(), ids=LAWS)
def test_an_element_does_what_its_law_says(mode, entries, monkeypatch):
    monkeypatch.setattr(homogeneous, "POINTS", 3)
    found = homogeneous.loaded(bench(f"{entries}; density = 1 g/cm^3"), mode)
    assert found.curve.place[-1] >= 0.2 * (1.0 - 1e-6)
    # The polynomial pieces of a curve of stress are within 1e-3 of it.
    assert found.curve.value == pytest.approx(found.curve.check, rel=1e-3)
    assert found.modulus[0] == pytest.approx(found.modulus[1], rel=1e-3)
    assert found.density == pytest.approx(1000.0, rel=1e-12)


@pytest.mark.parametrize(
    ("limits", "strain"),
    [
        ("breaking strain = 45 %", 0.45),
        ("strength = 3 kPa; Poisson's ratio = 0.4999", None),
        ("breaking strain = 300 %", 3.0),
    ],
)
def test_a_cube_tears_at_the_limit_of_its_tissue(limits, strain, monkeypatch):
    monkeypatch.setattr(homogeneous, "POINTS", 4)
    found = homogeneous.loaded(
        bench(f"Young's modulus = {YOUNG} Pa; {limits}"), TENSION, tears=True
    )
    if strain is None:  # the root of λ - λ⁻² = 3 σ/E
        strain = float(np.roots([1.0, -1.5, 0.0, -1.0]).real.max()) - 1.0
    assert found.rupture == pytest.approx(found.rupture_by_law, rel=5e-3)
    assert found.rupture[0] == pytest.approx(strain, rel=5e-3)
    assert found.curve.place[-1] < found.rupture[0]


def test_a_tissue_that_never_breaks_has_a_curve_and_no_rupture(monkeypatch):
    monkeypatch.setattr(homogeneous, "POINTS", 3)
    endless = f"Young's modulus = {YOUNG} Pa; strength is none"
    found = homogeneous.loaded(bench(endless), TENSION, tears=True)
    assert found.curve.place[-1] == pytest.approx(0.3)
    assert all(map(math.isnan, (*found.rupture, *found.rupture_by_law)))


def test_a_tissue_that_yields_is_loaded_below_that():
    flow = "yield stress = 1 kPa; flow viscosity = 9 Pa*s"
    found = homogeneous.loaded(bench(f"Young's modulus = {YOUNG} Pa; {flow}"), TENSION)
    assert found.curve.value.max() < 800.0 and "yields" in found.why


def test_a_law_that_softens_is_followed_to_its_largest_stress():
    found = homogeneous.loaded(bench("stress of strain = 5 kPa*strain*(1 - strain)"), TENSION)
    known = 'known stress in tension at 80 % from 1 kPa to 2 kPa by "A"'
    further = bench(f"stress of strain = 5 kPa*strain*(1 - strain); {known}")
    further = homogeneous.loaded(further, TENSION)
    assert found.curve.place[-1] == pytest.approx(0.3, rel=1e-3)
    assert 0.4 < further.curve.place[-1] <= 0.5
    assert further.why.startswith("its stress falls beyond a strain of")


# --- evidence on curves -----------------------------------------------------------------------


def verdicts(known, more=""):
    gel = bench(f"{KEEPING}; {more}; {known}")
    found = homogeneous.loaded(gel, TENSION, tears=bool(more))
    return [
        (row.quantity, row.verdict, row.is_good)
        for row in curve_rows("t", found.curve, found.why)
    ]


# At 20 % it has 2000 (1.2 - 1.2⁻²) = 1011 Pa.
@pytest.mark.parametrize(
    ("limits", "verdict"),
    [
        ("from 0.9 kPa to 1 kPa", "inside the scatter"),  # within 5 %
        ("from 0.5 kPa to 0.9 kPa", '12 % above "A"'),
        ("from 2 kPa to 3 kPa", '49 % below "A"'),
    ],
)
def test_a_curve_is_inside_the_scatter_or_off_by_a_share(limits, verdict, monkeypatch):
    monkeypatch.setattr(homogeneous, "POINTS", 3)
    ((quantity, said, is_good),) = verdicts(f'known stress in tension at 20 % {limits} by "A"')
    assert (quantity, said) == ("stress at 20 %", verdict)
    assert is_good is (verdict == "inside the scatter")


def test_a_curve_that_tears_before_a_known_place_is_told(monkeypatch):
    monkeypatch.setattr(homogeneous, "POINTS", 3)
    ranges = "from [0.2 kPa, 0.9 kPa] to [0.4 kPa, 1.1 kPa]"
    known = f'known stress in tension at [5 %, 20 %] {ranges} by "A"'
    ((_, said, is_good),) = verdicts(known, "breaking strain = 10 %")
    assert said == 'not measured at 20 % of "A": it tears'
    assert not is_good


# --- relaxation -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("second", "lost"),
    [("", 0.4), ("second relaxing share = 20 %; second relaxation time = 20 s", 0.6)],
)
def test_what_is_held_relaxes_by_its_shares_in_its_times(second, lost, monkeypatch):
    monkeypatch.setattr(solid_tests, "_SAMPLES", 60)
    one = "relaxing share = 40 %; relaxation time = 100 ms; retardation time = 1 s"
    found = solid_tests.relaxed(bench(f"Young's modulus = {YOUNG} Pa; {one}; {second}"))
    assert found.curve.value == pytest.approx(found.curve.check, abs=1e-4)
    assert found.share[0] == pytest.approx(lost, rel=0.02)
    if not second:
        assert found.time[0] == pytest.approx(0.1, rel=0.02)


def test_the_stress_that_is_left_has_a_closed_form():
    # After a ramp of no length, 1 - s + s exp(-t/τ).
    time = np.array([0.0, 1.0, 10.0])
    found = solid_tests.left_by_law([(0.4, 2.0)], 1e-9, time)
    assert found == pytest.approx(0.6 + 0.4 * np.exp(-time / 2.0), rel=1e-6)


def test_known_relaxation_is_compared_at_its_times(monkeypatch):
    monkeypatch.setattr(solid_tests, "_SAMPLES", 60)
    one = "relaxing share = 40 %; relaxation time = 1 s"
    known = 'known relaxation at [1 s, 20 s] from [70 %, 70 %] to [80 %, 80 %] by "A"'
    found = solid_tests.relaxed(bench(f"Young's modulus = {YOUNG} Pa; {one}; {known}"))
    ((row),) = curve_rows("t", found.curve, "")
    assert (row.quantity, row.verdict) == ("stress left at 20 s", '14 % below "A"')


def test_a_tissue_that_does_not_relax_contradicts_a_relaxation_that_is_known(monkeypatch):
    monkeypatch.setattr(homogeneous, "POINTS", 2)
    monkeypatch.setattr(indentation, "indentation", lambda *_: YOUNG)
    known = 'known relaxation at 10 s from 60 % to 70 % by "A"'
    gel = bench(f"Young's modulus = {YOUNG} Pa; {known}")
    found = laboratory.examiner_of(gel, lambda _: None).all()
    (row,) = [one for one in found.rows if one.test == "ramp and hold"]
    assert (row.quantity, row.verdict) == ("stress left at 10 s", '43 % above "A"')


def test_the_last_known_place_is_measured_though_statics_fall_short_of_it():
    # At 20 % a tissue that stiffens fast is pressed to 19.99993 %.
    known = 'known stress in compression at 20 % from 0.8 kPa to 40 kPa by "A 2011"'
    tissue = "Young's modulus = 14 kPa; density = 1050 kg/m^3; stiffening = 24"
    made = bench(f"{tissue}; Poisson's ratio = 0.45; {known}")
    found = homogeneous.loaded(made, COMPRESSION)
    (row,) = curve_rows("compression", found.curve, found.why)
    assert found.curve.place[-1] < 0.2 and row.is_good
