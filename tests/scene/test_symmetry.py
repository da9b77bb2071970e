"""Planes of symmetry: a half and a quarter of a problem are that of the whole."""

import re
from unittest.mock import Mock

import numpy as np
import pytest

import tissuec
from tests.every import every
from tests.findings import finding_of
from tests.validate.scenes import compiled_scene
from tissuec.analysis.vibration.modes import modes_of
from tissuec.core.errors import CompileError
from tissuec.mechanics.settling import settle
from tissuec.mechanics.state import State
from tissuec.validate.resting import rest
from tissuec.validate.validation import validate

PLANES = {
    axis: f"symmetric about plane through (0, 0, 0) mm facing {way}"
    for axis, way in {"x": "(1, 0, 0)", "y": "(0, -1, 0)"}.items()
}
#: A cube between plates that stick, of which parts can be drawn.
CUBE = """language 1
tissue gel {{
  Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3
  retardation time = 5 ms
}}
tissue cord {{ spring constant = 40 N/m; viscosity = 10 mN*s/m; mass = 5 mg }}
body block {{
  mesh is lattice {{ cell = 5 mm; box from ({x}, {y}, 0) mm to (10, 10, 20) mm }}
  tissue is gel; made of elements
}}
set base = nodes of block where z < 0.1 mm
set top = nodes of block where z > 19.9 mm
set middle = nodes of block where x > 4.9 mm and y > 4.9 mm and z between 9 mm and 11 mm
environment {{ gravity = (0, 0, -9.81) m/s^2; {planes} }}
script {{
  at 0 s: fix base
  {script}
}}
simulate {{ duration = {duration}; tolerance = 1e-9; integrator is dop853 }}
output {{ force of top every 5 ms; position of middle every 5 ms; trajectory every 5 ms }}
"""
PRESSED = "from 0 s to 10 ms: move top by (0, 0, -4) mm using smooth profile"
BAR = """language 1
tissue gel {{ Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3 }}
body bar {{
  mesh is lattice {{ cell = 5 mm; box from (0, {y}, 0) mm to (40, 10, 10) mm }}
  tissue is gel; made of elements
}}
set root = nodes of bar where x < 0.1 mm
set tip = nodes of bar where x > 39.9 mm and (y < -0.1 mm or y > 0.1 mm)
set seam = nodes of bar where x > 39.9 mm and y between -0.1 mm and 0.1 mm
environment {{ gravity = (0, 0, 0) m/s^2; {planes} }}
script {{
  at 0 s: {{
    fix root
    push tip with (0, 0, -0.3) mN on each node
    push seam with (0, 0, -0.3) mN * {share} on each node
  }}
}}
simulate {{ duration = 1 ms }}
"""


def cube(axes="", script=PRESSED, duration="20 ms"):
    """Return the scene of the part of a cube on one side of the planes of some axes."""
    sides = {axis: "0" if axis in axes else "-10" for axis in "xy"}
    planes = "; ".join(PLANES[axis] for axis in axes)
    return CUBE.format(**sides, planes=planes, script=script, duration=duration)


def bar(axes=""):
    """Return the scene of a cantilever with a load at its tip, or of its half."""
    if axes:
        return BAR.format(y=0, planes=PLANES["y"], share=0.5)
    return BAR.format(y=-10, planes="", share=1)


def settled(text, by, shift=0.0):
    """Return drawn and settled positions of a scene whose base and root stay."""
    compiled = compiled_scene(text)
    state = State.start(compiled.network, gravity=compiled.plan.gravity, drag=0.0)
    for event in compiled.plan.events:
        if event.time == 0.0:
            event.action.apply(state, Mock())
    if shift:
        drawn = compiled.network.position
        top = np.flatnonzero(drawn[:, 2] > 19.9e-3)
        state.holders["top"] = top
        state.position[top, 2] += shift
    by(state, np.ones(compiled.network.node_count, dtype=bool))
    return compiled.network.position, state.position


