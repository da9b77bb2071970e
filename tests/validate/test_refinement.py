"""``tissuec validate SCENE --mesh``: what finer meshes say about the error of a mesh."""

import json

import click
import numpy as np
import pytest

from tests.validate.test_validate_command import call  # noqa: F401  (a fixture)
from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.meshes.elements import wall_of_triangles
from tissuec.meshes.generators import Elemental
from tissuec.meshes.generators.lattice import Lattice
from tissuec.meshes.generators.round_solids import Cylinder, Ellipsoid, ThickTube
from tissuec.meshes.generators.sheet import Sheet
from tissuec.meshes.generators.sphere import Sphere
from tissuec.meshes.generators.tube import Tube
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request
from tissuec.validate.refinement import _dependence, dependences, mesh_run

BEAM = """language 1
tissue gel { Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3 }
body bar {
  mesh is lattice { kind is sodium chloride; cell = 5 mm
                    box from (0, 0, 0) mm to (40, 10, 10) mm }
  tissue is gel
}
set wall = nodes of bar where x < 0.1 mm
set tip = nodes of bar SELECTED
environment { gravity = (0, 0, -3) m/s^2; contact is off }
script { at 0 s: fix wall; at 0 s: settle }
simulate { duration = 1 ms; tolerance = 1e-5; integrator is automatic }
output { position(tip) every 1 ms; force(wall) every 1 ms }
"""
BY_PLACE = "where x > 39.9 mm"
AXIS = np.array([(0.0, 0.0, 0.0), (0.04, 0.0, 0.0)])
GENERATORS = {
    "lattice": Lattice("sodium chloride", 0.01, np.array([(0, 0, 0), (0.02, 0.01, 0.03)])),
    "graded lattice": Lattice(
        "sodium chloride",
        0.01,
        np.array([(0, 0, 0), (0.02, 0.02, 0.02)]),
        fine_cell=0.005,
        fine_box=np.array([(0, 0, 0.015), (0.02, 0.02, 0.02)]),
    ),
    "cylinder": Cylinder(AXIS, 0.008, 0.004),
    "coarse cylinder": Cylinder(AXIS, 0.008, 0.04),
    "ellipsoid": Ellipsoid(np.zeros(3), np.array([0.01, 0.01, 0.01]), 0.005),
    "thick tube": ThickTube(AXIS, 0.004, 0.006, 5, 16),
    "sheet": Sheet(np.zeros(3), AXIS[1], np.array([0.0, 0.02, 0.0]), 5, 3, "one"),
    "tube": Tube(AXIS, 0.005, 5, 8, diagonals="one"),
    "sphere": Sphere(np.zeros(3), 0.01, 1),
}


def cells_of(generator):
    """Return the number of elements of a mesh, and their dimension."""
    if isinstance(generator, Elemental):
        return sum(len(one.nodes) for one in generator.build_elements().elements), 3
    return sum(len(one.nodes) for one in wall_of_triangles(generator.build()).elements), 2


@pytest.mark.parametrize("name", GENERATORS)
def test_refined_mesh_fills_the_same_box_with_cells_half_as_long(name):
    generator = GENERATORS[name]
    (coarse, dimension), (fine, _) = cells_of(generator), cells_of(generator.refined())
    # Fine parts, and lengths of cylinders, are rounded to whole cells; at least four cells are
    # across a cylinder, so that cells along it become shorter by more.
    assert fine >= 0.8 * 2.0**dimension * coarse
    assert fine <= (1.3 if "coarse" not in name else 10.0) * 2.0**dimension * coarse
    if name != "graded lattice":  # which no net of springs has
        coarse, fine = (
            np.ptp(g.build().position, axis=0) for g in (generator, generator.refined())
        )
        assert fine == pytest.approx(coarse, rel=1e-6, abs=1e-12)


@pytest.mark.parametrize("order", [1.0, 2.0, 3.7])
def test_error_and_order_are_those_of_a_power_of_the_length(order):
    """With q = q0 + c h^p at 2 h, h and h / 2, p and the error of the first are exact."""
    exact, coefficient = np.array([[3.0], [5.0]]), np.array([[0.1], [-0.4]])
    rows = [exact + coefficient * 0.5 ** (n * order) for n in range(3)]
    found = _dependence("force", "N", np.array([0.0, 1.0]), rows, (2.0, 2.0))
    largest = max(np.abs(row).max() for row in rows)
    assert found.order == pytest.approx(order, rel=1e-12)
    assert found.error == pytest.approx(0.4 / largest, rel=1e-12)
    assert found.time == 1.0


