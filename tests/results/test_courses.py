"""Instruments without a shape are drawn where they hold and cut, and enter no tissue."""

from collections import Counter
from functools import cache

import numpy as np
import pytest

import tissuec
from tests.every import every
from tissuec.results.instruments.courses import courses, scissors_of, solids
from tissuec.results.instruments.grips import Scenery, rotations
from tissuec.results.instruments.meshes import KINDS, mesh_of, placed
from tissuec.results.moments import Moments

BAR = """language 1
tissue wall { spring constant = 100 N/m; viscosity = 0.1 N*s/m; mass = 2 g }
body bar {
  mesh is tube {
    axis from (0, 0, 0) mm to (60, 0, 0) mm
    radius = 4 mm; rings = 16; sides = 8; interior is crossed
  }
  tissue is wall
}
set ends = nodes of bar where x < 1 mm
set grip = nodes of bar where x between 47 mm and 53 mm
tool pincers { kind is forceps }
tool shears { kind is scissors }
tool finger { kind is probe; radius = 3 mm; centre = (30, 0, 40) mm }
tool spout { kind is nozzle; diameter = 2 mm; tip = (10, 0, 25) mm; direction = (0, 0, -1) }
tool bench { kind is plane; point = (0, 0, -20) mm; normal = (0, 0.6, 0.8) }
environment {
  gravity = (0, 0, 0) m/s^2; damping = 0.1 N*s/m
  contact is tools only; contact stiffness = 10 N/m
}
script {
  at 0 s: fix ends
  at 0.1 s: grasp grip with pincers
  from 0.1 s to 0.3 s: move pincers by (0, 3, 4) mm using smooth profile
  from 0.1 s to 0.3 s: turn pincers by 20 deg around (1, 0, 0) through (50, 0, 0) mm
    using smooth profile
  at 0.4 s: CUT
  at 0.5 s: release grip from pincers
  from 0.2 s to 0.35 s: irrigate bar with 1 ml/s through spout
}
simulate { duration = 0.6 s; tolerance = 1e-3 }
output { trajectory every 10 ms }
"""
PLANE = "cut bar along plane through (22, 0, 0) mm facing (1, 0, 0)"


@cache
def seen(cut: str):
    result = tissuec.run(BAR.replace("CUT", cut), companion="off")
    moments = Moments.of(result, np.arange(len(result.times)))
    return result, moments, {one.kind: one for one in courses(moments)}


@every("kind", KINDS)
def test_meshes_are_closed_and_face_outwards(kind):
    mesh = mesh_of(kind)
    rows = mesh.triangles.tolist()
    edges = Counter((a, b) for x, y, z in rows for a, b in ((x, y), (y, z), (z, x)))
    assert all(edges[b, a] == count == 1 for (a, b), count in edges.items())
    corners = mesh.vertices[mesh.triangles]
    assert (corners[:, 0] * np.cross(corners[:, 1], corners[:, 2])).sum() > 0.0
    assert len(mesh.triangles) <= 600


def test_forceps_move_rigidly_with_what_they_hold():
    result, moments, found = seen(f"{PLANE} with shears")
    forceps = found["forceps"]
    held = moments.vectors("position", result.nodes_of("grip"), np.float64)
    during = (moments.times >= 0.1) & (moments.times <= 0.5 - 1e-9)
    local = np.einsum("rij,rnj->rni", forceps.axes, held - forceps.origin[:, None])[during]
    # The held nodes move by 5 mm and turn by 0.4; single precision of frames limits this.
    assert np.abs(local - local[0]).max() < 1e-7
    assert np.ptp(forceps.origin[during], axis=0).max() > 3e-3


def test_jaws_touch_the_surface_of_what_they_hold():
    result, moments, found = seen(f"{PLANE} with shears")
    forceps = found["forceps"]
    row = Scenery.of(moments).row(0.3)
    grip = moments.vectors("position", result.nodes_of("grip"), np.float64)[row]
    local = (grip - forceps.origin[row]) @ forceps.axes[row].T
    points = mesh_of("forceps").posed(float(forceps.setting[row])) * forceps.size
    upper = mesh_of("forceps").part == 1
    tips = points[upper & (points[:, 2] < 0.3 * forceps.size)]
    # The inner face of the upper jaw stands at the outermost node, within a tenth of a unit.
    assert tips[:, 0].min() == pytest.approx(local[:, 0].max(), abs=0.1 * forceps.size)


