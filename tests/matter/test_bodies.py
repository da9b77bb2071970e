"""What bodies are said to be is what their tissue says, and what closed forms say of nets."""

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import Delaunay

import tissuec
from tests.matter.elastic import moved, stiffness
from tests.matter.shapes import SIDES, as_vtk, tetrahedra
from tests.test_cli import tissuec as command
from tissuec.analysis import bodies

MATTER = "Young's modulus = 5 kPa; density = 1060 kg/m^3; retardation time = 2 ms"
SPRINGS = "spring constant = 40 N/m; viscosity = 20 mN*s/m; mass = 10 mg"
NET = "spring constant = 40 N/m; density = 1060 kg/m^3; retardation time = 2 ms"
SCENE = """language 1
tissue gel {{ {tissue} }}
body piece {{ mesh is {mesh}; tissue is gel{more} }}
{sets}
environment {{ gravity = (0, 0, 0) m/s^2 }}
{script}
simulate {{ duration = 1 ms }}
"""
SHEET = (
    "sheet {{ corner = (0, 0, 0) mm; first edge = (40, 0, 0) mm; second edge = (0, 20, 0) mm; "
    "columns = {0}; rows = {1}; diagonals is {2} }}"
)
THREAD = "thread { line from (0, 0, 0) mm to (40, 0, 0) mm; thickness = 2 mm; pieces = 32 }"


def block(kind, cell, reach="second neighbours", sides=(40, 20, 20)):
    to = ", ".join(map(str, sides))
    return (
        f"lattice {{ kind is {kind}; reach is {reach}; cell = {cell} mm; "
        f"box from (0, 0, 0) mm to ({to}) mm }}"
    )


def text_of(mesh, tissue=MATTER, more="", sets="", script=""):
    more = f"; {more}" if more else ""
    return SCENE.format(mesh=mesh, tissue=tissue, more=more, sets=sets, script=script)


def piece(mesh, tissue=MATTER, more="", frequencies=0, **given):
    text = text_of(mesh, tissue, more, **given)
    (found,) = tissuec.properties(text, frequencies=frequencies)
    return found


def imported(folder, text, name, tissue=MATTER, more="", inside=""):
    (folder / name).write_text(text)
    scene = folder / "piece.tis"
    scene.write_text(text_of(f'imported {{ file "{name}" in mm{inside} }}', tissue, more))
    return scene


# --- elastic constants ------------------------------------------------------------------------


def test_a_lattice_of_equal_springs_has_the_stiffness_that_counting_gives():
    # All springs of cubes count in full, also those in faces and edges of the block. An edge
    # along x stores c a² for a strain of 1 along x, a diagonal c (2a²)/4 = c a²/2; those of the
    # planes xy and xz do, and couple x with y or z by as much.
    n, a, c = np.array([4, 2, 2]), 10e-3, 40.0
    edges = [n[i] * np.prod(np.delete(n, i) + 1) for i in range(3)]
    pairs = {(i, j): 2 * n[i] * n[j] * (n[3 - i - j] + 1) for i, j in ((0, 1), (0, 2), (1, 2))}
    normal = np.diag(np.array(edges, dtype=float))
    for (i, j), count in pairs.items():
        for one, other in ((i, i), (j, j), (i, j), (j, i)):
            normal[one, other] += 0.5 * count
    normal *= c * a**2 / 16e-6
    compliance = np.linalg.inv(normal)
    found = piece(block("sodium chloride", 10), NET)
    one = found.elasticity
    assert (found.kind, one.unit, one.directions) == ("solid", "Pa", ("x", "y", "z"))
    assert np.array(one.matrix)[:3, :3] == pytest.approx(normal, rel=1e-5)
    assert one.young == pytest.approx(1.0 / np.diag(compliance), rel=1e-5)
    assert found.mass == pytest.approx(1060.0 * 16e-6)
    assert found.density == pytest.approx(1060.0)
    assert found.retardation_time == pytest.approx(2e-3)
    assert found.wave_speeds == pytest.approx(np.sqrt(np.array(one.young) / 1060.0))


