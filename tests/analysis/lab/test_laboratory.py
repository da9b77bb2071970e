"""The laboratory measures what a tissue says, and tells what contradicts the evidence."""

import csv
import json
import math

import click
import numpy as np
import pytest
from click.testing import CliRunner

import tissuec
from tests.analysis.lab.benches import bench, text
from tissuec.analysis.lab import homogeneous, indentation, laboratory, motion, statics
from tissuec.analysis.lab.bench import TestBench, Unmeasured
from tissuec.analysis.lab.rows import LabCurve, StressStrainCurve, agrees
from tissuec.cli import group
from tissuec.core.errors import TissueError
from tissuec.core.source import Source
from tissuec.pipeline import read_words
from tissuec.scene.program.library import find_tissues
from tissuec.scene.request import Request

YOUNG, DENSITY, TIME, STRAIN = 5500.0, 1060.0, 2e-3, 0.45
GEL = (
    f"Young's modulus = {YOUNG} Pa; density = {DENSITY} kg/m^3; retardation time = {TIME} s; "
    f"breaking strain = {STRAIN}"
)
BARE = f"Young's modulus = {YOUNG} Pa"
EMPTY = StressStrainCurve(np.zeros(0), np.zeros(0))


def lab(folder, content, *options):
    """Return the exit code of the command and all that it prints."""
    path = folder / "gel.tis"
    path.write_text(content)
    done = CliRunner().invoke(group, ["lab", str(path), *options], standalone_mode=False)
    if isinstance(done.exception, TissueError | click.UsageError):
        return 2, str(done.exception)
    assert done.exception is None, done.exception
    return done.return_value, done.stdout


# --- closed forms -----------------------------------------------------------------------------


# What springs at edges miss is 0.5 % of the modulus and 0.01 of the ratio (docs/numerics.md);
# gauges, away from the ends, see a tenth of that.
@pytest.mark.parametrize("ratio", [pytest.param(0.25, marks=pytest.mark.slow), 0.45])
def test_an_isotropic_tissue_is_measured_as_it_is_given(ratio):
    gel = bench(f"{GEL}; Poisson's ratio = {ratio}")
    for coupon in gel.coupons():
        found = statics.tension(gel, coupon, 1e3)
        assert found.modulus == pytest.approx(YOUNG, rel=2e-3)
        assert found.ratio == pytest.approx(ratio, abs=3e-3)
        assert found.density == pytest.approx(DENSITY, rel=1e-12)
        shear = YOUNG / (2.0 * (1.0 + ratio))
        assert statics.shear(gel, coupon, YOUNG) == pytest.approx(shear, rel=1e-2)


def test_plates_measure_the_modulus_in_compression():
    # They keep the ends as wide as they are, which is felt between the gauges, too.
    gel = bench(GEL)
    modulus, curve = statics.compressed(gel, gel.coupons()[1])
    assert modulus == pytest.approx(YOUNG, rel=0.02)
    assert curve.strain[0] == pytest.approx(statics.SHORTEST, rel=0.05)
    assert (curve.stress[:-1] < 0.0).all()


def test_a_ball_is_pressed_into_a_half_space_as_hertz_says():
    force = 4.0 / 3.0 * YOUNG / (1.0 - 0.3**2) * 1e-3**1.5 * 0.02**0.5
    half_space = indentation.layer_force(YOUNG, 0.3, 0.02, 1e-3, math.inf)
    assert half_space == pytest.approx(force, rel=1e-12)
    # E. K. Dimitriadis et al. give this series for ν = 1/2, with as many digits.
    chi = 0.3
    series = 1.0 + 1.133 * chi + 1.283 * chi**2 + 0.769 * chi**3 + 0.0975 * chi**4
    layer = indentation.layer_force(YOUNG, 0.5, 0.02, 1e-3, (0.02 * 1e-3) ** 0.5 / chi)
    bare = indentation.layer_force(YOUNG, 0.5, 0.02, 1e-3, math.inf)
    assert layer / bare == pytest.approx(series, rel=2e-3)


# Sides of the block are free, at four radii of the contact, and a layer has none: the more it
# keeps its volume, the softer the block is beside it.
@pytest.mark.parametrize(("ratio", "off"), [(0.25, 0.05), (0.45, 0.04)])
def test_a_ball_measures_the_modulus_within_the_stated_share(ratio, off):
    gel = bench(f"{BARE}; Poisson's ratio = {ratio}")
    block = indentation.blocks(gel)[0]
    tension = statics.TensionTest(YOUNG, ratio, DENSITY)
    assert indentation.indentation(gel, block, tension) == pytest.approx(YOUNG, rel=off)