SOLID = """language 1
tissue gel { Young's modulus = 5 kPa; density = 1000 kg/m^3 }
body bar {
  mesh is lattice { cell = 4 mm; box from (0, 0, 0) mm to (20, 8, 8) mm }; tissue is gel
  made of elements
}
tool shears { kind is scissors }
environment { gravity = (0, 0, 0) m/s^2 }
script { at 1 ms: cut bar along plane through (10, 0, 0) mm facing (1, 0, 0) with shears }
simulate { duration = 2 ms }
output { trajectory every 1 ms }
"""


def test_scissors_are_drawn_where_they_cut_elements():
    with tissuec.run(SOLID, companion="off") as result:
        (scissors,) = courses(Moments.of(result, np.arange(len(result.times))))
    assert scissors.kind == "scissors"
    assert np.abs(scissors.axes[0, 1]) == pytest.approx([1.0, 0.0, 0.0], abs=1e-9)
    # In the middle of the cut edges, which nothing has moved yet.
    assert scissors.origin[1, 0] == pytest.approx(10e-3, abs=1e-4)


WIDEST = 0.35 - 1e-9  # [rad]: of each jaw
BALL = """language 1
tissue wall { spring constant = 100 N/m; viscosity = 0.1 N*s/m; mass = 2 g }
body ball {
  mesh is sphere { centre = (0, 0, 0) mm; radius = 13 mm; subdivisions = 2 }
  tissue is wall
}
set fundus = nodes of ball where PATCH
tool pincers { kind is KIND; SHAFT }
environment { gravity = (0, 0, 0) m/s^2 }
script { at 0 s: grasp fundus with pincers }
simulate { duration = 1 ms; integrator is velocity verlet; step = 1 ms }
output { trajectory every 1 ms }
"""


@pytest.mark.parametrize("kind", ["forceps", "clamp"])
@pytest.mark.parametrize(
    ("patch", "shaft"),
    [
        ("x > 10 mm", "shaft = (1, 0, 0)"),
        ("x > 10 mm", "shaft = (2, 1, 1)"),
        ("x + z > 15 mm", "shaft = (0, 1, 3)"),
        ("x + 2 * y > 24 mm", ""),
    ],
)
def test_both_jaws_touch_the_outermost_nodes_that_they_hold(kind, patch, shaft):
    scene = BALL.replace("PATCH", patch).replace("KIND", kind).replace("SHAFT", shaft)
    result = tissuec.run(scene, companion="off")
    moments = Moments.of(result, np.arange(len(result.times)))
    (found,) = courses(moments)
    held = moments.vectors("position", result.nodes_of("fundus"), np.float64)[0]
    local = (held - found.origin[0]) @ found.axes[0].T / found.size
    mesh = mesh_of(kind)
    points = mesh.posed(float(found.setting[0]))
    gaps: list[float] = []
    for part, side in ((1, 1.0), (2, -1.0)):
        node = local[(side * local[:, 0]).argmax()]
        jaw = points[(mesh.part == part) & (mesh.vertices[:, 2] < 4.0)] * [side, 1.0, 1.0]
        # The inner face is the least of each ring; jaws are 0.2 units thick and not quite flat.
        inner = jaw[np.lexsort((jaw[:, 0], jaw[:, 2].round(1)))]
        heights = np.unique(inner[:, 2].round(1))
        faces = [inner[inner[:, 2].round(1) == z, 0].min() for z in heights]
        assert heights[0] - 0.1 < node[2]
        gaps.append(side * node[0] - float(np.interp(node[2], heights, faces)))
    if found.setting[0] < WIDEST:
        assert gaps == pytest.approx([0.0, 0.0], abs=0.25)
    else:  # jaws that are too small are open as far as they can, between both nodes
        assert min(gaps) > 0.0


