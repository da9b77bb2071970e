"""Doubts: what is found, when, how often, and that looking changes nothing."""

import json
import re
import warnings

import numpy as np
import pytest
from click.testing import CliRunner

import tissuec
from tests.matter.shapes import as_vtk, tetrahedra
from tests.whole_runs import AfterAsking, carried_out
from tissuec.cli import group
from tissuec.engine.execution.doubts import WATCHES, DoubtMemory, Finding

SOLID = """language 1
param depth = 7 mm
tissue gel { spring constant = 10 N/m; density = 1000 kg/m^3; retardation time = 5 ms }
body block {
  mesh is lattice { kind is sodium chloride; cell = 5 mm; reach is second neighbours
    box from (0, 0, 0) mm to (15, 15, 10) mm }
  tissue is gel
}
set low = nodes of block where z < 0.1 mm
set lid = nodes of block where z > 9.9 mm
environment { gravity = (0, 0, 0) m/s^2; mass damping = 20 Hz }
script { at 0 s: fix low
  from 0 s to 0.1 s: move lid by (0, 0, -depth) using smooth profile }
simulate { duration = 0.15 s; tolerance = 1e-3 }
output { trajectory every 5 ms; force of lid every 5 ms }
"""
NEEDLE = """language 1
param thickness = 0.6 mm
tissue gel { spring constant = 20 N/m; density = 1010 kg/m^3; retardation time = 5 ms }
body block {
  mesh is lattice { kind is sodium chloride; cell = 3 mm; reach is second neighbours
    box from (0, 0, 0) mm to (9, 9, 9) mm }
  tissue is gel
}
set base = nodes of block where z < 0.1 mm
tool needle { kind is probe; radius = thickness
  axis from (4.5 mm, 4.5 mm, 9.1 mm + thickness) to (4.5, 4.5, 50) mm }
environment { gravity = (0, 0, 0) m/s^2; contact is tools only
  contact surface stiffness = 100 MPa/m; mass damping = 20 Hz }
script { at 0 s: fix base
  from 0 s to 40 ms: move needle by (0, 0, -6) mm using constant speed }
simulate { duration = 40 ms; tolerance = 1e-3 }
output { force of needle every 1 ms }
"""
BALL = """language 1
param c = 4 mm
tissue gelatine { spring constant = 20 N/m; density = 1010 kg/m^3; retardation time = 5 ms }
body block {
  mesh is lattice { kind is sodium chloride; cell = c; reach is second neighbours
    box from (-8, -8, -8) mm to (8, 8, 0) mm }
  tissue is gelatine
}
set base = nodes of block where z < -7.9 mm
tool ball { kind is probe; radius = 5 mm; centre = (0, 0, 3) mm }
environment { gravity = (0, 0, 0) m/s^2; contact is tools only
  contact surface stiffness = 50 MPa/m; mass damping = 20 Hz }
script { at 0 s: { fix base; settle } }
simulate { duration = 1 ms; tolerance = 1e-3 }
output { force of ball every 1 ms }
"""


def compiled(text, **params):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", tissuec.TissueWarning)
        return tissuec.compile(text, params=params)


def seen(scene, position, kind="inside out"):
    """Return what the watch of a kind finds in a state with other positions."""
    watch = WATCHES[kind].of(scene.network, scene.plan)
    state = scene.plan.start(scene.network)
    return list(watch.look(state, position))


def doubts(text, **params):
    scene = compiled(text, **params)
    return carried_out(scene)[0].doubts


def test_a_block_that_is_pressed_flat_is_inside_out_and_one_that_is_pressed_less_is_not():
    (found,) = doubts(SOLID)
    assert found.kind == "inside out"
    assert found.subject == "block"
    assert found.most == 9  # one layer of 3 x 3 cells
    # The lid has gone 5 of 10 mm, where one layer is flat if the other is not, at 50 ms.
    assert 0.05 < found.time <= 0.15
    assert found.unit == "cell"
    assert found.place.endswith(":4")
    assert doubts(SOLID, depth="6 mm") == ()  # as docs/choosing.md says


