"""Quantities that depend on the place: closed forms, orders of convergence, and refusals."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.sparse.linalg import spsolve

import tissuec
from tests.matter.elastic import stiffness
from tests.validate.scenes import validated
from tissuec.compiler.bodies.graded_ranges import graded_ranges
from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.pipeline import check_request, compile_request
from tissuec.scene.request import Request

LENGTH = 0.04
TISSUE = "Young's modulus = 10 kPa; density = 1000 kg/m^3; retardation time = 5 ms"
YOUNG = "Young's modulus = 10 kPa + 20 kPa * (x / 40 mm)^2"
DENSITY = "density = 1000 kg/m^3 + 500 kg/m^3 * x / 40 mm"
LATTICE = (
    "mesh is lattice {{ kind is sodium chloride; reach is second neighbours; cell = {cell} mm; "
    "box from (0, 0, 0) mm to (40, {width}, {width}) mm }}"
)
SOLID = (
    "mesh is lattice {{ cell = {cell} mm; box from (0, 0, 0) mm to (40, {width}, {width}) mm }}"
)
SHEET = (
    "mesh is sheet {{ corner = (0, 0, 0) mm; first edge = (40, 0, 0) mm; second edge = "
    "(0, {width}, 0) mm; columns = {columns}; rows = 3 }}; thickness = 1 mm; bending is none"
)
THREAD = (
    "mesh is thread {{ line from (0, 0, 0) mm to (40, 0, 0) mm; thickness = 2 mm; "
    "pieces = {pieces} }}"
)


def of_springs(text):
    """Return what a text says of a modulus for the constants of springs."""
    return text.replace("Young's modulus", "spring constant").replace("kPa", "N/m")


def compiled(body, tissue=TISSUE, more=""):
    text = f"""language 1
tissue gel {{ {tissue} }}
{more}
body bar {{ {body}; tissue is gel }}
environment {{ gravity = (0, 0, 0) m/s^2 }}
simulate {{ duration = 1 ms }}
"""
    return compile_request(Request(Source("bar.tis", text)))[0]


def said(body, tissue=TISSUE, more=""):
    with pytest.raises(CompileError) as error:
        compiled(body, tissue, more)
    return error.value.diagnostics


def matrix_of(network):
    """Return the stiffness of springs and elements at rest [N/m]."""
    number, count = np.arange(network.node_count), network.node_count
    total = stiffness(network)
    for field in network.elements:
        total = total + field.matrix(0.0, network.position, number, count)
    return total.tocsr()


def stretched(network):
    """Return the force that lengthens a bar, which keeps its width, per length [N/m].

    Args:
        network: Of the bar, along x from 0 to ``LENGTH``.
    """
    matrix, x = matrix_of(network), network.position
    ends = [np.isclose(x[:, 0], place) for place in (0.0, LENGTH)]
    held = np.ones(x.size, dtype=bool)
    held[::3] = ends[0] | ends[1]
    by = np.zeros(x.size)
    by[np.flatnonzero(ends[1]) * 3] = 1.0
    free = ~held
    by[free] = spsolve(matrix[free][:, free].tocsc(), -(matrix @ by)[free])
    return float((matrix @ by)[np.flatnonzero(ends[1]) * 3].sum())


def modulus(x):
    return 1e4 + 2e4 * (x / LENGTH) ** 2


MEAN = LENGTH / quad(lambda x: 1.0 / modulus(x), 0.0, LENGTH)[0]  # that a bar in tension has


@pytest.mark.parametrize("kind", ["solid", "wall", "thread", "springs"])
def test_a_graded_bar_is_as_stiff_as_its_compliances_in_a_row(kind):
    errors = []
    for count in (8, 16, 32):
        cell = 40 / count
        body, tissue = {
            "solid": (SOLID.format(cell=cell, width=2 * cell), "; Poisson's ratio = 0"),
            "wall": (SHEET.format(width=2 * cell, columns=count + 1), "; Poisson's ratio = 0"),
            "thread": (THREAD.format(pieces=count), ""),
            "springs": (LATTICE.format(cell=cell, width=2 * cell), ""),
        }[kind]
        given, young = TISSUE + tissue, YOUNG
        if kind == "springs":
            given, young = of_springs(TISSUE), of_springs(YOUNG)
        nets = [compiled(text, given).network for text in (f"{body}; {young}", body)]
        if kind == "thread":  # whose knots are no part of it
            pieces = [net.springs.stiffness[net.bodies[0].thread.pieces] for net in nets]
            graded, even = (1.0 / (1.0 / each).sum() for each in pieces)
        else:
            graded, even = map(stretched, nets)
        # Springs that are held across resist by more than Young's modulus, so ratios count.
        errors.append(abs(graded / even / (MEAN / 1e4) - 1.0))
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert errors[-1] < 3e-4
    assert orders == pytest.approx(2.0, abs=0.1)


def test_springs_from_tables_take_the_constant_at_their_middle():
    nodes = " ".join(f"{k + 1} {4 * k};" for k in range(11))
    springs = " ".join(f"{k + 1} {k + 2};" for k in range(10))
    text = f"""language 1