def test_scissors_close_in_the_plane_of_the_cut_when_it_happens():
    _, moments, found = seen(f"{PLANE} with shears")
    scissors, row = found["scissors"], Scenery.of(moments).row(0.4)
    # Springs show where the cut is; forceps have bent the tube by a tenth there.
    np.testing.assert_allclose(np.abs(scissors.axes[row, 1]), [1.0, 0.0, 0.0], atol=0.15)
    assert scissors.origin[row, 0] == pytest.approx(22e-3, abs=2e-3)  # half of a cell
    assert scissors.setting[row] == 0.0
    assert scissors.setting[row - 3] > 0.05
    assert scissors.life[0] < 0.4 < scissors.life[1] < 0.5


def test_a_scalpel_cuts_where_no_scissors_are_named():
    result, moments, found = seen(PLANE)
    assert "scalpel" in found and "scissors" not in found
    scalpel, row = found["scalpel"], Scenery.of(moments).row(0.4)
    # Its edge stands at the outermost of the springs that it cuts, not in the tissue.
    event = next(one for one in result.events if one.kind == "cut")
    places = moments.vectors_in("position", row)[
        result.network.springs.ends[list(event.springs)]
    ]
    shaft = scalpel.axes[row, 2]
    assert scalpel.origin[row] @ shaft == pytest.approx((places.mean(axis=1) @ shaft).max())


def test_a_jet_flows_while_it_irrigates_and_ends_at_the_tissue():
    _, moments, found = seen(PLANE)
    jet, row = found["jet"], Scenery.of(moments).row(0.2)
    assert jet.life == pytest.approx((0.2, 0.35))
    np.testing.assert_allclose(jet.axes[row, 2], [0.0, 0.0, 1.0], atol=1e-12)
    # From 25 mm above the axis of the tube to its upper side at 4 mm, or to nodes beside it.
    assert 20e-3 < jet.size * jet.setting[row] < 26e-3


def test_the_handle_of_a_probe_leads_away_from_the_tissue():
    _, _, found = seen(PLANE)
    handle = found["handle"]
    assert handle.size == 3e-3
    assert handle.axes[0, 2, 2] > 0.7  # upwards: the tube is below


SUTURE = """language 1
tissue silk { spring constant = 200 N/m; viscosity = 0.5 N*s/m; mass = 20 mg }
body cord {
  mesh is thread { line from (0, 0, 0) mm to (24, 0, 0) mm; pieces = 6; thickness = 0.6 mm }
  tissue is silk
}
set start = nodes of cord where x < 1 mm
set tail = nodes of cord where x > 23 mm
set waist = springs of cord where x between 9 mm and 11 mm
tool "Needle 1" { kind is needle; size = 1.5 mm }
tool haemostat { kind is clamp; shaft = (3, 0, 4) }
tool shears { kind is scissors; shaft = (3, -4, 0); size = 2 mm }
tool finger { kind is probe; radius = 1 mm; centre = (0, 0, 9) mm; shaft = (0, 2, 0) }
environment {
  gravity = (0, 0, 0) m/s^2; damping = 1 mN*s/m
  contact is tools only; contact stiffness = 10 N/m
}
script {
  at 0 s: { grasp start with haemostat; grasp tail with "needle 1" }
  from 0 s to 80 ms: move "needle 1" by (0, 2, 3) mm using smooth profile
  at 60 ms: cut waist with Shears
}
simulate { duration = 0.1 s; tolerance = 1e-3 }
output { trajectory every 10 ms }
"""


def test_instruments_are_drawn_as_the_scene_says():
    result = tissuec.run(SUTURE, companion="off")
    moments = Moments.of(result, np.arange(len(result.times)))
    found = {one.kind: one for one in courses(moments)}
    assert set(found) == {"needle", "clamp", "scissors", "handle"}
    needle, clamp, scissors, handle = (
        found[kind] for kind in ("needle", "clamp", "scissors", "handle")
    )
    # The needle leads the thread onwards from its end, which its tail stays at.
    assert (needle.name, needle.size) == ("Needle 1", 1.5e-3)
    np.testing.assert_allclose(needle.axes[0, 2], [1.0, 0.0, 0.0], atol=1e-9)
    tail = moments.vectors("position", result.nodes_of("tail"), np.float64)[:, 0]
    np.testing.assert_allclose(needle.origin, tail, atol=1e-12)
    assert np.ptp(tail, axis=0).max() == pytest.approx(3e-3)
    np.testing.assert_allclose(clamp.axes[0, 2], [0.6, 0.0, 0.8])
    assert scissors.size == 2e-3
    # The shaft lies in the plane of the cut, which is across x.
    np.testing.assert_allclose(scissors.axes[0, 2], [0.0, -1.0, 0.0], atol=0.2)
    np.testing.assert_allclose(handle.axes[:, 2], [[0.0, 1.0, 0.0]] * len(moments))