def test_cells_that_keep_their_volume_count():
    keep = "script { at 0 s: preserve volume of piece with 1 MPa }"
    plain, kept = (
        piece(block("sodium chloride", 10), SPRINGS, script=each).elasticity
        for each in ("", keep)
    )
    added = np.subtract(kept.matrix, plain.matrix)
    due = np.zeros((6, 6))
    due[:3, :3] = 1e6  # a bulk modulus resists the sum of the strains
    assert added == pytest.approx(due, rel=1e-5, abs=1.0)


def test_a_lattice_without_diagonals_resists_along_its_axes_only():
    one = piece(block("sodium chloride", 10, reach="nearest neighbours"), SPRINGS).elasticity
    assert min(one.young) > 0.0
    assert one.shear == (0.0, 0.0, 0.0)
    assert one.anisotropy == math.inf


def test_irregular_nets_are_relaxed_as_independent_statics_relax_them(tmp_path):
    scene = imported(tmp_path, as_vtk(*tetrahedra(SIDES, 10.0, 0.25)), "bar.vtk", NET)
    (found,) = tissuec.properties(scene, frequencies=0)
    compiled = tissuec.compile(scene)
    x = compiled.network.position
    strain = np.array([[1.0, 0.3, -0.2], [0.3, -0.5, 0.4], [-0.2, 0.4, 0.7]])
    held = {
        3 * int(node) + axis: float(strain[axis] @ x[node])
        for node in np.unique(compiled.network.skin)
        for axis in range(3)
    }
    u, force = moved(stiffness(compiled.network, compiled.plan), held)
    i, j = np.array([(0, 0), (1, 1), (2, 2), (1, 2), (2, 0), (0, 1)]).T
    voigt = strain[i, j] * np.where(i == j, 1.0, 2.0)
    stored = 16e-6 * voigt @ np.array(found.elasticity.matrix) @ voigt
    # Energies of both are precise to the square of what is left of forces.
    assert stored == pytest.approx(float((u * force).sum()), rel=1e-6)
    evenly = np.abs(u - x @ strain).max()
    assert evenly > 1e-3 * np.abs(u).max(), "nothing has to be relaxed"


def test_flat_walls_are_relaxed_as_independent_statics_relax_them(tmp_path):
    places = np.stack(np.meshgrid(np.arange(7.0), np.arange(5.0)), -1).reshape(-1, 2)
    inner = ((places > 0.0) & (places < (6.0, 4.0))).all(axis=1)
    places[inner] += np.random.default_rng(2).uniform(-0.3, 0.3, (inner.sum(), 2))
    lines = [f"v {x!r} {y!r} 0" for x, y in places.tolist()]
    lines += ["f {} {} {}".format(*face) for face in (Delaunay(places).simplices + 1).tolist()]
    scene = imported(tmp_path, "\n".join(lines), "wall.obj", NET, "thickness = 1 mm")
    (found,) = tissuec.properties(scene, frequencies=0)
    compiled = tissuec.compile(scene)
    x = compiled.network.position
    strain = np.array([[1.0, 0.3, 0.0], [0.3, -0.5, 0.0], [0.0, 0.0, 0.0]])
    held = {3 * node + 2: 0.0 for node in range(len(x))} | {
        3 * int(node) + axis: float(strain[axis] @ x[node])
        for node in np.flatnonzero(~inner)
        for axis in range(2)
    }
    u, force = moved(stiffness(compiled.network, compiled.plan), held)
    voigt = np.array([1.0, -0.5, 0.6])
    stored = 24e-6 * 1e-3 * voigt @ np.array(found.elasticity.matrix) @ voigt
    assert stored == pytest.approx(float((u * force).sum()), rel=1e-6)
    assert np.abs(u - x @ strain).max() > 1e-2 * np.abs(u).max(), "nothing has to be relaxed"