tissue cord {{
  spring constant = 30 N/m; viscosity = 1 mN*s/m; mass = 1 g; breaking force = 1 N
}}
body bar {{
  mesh is explicit; tissue is cord; rupture is allowed
  spring constant = 30 N/m + 1 N/m * x / 1 mm
  viscosity = 1 mN*s/m * (1 + x / 40 mm)
  breaking force = 2 N - 1 N * x / 40 mm
  prestress = 10 % * x / 40 mm
}}
table nodes of bar in mm with columns "id x" {{ {nodes} }}
table springs of bar with columns "a b" {{ {springs} }}
environment {{ gravity = (0, 0, 0) m/s^2 }}
simulate {{ duration = 1 ms }}
"""
    springs = compile_request(Request(Source("bar.tis", text)))[0].network.springs
    middle = 1e-3 * (2.0 + 4.0 * np.arange(10))
    assert springs.stiffness == pytest.approx(30.0 + 1e3 * middle, rel=1e-12)
    assert springs.damping == pytest.approx(1e-3 * (1.0 + middle / LENGTH), rel=1e-12)
    assert springs.strength == pytest.approx(2.0 - middle / LENGTH, rel=1e-12)
    assert springs.rest == pytest.approx(4e-3 * (1.0 - 0.1 * middle / LENGTH), rel=1e-12)


@pytest.mark.parametrize("kind", ["solid", "tetrahedra", "wall", "thread", "springs"])
def test_a_graded_density_has_the_mass_and_centre_of_its_integral(kind):
    errors = []
    for count in (8, 16):
        cell = 40 / count
        body = {
            "solid": SOLID.format(cell=cell, width=10),
            "tetrahedra": "mesh is cylinder { axis from (0, 0, 0) mm to (40, 0, 0) mm; "
            f"radius = 5 mm; cell = {cell / 2} mm }}",
            "wall": SHEET.format(width=10, columns=count + 1),
            "thread": THREAD.format(pieces=count),
            "springs": LATTICE.format(cell=cell, width=10),
        }[kind]
        tissue = of_springs(TISSUE) if kind == "springs" else TISSUE
        graded = compiled(f"{body}; {DENSITY}", tissue).network
        even = compiled(body, tissue).network
        # The integral of a linear density over a bar that is even across is exact.
        assert graded.mass.sum() == pytest.approx(1.25 * even.mass.sum(), rel=1e-9)
        centre = graded.mass @ graded.position[:, 0] / graded.mass.sum()
        errors.append(abs(centre / (LENGTH * (0.5 + 1.0 / 6.0) / 1.25 * 1.0) - 1.0))
    assert errors[-1] < 2e-3
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.15)


def test_regions_grade_their_own_tissue_and_inherit_the_grading_of_the_body():
    body = SOLID.format(cell=5, width=10)
    found = compiled(
        f"{body}; Young's modulus = 10 kPa * (1 + x / 40 mm); "
        "region own where x > 30 mm { tissue is hard }; "
        "region near where x < 10 mm { density = 900 kg/m^3 + 10 kg/m^3 * y / 1 mm }",
        more=f"tissue hard {{ {TISSUE.replace('10 kPa', '99 kPa')} }}",
    ).network
    (field,) = found.elements
    centre = found.position[field.nodes].mean(axis=1)
    own = centre[:, 0] > 0.03
    assert field.young[own] == pytest.approx(99e3, rel=1e-12)
    assert field.young[~own] == pytest.approx(1e4 * (1 + centre[~own, 0] / LENGTH), rel=1e-12)
    own_volume = 125e-9
    density = np.where(centre[:, 0] < 0.01, 900.0 + 1e4 * centre[:, 1], 1000.0)
    assert found.mass.sum() == pytest.approx((density * own_volume).sum(), rel=1e-12)


def test_quantities_of_elements_follow_their_formulas():
    tissue = (
        "Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3; "
        "shear viscosity = 2 Pa*s; fibre modulus = 30 kPa; fibre dispersion = 0.1; "
        "prestress = 2 %; breaking strain = 50 %; relaxing share = 40 %; "
        "relaxation time = 1 s"
    )
    body = (
        f"{SOLID.format(cell=10, width=10)}; fibres = (1, 0, 0); rupture is allowed; "
        "Poisson's ratio = 0.1 + 0.3 * x / 40 mm; shear viscosity = 1 Pa*s * (1 + x / 40 mm); "
        "fibre modulus = 20 kPa + 1 kPa * x / 1 mm; fibre dispersion = 0.2 * x / 40 mm; "
        "prestress = 10 % * x / 40 mm; breaking strain = 20 % + 10 % * x / 10 mm; "
        "relaxation time = 1 s + 1 s * x / 10 mm"
    )
    (field,) = compiled(body, tissue).network.elements
    u = np.array([5.0, 15.0, 25.0, 35.0])
    ratio, shear = 0.1 + 0.3 * u / 40, 1e4 / (2.2 + 0.6 * u / 40)
    assert field.shear == pytest.approx(shear, rel=1e-12)
    assert field.bulk_modulus == pytest.approx(1e4 / (3 * (1 - 2 * ratio)), rel=1e-12)
    assert field.viscosity == pytest.approx(1 + u / 40, rel=1e-12)
    assert field.fibres.modulus == pytest.approx(1e4 + 1e3 * u, rel=1e-12)
    assert field.fibres.dispersion == pytest.approx(0.2 * u / 40, rel=1e-12)
    assert field.prestretch.stretch == pytest.approx(1 / (1 - 0.1 * u / 40), rel=1e-12)
    assert field.limits.strain == pytest.approx(0.2 + 0.01 * u, rel=1e-12)
    assert field.branches.time[0] == pytest.approx(1.0 + 0.1 * u, rel=1e-12)


def test_a_curve_of_stress_keeps_its_shape():
    tissue = TISSUE.replace("retardation", "stiffening = 8; retardation")
    body = f"{SOLID.format(cell=10, width=10)}; Young's modulus = 10 kPa * (1 + x / 40 mm)"
    (graded,) = compiled(body, tissue).network.elements
    (even,) = compiled(SOLID.format(cell=10, width=10), tissue).network.elements
    place = compiled(body, tissue).network.position.copy()
    place[:, 0] *= 1.2
    factor = 1 + np.array([5.0, 15.0, 25.0, 35.0]) / 40
    assert graded.energies(place) == pytest.approx(factor * even.energies(place), rel=1e-12)


def test_the_weakest_place_breaks_first(tmp_path):
    text = f"""language 1