def test_shapes_of_tools_are_surfaces_where_their_nodes_are():
    _, moments, _ = seen(PLANE)
    found = {one.kind: one for one in solids(moments)}
    names = {kind: one.name for kind, one in found.items()}
    assert names == {"capsule": "finger", "opening": "spout", "plane": "bench"}
    ball, tube, plate = (placed(found[kind], 3) for kind in ("capsule", "opening", "plane"))
    distance = np.linalg.norm(ball - [30e-3, 0.0, 40e-3], axis=1)
    assert distance.max() == pytest.approx(3e-3) and distance.min() > 2.9e-3
    # The opening of 2 mm looks down; its tube leads upwards.
    assert tube[:, 2].min() == pytest.approx(25e-3)
    rim = np.hypot(tube[:, 0] - 10e-3, tube[:, 1])[tube[:, 2] < 25.001e-3]
    assert rim.max() == pytest.approx(1e-3) and tube[:, 2].max() > 40e-3
    height = (plate - [0.0, 0.0, -20e-3]) @ [0.0, 0.6, 0.8]
    assert height.max() == pytest.approx(0.0, abs=1e-9) and height.min() > -1e-3
    # Below the middle of the bar.
    assert plate.mean(axis=0)[0] == pytest.approx(30e-3, abs=1e-3)


def test_a_rod_reaches_from_end_to_end():
    rod = mesh_of("capsule").posed(4.0)
    ends = np.clip(rod[:, 2], 0.0, 4.0)
    assert np.linalg.norm(rod - ends[:, None] * [0, 0, 1], axis=1) == pytest.approx(1, abs=0.02)
    assert (rod[:, 2].min(), rod[:, 2].max()) == pytest.approx((-1.0, 5.0), abs=0.02)


@pytest.mark.parametrize(
    ("sentence", "name"),
    [
        (f"{PLANE} with shears", "shears"),
        ("cut stems with my shears", "my shears"),
        ('cut "tube with ends" with "shears by hand" along line from a to b', "shears by hand"),
        ('cut "tube with shears"', ""),
    ],
)
def test_scissors_are_those_of_the_sentence(sentence, name):
    assert scissors_of(sentence) == name


def test_shafts_do_not_lead_through_tissue():
    _, moments, found = seen(f"{PLANE} with shears")
    row = Scenery.of(moments).row(0.4)
    tissue = Scenery.of(moments).tissue(row)
    for kind in ("forceps", "scissors"):
        course = found[kind]
        local = (tissue - course.origin[row]) @ course.axes[row].T / course.size
        along = (local[:, 2] > 2.0) & (np.hypot(local[:, 0], local[:, 1]) < 0.5)
        assert not along.any()


def test_rotations_are_found_and_degenerate_sets_are_left_alone():
    generator = np.random.default_rng(3)
    reference = generator.normal(size=(6, 3))
    turn = np.linalg.qr(generator.normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    found = rotations(reference, (reference @ turn.T)[None] + 0.3)[0]
    np.testing.assert_allclose(found, turn, atol=1e-12)
    line = np.outer(np.arange(4.0), [1.0, 2.0, 0.0])
    np.testing.assert_array_equal(rotations(line, line[None])[0], np.eye(3))


def test_nothing_is_drawn_of_tools_that_hold_nodes_outside_of_the_frames():
    scene = BAR.replace("CUT", PLANE).replace("trajectory every", "trajectory of [ends] every")
    result = tissuec.run(scene, companion="off")
    moments = Moments.of(result, np.arange(len(result.times)))
    assert {one.kind for one in courses(moments)} <= {"handle", "jet"}
