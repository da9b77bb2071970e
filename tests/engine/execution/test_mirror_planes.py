"""Nodes that cross a plane of symmetry are a doubt of the run."""

import tissuec
from tests.whole_runs import carried_out
from tissuec.engine.execution.doubts import WATCHES

#: A bar between two planes, which a force on its end bends back.
SCENE = """language 1
tissue gel { Young's modulus = 2 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3
  retardation time = 5 ms }
body bar {
  mesh is lattice { cell = 2.5 mm; box from (0, 0, 0) mm to (20, 5, 2.5) mm }
  tissue is gel
}
set low = nodes of bar where x < 0.1 mm
set tip = nodes of bar where x > 19.9 mm
environment { gravity = (0, 0, 0) m/s^2; damping = 0.0005 N*s/m
  symmetric about plane through (0, 0, 0) mm facing (1, 0, 0) }
script { at 0 s: fix low
  at 0 s: push tip with FORCE mN }
simulate { duration = 0.4 s; tolerance = 1e-2 }
"""
BACK = SCENE.replace("FORCE", "(-8, 1, 0)")
ASIDE = SCENE.replace("FORCE", "(0, 0.1, 0)")
KIND = "beyond a plane of symmetry"


def found(text):
    outcome, _ = carried_out(tissuec.compile(text))
    return [doubt for doubt in outcome.doubts if doubt.kind == KIND]


def test_a_dead_load_that_pushes_nodes_into_the_mirror_image_is_reported():
    (doubt,) = found(BACK)
    assert doubt.subject == "bar"
    assert doubt.what == "nodes of bar are beyond a plane of symmetry, in their mirror image"
    assert doubt.most >= doubt.last > 0
    assert "node " in doubt.where
    assert "drawn at" in doubt.where
    assert doubt.unit == "node"


def test_nodes_on_their_side_and_on_the_plane_are_none():
    assert found(ASIDE) == []


def test_scenes_without_planes_are_not_looked_at():
    text = ASIDE.replace("symmetric about plane through (0, 0, 0) mm facing (1, 0, 0)", "")
    scene = tissuec.compile(text)
    assert WATCHES[KIND].of(scene.network, scene.plan) is None