def test_cells_are_counted_one_by_one():
    scene = compiled(SOLID)
    x = scene.network.position.copy()
    assert seen(scene, x) == []
    # Nodes at the middle height that stand below the lowest: each cell of the lower layer.
    x[np.isclose(x[:, 2], 0.005), 2] = -0.001
    (found,) = seen(scene, x)
    assert found.count == 9
    # A cell is flat if four of its nodes lie in the plane of the others, and not before.
    for height, count in ((1e-6, 0), (-1e-6, 1)):
        x = scene.network.position.copy()
        corner = np.isclose(x[:, 2], 0.01) & (x[:, 0] < 0.006) & (x[:, 1] < 0.006)
        x[corner, 2] = 0.005 + height
        assert sum(one.count for one in seen(scene, x)) == count


@pytest.mark.parametrize("depth", [0.2, 1.5])
def test_tetrahedra_are_counted_one_by_one(depth, tmp_path):
    """A node inside that is pushed through the opposite faces inverts those around it."""
    x, cells = tetrahedra((20.0, 20.0, 10.0), 5.0, 0.0)
    (tmp_path / "bar.vtk").write_text(as_vtk(x, cells))
    path = tmp_path / "bar.tis"
    mesh = 'mesh is imported { file "bar.vtk" in mm }'
    path.write_text(re.sub(r"mesh is lattice \{.*?\) mm \}", mesh, SOLID, flags=re.DOTALL))
    scene = compiled(path)
    drawn = scene.network.position
    assert not list(seen(scene, drawn))
    node = int(np.argmin(np.linalg.norm(drawn - drawn.mean(axis=0), axis=1)))
    moved = drawn.copy()
    moved[node, 2] += depth * 5e-3
    at = {tuple(np.round(1e3 * place, 6)): n for n, place in enumerate(drawn)}
    corners = np.array([at[tuple(np.round(place, 6))] for place in x])[cells]
    content = [
        np.linalg.det(place[corners[:, 1:]] - place[corners[:, :1]]) for place in (drawn, moved)
    ]
    count = int(np.count_nonzero(content[0] * content[1] <= 0.0))
    found = seen(scene, moved)
    assert [one.count for one in found] == ([count] if count else [])
    assert bool(count) is (depth > 1.0)


def test_what_is_moved_and_turned_is_not_inside_out():
    scene = compiled(SOLID)
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    assert seen(scene, scene.network.position @ turn.T + [5.0, -7.0, 2.0]) == []
    mirrored = scene.network.position * [1.0, 1.0, -1.0]
    assert sum(one.count for one in seen(scene, mirrored)) == 18


SHEET = """language 1
tissue skin { spring constant = 10 N/m; viscosity = 0 N*s/m; mass = 1 mg }
body sheet {
  mesh is sheet {
    corner = (0, 0, 0) mm; first edge = (40, 0, 0) mm; second edge = (0, 40, 0) mm
    columns = 5; rows = 5; diagonals is both
  }
  tissue is skin
}
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 1 ms }
"""


def test_a_face_is_inside_out_among_its_neighbours_but_a_fold_along_a_row_is_not():
    scene = compiled(SHEET)
    drawn = scene.network.position
    folded = drawn.copy()
    beyond = folded[:, 0] > 0.02
    folded[beyond, 0] = 0.04 - folded[beyond, 0]
    folded[beyond, 2] = 1e-4
    assert sum(one.count for one in seen(scene, folded)) == 0
    pulled = drawn.copy()
    middle = np.flatnonzero(np.isclose(drawn[:, :2], 0.02).all(axis=1))
    pulled[middle, :2] += [0.015, 0.001]  # across an edge of the faces beside it
    (found,) = seen(scene, pulled)
    assert found.count >= 1
    assert found.unit == "face"


def test_cells_that_have_lost_an_edge_are_not_counted():
    scene = compiled(SOLID)
    x = scene.network.position.copy()
    x[np.isclose(x[:, 2], 0.005), 2] = -0.001
    watch = WATCHES["inside out"].of(scene.network, scene.plan)
    state = scene.plan.start(scene.network)
    # Node 0 is a corner of one cell only: what it loses is an edge of that cell.
    lost = np.flatnonzero((scene.network.line_ends == 0).any(axis=1))[:1]
    state.alive = state.alive.copy()
    state.alive[lost] = False
    (found,) = watch.look(state, x)
    assert found.count == 8