def mismatch(whole, part):
    """Return by how much places of a part differ from those of the whole, as a share."""
    drawn, placed = whole
    own, found = part
    apart = np.abs(drawn[None] - own[:, None]).sum(axis=2)
    twins = apart.argmin(axis=1)
    assert apart.min(axis=1).max() < 1e-12
    return np.abs(placed[twins] - found).max() / np.abs(placed - drawn).max()


@pytest.mark.parametrize("axes", ["x", "y", "xy"])
def test_a_part_of_a_cube_moves_as_the_whole(axes, tmp_path):
    whole, part = (
        tissuec.run(cube(each), out=tmp_path / f"{each or 'whole'}.vtkhdf", companion="off")
        for each in ("", axes)
    )
    share = 0.5 ** len(axes)
    force, own = (run.logs["force of top"].value[:, 2] for run in (whole, part))
    # Both keep 1e-9 of the displacement, in other steps.
    np.testing.assert_allclose(own, share * force, atol=3e-9 * np.abs(force).max())
    places, found = (run.logs["position of middle"].value for run in (whole, part))
    np.testing.assert_allclose(found, places, atol=3e-9 * 4e-3)
    on_plane = np.abs(part.network.position[:, "xy".index(axes[0])]) < 1e-12
    assert np.abs(part.position[-1][on_plane, "xy".index(axes[0])]).max() < 1e-18


@pytest.mark.parametrize(
    ("stiffness", "close"),
    [
        ("stiffness = 20 N/m", 3e-6),
        ("surface stiffness = 5 MPa/m; contact places is nodes", 3e-6),
        # Diagonals of faces are no mirror images of those on the other side.
        ("surface stiffness = 5 MPa/m", 2e-2),
    ],
)
def test_a_probe_on_the_plane_feels_half_of_the_whole(stiffness, close, tmp_path):
    """With damping of each node; contact and damping of nodes on the plane belong to both."""
    probe = """
tool probe { kind is probe; radius = 8 mm; axis from (0, -4, 28.5) mm to (0, 4, 28.5) mm }
"""
    pressed = "from 0 s to 10 ms: move probe by (0, 0, -3) mm using smooth profile"
    forces = []
    for axes in ("", "x"):
        text = cube(axes, script=pressed, duration="12 ms").replace("1e-9", "1e-7")
        contact = f"contact is tools only; contact {stiffness}; damping = 2 mN*s/m; "
        contact += "surface damping = 20 Pa*s/m; gravity = (0, 0, 0) m/s^2; "
        text = text.replace("gravity = (0, 0, -9.81) m/s^2; ", contact)
        text = text.replace("force of top", "force of probe") + probe
        run = tissuec.run(text, out=tmp_path / f"{axes or 'whole'}.vtkhdf", companion="off")
        forces.append(run.logs["force of probe"].value[:, 2])
    whole, half = forces
    assert np.abs(whole).max() > 1e-3
    np.testing.assert_allclose(half, 0.5 * whole, atol=close * np.abs(whole).max())


@pytest.mark.parametrize("by", [settle, rest], ids=["engine", "reference"])
@pytest.mark.parametrize("axes", ["x", "xy"])
def test_a_part_of_a_cube_rests_as_the_whole(by, axes):
    whole = settled(cube(script=""), settle, -4e-3)
    assert mismatch(whole, settled(cube(axes, script=""), by, -4e-3)) < 1e-9


NOTHING = "nothing holds the net: the centre of mass is unchanged"
PLANES_ONLY = (
    "nothing but planes of symmetry holds the net: along these, the centre of mass is unchanged"
)


@pytest.mark.parametrize(
    ("axes", "said"), [("", NOTHING), ("x", PLANES_ONLY), ("xy", PLANES_ONLY), ("xyz", "")]
)
def test_settling_tells_what_planes_do_not_hold(axes, said):
    base = "symmetric about plane through (0, 0, 0) mm facing (0, 0, 1)" if "z" in axes else ""
    text = cube(axes.replace("z", ""), script="").replace(
        "environment {", f"environment {{ {base};"
    )
    compiled = compiled_scene(text.replace("at 0 s: fix base", "").replace("-9.81", "0"))
    state = State.start(compiled.network, gravity=np.zeros(3), drag=0.0)
    remarks = settle(state, np.ones(compiled.network.node_count, dtype=bool))
    assert [one.message for one in remarks] == ([said] if said else [])
    assert np.abs(state.position - compiled.network.position).max() < 1e-12


