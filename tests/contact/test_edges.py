"""Thin tools across edges and corners of elements are held, even deeper than their radius."""

import numpy as np
import pytest

from tests.contact.scenes import BLOCK, TUBE, play

SCENE = """language 1
tissue gel {{ Young's modulus = 20 kPa; density = 1000 kg/m^3; retardation time = 5 ms }}
body block {{ mesh is {mesh}
  tissue is gel }}
set base = nodes of block where z < 0.1 mm
tool tool {{ {tool} }}
environment {{ gravity = (0, 0, 0) m/s^2; mass damping = 50 Hz; contact is tools only }}
script {{
  at 0 s: fix base
  from 0 s to 0.1 s: move tool by {way} mm using smooth profile
}}
simulate {{ duration = 0.12 s; tolerance = 1e-2 }}
output {{ force of tool every 10 ms; penetration of tool every 5 ms }}
"""
ACROSS = "kind is probe; radius = 0.5 mm; axis from (-6, 4, 18) mm to (6, 5, 18) mm"
#: Mesh, tool, radius in mm and way.
HELD = {
    "needle askew on an edge": (
        BLOCK,
        "kind is probe; radius = 0.5 mm; axis from (-4, 3, 20) mm to (4, 6, 12.1) mm",
        0.5,
        "(3, 0, -3)",
    ),
    "needle across an edge": (BLOCK, ACROSS, 0.5, "(0, 0, -3)"),
    "hook around a corner": (
        BLOCK,
        "kind is hook; radius = 0.7 mm; shaft from (-6, -10, 17) mm to (-6, 20, 17) mm"
        "; bend = (4, 21, 17) mm",
        0.7,
        "(4, -9, -3)",
    ),
    "hook on a tube": (
        TUBE,
        "kind is hook; radius = 0.7 mm; shaft from (30, 8, 30) mm to (16, 8, 17.2) mm"
        "; bend = (6, 9, 17.2) mm",
        0.7,
        "(0, 0, -4)",
    ),
    "needle along a tube": (
        TUBE,
        "kind is probe; radius = 0.5 mm; axis from (12, -12, 17) mm to (17, 28, 17) mm",
        0.5,
        "(0, 0, -4)",
    ),
}


@pytest.mark.parametrize("name", HELD)
def test_thin_tools_are_held_at_edges(name):
    mesh, tool, radius, way = HELD[name]
    played = play(SCENE.format(mesh=mesh, tool=tool, way=way))
    assert played.outcome.kind == "done" and played.outcome.doubts == ()
    depth = played.log("penetration of tool")[1].max()
    assert 0.02e-3 < depth < 1e-3 * radius
    assert np.linalg.norm(played.log("force of tool")[1][-1]) > 5e-3


def test_a_needle_that_is_pressed_into_an_edge_by_more_than_its_radius_is_held():
    played = play(SCENE.format(mesh=BLOCK, tool=ACROSS, way="(0, 0, -7)"))
    assert played.outcome.kind == "done" and played.outcome.doubts == ()
    assert played.log("penetration of tool")[1].max() > 0.5e-3
    up = -played.log("force of tool")[1][:, 2]
    assert up[-1] > 0.9 * up.max() > 20e-3