def test_a_needle_between_nodes_is_found_and_named_in_the_log_of_events():
    scene = compiled(NEEDLE)
    outcome, recording = carried_out(scene)
    (found,) = outcome.doubts
    assert found.subject == "needle in block"
    # The end of its axis is drawn 0.7 mm above the surface and goes 6 mm in 40 ms.
    assert 0.7 / 6.0 * 0.04 < found.time <= 0.7 / 6.0 * 0.04 + 2e-3
    (note,) = (event for event in recording.events if event.kind == "note")
    assert note.cause == found.what
    assert note.time == found.time
    thick = [one.kind for one in doubts(NEEDLE, thickness="6 mm")]
    assert "passes through a surface" not in thick


def test_a_ball_on_one_node_is_doubtful_and_one_on_many_is_not():
    (found,) = doubts(BALL)
    assert found.kind == "few nodes in contact"
    assert found.most == 1
    assert doubts(BALL, c="2 mm") == ()


def test_of_findings_with_a_weight_the_largest_decides():
    memory = DoubtMemory()
    scene = compiled(SHEET)
    span = scene.plan.simulation.span
    for time, count, weight in ((1.0, 1, 2.0), (2.0, 0, 5.0), (3.0, 1, 4.0)):
        memory.enter("few", Finding("a", count, "a is", "", "node", "", span, weight), time)
    assert memory.found == {}
    memory.enter("few", Finding("a", 2, "a is", "", "node", "", span, 6.0), 4.0)
    assert [(one.time, one.most) for one in memory.found.values()] == [(4.0, 2)]


def test_first_time_and_numbers_are_kept_apart():
    memory, span = DoubtMemory(), compiled(SHEET).plan.simulation.span
    for time, count in ((1.0, 0), (2.0, 3), (3.0, 7), (4.0, 0)):
        memory.enter("out", Finding("a", count, "a is", f"at {time}", "cell", "", span), time)
    (found,) = memory.found.values()
    assert (found.time, found.where, found.most, found.last) == (2.0, "at 2.0", 7, 0)
    assert "up to 7 cells, 0 at the end, first at 2 s at 2.0" in str(found)


def test_looking_changes_no_bit_of_the_motion(monkeypatch):
    scene = compiled(SOLID)
    seen_motion = carried_out(scene)[1].frame_arrays()
    monkeypatch.setattr("tissuec.engine.execution.recorder.Recorder.takes_notes", False)
    outcome, recording = carried_out(scene)
    assert outcome.doubts == ()
    for one, other in zip(seen_motion, recording.frame_arrays(), strict=True):
        assert np.array_equal(one, other)


def when_resumed(scene, counts):
    """Return the different doubts of runs that are stopped and resumed; see ``AfterAsking``."""
    found = set()
    for count in counts:
        first, recording = carried_out(scene, interrupt=AfterAsking(count))
        if first.kind == "interrupted":
            rest, _ = carried_out(scene, resume=recording.state)
            found.add(rest.doubts)
    return found


def test_a_run_that_is_interrupted_and_resumed_has_the_same_doubts(monkeypatch):
    scene = compiled(SOLID)
    whole = carried_out(scene)[0]
    monkeypatch.setattr("tissuec.engine.execution.run.CHECKPOINT_EVERY", 0.0)
    assert when_resumed(scene, (3, 8, 14)) == {whole.doubts}


def test_every_output_says_it(tmp_path):
    scene, result = tmp_path / "flat.tis", tmp_path / "flat.vtkhdf"
    scene.write_text(SOLID, encoding="utf-8")

    def said(*words):
        found = CliRunner().invoke(group, [*map(str, words)], standalone_mode=False)
        return found.return_value, found.stdout, found.stderr

    code, _, talk = said("run", scene, "-o", result, "--companion", "off")
    assert code == 0
    assert "doubtful: cells of block are inside out (9 cells, first at" in talk
    assert talk.count("inside out") == 1
    strict = ("run", scene, "-o", result, "--strict", "--companion", "off")
    code, document, _ = said("--json", *strict)
    assert code == 1
    (found,) = json.loads(document)["doubts"]
    assert found["kind"] == "inside out"
    assert "inside out" in said("info", result)[1]
    with tissuec.load(result) as trajectory:
        (doubt,) = trajectory.doubts
        assert doubt.most == found["most"] == trajectory.manifest["doubts"][0]["most"]
        assert [event.kind for event in trajectory.events].count("note") == 1
    page = tmp_path / "flat.html"
    assert said("report", result, "-o", page)[0] == 0
    assert "doubtful: inside out" in page.read_text(encoding="utf-8")
    with pytest.warns(tissuec.TissueWarning, match="inside out"):
        tissuec.run(scene, companion="off").close()
    with pytest.raises(tissuec.SimulationError, match="inside out"):
        tissuec.run(scene, companion="off", strict=True)