def test_half_of_a_cantilever_bends_as_the_whole():
    assert mismatch(settled(bar(), settle), settled(bar("y"), settle)) < 1e-9


def test_modes_of_a_half_are_the_symmetric_ones_of_the_whole():
    frequencies = []
    for text in (bar(), bar("y")):
        compiled = compiled_scene(text)
        state = State.start(compiled.network, gravity=np.zeros(3), drag=0.0)
        state.holders["root"] = np.flatnonzero(compiled.network.position[:, 0] < 1e-6)
        modes = modes_of(state, np.ones(compiled.network.node_count, dtype=bool), count=12)
        frequencies.append([mode.frequency for mode in modes])
    whole, half = map(np.array, frequencies)
    nearest = np.abs(whole[:, None] / half[None, :6] - 1.0).min(axis=0)
    assert nearest[:3].max() < 1e-9
    # Bending sideways is no symmetric motion: the whole has modes that the half has not.
    missing = np.abs(whole[:6, None] / half[None] - 1.0).min(axis=1) > 1e-3
    assert missing.any()


def test_all_modes_of_a_part_keep_to_the_planes():
    compiled = compiled_scene(cube("xy").replace("cell = 5 mm", "cell = 10 mm"))
    state = State.start(compiled.network, gravity=np.zeros(3), drag=0.0)
    drawn = compiled.network.position
    modes = modes_of(state, np.ones(len(drawn), dtype=bool), count=999)
    on = [np.abs(drawn[:, axis]) < 1e-12 for axis in (0, 1)]
    assert len(modes) == 3 * len(drawn) - on[0].sum() - on[1].sum()
    every, known = np.ones(len(drawn), dtype=bool), np.array([one.frequency for one in modes])
    # In the widest gap among the highest ones, since some of a cube are the same.
    gap = len(known) - 5 + np.argmax(known[-5:] / known[-6:-1])
    above = np.sqrt(known[gap - 1 : gap + 1].prod())
    assert len(modes_of(state, every, count=9, above=above)) == len(known) - gap
    largest = max(np.abs(mode.shape).max() for mode in modes)
    for mode in modes:
        for axis in (0, 1):
            assert np.abs(mode.shape[on[axis], axis]).max() < 1e-9 * largest
    assert [mode.kind for mode in modes].count("rigid") == 1  # along the line of both planes


def test_the_reference_agrees():
    text = cube("x", duration="5 ms").replace("1e-9", "1e-6")
    text += "set seam = nodes of block where x == 0 mm and z < 19 mm\n"
    text = text.replace("force of top", "force of seam")  # which the plane bears
    found = validate(compiled_scene(text), method="DOP853", rtol=None, progress=Mock())
    assert found.verdict == "kept", found.reasons
    assert found.comparison is not None
    (error,) = [one for one in found.comparison.quantities if "seam" in one.name]
    assert error.error < 1e-5 and error.scale > 1e-4


def test_what_a_plane_leaves_of_forces_is_in_it_for_every_corner():
    compiled = compiled_scene(cube("xy"))
    guides = compiled.network.guides
    force = np.random.default_rng(1).normal(size=compiled.network.position.shape)
    kept = force.copy()
    guides.keep(kept)
    on = np.abs(compiled.network.position[:, :2]) < 1e-12
    assert np.array_equal(kept[:, :2] == 0.0, on) and np.array_equal(kept[:, 2], force[:, 2])
    assert np.array_equal(kept[:, :2][~on], force[:, :2][~on])


