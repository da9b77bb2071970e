"""Elastic constants of elements include their fibres."""

import pytest

import tissuec

SCENE = """language 1
tissue gut {{
  Young's modulus = 40 kPa; Poisson's ratio = {ratio}; density = 1000 kg/m^3
  fibre modulus = 300 kPa
}}
body piece {{ mesh is {mesh}; tissue is gut; {fibres} }}
environment {{ gravity = (0, 0, 0) m/s^2 }}
simulate {{ duration = 1 ms }}
"""
BLOCK = "lattice { cell = 5 mm; box from (0, 0, 0) mm to (10, 10, 20) mm }"
SHEET = """sheet {
  corner = (0, 0, 0) mm; first edge = (0, 12, 9) mm; second edge = (10, 0, 0) mm
  columns = 5; rows = 3
}; thickness = 1 mm"""
TUBE = """tube {
  axis from (0, 0, 0) mm to (0, 20, 15) mm; radius = 8 mm; rings = 6; sides = 24
}; thickness = 1 mm"""


def found(mesh, fibres, ratio=0.45):
    text = SCENE.format(mesh=mesh, fibres=fibres, ratio=ratio)
    (piece,) = tissuec.properties(text, frequencies=0)
    return piece


def across(ratio):
    """Return the modulus across fibres of the modulus b, 1/(1/E - b (ν/E)²/(1 + b/E)) [Pa]."""
    young, added = 40e3, 260e3
    return 1.0 / (1.0 / young - added * (ratio / young) ** 2 / (1.0 + added / young))


@pytest.mark.parametrize("ratio", [0.0, 0.45])
@pytest.mark.parametrize(
    ("mesh", "fibres", "along"),
    [
        (BLOCK, "fibres = (0, 1, 0)", 1),
        (SHEET, "fibres = (0, 12, 9)", 0),
        (SHEET, "fibres = (1, 0, 0)", 1),
        (TUBE, "fibres is axial", 1),
        (TUBE, "fibres is circumferential", 0),
    ],
)
def test_fibres_raise_the_modulus_along_them(mesh, fibres, along, ratio):
    one = found(mesh, fibres, ratio).elasticity
    expected = [across(ratio)] * len(one.young)
    expected[along] = 300e3
    assert one.young == pytest.approx(expected, rel=2e-3)
    assert one.shear == pytest.approx([20e3 / (1.0 + ratio)] * len(one.shear))
    assert one.anisotropy > 300e3 / max(40e3, across(ratio)) * 0.998


def test_helical_fibres_resist_torsion():
    one = found(TUBE, "fibres = 45 deg; second fibres = -45 deg", 0.0).elasticity
    # β a a a a of both families at 45 degrees is β/2 in every component of the plane.
    assert one.young[0] == pytest.approx(one.young[1], rel=1e-3)
    assert one.shear == pytest.approx([20e3 + 130e3], rel=1e-3)


def test_fibres_of_several_directions_have_no_common_constants():
    tube = """thick tube {
      axis from (0, 0, 0) mm to (0, 0, 10) mm; inner radius = 4 mm; outer radius = 5 mm
      rings = 3; sides = 8; layers = 1
    }"""
    piece = found(tube, "fibres is circumferential")
    assert piece.elasticity is None
    assert "elastic constants are not computed for elements that differ" in piece.notes
    assert found(tube, "fibres is axial").elasticity.young[2] == pytest.approx(300e3)