FLAP = """language 1
tissue gum { spring constant = 40 N/m; viscosity = 0.1 N*s/m; mass = 10 mg }
body flap {
  mesh is sheet {
    corner = (0, 0, 0) mm; first edge = (40, 0, 0) mm; second edge = (0, 40, 0) mm
    columns = 5; rows = 5; diagonals is both
  }
  tissue is gum
}
"""
HOOK = (
    FLAP
    + """set edge = nodes of flap where x < 1 mm or x > 39 mm
tool hook {
  kind is hook; radius = 0.5 mm
  shaft from (16, -40, -6) mm to (16, -40, -4) mm; bend = (16, 80, -2) mm
}
environment {
  gravity = (0, 0, 0) m/s^2; damping = 1 mN*s/m
  contact is tools only; contact stiffness = 20 N/m
}
script {
  at 0 s: fix edge
  WAY
}
simulate { duration = 0.5 s; tolerance = 1e-3 }
output { force of hook every 5 ms }
"""
)
LIFTED = "from 0.05 s to 0.45 s: move hook by (0, 0, 16) mm using smooth profile"
BACK = """from 0.05 s to 0.25 s: move hook by (0, 0, 3) mm using smooth profile
  from 0.25 s to 0.45 s: move hook by (0, 0, -3) mm using smooth profile"""


@pytest.mark.parametrize(("way", "is_lost"), [(LIFTED, True), (BACK, False)])
def test_a_tool_that_has_passed_is_told_with_time_and_place(way, is_lost):
    doubts = tissuec.run(HOOK.replace("WAY", way)).doubts
    told = {one.subject: one for one in doubts}
    assert told["hook in flap"].last == 0
    assert ("hook through flap" in told) == is_lost
    if is_lost:
        one = told["hook through flap"]
        assert one.what == "hook has passed through flap and holds it no longer"
        assert 0.05 < one.time < 0.45
        assert one.where.startswith("at node ") and one.where.endswith(" of flap")


#: A needle that goes through a sheet and comes back, within a sixty-fourth of the run.
QUICK = (
    FLAP
    + """tool needle {
  kind is probe; radius = 0.5 mm; axis from (3, 16, 2) mm to (8, 17, 2) mm
}
environment {
  gravity = (0, 0, 0) m/s^2; contact is tools only; contact stiffness = 20 N/m
}
script {
  at 0 s: fix flap
  from 10 ms to 15 ms: move needle by (0, 0, -4) mm using smooth profile
  from 15 ms to 20 ms: move needle by (0, 0, 4) mm using smooth profile
}
simulate { duration = 2 s; tolerance = 1e-3 }
"""
)


@pytest.mark.parametrize("still", ["", "from 0 s to 5 ms: settle"])
def test_what_passes_and_comes_back_between_two_looks_is_found_and_located(still):
    outcome, recording = carried_out(
        compiled(QUICK.replace("at 0 s: fix flap", f"at 0 s: fix flap\n  {still}"))
    )
    crossing, *passages = outcome.doubts
    assert crossing.kind == "passes through a surface" and crossing.last == 0
    # The axis is 2 mm above the sheet: half of the way.
    assert crossing.time == pytest.approx(12.5e-3, abs=0.5e-3)
    assert crossing.where.endswith(" of flap")
    (found,) = passages
    assert found.what == "needle has passed through flap and holds it no longer"
    assert [event.kind for event in recording.events].count("note") == 2


def test_a_run_that_is_resumed_amid_a_passage_has_the_same_doubts(monkeypatch):
    scene = compiled(HOOK.replace("WAY", LIFTED))
    whole = carried_out(scene)[0]
    assert len(whole.doubts) == 2
    monkeypatch.setattr("tissuec.engine.execution.run.CHECKPOINT_EVERY", 0.0)
    assert when_resumed(scene, (2, 5, 9, 14, 20)) == {whole.doubts}