@every(
    ("old", "new", "said"),
    [
        ("(0, -10, 0) mm to", "(-10, -10, 0) mm to", "block lies on both sides of this plane"),
        ("through (0, 0, 0)", "through (-1, 0, 0)", "no node lies on this plane; the"),
        ("(0, 0, -9.81)", "(1, 0, -9.81)", "gravity is not parallel to a plane of symmetry"),
        ("by (0, 0, -4) mm", "by (1, 0, -4) mm", "a motion of nodes of this plane is not"),
        (PRESSED, "at 0 s: push top with (1, 0, 0) N", "a force on nodes of this plane is not"),
        (PRESSED, "from 0 s to 10 ms: turn top by 5 deg around (0, 0, 1) using smooth profile",
         "a turn of nodes of this plane is not parallel"),
        ("facing (1, 0, 0)", "", "the direction is missing"),
        ("facing (1, 0, 0)", "facing (1, 0, 0) by 2 mm", 'plane does not take "by"'),
        (PLANES["x"], f"{PLANES['x']}; {PLANES['x'].replace('(1, 0, 0)', '(1, 1, 0)')}",
         "planes of symmetry must be perpendicular"),
        ("symmetric about plane through", "symmetry plane through", "wrong form of a plane of"),
        ("tissue is gel; made of elements", "tissue is cord", "springs of block lie within"),
    ],
)  # fmt: skip
def test_what_does_not_go_with_a_plane_is_refused(old, new, said):
    text = cube("x")
    assert old in text
    changed = text.replace(old, new)
    if "is cord" in changed:
        changed = changed.replace("{ cell", "{ kind is sodium chloride; cell")
    with pytest.raises(CompileError) as caught:
        compiled_scene(changed)
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("facing", "angle", "proposed"),
    [("(1, 1, 0)", "45", "(0, 1, 0)"), ("(-1, 0, 2)", "63.4", "(0, 0, 1)")],
)
def test_an_oblique_plane_is_refused_with_a_perpendicular_one(facing, angle, proposed):
    oblique = PLANES["x"].replace("(1, 0, 0)", facing)
    text = cube("x").replace(PLANES["x"], f"{PLANES['x']}; {oblique}")
    found = finding_of(compiled_scene, text)
    assert f"an angle of {angle} degrees" in found.message
    assert f"write facing {proposed}," in found.hint
    with pytest.raises(CompileError) as caught:  # the cube has no weight along x
        compiled_scene(text.replace(facing, proposed))
    assert "at an angle of" not in str(caught.value)


def test_what_is_proposed_for_gravity_across_a_plane_bears_the_weight(tmp_path):
    """The block of 10 mm by 20 mm by 20 mm lies on it; equilibria keep 1e-6 of the forces."""
    base = "symmetric about plane through (0, 0, 0) mm facing (0, 0, 1)"
    text = cube("x", script="").replace("at 0 s: fix base", "at 0 s: settle")
    crossed = text.replace(PLANES["x"], f"{PLANES['x']}; {base}")
    found = finding_of(compiled_scene, crossed)
    assert found.message == "gravity is not parallel to a plane of symmetry"
    tool, entry = re.findall(r"write (tool .*\}) and, in environment, (.*)", found.hint)[0]
    lying = crossed.replace(base, entry) + tool + "\n"
    lying = lying.replace("force of top", "force of floor").replace(PLANES["x"], "")
    lying = lying.replace("duration = 20 ms; tolerance = 1e-9; integrator is dop853", STATICS)
    run = tissuec.run(lying, out=tmp_path / "lying.vtkhdf", companion="off")
    weight = 1000 * 9.81 * 10e-3 * 20e-3 * 20e-3
    assert abs(run.logs["force of floor"].value[-1, 2]) == pytest.approx(weight, rel=1e-5)


