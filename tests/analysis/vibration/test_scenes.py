"""Modes of scenes: against theory and runs, on the command line, and as a result that plays."""

import json

import numpy as np
import pytest

import tissuec
from tests.analysis.vibration.theory import (
    ball,
    bar,
    bar_frequencies,
    breathing,
    breathing_rate,
    extensional,
    rod,
)
from tests.test_cli import tissuec as command

#: A mass between two walls, on springs that are under tension, and a free pair of masses.
TEXT = """language 1
tissue cord { spring constant = 40 N/m; viscosity = 10 mN*s/m; mass = 5 g; prestress = 20 % }
tissue slack { spring constant = 40 N/m; viscosity = 10 mN*s/m; mass = 5 g }
body line { mesh is explicit; tissue is cord }
table nodes of line in mm with columns "id x" { 1 0; 2 10; 3 20 }
table springs of line with columns "a b" { 1 2; 2 3 }
body pair { mesh is explicit; tissue is slack }
table nodes of pair in mm with columns "id x y" { 1 0 50; 2 10 50 }
table springs of pair with columns "a b" { 1 2 }
set walls = nodes of line where id != 2
set bob = nodes of line where id == 2
environment { gravity = (0, 0, 0) m/s^2 }
script { at 0 s: fix walls }
simulate { duration = 0.6 s; tolerance = 1e-6 }
output { position of bob every 1 ms }
"""


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "scene.tis"
    path.write_text(TEXT)
    return path


def test_a_rod_of_matter_has_the_frequencies_of_a_clamped_bar():
    # Its own error of second order: (π h (2j-1) / 4 L)² / 6 for the mode j.
    odd = np.array([1, 3, 5])
    for pieces in (16, 32):
        found = np.array([mode.frequency for mode in rod(pieces)])
        due = 1.0 - (np.pi * odd / (4 * pieces)) ** 2 / 6.0
        # What comes next is of fourth order.
        assert found / bar_frequencies(40.0, 3) == pytest.approx(due, abs=1e-4)


def test_a_block_of_matter_vibrates_along_as_a_clamped_bar_does():
    # It may not become narrower at the clamp, which makes it stiffer by a part of its height.
    coarse, fine = (
        extensional(bar(40, 8, cell, count=8)).frequency / bar_frequencies(40, 1)[0]
        for cell in (4, 2)
    )
    assert 1.0 < fine < 1.01 and abs(fine - coarse) < 0.01


@pytest.mark.parametrize("preserved", [False, True])
def test_a_sphere_breathes_as_a_membrane_does(preserved):
    # Of the 162 nodes; the polyhedron has 3.5 % less volume and 1.9 % less area.
    mode, likeness = breathing(ball(2, preserved=preserved))
    assert likeness > 0.998  # nodes around which five triangles meet move by less
    rate = breathing_rate(preserved=preserved)
    assert 2.0 * np.pi * mode.frequency == pytest.approx(rate, rel=0.005)


def test_a_run_swings_as_the_mode_says():
    undamped = TEXT.replace("viscosity = 10 mN*s/m", "viscosity = 0 N*s/m")
    text = undamped.replace(
        "fix walls }",
        "fix walls\n  from 0 s to 0.01 s: move bob by (0, 0.01, 0) mm using smooth profile\n"
        "  at 0.01 s: release bob }",
    )
    run = tissuec.run(text, companion="off")
    log = run.logs["position of bob"]
    height, time = log.value[:, 1], log.time
    late = time > 0.02
    signs = np.flatnonzero(np.diff(np.sign(height[late])) != 0)
    t, y = time[late], height[late]
    crossings = t[signs] - y[signs] * (t[signs + 1] - t[signs]) / (y[signs + 1] - y[signs])
    half = np.polyfit(np.arange(len(crossings)), crossings, 1)[0]
    (mode, *_) = tissuec.modes(undamped, body="line", count=1, above=0.0)
    # Straight lines between samples that are a fiftieth of a period apart.
    assert 0.5 / half == pytest.approx(mode.frequency, rel=1e-3)


def test_what_settles_at_0_s_has_settled():
    pendulum = """language 1
tissue cord { spring constant = 4 kN/m; viscosity = 1 mN*s/m; mass = 5 g }
body line { mesh is explicit; tissue is cord }
table nodes of line in mm with columns "id x z" { 1 0 0; 2 0 -100 }
table springs of line with columns "a b" { 1 2 }
set hook = nodes of line where id == 1
environment { gravity = (0, 0, -9.81) m/s^2 }
script { at 0 s: { fix hook SETTLE } }
simulate { duration = 1 s }
"""
    found = tissuec.modes(pendulum.replace("SETTLE", "; settle"))
    length = 0.1 + 0.005 * 9.81 / 4e3
    swing = np.sqrt(9.81 / length) / (2.0 * np.pi)
    known = [swing, swing, np.sqrt(4e3 / 0.005) / (2.0 * np.pi)]
    assert [mode.frequency for mode in found] == pytest.approx(known, rel=1e-9)
    assert found.notes == ("there are only 3 modes: 1 free node in three directions",)
    drawn = tissuec.modes(pendulum.replace("SETTLE", ""), count=3)
    assert "forces do not balance: up to 49.1 mN on a node" in drawn.notes[0]


