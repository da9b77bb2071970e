"""Equilibria of volumes, bending walls and foundations have exact derivatives."""

import numpy as np
import pytest

from tests.learn.test_resting import assert_derived, csv, model  # noqa: F401  # a fixture
from tissuec.learn.derivatives.model import measured
from tissuec.learn.fit.search import Search

MOVED = "from 0 s to 1 s: move top by (0.5, 0, 2) mm using smooth profile"
SCENE = """language 1
tissue gum {{ Young's modulus = 40 kPa; density = 1000 kg/m^3; {tissue}
  retardation time = 1 ms }}
body bag {{ made of springs; {mesh}; tissue is gum }}
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
#: A wall that resists bending, around a volume that more than 96 unknowns enclose.
BAG = """mesh is sphere { centre = (0, 0, 0) mm; radius = 10 mm; subdivisions = 1 }
  thickness = 1 mm; bending is elastic"""
#: A solid, each of whose nodes keeps a volume by pressure.
BLOCK = """mesh is lattice { kind is sodium chloride; cell = 8 mm; reach is second neighbours
  box from (-8, -4, -12) mm to (8, 4, 12) mm }"""


def bag():
    script = f"at 0 s: preserve volume of bag with 8 kPa; at 0 s: inflate bag to 5 ml; {MOVED}"
    adjust = "adjust Young's modulus of gum; adjust density of gum"
    return SCENE.format(tissue="", mesh=BAG, script=script, adjust=adjust)


def block(ratio=0.4):
    adjust = "adjust Young's modulus of gum; adjust Poisson's ratio of gum from 0.26 to 0.49"
    tissue = f"Poisson's ratio = {ratio}"
    return SCENE.format(tissue=tissue, mesh=BLOCK, script=MOVED, adjust=adjust)


@pytest.mark.parametrize("scene", [bag, block])
def test_derivatives_are_those_of_the_predictions(model, scene):  # noqa: F811
    found, _ = model(scene(), csv([0.3, 2.0]))
    assert_derived(found, np.array([0.02, -0.05]))


def test_youngs_modulus_and_poissons_ratio_are_found(model):  # noqa: F811
    true, _ = model(block(0.45), csv([0.0, 1.0, 2.0]))
    values = true.predict(np.array([np.log(1.5), 0.0]))
    found, problem = model(block(0.3), csv([0.0, 1.0, 2.0]))
    problem.data = values
    assert len(measured(found.series)) == len(values)
    search = Search(problem, found.shaping.bounds(), lambda _: None)
    end = search.go(search.begin())
    modulus, ratio = (
        found.shaping.blocks[k].value(end.theta[found.shaping.place(k)])[0] for k in (0, 1)
    )
    # Data is exact, and the search ends at its own tolerance of the error.
    assert (modulus, ratio) == pytest.approx((60e3, 0.45), rel=1e-6)