JOINED = """language 1
tissue gel { Young's modulus = 10 kPa; density = 1000 kg/m^3 }
tissue cord { spring constant = 40 N/m; viscosity = 10 mN*s/m; mass = 5 mg }
body low {
  mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (5, 10, 10) mm }; tissue is gel
}
body high {
  mesh is lattice { cell = 5 mm; box from (0, 0, 20) mm to (5, 10, 25) mm }; tissue is gel
}
set top = nodes of low where z == 10 mm
set under = nodes of high where z == 20 mm
joint link { springs from top to under; tissue is cord }
environment {
  gravity = (0, 0, 0) m/s^2; symmetric about plane through (0, 0, 0) mm facing (0, 1, 0)
}
simulate { duration = 1 ms }
"""


def test_a_joint_goes_with_a_plane_once_its_nodes_are_left_out():
    found = finding_of(compiled_scene, JOINED)
    assert found.message.startswith("springs of link lie within this plane")
    assert "leave nodes on the plane out of one of the sets that link joins" in found.hint
    beside = JOINED.replace("z == 10 mm", "z == 10 mm and y > 0 mm")
    network = compiled_scene(beside).network
    assert network.joints[0].springs.stop - network.joints[0].springs.start == 4
    network = compiled_scene(beside.replace("from top to under", "from under to top")).network
    assert network.guides is not None


def test_planes_beside_a_body_that_cannot_be_drawn_are_not_reported():
    wrong = "box from (0, 0, 0) mm to (7, 20, 20) mm"
    text = re.sub(r"box from [^;}]*", wrong, cube("x"), count=1)
    with pytest.raises(CompileError) as caught:
        compiled_scene(text)
    assert all("plane" not in one.message for one in caught.value.diagnostics)


SHEET = """language 1
tissue gel { Young's modulus = 10 kPa; density = 1000 kg/m^3 }
body wall {
  mesh is sheet { corner = (0, 0, 0) mm; first edge = (20, 0, 0) mm; second edge = (0, 9, 0) mm
                  columns = 5; rows = 3 }
  tissue is gel; thickness = 1 mm; made of elements; bending is none
}
environment {
  gravity = (0, 0, 0) m/s^2; symmetric about plane through (0, 0, 0) mm facing (1, 0, 0)
}
simulate { duration = 1 ms }
"""


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("; bending is none", "", "wall resists bending, but not against its mirror image"),
        ("facing (1, 0, 0)", "facing (0, 0, 1)", "triangles of wall lie within this plane"),
    ],
)
def test_walls_have_their_mirror_image_where_they_do_not_bend(old, new, said):
    assert compiled_scene(SHEET).network.guides is not None
    with pytest.raises(CompileError) as caught:
        compiled_scene(SHEET.replace(old, new))
    assert said in str(caught.value)


def test_a_turn_in_the_plane_is_no_conflict():
    turn = "from 0 s to 10 ms: turn top by 5 deg around (1, 0, 0) using smooth profile"
    compiled_scene(cube("x", script=turn))


# --- what planes bear -------------------------------------------------------------------------

CONFINED = """language 1
tissue cartilage {
  Young's modulus = 500 kPa; Poisson's ratio = 0.2; density = 1100 kg/m^3
}
body plug {
  mesh is lattice { cell = 1 mm; box from (0, 0, 0) mm to (2, 2, 2) mm }
  tissue is cartilage
}
set floor = nodes of plug where z == 0 mm
set lid = nodes of plug where z == 2 mm
set wall = nodes of plug where x == 2 mm
environment {
  gravity = (0, 0, 0) m/s^2
  symmetric about plane through (0, 0, 0) mm facing (1, 0, 0)
  symmetric about plane through (2, 0, 0) mm facing (-1, 0, 0)
  symmetric about plane through (0, 0, 0) mm facing (0, 1, 0)
  symmetric about plane through (0, 2, 0) mm facing (0, -1, 0)
}
script { at 0 s: fix floor; from 0 s to 10 ms: move lid by (0, 0, -0.002) mm using ramp }
simulate { duration = 10 ms }
output { force of lid every 1 ms; force of wall every 1 ms; trajectory every 1 ms }
"""
STATICS = "duration = 10 ms; integrator is equilibrium; step = 5 ms"


