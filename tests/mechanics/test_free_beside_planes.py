"""Bodies that nothing but planes of symmetry holds settle as the whole would."""

import pytest

import tissuec

SCENE = """language 1
tissue gel {{
  Young's modulus = 20 kPa; Poisson's ratio = 0.4; density = 1000 kg/m^3; prestress = 10 %
}}
body block {{
  mesh is lattice {{ cell = 5 mm; box from ({x}, {y}, {z}) mm to (15, 10, 10) mm }}
  tissue is gel; prestress along (1, 0, 0)
}}
set top = nodes of block where z > 9.9 mm
environment {{ gravity = (0, 0, 0) m/s^2; {planes} }}
script {{ at 0 s: {{ {more}settle }} }}
simulate {{ duration = 1 us }}
output {{ trajectory every 1 us }}
"""
ACROSS = {
    axis: "symmetric about plane through (0, 0, 0) mm facing ({}, {}, {})".format(
        *(int(axis == one) for one in "xyz")
    )
    for axis in "xyz"
}


def scene(planes, more=""):
    """Return a block with the part beyond some planes left out."""
    low = {axis: 0 if axis in planes else -15 if axis == "x" else -10 for axis in "xyz"}
    return SCENE.format(**low, planes="; ".join(ACROSS[one] for one in planes), more=more)


def corner(planes, more=""):
    """Return where a corner is [m], shape (3,)."""
    with tissuec.run(scene(planes, more), companion="off") as result:
        return result.position[0][-1]  # nodes of a lattice are numbered towards it


@pytest.mark.parametrize("planes", ["x", "z", "xy", "yz", "xyz"])
def test_a_part_settles_where_it_is_in_the_whole(planes):
    assert corner(planes) == pytest.approx(corner(""), abs=1e-9)


@pytest.mark.parametrize("planes", ["z", "yz"])
def test_planes_bear_what_pushes_a_free_body_onto_them(planes):
    pushed = corner(planes, "push top with (0, 0, -20) mN; ")
    assert 1e-6 < corner(planes)[2] - pushed[2] < 1e-3


def test_a_push_along_a_plane_has_no_equilibrium():
    with pytest.warns(tissuec.TissueWarning, match="no support balances a force of 20 mN"):
        tissuec.run(scene("z", "push top with (20, 0, 0) mN; "), companion="off")
