"""Regions of elements: their nodes, volumes, and what is said where they are not as written."""

import numpy as np
import pytest

import tissuec
from tests.every import every
from tests.findings import finding_of
from tests.validate.scenes import compiled_scene
from tests.whole_runs import carried_out
from tissuec.compiler.elements.region_sizes import region_sizes
from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.geometry.element_samples import samples_within
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

SCENE = """language 1
tissue gel {{ Young's modulus = 5 kPa; density = 1000 kg/m^3 }}
tissue hard like gel {{ Young's modulus = 200 kPa }}
body block {{
  mesh is {mesh}
  tissue is gel; made of elements {more}
  {regions}
}}
{sets}
environment {{ gravity = (0, 0, 0) m/s^2 }}
simulate {{ duration = 1 us }}
{output}
"""
CUBES = "lattice {{ cell = {} mm; box from (0, 0, 0) mm to (20, 20, 20) mm }}"
COARSE = CUBES.format(5)
ROUND = "{ axis from (10, 10, 0) mm to (10, 10, 20) mm; radius = 10 mm; cell = 5 mm }"
WALL = """{ corner = (0, 0, 0) mm; first edge = (20, 0, 0) mm; second edge = (0, 0, 20) mm
  columns = 5; rows = 5 }"""
BALL_OF_9 = "ellipsoid { centre = (0, 0, 0) mm; radii = (9, 9, 9) mm; "
AXIS = "{ axis from (0, 0, 0) mm to (0, 0, 9) mm; "
TUBE = f"thick tube {AXIS} inner radius = 5 mm; outer radius = 9 mm; rings = 3; "
BALL = "region nodule where within 6 mm of (10, 10, 10) mm { tissue is hard }"
LAYER = "region cover where z > 13 mm { tissue is hard }"


def scene(mesh=COARSE, regions="", sets="", output="", more=""):
    return SCENE.format(mesh=mesh, regions=regions, sets=sets, output=output, more=more)


def sizes(text):
    """Return the size of each region of the block, and what is written."""
    drawing = compiled_scene(text).groups.bodies["block"].drawing
    return [(one.size, one.written) for one in region_sizes(drawing)]


def warnings(text):
    found = compile_request(Request(Source("scene.tis", text)))[1]
    return [one for one in found if one.code == "W213"]


def test_nodes_and_elements_of_a_region_are_those_of_each_other():
    logs = """set nodule = nodes of block where region is nodule
output { count(elements of nodule) every 1 us; count(nodes of nodule) every 1 us }"""
    _, run = carried_out(compiled_scene(scene(regions=BALL, output=logs)))
    assert run.log_arrays("elements of nodule")[1].tolist() == [[8.0], [8.0]]
    assert run.log_arrays("nodes of nodule")[1].tolist() == [[27.0], [27.0]]


def test_regions_side_by_side_share_the_nodes_between_them():
    regions = """region low where z < 10 mm { tissue is gel }
  region high where z > 10 mm { tissue is hard }"""
    compiled = compiled_scene(scene(regions=regions))
    named = {one.name: one.indices for one in compiled.groups.named()}
    height = compiled.network.position[:, 2]
    assert np.array_equal(named["low"], np.flatnonzero(height <= 10e-3))
    assert np.array_equal(named["high"], np.flatnonzero(height >= 10e-3))


@every(
    ("mesh", "more"),
    [
        (COARSE, ""),
        (CUBES.format(1.25), ""),
        (f"cylinder {ROUND}", ""),
        (f"sheet {WALL}", "; thickness = 1 mm"),
    ],
)  # fmt: skip
def test_volumes_of_conditions_are_found_to_one_per_cent(mesh, more):
    found = compiled_scene(scene(mesh, more=more)).groups.bodies["block"].drawing.mesh
    whole = 400e-6 if more else float(found.volume.sum())
    ((_, written),) = sizes(scene(mesh, LAYER, more=more))
    assert written == pytest.approx(0.35 * whole, rel=0.01)
    if not more and "lattice" in mesh:
        ((_, written),) = sizes(scene(mesh, BALL))
        assert written == pytest.approx(4 / 3 * np.pi * 6e-3**3, rel=0.01)


@every("shape", ["hexahedron", "wedge", "tetrahedron", "triangle"])
def test_samples_fill_elements_evenly(shape):
    weights = samples_within(shape, 4000)
    assert weights.min() >= 0.0 and weights.sum(axis=1) == pytest.approx(1.0)
    assert weights.mean(axis=0) == pytest.approx(1.0 / weights.shape[1], rel=0.02)
    if shape in ("tetrahedron", "triangle"):  # second moments of simplices: 2 / ((n+1)(n+2))
        corners = weights.shape[1]
        second = 2.0 / (corners * (corners + 1))
        assert (weights**2).mean(axis=0) == pytest.approx(second, rel=0.03)


def test_a_region_of_whole_cells_has_its_volume_and_no_warning():
    text = scene(COARSE, "region top where z > 10 mm { tissue is hard }")
    assert sizes(text)[0] == pytest.approx((4e-6, 4e-6), rel=1e-3)
    assert not warnings(text)


def test_a_ball_of_few_cells_is_reported_with_its_volumes():
    text = scene(COARSE, BALL)  # of 6 mm, of which there are eight cells
    (found,) = warnings(text)
    assert found.span.text.startswith("region nodule")
    assert "have the volume 1 ml, 11 % more than its condition (0.904 ml)" in found.message
    assert not warnings(scene(CUBES.format(1), BALL))  # as the hint says