TWO_BLOCKS = """language 1
tissue gel { Young's modulus = 5 kPa; density = 1000 kg/m^3; retardation time = 5 ms }
body lower { mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (15, 15, 10) mm }
  tissue is gel }
body upper { mesh is lattice { cell = 5 mm; box from (2, 3, HEIGHT) mm to (12, 13, TOP) mm }
  tissue is gel }
set base = nodes of lower where z == 0 mm
set top = nodes of upper where z == TOP mm
environment { gravity = (0, 0, 0) m/s^2; mass damping = 50 Hz CONTACT }
script { at 0 s: fix base
  from 0 s to 20 ms: move top by (0, 0, -3) mm using smooth profile }
simulate { duration = 30 ms; tolerance = 1e-2 }
output { trajectory every 0.5 ms }
"""
WITH_CONTACT = "; contact is bodies too; contact thickness = 0.5 mm"


def two_blocks(height, contact=""):
    text = TWO_BLOCKS.replace("HEIGHT", str(height)).replace("TOP", str(height + 10))
    return text.replace("CONTACT", contact)


@pytest.mark.parametrize(
    ("contact", "why"),
    [
        ("", "contact between bodies is off"),
        ("; contact is tools only", "contact between bodies is off"),
        (WITH_CONTACT, ""),
    ],
)
def test_bodies_that_pass_through_each_other_are_found(contact, why):
    found = doubts(two_blocks(11, contact))
    if not why:
        assert found == ()
        return
    (one,) = found
    assert (one.kind, one.subject) == ("bodies overlap", "lower and upper")
    assert one.what.endswith(why) and one.most >= one.last > 10
    # The gap of 1 mm is closed when the top has moved by a third of its way.
    assert 5e-3 < one.time < 12e-3 and " of " in one.where


def test_bodies_that_sink_deep_into_each_other_are_found():
    # Motions of few cells are too slow.
    text = two_blocks(11, f"{WITH_CONTACT}; contact surface stiffness = 1 kPa/m")
    found = doubts(text.replace("cell = 5 mm", "cell = 2.5 mm"))
    assert {one.kind for one in found} == {"sinks into a body"}
    assert {one.subject for one in found} == {"lower in upper", "upper in lower"}
    # A quarter of the upper block's volume over half its surface is 0.83 mm, behind a gap of
    # 1 mm: 0.61 of the way of the top.
    assert all(9e-3 < one.time < 16e-3 for one in found)


def test_bodies_that_touch_as_drawn_and_those_that_stay_apart_are_not_reported():
    assert doubts(two_blocks(10)) == () == doubts(two_blocks(14))


PINCHED = """language 1
tissue gel { spring constant = 2 N/m; density = 1000 kg/m^3; retardation time = 5 ms }
body tube { mesh is tube { axis from (0, 0, 0) mm to (20, 0, 0) mm; radius = 5 mm; rings = 7
  sides = 12 }; tissue is gel; thickness = 0.5 mm }
set top = nodes of tube where z > 4.9 mm and x between 6 mm and 14 mm
set bottom = nodes of tube where z < -4.9 mm
environment { gravity = (0, 0, 0) m/s^2; mass damping = 50 Hz; CONTACT }
script { at 0 s: fix bottom
  from 0 s to 20 ms: move top by (0, 0, WAY) mm using smooth profile }
simulate { duration = 20 ms; tolerance = 1e-2 }
output { trajectory every 1 ms }
"""


@pytest.mark.parametrize(
    ("contact", "way", "why"),
    [
        ("contact is off", -8, ""),
        ("contact is off", -12, "contact within bodies is off"),
        (
            "contact is everywhere; contact thickness = 0.5 mm; "
            "contact surface stiffness = 1 kPa/m",
            -12,
            "contact cannot hold it apart",
        ),
    ],
)
def test_a_body_that_passes_through_itself_is_found(contact, way, why):
    found = doubts(PINCHED.replace("CONTACT", contact).replace("WAY", str(way)))
    kinds = [one.kind for one in found]
    if not why:
        assert "bodies overlap" not in kinds
        return
    one = found[kinds.index("bodies overlap")]
    assert one.subject == "tube" and one.most >= one.last > 0
    assert one.what == f"the surface of tube passes through itself: {why}"
    assert one.time > 10e-3 and one.where.endswith(" of tube")
