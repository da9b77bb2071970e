"""Elements that are strained beyond the stability of their law are a doubt of the run."""

import numpy as np
import pytest

import tissuec
from tissuec.engine.execution.doubts import WATCHES
from tissuec.laws.solid.invariants import Yeoh
from tissuec.laws.stability import stable_strains

SCENE = """language 1
tissue soft { Young's modulus = 10 kPa; Poisson's ratio = 0.49; density = 1000 kg/m^3
  solid law is yeoh { second = -0.3 } }
tissue firm { Young's modulus = 10 kPa; Poisson's ratio = 0.49; density = 1000 kg/m^3 }
body block { MESH; tissue is soft; region inner where x < 4.9 mm { tissue is firm } }
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 1 ms }
"""
SOLID = "mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (10, 5, 5) mm }"
WALL = """thickness = 1 mm; mesh is sheet { corner = (0, 0, 0) mm
  first edge = (10, 0, 0) mm; second edge = (0, 5, 0) mm; columns = 3; rows = 2 }"""
LIMIT = stable_strains(Yeoh(second=-0.3)).tension


@pytest.mark.parametrize(("mesh", "count"), [(SOLID, 1), (WALL, 2)])
def test_elements_beyond_the_limit_are_counted(mesh, count):
    text = SCENE.replace("MESH", mesh)
    with pytest.warns(tissuec.TissueWarning, match="stable only up to 52 % in tension"):
        scene = tissuec.compile(text)
    watch, state = WATCHES["unstable law"].of(scene.network, scene.plan), None
    state = scene.plan.start(scene.network)
    for part, expected in ((0.97, 0), (1.03, count)):
        along = 1.0 + part * LIMIT
        x = scene.network.position * [along, along**-0.5, along**-0.5]
        (found,) = watch.look(state, x)
        assert (found.count, bool(found.where)) == (expected, bool(expected))
    alive = np.zeros_like(state.alive)
    state.alive = alive
    assert [one.count for one in watch.look(state, x)] == [0]


def test_stable_laws_are_not_looked_at():
    scene = tissuec.compile(SCENE.replace("-0.3", "0.3").replace("MESH", SOLID))
    assert WATCHES["unstable law"].of(scene.network, scene.plan) is None