GUM = "spring constant = 40 N/m"
BRITTLE = f"{GUM}; breaking force = 50 mN"


# Levels of load are 1.4 % apart. Springs along the coupon break first, and resist a strain of
# 50 % with this force; others resist its becoming thin.
def test_a_coupon_of_springs_breaks_at_its_breaking_force():
    gum = bench(BRITTLE)
    coupon = gum.coupons()[0]
    modulus = statics.tension(gum, coupon, gum.stiffness).modulus
    found = statics.rupture(gum, coupon, modulus, None)
    again = statics.rupture(gum, coupon, modulus, found.stress)
    assert again.strain == pytest.approx(0.05 / 40.0 / 2.5e-3, rel=0.15)
    assert again.stress == pytest.approx(found.stress, rel=0.05)
    assert again.curve.strain[-1] < again.strain


@pytest.mark.parametrize(
    ("near", "why"), [(1.0, "not break up to 1.1 Pa"), (1e6, "already breaks at 100 kPa")]
)
def test_a_coupon_that_breaks_elsewhere_than_another_is_told(near, why):
    gum = bench(BRITTLE)
    with pytest.raises(Unmeasured, match=why):
        statics.rupture(gum, gum.coupons()[0], gum.stiffness, near)


def test_a_coupon_without_a_limit_does_not_break(monkeypatch):
    gum = bench(GUM)
    coupon = gum.coupons()[0]
    modulus = statics.tension(gum, coupon, gum.stiffness).modulus
    found = statics.rupture(gum, coupon, modulus, None)
    assert math.isnan(found.strain)
    assert found.curve.strain[-1] > 0.2


# A twisted bar is braked by shear alone: ω² τ / 2, however large its Poisson's ratio.
# A specimen is free of prestress, which would make it oscillate faster.
@pytest.mark.parametrize(
    ("ratio", "thickness", "more"),
    [(0.45, None, ""), (0.45, None, "; prestress = 20 %"), (None, 1e-3, "")],
)
def test_oscillations_measure_the_retardation_time(ratio, thickness, more):
    of_ratio = f"; Poisson's ratio = {ratio}" if ratio else ""
    gel = bench(f"{GEL}{of_ratio}{more}", thickness=thickness)
    tension = statics.TensionTest(YOUNG, ratio or 0.25, DENSITY)
    coupon = gel.coupons(motion.width_for(gel, tension))[0]
    found = motion.oscillation(gel, coupon, tension)
    assert found.time == pytest.approx(TIME, rel=0.03)  # 2 cells across


def test_a_strip_has_the_modulus_and_the_ratio_of_its_tissue():
    strip = bench(BARE, thickness=1e-3)
    found = statics.tension(strip, strip.coupons()[0], 1e6)
    assert found.modulus == pytest.approx(YOUNG, rel=2e-3)
    assert found.ratio == pytest.approx(0.25, abs=3e-3)


def test_a_tissue_without_resistance_is_not_measured():
    gum = bench("spring constant = 0 N/m; viscosity = 1 mN*s/m; mass = 1 mg")
    with pytest.raises(Unmeasured):
        statics.tension(gum, gum.coupons()[0], 1e3)


# --- evidence ---------------------------------------------------------------------------------

KNOWN = """
  known Young's modulus from 6 kPa to 7 kPa by "A"; known shear modulus = 2.2 kPa by "B"
  known breaking strain = 30 % by "C"; known density = 1 g/cm^3 by unverified "D" """


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("found")


@pytest.fixture(scope="module", params=[5, pytest.param(10, marks=pytest.mark.slow)])
def contradicted(folder, request):
    """Return what the command says of a tissue that contradicts some of its evidence."""
    with pytest.MonkeyPatch.context() as patch:
        if request.param == 5:
            patch.setattr(homogeneous, "POINTS", 5)
            patch.setattr(indentation, "indentation", lambda *_: YOUNG)
        return lab(folder, text(BARE + KNOWN), "--json", "--out", str(folder))