def test_moved_and_scaled_bodies_are_measured_where_they_are_described():
    moved = "; scaled by 2; turned by 90 deg around (0, 1, 0) through (0, 0, 0) mm"
    (size, written) = sizes(scene(COARSE, BALL, more=moved))[0]
    ball = 4.0 / 3.0 * np.pi * 6e-3**3
    assert size == pytest.approx(8 * 1e-6) and written == pytest.approx(8 * ball, rel=5e-3)


@every(
    ("mesh", "share"),
    [
        ("ellipsoid { centre = (0, 0, 0) mm; radii = (20, 12, 8) mm; cell = 5 mm }", "18 %"),
        (f"{BALL_OF_9} cell = 5 mm; part is eighth }}", "23 %"),
        (f"{BALL_OF_9} cell = 1.8 mm }}", ""),
    ],
)
def test_round_nets_of_few_cells_are_reported(mesh, share):
    text = scene(mesh)
    assert not warnings(text)
    net = text.replace("made of elements", "made of springs")
    net = net.replace("Young's modulus = 5 kPa", "spring constant = 5 N/m")
    net = net.replace("density", "retardation time = 1 ms; density")
    assert [f"{share} less" in one.message for one in warnings(net)] == [True] * bool(share)


def test_the_volume_of_a_shape_is_that_of_its_elements():
    for mesh in (
        f"cylinder {AXIS} radius = 9 mm; end radius = 5 mm; cell = 0.6 mm; part is quarter }}",
        f"{TUBE} end outer radius = 7 mm; sides = 200; part is half }}",
    ):
        drawing = compiled_scene(scene(mesh)).groups.bodies["block"].drawing
        assert drawing.mesh.volume.sum() == pytest.approx(
            drawing.body.mesh.shape_volume, rel=1e-12
        )


def test_bodies_are_explained_with_the_volumes_of_their_regions():
    (body,) = tissuec.properties(scene(COARSE, BALL), frequencies=0)
    (region,) = body.regions
    assert region.name == "nodule" and region.size == pytest.approx(1e-6)
    assert region.written == pytest.approx(4.0 / 3.0 * np.pi * 6e-3**3, rel=5e-3)


THREE = """*NODE
{nodes}
*ELEMENT, TYPE=C3D8, ELSET=P1
1, 1,2,6,5,9,10,14,13
*ELEMENT, TYPE=C3D8, ELSET=P2
2, 2,3,7,6,10,11,15,14
*ELEMENT, TYPE=C3D8, ELSET=P3
3, 3,4,8,7,11,12,16,15
"""


def test_three_parts_of_a_file_are_three_regions(tmp_path):
    places = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1, 2, 3)]
    rows = "\n".join(f"{n}, {x}, {y}, {z}" for n, (x, y, z) in enumerate(places, start=1))
    (tmp_path / "parts.inp").write_text(THREE.format(nodes=rows), encoding="utf-8")
    mesh = 'imported { file "parts.inp" in mm }'
    names = {"two": "P2", "three": "P3"}
    regions = "\n  ".join(
        f'region {name} where group is "{part}" {{ tissue is hard }}'
        for name, part in names.items()
    )
    path = tmp_path / "scene.tis"
    path.write_text(scene(mesh, regions), encoding="utf-8")
    compiled = compile_request(Request.file(path))[0]
    drawing = compiled.groups.bodies["block"].drawing
    assert drawing.element_part.tolist() == [0, 1, 2]
    assert [len(one.indices) for one in compiled.groups.named()] == [8, 8]


def test_the_way_out_of_regions_that_overlap_works():
    regions = """region left where x < 11 mm { tissue is gel }
  region right where x > 6 mm and z > 5 mm { tissue is hard }"""
    found = finding_of(compiled_scene, scene(regions=regions))
    assert found.code == "TIS311" and "share 12 elements" in found.message
    more = found.hint.split(": ")[1].split(", or")[0]
    assert more == "and not (x < 11 mm)"
    compiled_scene(scene(regions=regions.replace("z > 5 mm", f"z > 5 mm {more}")))


def test_elements_without_a_region_that_holds_a_centre_are_an_error():
    text = scene(regions="region cover where z > 19 mm { tissue is hard }")
    with pytest.raises(CompileError, match="contains the centre of no element"):
        compiled_scene(text)


def test_a_layer_between_parts_that_has_their_nodes_alone_is_no_part_of_them(tmp_path):
    """All nodes of the middle element belong to elements of P1 as well."""
    places = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1, 2, 3)]
    rows = "\n".join(f"{n}, {x}, {y}, {z}" for n, (x, y, z) in enumerate(places, start=1))
    file = THREE.format(nodes=rows).replace("ELSET=P3", "ELSET=P1")
    (tmp_path / "parts.inp").write_text(file, encoding="utf-8")
    path = tmp_path / "scene.tis"
    for part, found in (("P1", [1, 0, 1]), ("P2", [0, 1, 0])):
        region = f'region outer where group is "{part}" {{ tissue is hard }}'
        text = scene('imported { file "parts.inp" in mm }', region)
        path.write_text(text, encoding="utf-8")
        drawing = compile_request(Request.file(path))[0].groups.bodies["block"].drawing
        assert drawing.element_part.tolist() == found
        (size,) = [one.size for one in region_sizes(drawing)]
        assert size == pytest.approx(sum(found) * 1e-9)
