"""Bodies of hexahedra with 27 nodes: what they consist of, runs, and what is refused."""

import numpy as np
import pytest

import tissuec
from tests.findings import finding_of
from tests.imports.organs import box_of_tetrahedra, write_vtk
from tests.validate.scenes import compiled_scene, validated

SCENE = """language 1
tissue gel {{ Young's modulus = 10 kPa; Poisson's ratio = {ratio}; density = 1000 kg/m^3
  {tissue} }}
body block {{
  {mesh}
  tissue is gel
  made of quadratic elements
  {body}
}}
set low = nodes of block where z < 0.1 mm
set high = nodes of block where z > 19.9 mm
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{ at 0 s: fix low; {script} }}
simulate {{ duration = {duration} }}
output {{ {output} }}
"""
LATTICE = "mesh is lattice { cell = 10 mm; box from (0, 0, 0) mm to (20, 10, 20) mm }"
ONE = "mesh is lattice { cell = 20 mm; box from (0, 0, 0) mm to (20, 20, 20) mm }"


def scene(
    mesh=LATTICE, *, ratio=0.3, tissue="", body="", script="", duration="1 ms",
    output="position(high) every 1 ms",
):  # fmt: skip
    return SCENE.format(
        mesh=mesh, ratio=ratio, tissue=tissue, body=body, script=script, duration=duration,
        output=output,
    )  # fmt: skip


def test_cells_of_a_lattice_have_27_nodes():
    network = compiled_scene(scene()).network
    (elements,) = network.elements
    assert elements.nodes.shape == (4, 27)
    assert network.node_count == 5 * 3 * 5
    mass = network.mass
    assert mass.sum() == pytest.approx(4e-3, rel=1e-12)
    # Of one element: corners, edges, faces and the centre.
    alone = compiled_scene(scene(ONE)).network.mass * 216.0 / 8e-3
    kinds, counts = np.unique(np.round(alone, 9), return_counts=True)
    assert dict(zip(kinds, counts, strict=True)) == {1: 8, 4: 12, 16: 6, 64: 1}


def test_regions_and_graded_cells_are_those_of_the_elements():
    mesh = LATTICE.replace("20) mm }", "20) mm; fine cell = (10, 10, 1) mm\n"
                           "fine box from (0, 0, 19) mm to (20, 10, 20) mm }")  # fmt: skip
    body = "region top where z > 19 mm { tissue is gel }"
    compiled = compiled_scene(scene(mesh, body=body))
    (elements,) = compiled.network.elements
    heights = np.unique(compiled.network.position[:, 2])
    assert heights[-3:] == pytest.approx([19e-3, 19.5e-3, 20e-3], rel=1e-12)
    assert elements.volume.sum() == pytest.approx(4e-6, rel=1e-12)


@pytest.mark.parametrize(
    "tissue",
    ["retardation time = 5 ms", "relaxing share = 50 %; relaxation time = 5 ms",
     "yield stress = 100 Pa; flow viscosity = 20 Pa*s"],
)  # fmt: skip
def test_runs_agree_with_the_reference(tissue):
    script = "from 0 s to 2 ms: push high with (0, 20, -40) mN using smooth profile"
    text = scene(ONE, tissue=tissue, script=script, duration="3 ms",
                 output="trajectory every 1 ms; position(high) every 1 ms")  # fmt: skip
    validated(text)


def test_a_cut_divides_elements():
    script = "at 0 s: cut block along plane through (0, 0, 11) mm facing (0, 0, 1)"
    text = scene(script=script, output="count(pieces of block) every 1 ms")
    with tissuec.run(text, companion="off") as run:
        (log,) = run.logs.values()
        assert log.value.ravel()[-1] == 2


@pytest.mark.parametrize(
    ("mesh", "body", "code", "said"),
    [
        (LATTICE, "rupture is allowed", "TIS306", "quadratic elements cannot break"),
        ("mesh is sphere { centre = (0, 0, 10) mm; radius = 10 mm; subdivisions = 1 }",
         "thickness = 1 mm", "TIS306", "only solids can consist of quadratic elements"),
        ('mesh is imported { file "box.vtk" in mm }', "", "TIS309",
         "its tetrahedra are quadratic anyway, with ten nodes each"),
    ],
)  # fmt: skip
def test_what_quadratic_elements_are_not_is_refused(
    mesh, body, code, said, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    write_vtk(tmp_path / "box.vtk", *box_of_tetrahedra())
    found = finding_of(compiled_scene, scene(mesh, body=body))
    assert found.code == code and said in found.message
    assert "made of elements" in str(found.hint)


def test_a_made_of_without_a_meaning_names_all_choices():
    found = finding_of(compiled_scene, scene().replace("quadratic elements", "quadratic"))
    assert "elements, quadratic elements, springs" in str(found.hint)