@pytest.mark.parametrize("fill", ["tetrahedra", "sodium chloride; reach is second neighbours"])
def test_filled_surfaces_of_springs_are_solids(fill, tmp_path, repository):
    surface = (repository / "library" / "meshes" / "liver.obj").read_text()
    inside = f"; filling is {fill}; cell = 20 mm"
    scene = imported(tmp_path, surface, "liver.obj", SPRINGS, inside=inside)
    (found,) = tissuec.properties(scene, frequencies=0)
    assert found.kind == ("solid" if fill == "tetrahedra" else "wall")
    scene = imported(tmp_path, surface, "liver.obj", NET, inside=inside)
    codes = [one.code for one in tissuec.check(scene) if one.code[0] == "T"]
    assert codes == ([] if fill == "tetrahedra" else ["TIS309"])  # of an unknown volume


def test_a_wall_without_a_thickness_has_a_modulus_times_it():
    found = piece(SHEET.format(5, 3, "none"), SPRINGS)
    # Springs of 40 N/m along both edges: 3 rows in 20 mm, 5 columns in 40 mm.
    assert found.elasticity.unit == "N/m"
    assert found.elasticity.young == pytest.approx([40.0 * 3 * 10 / 20, 40.0 * 5 * 10 / 40])
    assert found.elasticity.shear == (0.0,)
    assert found.density is None
    per_area = found.mass / 8e-4
    due = np.sqrt(np.array(found.elasticity.young) / per_area)
    assert found.wave_speeds == pytest.approx(due)


TUBE = (
    "tube {{ axis from (0, 0, 0) mm to (80, 0, 0) mm; radius = 10 mm; rings = 17; sides = 12; "
    "diagonals is {0} }}"
)


def test_springs_across_a_tube_resist_as_it_widens():
    plain = piece(TUBE.format("both"), SPRINGS)
    spoked = piece(TUBE.format("both; interior is spokes"), SPRINGS)
    # Each of six spokes in a ring becomes longer by the diameter.
    added = np.subtract(spoked.elasticity.matrix, plain.elasticity.matrix)
    due = np.zeros((3, 3))
    due[0, 0] = 17 * 6 * 40.0 * 0.02**2 / plain.area
    assert added == pytest.approx(due, abs=1e-9 * due[0, 0])


@pytest.mark.parametrize(("more", "section"), [("", None), ("section = 2 mm^2", 2e-6)])
def test_bars_have_a_spring_constant_times_their_length(more, section):
    text = text_of("explicit", SPRINGS, more) + (
        'table nodes of piece in mm with columns "id x y" { 1 0 0; 2 10 0; 3 10 20 }\n'
        'table springs of piece with columns "a b" { 1 2; 2 3 }\n'
    )
    (found,) = tissuec.properties(text, frequencies=0)
    assert found.kind == "bars"
    assert found.elasticity.unit == ("N" if section is None else "Pa")
    assert found.elasticity.directions == ("least", "largest")
    assert found.elasticity.young == pytest.approx(np.array([0.4, 0.8]) / (section or 1.0))
    assert found.wave_speeds == ()


# --- motion -----------------------------------------------------------------------------------


def test_waves_along_a_thread_set_its_first_frequency_and_decay():
    sets = "set left = nodes of piece where x < 0.1 mm"
    found = piece(THREAD, sets=sets, script="script { at 0 s: fix left }", frequencies=2)
    assert found.elasticity.young == pytest.approx([5e3])
    (speed,) = found.wave_speeds
    assert speed == pytest.approx(np.sqrt(5e3 / 1060.0))
    # A quarter of a wave; 32 pieces are off by (π / 128)² / 6.
    first, second = found.vibrations
    assert first.frequency == pytest.approx(speed / 0.16, rel=2e-4)
    assert second.frequency == pytest.approx(3.0 * speed / 0.16, rel=2e-3)
    omega = 2.0 * np.pi * first.frequency
    assert first.damping_ratio == pytest.approx(omega * 2e-3 / 2.0)
    assert first.decay_time == pytest.approx(2.0 / (omega**2 * 2e-3))