def test_without_an_order_the_estimate_is_that_of_order_one():
    rows = [np.array([[value]]) for value in (1.0, 1.1, 1.25)]  # changes that grow
    found = _dependence("force", "N", np.zeros(1), rows, (2.0, 2.0))
    assert found.order is None
    assert found.error == pytest.approx((1.25 + 0.15 - 1.0) / 1.25)


def test_estimate_of_a_cantilever_agrees_with_a_mesh_four_times_as_fine():
    """The displacement converges with an order of about 1.2, by the corners of the held end."""
    request = Request(Source("beam.tis", BEAM.replace("SELECTED", BY_PLACE)))
    compiled = [compile_request(request, halvings=n)[0] for n in range(4)]
    runs = [mesh_run(one, lambda time: None) for one in compiled]
    displacement, tip, force = dependences(compiled[0], runs[:3])
    error, _, _ = dependences(compiled[0], [runs[0], runs[3]])
    assert displacement.name == "displacement"
    # The finest mesh has about a sixth of the error left.
    assert displacement.error == pytest.approx(error.change, rel=0.3)
    assert 0.8 < displacement.order < 1.6
    assert tip.error < displacement.error
    # The share of the weight that held nodes carry themselves falls with the first power.
    whole = 3.0 * 4e-6 * 1000.0
    assert force.order == pytest.approx(1.0, abs=1e-9)
    left = (whole - force.values[0]) / force.values[-1]
    assert force.error == pytest.approx(left, rel=1e-9)


def test_command_reports_the_meshes_and_the_estimate(call):  # noqa: F811
    code, out, err = call(BEAM.replace("SELECTED", BY_PLACE), "--mesh")
    assert code == 0
    heads = "quantity 32 cells 256 cells change order error worst at"
    assert " ".join(out.splitlines()[0].split()) == heads
    assert "estimated error of the mesh with 32 cells: up to" in out
    assert "--mesh 2 measures the order" in out
    assert "run with 425 nodes, 256 elements" in err
    document = json.loads(call(BEAM.replace("SELECTED", BY_PLACE), "--mesh", "--json")[1])
    assert [one["elements"] for one in document["meshes"]] == [32, 256]
    assert document["quantities"][0]["name"] == "displacement"


@pytest.mark.parametrize("option", [("--method", "DOP853"), ("--rtol", "1e-8")])
def test_options_of_another_solver_are_refused_beside_meshes(call, option):  # noqa: F811
    with pytest.raises(click.UsageError, match="which --mesh does not need"):
        call(BEAM.replace("SELECTED", BY_PLACE), "--mesh", *option)


@pytest.mark.parametrize(
    ("text", "code", "said"),
    [
        (BEAM.replace("SELECTED", "in [1, 2]"), "TIS302", "not of a finer one"),
        (
            BEAM.replace("SELECTED", BY_PLACE).replace(
                "Young's modulus = 10 kPa; Poisson's ratio = 0.3;",
                "spring constant = 10 N/m; viscosity = 1 mN*s/m;",
            ),
            "TIS309",
            "no body consists of elements",
        ),
    ],
)  # fmt: skip
def test_what_cannot_be_refined_is_refused(text, code, said):
    with pytest.raises(CompileError) as caught:
        compile_request(Request(Source("beam.tis", text)), halvings=1)
    assert caught.value.diagnostics[0].code == code
    assert said in caught.value.diagnostics[0].message


def test_nodes_of_bodies_that_touch_are_compared_with_their_own():
    """One of two blocks that share a face moves by 1 mm, the other stays."""
    text = BEAM.replace("SELECTED", BY_PLACE).replace("(0, 0, -3)", "(0, 0, 0)")
    text = text.replace(
        "at 0 s: settle", "from 0 s to 1 ms: move second by (1, 0, 0) mm using ramp"
    )
    text = text.replace(
        "position(tip) every 1 ms; force(wall) every 1 ms", "position(second) every 1 ms"
    )
    text = text.replace("at 0 s: fix wall", "at 0 s: fix bar")
    text += """body second { mesh is lattice { cell = 5 mm
                box from (40, 0, 0) mm to (50, 10, 10) mm }; tissue is gel }
"""
    request = Request(Source("two.tis", text))
    compiled = [compile_request(request, halvings=n)[0] for n in range(2)]
    displacement, _ = dependences(
        compiled[0], [mesh_run(one, lambda time: None) for one in compiled]
    )
    assert displacement.change < 1e-9
