"""Cells end where regions do: volumes in closed form, and which nodes move."""

import numpy as np
import pytest

from tests.every import every
from tests.scene.test_region_volumes import CUBES, scene, sizes
from tests.validate.scenes import compiled_scene

COARSE = CUBES.format(5)
TUBE = """thick tube { axis from (0, 0, 0) mm to (0, 0, 40) mm; inner radius = 5 mm
  outer radius = 9 mm; rings = 9; sides = 16 }"""
ROD = "cylinder { axis from (0, 0, 0) mm to (0, 0, 40) mm; radius = 10 mm; cell = 5 mm }"
SHEET = """sheet { corner = (0, 0, 0) mm; first edge = (20, 0, 0) mm
  second edge = (0, 0, 20) mm
  columns = 5; rows = 5 }"""
LUMEN = "tube { axis from (0, 0, 0) mm to (0, 0, 40) mm; radius = 5 mm; rings = 9; sides = 12 }"


def region(condition):
    return f"region part where {condition} {{ tissue is hard }}"


def planes(text, axis):
    """Return where nodes are along an axis [mm]."""
    mesh = compiled_scene(text).groups.bodies["block"].drawing.mesh
    return np.unique(np.round(1e3 * mesh.position[:, axis], 9)).tolist()


@every(
    ("mesh", "condition", "volume"),
    [
        (COARSE, "z > 13 mm", 400 * 7),
        (COARSE, "z - 3 mm > 4 mm and not (2 * z > 26 mm)", 400 * 6),
        (COARSE, "z > 13 mm and x between 4 mm and 9 mm", 20 * 7 * 5),
        (COARSE, "z > 17.6 mm or z < 2.6 mm", 400 * 5),
        (COARSE, "x between 9 mm and 10.5 mm", 400 * 1.5),
        (COARSE, "x^2 > 169 mm^2", 400 * 7),
        (ROD, "z > 13 mm", 27 * np.pi * 100),
        (TUBE, "z > 13 mm", 27 * np.pi * (81 - 25)),
        (TUBE, "x^2 + y^2 > 64 mm^2", 40 * np.pi * (81 - 64)),
        (TUBE, "x^2 + y^2 < 36 mm^2 and z between 7 mm and 13 mm", 6 * np.pi * (36 - 25)),
    ],
)
def test_regions_have_the_volumes_of_their_conditions(mesh, condition, volume):
    ((size, _),) = sizes(scene(mesh, region(condition)))
    assert size == pytest.approx(volume * 1e-9, rel=1e-9)


@every(
    ("mesh", "condition", "area"),
    [(SHEET, "z > 13 mm and x < 4 mm", 28.0), (LUMEN, "z < 13 mm", None)],
)
def test_so_have_those_of_walls(mesh, condition, area):
    ((size, written),) = sizes(scene(mesh, region(condition), more="; thickness = 1 mm"))
    due = 1e6 * written if area is None else area
    # Places at which the condition is examined are counted to one per cent.
    assert 1e6 * size == pytest.approx(due, rel=0.01 if area is None else 1e-9)


def test_only_the_nearest_planes_move():
    moved = scene(COARSE, region("z > 13 mm"))
    assert planes(moved, 2) == [0.0, 5.0, 10.0, 13.0, 20.0]
    assert planes(moved, 0) == [0.0, 5.0, 10.0, 15.0, 20.0]
    # Both are nearest to the plane at 10 mm; the other one of the two moves less than 15 mm.
    assert planes(scene(COARSE, region("z between 9 mm and 10.5 mm")), 2) == [
        0,
        9,
        10.5,
        15,
        20,
    ]


def test_planes_at_borders_stay():
    two = f"{region('z > 10 mm')}\n  region other where z < 8.5 mm {{ tissue is hard }}"
    assert planes(scene(COARSE, two), 2) == [0.0, 8.5, 10.0, 15.0, 20.0]
    assert planes(scene(COARSE, region("z >= 10 mm")), 2) == [0.0, 5.0, 10.0, 15.0, 20.0]


def test_no_cell_becomes_thinner_than_a_quarter():
    text = scene(COARSE, region("z > 13 mm or z > 19 mm"))
    assert planes(text, 2) == [0.0, 5.0, 10.0, 13.0, 20.0]
    text = scene(COARSE, region("z > 18.7 mm"))
    assert planes(text, 2) == [0.0, 5.0, 10.0, 18.7, 20.0]


def test_graded_cells_move_too():
    fine = "lattice { cell = 5 mm; box from (0, 0, 0) mm to (20, 20, 20) mm; fine cell = 1 mm; "
    fine += "fine box from (0, 0, 16) mm to (20, 20, 20) mm }"
    ((size, _),) = sizes(scene(fine, region("z > 16.4 mm")))
    assert size == pytest.approx(400 * 3.6e-9, rel=1e-9)


def test_moved_meshes_and_bodies_have_their_borders_where_they_are_described():
    turned = COARSE.replace("}", "; scaled by 2; turned by 90 deg around (0, 1, 0) "
                                 "through (0, 0, 0) mm }")  # fmt: skip
    ((size, _),) = sizes(scene(turned, region("x > 13 mm")))
    assert size == pytest.approx(1600 * 27e-9, rel=1e-9)
    ((size, _),) = sizes(scene(COARSE, region("z > 13 mm"), more="; scaled by 2"))
    assert size == pytest.approx(8 * 400 * 7e-9, rel=1e-9)


@every(
    "condition",
    [
        "within 6 mm of (10, 10, 10) mm",
        "z + 0.1 * x > 13 mm",
        "z == 13 mm or z > 10 mm",
    ],
)
def test_borders_that_cells_cannot_follow_move_nothing(condition):
    text = scene(COARSE, region(condition))
    for axis in range(3):
        assert planes(text, axis) == [0.0, 5.0, 10.0, 15.0, 20.0]


def test_masses_are_those_of_regions():
    heavy = scene(COARSE, region("z > 13 mm")).replace(
        "tissue hard like gel { ", "tissue hard like gel { density = 2000 kg/m^3; "
    )
    network = compiled_scene(heavy).network
    assert network.mass.sum() == pytest.approx(400e-9 * (13 * 1000 + 7 * 2000), rel=1e-12)


def test_nodes_between_corners_follow_them():
    text = scene(COARSE, region("z > 13 mm")).replace("of elements", "of quadratic elements")
    assert planes(text, 2) == [0.0, 2.5, 5.0, 7.5, 10.0, 11.5, 13.0, 16.5, 20.0]
    ((size, _),) = sizes(text)
    assert size == pytest.approx(400 * 7e-9, rel=1e-9)