def test_decay_is_the_slower_one_beyond_critical_damping():
    slow = bodies.Vibration(frequency=1.0 / (2.0 * np.pi), damping_ratio=5.0)
    rates = np.roots([1.0, 10.0, 1.0])  # u'' + 2 ζ u' + u = 0
    assert slow.decay_time == pytest.approx(-1.0 / rates.max())
    assert bodies.Vibration(1.0, 0.0).decay_time == math.inf


def test_a_held_body_has_no_frequencies_and_what_is_too_large_says_so(monkeypatch):
    sets = "set whole = nodes of piece where x < 1 m"
    held = piece(THREAD, sets=sets, script="script { at 0 s: fix whole }", frequencies=2)
    assert held.vibrations == ()
    monkeypatch.setattr(bodies, "LARGEST", 10)
    monkeypatch.setattr(bodies, "LARGEST_TO_VIBRATE", 5)
    found = piece(block("sodium chloride", 20), NET, frequencies=2)
    assert found.elasticity is None
    assert found.wave_speeds == ()
    assert [note.partition(" are")[0] for note in found.notes] == [
        "elastic constants",
        "frequencies",
    ]


# --- breaking ---------------------------------------------------------------------------------


@pytest.mark.parametrize("limit", ["breaking strain = 45 %", "strength = 2.25 kPa"])
def test_a_bar_breaks_at_the_strain_and_stress_of_its_tissue(limit):
    found = piece(THREAD, f"{MATTER}; {limit}", "rupture is allowed")
    assert found.breaking.stretch == pytest.approx([1.45] * 3)
    assert found.breaking.stress == pytest.approx(2.25e3, rel=1e-5)
    assert piece(THREAD, f"{MATTER}; {limit}").breaking is None


@pytest.mark.parametrize(
    ("mesh", "more"),
    [
        (block("sodium chloride", 10), ""),
        (SHEET.format(5, 3, "both"), "thickness = 1 mm; "),
    ],
    ids=["block", "sheet"],
)
def test_nets_break_at_the_strain_of_their_tissue(mesh, more):
    found = piece(mesh, f"{NET}; breaking strain = 45 %", f"{more}rupture is allowed")
    assert found.breaking.stretch == pytest.approx([1.45] * 3)


def test_springs_of_a_law_break_where_it_reaches_their_limit():
    law = "spring law is exponential { stiffening = 4 }"
    text = text_of("explicit", f"{law}; {SPRINGS}; breaking force = 2 N", "rupture is allowed")
    text += (
        'table nodes of piece in mm with columns "id x" { 1 0; 2 10 }\n'
        'table springs of piece with columns "a b" { 1 2 }\n'
    )
    (found,) = tissuec.properties(text, frequencies=0)
    strain = found.breaking.stretch[1] - 1.0
    law = tissuec.compile(text).network.springs.behaviour
    assert law.pull(np.array([strain * 10e-3])) == pytest.approx([2.0])
    assert found.breaking.stress is None


def test_a_limit_that_is_never_reached_is_none():
    table = (
        'table nodes of piece in mm with columns "id x" { 1 0; 2 10 }\n'
        'table springs of piece with columns "a b" { 1 2 }\n'
    )
    law = "spring force of e = c * e / (1 + abs(e) / 1 mm)"  # below c times 1 mm
    text = text_of("explicit", f"{law}; {SPRINGS}; breaking force = 2 N", "rupture is allowed")
    (found,) = tissuec.properties(text + table, frequencies=0)
    assert found.breaking is None