def test_contradicted_evidence_exits_with_1_and_names_the_source(contradicted):
    code, told = contradicted
    (found,) = json.loads(told)["tissues"]
    verdicts = {(row["test"], row["quantity"]): row["verdict"] for row in found["rows"]}
    assert code == 1
    assert verdicts["tension", "Young's modulus"] == 'contradicts "A"'
    assert verdicts["shear", "shear modulus"] == "good"
    assert "it does not break" in verdicts["tearing", "breaking strain"]
    assert "the evidence on density was not tested" in found["notes"]


def test_tables_hold_what_is_measured(contradicted, folder):
    with (folder / "gel_table.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert float(rows[0]["measured"]) == pytest.approx(YOUNG, rel=2e-3)
    for mode in ("tension", "compression", "shear", "equibiaxial_tension"):
        curve = (folder / f"gel_{mode}.csv").read_text().splitlines()
        strains = [float(line.split(",")[0]) for line in curve[1:]]
        assert strains == sorted(strains) and strains[-1] > 0.19


@pytest.mark.slow  # as long as that of matter, whose measurements are the same
def test_a_tissue_of_springs_is_measured_without_a_contradiction(tmp_path):
    code, told = lab(tmp_path, text(GUM), "--spacing", "5 mm")
    assert code == 0, told
    assert "depends on the mesh" in told


@pytest.mark.parametrize(("word", "is_known"), [("soft", True), ("hard", False)])
def test_a_changed_conclusion_is_found(word, is_known):
    request = Request(
        Source(
            "gel.tis",
            f"""language 1
property hardness from 0 to 1 {{ evenly = [soft, hard] }}
quantity Young's modulus from 1 kPa to 100 kPa on log scale {{ evenly = [low, high] }}
rules simple {{
  if hardness is soft then Young's modulus is low
  if hardness is hard then Young's modulus is high
}}
tissue gel {{
  described in simple
  hardness is {word}
  known Young's modulus from 2 kPa to 5 kPa by "A"
}}
""",
        )
    )
    gel = TestBench(request, read_words(request)[0].tissues["gel"], spacing=1e-3)
    found = statics.tension(gel, gel.coupons()[0], 1e3)
    assert agrees(found.modulus, gel.tissue.known[0]) is is_known


@pytest.mark.parametrize(
    ("value", "is_known"), [(2.86, True), (2.84, False), (7.36, True), (7.4, False)]
)
def test_evidence_is_met_as_well_as_the_laboratory_measures(value, is_known):
    words, _ = read_words(
        Request(Source("t.tis", text('known strength from 3 Pa to 7 Pa by "A"')))
    )
    assert agrees(value, words.tissues["gel"].known[0]) is is_known


@pytest.fixture
def at_once(monkeypatch):
    """Let all tests of bare gel say 1 without any scene."""
    intact = statics.Rupture(EMPTY, math.nan, math.nan)
    monkeypatch.setattr(statics, "tension", lambda *_: statics.TensionTest(1.0, 0.3, 1.0))
    monkeypatch.setattr(statics, "compressed", lambda *_: (1.0, EMPTY))
    monkeypatch.setattr(statics, "shear", lambda *_: 1.0)
    monkeypatch.setattr(statics, "rupture", lambda *_: intact)
    monkeypatch.setattr(homogeneous, "loaded", lambda *_, **__: ones())
    monkeypatch.setattr(indentation, "indentation", lambda *_: 1.0)


def ones(modulus=1.0):
    """Return a response of which all numbers but one are 1."""
    empty, none = np.zeros(0), (math.nan, math.nan)
    curve = LabCurve("tension", empty, empty, empty)
    return homogeneous.CubeResponse(curve, (modulus, 1.0), (0.3, 0.3), 1.0, none, none, "")


def test_quantities_of_springs_are_said_to_depend_on_the_mesh(tmp_path, at_once):
    told = lab(tmp_path, text(GUM), "--spacing", "5 mm")[1]
    assert "depends on the mesh" in told and "the spacing is 5 mm" in told
    assert (
        "as strips" in lab(tmp_path, text(GUM), "--thickness", "1 mm", "--spacing", "5 mm")[1]
    )


def test_elements_that_yield_are_not_drawn_to_rupture(at_once):
    flow = "yield stress = 1 kPa; flow viscosity = 9 Pa*s; strength = 5 kPa"
    (found,) = tissuec.examine(text(f"{BARE}; {flow}"))
    assert not any(row.test == "tearing" for row in found.rows)
    assert any(note.startswith("no test of tearing: elements that y") for note in found.notes)


@pytest.mark.parametrize(("measured", "is_good"), [(1.04, True), (1.06, False)])
def test_a_measurement_that_differs_from_the_law_is_told(
    measured, is_good, at_once, monkeypatch
):
    monkeypatch.setattr(homogeneous, "loaded", lambda *_, **__: ones(measured))
    (found,) = tissuec.examine(text(BARE))
    assert found.is_good is is_good
    assert found.rows[0].verdict == ("good" if is_good else "the law differs by 5.7 %")


@pytest.mark.parametrize(("made", "is_good"), [(1.17, True), (1.18, False)])
def test_meshes_that_differ_are_told(made, is_good, at_once, monkeypatch):
    found = iter([1.0, made])
    monkeypatch.setattr(indentation, "indentation", lambda *_: next(found))
    (examined,) = tissuec.examine(text(BARE))
    (row,) = [one for one in examined.rows if one.test == "indentation"]
    assert row.is_good is is_good
    assert row.verdict == ("good" if is_good else "the meshes differ by 15 %")


@pytest.mark.parametrize(("mode", "is_good"), [("tension", False), ("compression", True)])
def test_without_its_modulus_nothing_is_known_of_a_tissue(mode, is_good, at_once, monkeypatch):
    def fail(bench, asked, **_):
        if asked == mode:
            raise Unmeasured("it floats")
        return ones()

    monkeypatch.setattr(homogeneous, "loaded", fail)
    (found,) = tissuec.examine(text(BARE))
    assert found.is_good is is_good
    assert [row.verdict for row in found.rows if not row.quantity] == [
        "not measured: it floats"
    ]


def test_rows_are_heard_as_soon_as_they_are_there(at_once):
    heard = []
    request = Request(Source("gel.tis", text(BARE)))
    gel = read_words(request)[0].tissues["gel"]
    found = laboratory.examine(request, gel, listener=heard.append)
    assert heard == found.rows and len(heard) > 4


def test_what_resists_tension_only_gives_way_to_plates():
    rope = bench("spring constant = 40 N/m; spring law is tension only")
    with pytest.raises(Unmeasured, match="no resistance"):
        statics.compressed(rope, rope.coupons()[0])


def test_a_scene_lends_its_tissues_only(tmp_path):
    scene = text(BARE) + (
        "let side = 4 mm\n"
        "body piece { mesh is lattice { kind is sodium chloride; cell = side; "
        "reach is second neighbours; box from (0, 0, 0) mm to (8, 8, 8) mm }; tissue is gel }\n"
        "set left = nodes of piece where x < 1 mm\nscript { at 0 s: fix left }\n"
        "simulate { duration = 1 s }\noutput { force of left every 1 ms }\n"
        "expect force(left) < 1 N over run\n"
        "tissue other { spring constant = 1 N/m }\n"
    )
    request = Request(Source("scene.tis", scene))
    gel = read_words(request)[0].tissues["gel"]
    found = TestBench(request, gel, spacing=1e-3)
    modulus = statics.tension(found, found.coupons()[0], 1e3).modulus
    assert modulus == pytest.approx(YOUNG, rel=2e-3)


def test_what_cannot_be_measured_is_told(tmp_path):
    assert "Young's modulus" in lab(tmp_path, text("density = 1 g/cm^3"))[1]
    assert 'did you mean "gel"?' in lab(tmp_path, text(BARE), "--tissue", "gle")[1]
    assert "a length" in lab(tmp_path, text(BARE), "--spacing", "5 s")[1]


def test_shipped_tissues_are_found_by_short_names():
    assert find_tissues("liver") == find_tissues("matter/liver")
    with pytest.raises(TissueError, match="did you mean"):
        find_tissues("tissues/livre")


def test_a_signal_ends_the_laboratory(monkeypatch):
    from tissuec.analysis.lab import bench as module

    class Interrupted:
        kind, message, signal = "interrupted", "interrupted by SIGINT", 2

    def simulate(compiled, path, **options):
        done = original(compiled, path, **options)
        return type(done)(Interrupted(), done.path)

    original = module.simulate
    monkeypatch.setattr(module, "simulate", simulate)
    gel = bench(BARE)
    with pytest.raises(KeyboardInterrupt):
        statics.tension(gel, gel.coupons()[0], 1e3)
