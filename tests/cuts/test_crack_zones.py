"""Warnings of meshes that are too coarse for the zones in which faces of tears soften."""

import numpy as np
import pytest

from tests.validate.scenes import compiled_scene
from tissuec.compiler.checks.crack_zones import crack_zones

STRIP = """language 1
tissue gel { Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3
  toughness = 0.2 J/m^2; STRENGTH }
body strip {
  mesh is lattice { cell = CELL mm; box from (0, 0, 0) mm to (28, 14, CELL) mm }
  made of elements; tissue is gel; RUPTURE
}
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 1 ms }
"""
PLANE = 10e3 / (1.0 - 0.3**2)  # E' [Pa]


def text(cell, strength="", rupture="rupture by faces"):
    found = STRIP.replace("CELL", str(cell)).replace("RUPTURE", rupture)
    return found.replace("STRENGTH", strength)


def warnings(cell=2.0, **given):
    return list(crack_zones(compiled_scene(text(cell, **given))))


def strength_of(zone):
    """Return a strength [Pa] whose zone has this length [m]."""
    return np.sqrt(9.0 * np.pi / 32.0 * PLANE * 0.2 / zone)


def test_seven_cells_across_are_enough():
    assert not warnings()


def test_too_few_cells_across_are_reported_with_the_zone():
    (found,) = warnings(cell=3.5)
    assert found.code == "W218"
    assert "softens along 3 cells (10.5 mm)" in found.message
    assert "14 mm across" in found.message
    assert "of 2 mm or less" in found.hint


def test_such_a_body_reaches_its_strength_before_its_toughness():
    """The bound is that of a strip of the height H: G = σ²H/2E'."""
    network = compiled_scene(text(2.0)).network
    (field,) = network.elements_of("strip")
    stress = np.sqrt(2.0 * PLANE * 0.2 / 14e-3)
    assert field.limits.stress == pytest.approx(stress, rel=0.02)
    assert (field.limits.stress > stress).all()


@pytest.mark.parametrize(("zone", "count"), [(1.9e-3, 1), (2.1e-3, 0)])
def test_strengths_whose_zone_is_shorter_than_a_cell_are_reported(zone, count):
    found = warnings(strength=f"strength = {strength_of(zone)} Pa")
    assert len(found) == count
    for each in found:
        assert "soften along 1.9 mm, less than a cell (2 mm)" in each.message
        assert "strength" in each.span.text
        assert each.hint == "leave the strength out"


def test_only_tears_by_faces_have_zones():
    assert not warnings(cell=3.5, rupture="rupture by toughness")
    assert not warnings(cell=3.5, rupture="rupture is not allowed")