tissue gel {{ {TISSUE}; breaking strain = 50 % }}
body bar {{
  {SOLID.format(cell=10, width=10)}; tissue is gel; rupture is allowed
  breaking strain = 30 % - 10 % * x / 40 mm
}}
set left = nodes of bar where x < 0.1 mm
set right = nodes of bar where x > 39.9 mm
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{
  at 0 s: fix left
  from 0 s to 1 s: move right by (12, 0, 0) mm using constant speed
  when ruptured(bar) > 0: end the run
}}
simulate {{ duration = 1 s }}
"""
    path = tmp_path / "bar.tis"
    path.write_text(text)
    run = tissuec.run(path)
    (rupture,) = [one for one in run.events if "35" in one.cause or "rupture" in one.kind]
    assert "35" in rupture.cause  # the centre of the last element


def test_a_graded_scene_agrees_with_the_reference(tmp_path):
    text = f"""language 1
tissue gel {{ {TISSUE} }}
body bar {{ {SOLID.format(cell=10, width=10)}; tissue is gel; {YOUNG}; {DENSITY} }}
set left = nodes of bar where x < 0.1 mm
environment {{ gravity = (0, 0, -9.81) m/s^2 }}
script {{ at 0 s: fix left }}
simulate {{ duration = 20 ms }}
output {{ trajectory with [modulus] every 5 ms }}
"""
    found = validated(text)
    assert found.verdict == "kept", found.reasons
    path = tmp_path / "bar.tis"
    path.write_text(text)
    run = tissuec.run(path)
    found = run.fields["modulus"][:]
    assert found.shape == run.position.shape[:2]
    x = run.position[0, :, 0]
    left, right = np.isclose(x, 0.0), np.isclose(x, LENGTH)
    assert found[-1][left] == pytest.approx(modulus(0.005), rel=1e-6)
    assert found[-1][right] == pytest.approx(modulus(0.035), rel=1e-6)


def test_ranges_are_those_of_elements():
    (young, density) = graded_ranges(
        compiled(f"{SOLID.format(cell=10, width=10)}; {YOUNG}; {DENSITY}")
    )
    assert (young.low, young.high) == pytest.approx((modulus(0.005), modulus(0.035)))
    assert (density.body, density.quantity) == ("bar", "density")
    assert density.formula == "1000 kg/m^3 + 500 kg/m^3 * x / 40 mm"


def test_a_value_that_cannot_be_names_its_place():
    (one,) = said(
        f"{SOLID.format(cell=10, width=10)}; Young's modulus = 10 kPa - 20 kPa * x / 40 mm"
    )
    assert one.code == "TIS308"
    assert "at (35, 5, 5) mm it is -7.5 kPa" in one.message


def test_learning_refuses_a_graded_quantity(tmp_path):
    (tmp_path / "pull.csv").write_text("t,u\n0,0\n1,1\n")
    text = f"""language 1