def test_springs_that_break_late_are_told_with_a_force_that_breaks_them_early():
    def said(force):
        tissue = f"{SPRINGS}; breaking force = {force}"
        return text_of(SHEET.format(9, 5, "both"), tissue, "rupture is allowed")

    (late,) = tissuec.check(said("5 N"))
    assert late.code == "W209"
    better = re.match(r"(\S+ mN) would break it at 1.5 times", str(late.hint))[1]
    assert not tissuec.check(said(better))
    (found,) = tissuec.properties(said(better), frequencies=0)
    assert found.breaking.stretch[1] == pytest.approx(1.5, rel=1e-2)  # of its three digits


def test_frequencies_about_an_equilibrium_are_told_where_they_are_others():
    """A row of springs that its weight draws down swings faster about its equilibrium."""
    nodes = "".join(f"{n} {5 * n} 0 0\n" for n in range(9))
    table = (
        f'table nodes of piece in mm with columns "id x y z" {{\n{nodes}}}\n'
        'table springs of piece with columns "a b" {\n'
        + "".join(f"{n} {n + 1}\n" for n in range(8))
        + "}\nset ends = nodes of piece where x < 1 mm or x > 39 mm\n"
    )

    def notes(strain, gravity, script="at 0 s: fix ends"):
        tissue = f"{SPRINGS}; prestress = {strain} %"
        text = text_of("explicit", tissue, sets=table, script=f"script {{ {script} }}")
        text = text.replace("(0, 0, 0) m/s^2", f"(0, 0, -{gravity}) m/s^2")
        (found,) = tissuec.properties(text)
        return [note for note in found.notes if "equilibrium" in note], found.vibrations

    (said,), drawn = notes(1, 9.81)
    assert said.startswith("frequencies are about the state at 0 s, which is not in equil")
    none, settled = notes(1, 9.81, "at 0 s: { fix ends; settle }")
    assert not none
    shown = [float(one) for one in re.findall(r"[\d.]+(?=, | Hz)", said)]
    assert shown == pytest.approx([one.frequency for one in settled], rel=1e-2)
    assert shown[0] > 1.1 * drawn[0].frequency
    assert not notes(20, 1e-3)[0]  # hardly out of balance


# --- command ----------------------------------------------------------------------------------


def test_the_command_prints_each_body_and_gives_the_same_as_data(tmp_path: Path):
    scene = tmp_path / "piece.tis"
    tissue = f"{NET}; breaking strain = 45 %"
    scene.write_text(text_of(block("sodium chloride", 10), tissue, "rupture is allowed"))
    shown = command("explain", "piece.tis", "--bodies", cwd=tmp_path)
    assert shown.returncode == 0, shown.stderr
    table = shown.stdout[shown.stdout.index("piece: ") :].splitlines()
    assert table[0] == "piece: solid of gel; 45 nodes, 232 springs"
    lines = {line[2:].split("  ")[0]: " ".join(line.split()) for line in table[1:]}
    assert lines["mass"] == "mass 17 g 1060 kg/m^3, 16 ml"
    assert lines["breaks at"].startswith("breaks at 1.45 times its length")
    given = command("explain", "piece.tis", "--bodies", "--json", cwd=tmp_path)
    (body,) = json.loads(given.stdout)["bodies"]
    (same,) = tissuec.properties(scene)
    assert body["elasticity"]["young"] == pytest.approx(same.elasticity.young)
    assert body["vibrations"][0]["frequency"] == pytest.approx(same.vibrations[0].frequency)
    assert body["wave_speeds"] == pytest.approx(same.wave_speeds)
    assert body["density"] == pytest.approx(1060.0)


def test_a_body_that_is_not_there_is_told():
    with pytest.raises(tissuec.TissueError, match='no body "pece"; did you mean "piece"'):
        tissuec.properties(text_of(THREAD), body="pece")
    (found,) = tissuec.properties(text_of(THREAD), body="Piece", frequencies=0)
    assert found.name == "piece"