def test_an_equilibrium_that_is_not_there_is_an_error():
    falling = TEXT.replace("(0, 0, 0) m/s^2", "(0, 0, -9.81) m/s^2")
    falling = falling.replace("fix walls }", "{ fix walls; settle } }")
    with pytest.raises(tissuec.SimulationError, match="no support balances"):
        tissuec.modes(falling)


def test_the_table_says_what_moves_and_how(scene, tmp_path):
    said = command("modes", scene, "--count", 10, cwd=tmp_path)
    assert said.returncode == 0, said.stderr
    head, *rows = (line.split() for line in said.stdout.splitlines())
    assert head[0] == "mode"
    assert [row[1] for row in rows[:5]] == ["rigid"] * 5
    assert all(row[-3:] == ["pair", "100", "%"] for row in rows[:5])
    assert rows[5][-3:] == ["line", "100", "%"]
    assert "there are only 9 modes: 3 free nodes in three directions" in said.stderr


def test_one_body_moves_while_all_else_stays(scene, tmp_path):
    said = command("--json", "modes", scene, "--body", "LINE", cwd=tmp_path)
    document = json.loads(said.stdout)
    assert document["ok"] and document["free_nodes"] == 1 and document["file"] is None
    assert [mode["shares"] for mode in document["modes"]] == [{"line": 1.0}] * 3
    along = document["modes"][2]
    assert along["frequency"] == pytest.approx(np.sqrt(2 * 40.0 / 0.005) / (2 * np.pi))
    assert along["damping_ratio"] == pytest.approx(0.01 * np.sqrt(2 / 40.0 / 0.005) / 2)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (
            ["--body", "lime"],
            'there is no body "lime"; did you mean "line"?  bodies: line, pair',
        ),
        (["--body", "line", "--set", "x=1"], "there is no such param"),
        (["--above", "-1"], "a frequency must be 0 or more"),
        (["--above", "3 mm"], '"3 mm" is not a frequency or a rate (1/s)'),
        (["--count", "0"], "0 is not in the range"),
        (["--out", "scene.tis"], "is the input file"),
    ],
)
def test_what_cannot_be_is_told_with_a_way_out(scene, tmp_path, options, said):
    result = command("modes", scene, *options, cwd=tmp_path)
    assert result.returncode == 2
    assert said in result.stderr


def test_a_scene_in_which_nothing_can_move_is_an_error(scene, tmp_path):
    scene.write_text(TEXT.replace("fix walls }", "{ fix line; fix pair } }"))
    result = command("modes", scene, cwd=tmp_path)
    assert result.returncode == 2
    assert "no node of the scene can move: all nodes are held at 0 s" in result.stderr


def test_nothing_above_a_frequency_is_said_and_leaves_no_file(scene, tmp_path):
    result = command("modes", scene, "--above", "1 MHz", "--out", "m.vtkhdf", cwd=tmp_path)
    assert result.returncode == 0
    assert "there is no mode above 1e+06 Hz" in result.stderr
    assert not (tmp_path / "m.vtkhdf").exists()


def test_each_mode_plays_for_a_second_by_a_twentieth_of_its_body(scene, tmp_path):
    found = tissuec.modes(scene, count=7, out=tmp_path / "modes.vtkhdf")
    played = tissuec.load(tmp_path / "modes.vtkhdf")
    assert played.finished and played.times[-1] == 7.0
    assert [event.time for event in played.events] == [0, 1, 2, 3, 4, 5, 6]
    assert played.events[0].cause == "mode 1: rigid"
    assert played.events[5].cause == f"mode 6: {found[5].frequency:.4g} Hz"
    position, force = np.asarray(played.position), np.asarray(played.force)
    sizes = {"pair": 0.01, "line": 0.02}
    rows = [int(np.argmin(np.abs(np.asarray(played.times) - k - 0.25))) for k in range(7)]
    mass = found.state.mass
    for mode, row in zip(found, rows, strict=True):
        assert position[row - 6] == pytest.approx(position[0], abs=1e-15)
        moved = position[row] - position[0]
        (body,) = mode.shares
        farthest = np.linalg.norm(moved, axis=1).max()
        assert farthest == pytest.approx(0.05 * sizes[body], rel=1e-9)
        # K φ = ω² M φ: the forces of the springs bring each free node back.
        square = (2.0 * np.pi * mode.frequency) ** 2
        free = ~found.state.held
        pulled = (force[row] - force[0])[free]
        due = -square * (mass[:, None] * moved)[free]
        assert pulled == pytest.approx(due, abs=1e-6 * np.abs(force).max())


def test_contact_is_ignored_and_told():
    text = """language 1
tissue gel { spring constant = 40 N/m; viscosity = 10 mN*s/m; mass = 5 g }
body block {
  mesh is lattice {
    kind is sodium chloride; reach is second neighbours
    cell = 10 mm; box from (0, 0, 0) mm to (10, 10, 10) mm
  }
  tissue is gel
}
tool floor { kind is plane; point = (5, 5, 1) mm; normal = (0, 0, 1) }
environment { gravity = (0, 0, 0) m/s^2; contact is tools only }
simulate { duration = 0.1 s }
"""
    with pytest.warns(tissuec.TissueWarning, match="overlap at the start at 4 nodes"):
        found = tissuec.modes(text, count=6)
    assert "contact is ignored: it acts on 4 nodes" in found.notes
    assert [mode.kind for mode in found] == ["rigid"] * 6