tissue gel {{ {TISSUE} }}
body bar {{ made of springs; {LATTICE.format(cell=10, width=10)}; tissue is gel; {YOUNG} }}
set right = nodes of bar where x > 39.9 mm
environment {{ gravity = (0, 0, 0) m/s^2 }}
simulate {{ duration = 1 ms }}
learn gel {{
  data = "pull.csv"
  time = column "t" in ms
  fit = position(right along (1, 0, 0)) using column "u" in mm
  adjust Young's modulus of gel
}}
"""
    path = tmp_path / "bar.tis"
    path.write_text(text)
    with pytest.raises(CompileError) as error:
        compile_request(Request.file(path))
    assert any(
        "depends on the place and cannot be adjusted" in d.message
        for d in error.value.diagnostics
    )


def test_a_number_that_is_set_beside_a_formula_has_no_effect():
    text = f"""language 1
tissue gel {{ {TISSUE} }}
body bar {{ {SOLID.format(cell=10, width=10)}; tissue is gel; {YOUNG} }}
environment {{ gravity = (0, 0, 0) m/s^2 }}
simulate {{ duration = 1 ms }}
"""
    request = Request(Source("bar.tis", text), overrides=("Young's modulus of gel = 5 kPa",))
    _, warnings = check_request(request)
    assert any(one.code == "W505" for one in warnings)
