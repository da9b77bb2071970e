"""Constants of solid laws are learnt from tables of force over displacement and over time.

Tables over displacement have the stress of the law in closed form, which neither elements nor
the search for equilibria have a part in. Those over time are runs of the truth.
"""

import pickle

import numpy as np
import pytest

import tissuec
from tissuec.analysis.lab.closed_form import LawCurve
from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.learn.fit.learning import learn
from tissuec.learn.parameters.substitution import UsePlace, recompiled
from tissuec.learn.presets.preset import compose, place
from tissuec.pipeline import check_request, compile_request, read_words
from tissuec.scene.learning.entries import ADJUSTED
from tissuec.scene.request import Request
from tissuec.scene.tissues.quantities import QUANTITIES

#: Of the bar, which is confined across: length and cross section [m, m²].
LENGTH, AREA = 0.02, 1e-4
STRAINS = np.array([0.0, 0.1, 0.2, 0.3])
MATTER = "density = 1000 kg/m^3; retardation time = 1 ms; Poisson's ratio = 0.45"
#: What is learnt: a start and the truth of each number, by entries of the tissue.
LEARNT = {
    "ogden": (
        "Young's modulus = 20 kPa; solid law is ogden {{ exponent = {} }}",
        {"exponent": (4.0, 5.0)},
    ),
    "several terms": (
        "Young's modulus = 20 kPa; solid law is ogden {{ exponent = 4; second exponent = {}; "
        "second share = {} }}",
        {"second exponent": (-2.0, -3.0), "second share": (0.2, 0.3)},
    ),
    "fibres": (
        "Young's modulus = 20 kPa; fibre modulus = {} kPa; fibre stiffening = {}",
        {"fibre modulus": (70.0, 90.0), "fibre stiffening": (2.0, 3.0)},
    ),
    "yeoh": (
        "Young's modulus = 20 kPa; solid law is yeoh {{ second = {}; third = 0.2 }}",
        {"second": (0.1, 0.7)},
    ),
    "chains": (
        "Young's modulus = 20 kPa; solid law is arruda boyce {{ segments = {} }}",
        {"segments": (6.0, 3.0)},
    ),
    "holmes mow": (
        "Young's modulus = 20 kPa; solid law is holmes mow {{ exponent = {} }}",
        {"exponent": (0.5, 1.0)},
    ),
    "unconstrained": (
        "Young's modulus = 20 kPa; solid law is unconstrained ogden {{ exponent = {}; "
        "second exponent = -2; second share = {} }}",
        {"exponent": (4.0, 5.0), "second share": (0.2, 0.3)},
    ),
    "param": (
        "Young's modulus = 20 kPa; solid law is yeoh {{ second = 2 * c2; third = c2 }}",
        {"c2": (0.1, 0.4)},
    ),
    "formula": (
        "Young's modulus = 20 kPa; stress of strain = 20 kPa * strain * (1 + c2 * strain)",
        {"c2": (0.5, 2.0)},
    ),
    "curve": (
        "Young's modulus = 20 kPa; spring law is stress curve "
        "{{ strains = [-0.2, 0, 0.1, 0.2, 0.4]; "
        "stresses = [-4 kPa, 0 kPa, 2 kPa, 4 kPa * c2, 10 kPa] }}",
        {"c2": (1.1, 1.3)},
    ),
    "stiffening": ("Young's modulus = 20 kPa; stiffening = {}", {"stiffening": (1.0, 4.0)}),
    "Poisson's ratio": (
        "Young's modulus = 20 kPa; Poisson's ratio = {}",
        {"Poisson's ratio": (0.3, 0.4)},
    ),
}


def tissue(name, column):
    """Return the tissue of a case, and its params: at the start (0) or as in the truth (1)."""
    entries, numbers = LEARNT[name]
    values = [pair[column] for pair in numbers.values()]
    params = f"param c2 = {numbers['c2'][column]}" if "c2" in numbers else ""
    matter = MATTER.partition("; Poisson")[0] if "Poisson" in entries else MATTER
    return f"{params}\ntissue gum {{ {entries.format(*values)}; {matter} }}"


def cube(name, column, learnt="", simulate="", time="1 s", damping=""):
    return f"""language 1
{tissue(name, column)}
body cube {{
  mesh is lattice {{ cell = 10 mm; box from (0, 0, 0) mm to (20, 10, 10) mm }}
  tissue is gum; {"fibres = (1, 0, 0)" if name == "fibres" else ""}
}}
set end = nodes of cube where x > 19 mm
environment {{
  gravity = (0, 0, 0) m/s^2; {damping}
  symmetric about plane through (0, 0, 0) mm facing (1, 0, 0)
  symmetric about plane through (0, 0, 0) mm facing (0, 1, 0)
  symmetric about plane through (0, 0, 0) mm facing (0, 0, 1)
  symmetric about plane through (0, 10, 10) mm facing (0, 1, 0)
  symmetric about plane through (0, 10, 10) mm facing (0, 0, 1)
}}
script {{ from 0 s to {time}: move end by (6, 0, 0) mm using smooth profile }}
simulate {{ duration = {time}; {simulate} }}
output {{ force(end) every {time} / 8 }}
{learnt}
"""


def block(name, axis):
    adjusts = "\n".join(f"  adjust {what}" for what in LEARNT[name][1])
    return f"""learn gum {{
  data = "data.csv"
  {axis}
  fit = force(end along (1, 0, 0)) using column "force_N" in N
{adjusts}
  tolerance = 1e-6
  write "learnt.tis"
}}"""


DISPLACED = 'displacement of end along (1, 0, 0) using column "u_mm" in mm'