def last(text, *logs, folder):
    """Return the last samples of logs of a run that finds equilibria."""
    text = re.sub(r"duration = [^}]*", STATICS + " ", text)
    run = tissuec.run(text, out=folder / "scene.vtkhdf", companion="off")
    return [run.logs[one].value[-1] for one in logs], run


def test_a_wall_that_confines_a_body_bears_what_it_presses_with(tmp_path):
    (lid, wall), run = last(CONFINED, "force of lid", "force of wall", folder=tmp_path)
    aggregate = 500e3 * 0.8 / (1.2 * 0.6)
    pressed = aggregate * 1e-3 * 4e-6
    # Strains of 0.1 % differ from infinitesimal ones by 0.1 to 0.3 %.
    assert lid == pytest.approx([0.0, 0.0, -pressed], rel=3e-3, abs=1e-9)
    assert wall == pytest.approx([-0.25 * pressed, 0.0, 0.0], rel=3e-3, abs=1e-9)
    # Forces at nodes in frames are those of the logs.
    own = run.network.position[:, 0] == 2e-3
    assert -run.force[-1][own].sum(axis=0) == pytest.approx(wall, rel=1e-12, abs=1e-15)


QUARTER = """language 1
tissue wall { Young's modulus = 60 kPa; Poisson's ratio = 0.4; density = 1050 kg/m^3 }
body ring {
  mesh is thick tube {
    axis from (0, 0, 0) mm to (0, 0, 0.5) mm; inner radius = 2 mm; outer radius = 3 mm
    rings = 2; sides = 16; layers = 2; part is quarter
  }
  tissue is wall
}
set cut = nodes of ring where y == 0 mm
set inner = nodes of ring where y == 0 mm and x < 2.1 mm
environment {
  gravity = (0, 0, 0) m/s^2
  symmetric about plane through (0, 0, 0) mm facing (0, 0, 1)
  symmetric about plane through (0, 0, 0.5) mm facing (0, 0, -1)
  symmetric about plane through (0, 0, 0) mm facing (1, 0, 0)
  symmetric about plane through (0, 0, 0) mm facing (0, 1, 0)
}
script { from 0 s to 10 ms: press inside of ring with 5 kPa using ramp }
simulate { duration = 10 ms }
output { force of cut every 10 ms; position of inner every 10 ms }
"""


def test_half_of_a_ring_bears_its_hoop_force_at_the_plane(tmp_path):
    (force, inner), _ = last(QUARTER, "force of cut", "position of inner", folder=tmp_path)
    # The pressure on a chord, whatever the ring: equilibrium to 1e-6 of the forces.
    assert force[1] == pytest.approx(-5e3 * inner[0] * 0.5e-3, rel=1e-6)
    assert inner[0] > 2.1e-3


BEAM = """language 1
tissue gel { Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3 }
body beam {
  mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (40, 10, 10) mm }
  tissue is gel
}
set root = nodes of beam where x == 0 mm
set rest = nodes of beam where x == 0 mm and z == 5 mm
set tip = nodes of beam where x == 40 mm
environment {
  gravity = (0, 0, 0) m/s^2; symmetric about plane through (0, 0, 0) mm facing (1, 0, 0)
}
script { at 0 s: { fix rest; push tip with (0, 0, -0.02) mN on each node } }
simulate { duration = 10 ms }
output {
  torque of root every 10 ms; force of root every 10 ms
  position of root every 10 ms; position of tip every 10 ms
}
"""


def test_a_plane_bears_the_bending_moment_of_half_a_beam(tmp_path):
    logs = "torque of root", "force of root", "position of root", "position of tip"
    (torque, force, root, tip), _ = last(BEAM, *logs, folder=tmp_path)
    load = np.array([0.0, 0.0, -9 * 0.02e-3])
    assert force == pytest.approx(-load, rel=1e-6, abs=1e-10)
    assert torque == pytest.approx(-np.cross(tip - root, load), rel=1e-5, abs=1e-12)
    assert abs(torque[1]) == pytest.approx(9 * 0.02e-3 * 40e-3, rel=1e-2)
