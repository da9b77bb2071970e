"""Equilibria of volumes, bending walls and foundations have exact derivatives."""

import numpy as np

from tests.learn.test_resting import assert_derived, csv, model  # noqa: F401  # a fixture

MOVED = "from 0 s to 1 s: move top by (0.5, 0, 2) mm using smooth profile"
SCENE = """language 1
tissue gum {{ spring constant = 28 N/m; density = 1000 kg/m^3; {tissue}
  retardation time = 1 ms }}
body bag {{ {mesh}; tissue is gum }}
force bed {{ kind is foundation; acts on bag; stiffness = 100 kPa/m }}
set bottom = nodes of bag where z < -8 mm
set top = nodes of bag where z > 8 mm
set side = nodes of bag where x > 6 mm
environment {{ gravity = (0, 0, -9.81) m/s^2 }}
script {{ at 0 s: fix bottom; {script} }}
simulate {{ duration = 1 s }}
learn gum {{ data = "data.csv"; displacement of top along (0, 0, 1) using column "u" in mm
  fit = force(top) using columns "f g h" in N
  fit = position(side) along (1, 0, 0) using column "f" in mm
  {adjust} }}
"""
#: A wall around a volume that more than 96 unknowns enclose.
BAG = """mesh is sphere { centre = (0, 0, 0) mm; radius = 10 mm; subdivisions = 1 }
  thickness = 1 mm"""


def bag():
    script = f"at 0 s: preserve volume of bag with 8 kPa; at 0 s: inflate bag to 5 ml; {MOVED}"
    adjust = "adjust spring constant of gum; adjust density of gum"
    return SCENE.format(tissue="", mesh=BAG, script=script, adjust=adjust)


def test_derivatives_are_those_of_the_predictions(model):  # noqa: F811
    found, _ = model(bag(), csv([0.3, 2.0]))
    assert_derived(found, np.array([0.02, -0.05]))