def fitted(folder, text):
    path = folder / "scene.tis"
    path.write_text(text)
    request = Request.file(path)
    compiled, _ = compile_request(request)
    found = learn(compiled, compiled.fit_problems[0], request)
    return found, compiled, request


def truths(name):
    """Return the true numbers of a case in SI units."""
    return [
        pair[1] * (1e3 if "modulus" in what else 1.0) for what, pair in LEARNT[name][1].items()
    ]


def stresses(tissue):
    """Return the nominal stresses of a confined bar at all strains in closed form [Pa]."""
    law = LawCurve.of(tissue)
    return np.array([law._principal(np.array([1.0 + e, 1.0, 1.0]))[0] for e in STRAINS])


def over_displacement(folder, name):
    """Write the table of a case over displacement, in closed form."""
    words, _ = read_words(Request(Source("truth.tis", f"language 1\n{tissue(name, 1)}")))
    table = np.column_stack([1e3 * LENGTH * STRAINS, AREA * stresses(words.tissues["gum"])])
    path = folder / "data.csv"
    np.savetxt(path, table, "%.17g", ",", header="u_mm,force_N", comments="")


#: Those whose equilibria take less than 3 s; runs over time take less for each law.
QUICK = ("yeoh", "param")


@pytest.mark.parametrize(
    "name",
    [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in LEARNT],
)
def test_constants_are_learnt_from_forces_over_displacements(name, tmp_path):
    over_displacement(tmp_path, name)
    found, *_ = fitted(tmp_path, cube(name, 0, block(name, DISPLACED)))
    assert not found.failure and "exact derivatives of every equilib" in found.method
    values = [float(one.value[0]) for one in found.estimates]
    # The data is exact; equilibria are found to 1e-9, and Newton's steps end at 1e-9 of E.
    assert values == pytest.approx(truths(name), rel=1e-5)


@pytest.mark.parametrize(
    ("name", "damping"),
    [
        *((name, "") for name in ("ogden", "fibres", "yeoh", "stiffening", "Poisson's ratio")),
        # On planes of symmetry, a part of it acts on the drawn part.
        ("yeoh", "mass damping = 300 Hz; damping = 20 mN*s/m"),
    ],
)
def test_constants_are_learnt_from_forces_over_time(name, damping, tmp_path):
    truth = cube(name, 1, simulate="tolerance = 1e-6", time="20 ms", damping=damping)
    run = tissuec.run(truth, companion="off").logs["force of end"]
    table = np.column_stack([run.time, run.value[:, 0]])[1:]
    path = tmp_path / "data.csv"
    np.savetxt(path, table, "%.17g", ",", header="t_s,force_N", comments="")
    scene = cube(name, 0, block(name, ""), time="20 ms", damping=damping)
    found, *_ = fitted(tmp_path, scene)
    assert not found.failure and "exact derivatives of every step" in found.method
    values = [float(one.value[0]) for one in found.estimates]
    # Runs of the data have errors of 1e-6 of the displacement.
    assert values == pytest.approx(truths(name), rel=1e-4)


@pytest.mark.parametrize(
    "name",
    ["param", *(pytest.param(n, marks=pytest.mark.slow) for n in ("several terms", "formula"))],
)
def test_the_preset_has_the_learnt_law(name, tmp_path):
    over_displacement(tmp_path, name)
    found, compiled, request = fitted(tmp_path, cube(name, 0, block(name, DISPLACED)))
    place(compose(found, compiled, request, found.fit_problem.write), force=True)
    words, _ = read_words(Request.file(tmp_path / "learnt.tis", strict=True))
    truth, _ = read_words(Request(Source("truth.tis", f"language 1\n{tissue(name, 1)}")))
    (written,) = words.tissues.values()
    found, expected = (stresses(one) for one in (written, truth.tissues["gum"]))
    # Six digits are written.
    assert found == pytest.approx(expected, rel=1e-4)


def test_what_is_learnt_is_in_the_table_of_what_can_be_adjusted():
    """Constants of laws are not in it, which have names of their own."""
    quantities = {what.casefold() for _, numbers in LEARNT.values() for what in numbers}
    assert quantities & QUANTITIES.keys() <= set(ADJUSTED)
    assert {"poisson's ratio", "fibre modulus", "fibre stiffening"} <= set(ADJUSTED)


def test_a_law_that_does_not_exist_is_no_scene():
    compiled, _ = compile_request(Request(Source("a.tis", cube("ogden", 0))))
    with pytest.raises(CompileError, match=r"at least 0\.01"):
        recompiled(compiled, {}, {(UsePlace("gum"), "exponent"): 0.0})


def test_a_scene_in_another_process_is_the_same():
    """Quantities are told apart by identity: a retardation time is no viscosity."""
    compiled, _ = compile_request(Request(Source("a.tis", cube("yeoh", 0))))
    again = recompiled(pickle.loads(pickle.dumps(compiled)), {}, {})
    here, there = compiled.network.blocks[0], again.network.blocks[0]
    assert there.field.viscosity == pytest.approx(here.field.viscosity, rel=1e-15)


def test_tissue_that_flows_is_not_fitted_over_a_displacement(tmp_path):
    over_displacement(tmp_path, "yeoh")
    flows = "yield stress = 5 kPa; flow viscosity = 10 Pa*s; density"
    text = cube("yeoh", 0, block("yeoh", DISPLACED)).replace("density", flows, 1)
    with pytest.raises(CompileError, match="elements that yield need time"):
        fitted(tmp_path, text)
    with pytest.raises(CompileError, match="elements that yield need time"):
        check_request(Request.file(tmp_path / "scene.tis"))
