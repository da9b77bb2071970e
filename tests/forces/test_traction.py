"""Forces that are even over faces: against closed forms, pressures and quadrature."""

import numpy as np
import pytest
from scipy.optimize import fsolve

import tissuec
from tests.derivatives import forces
from tests.findings import finding_of
from tests.hand_plan import carry_out
from tests.imports.organs import box_of_tetrahedra, write_vtk
from tests.validate.scenes import compiled_scene, validated
from tests.whole_runs import AfterAsking
from tissuec.forces.enclosed.pressed_sides import Pressed, pressed_faces
from tissuec.forces.enclosed.pressure import SurfacePressure
from tissuec.model.profiles import TimeProfile

STEADY = TimeProfile("constant", 0.0, np.inf)
MODULUS, RATIO, STRESS = 10e3, 0.3, 1e3  # [Pa], 1, [Pa]
BOX = "cell = {} mm; box from (-10, -10, 0) mm to (10, 10, 20) mm"
MESHES = {
    "2 across": f"mesh is lattice {{ {BOX.format(10)} }}",
    "4 across": f"mesh is lattice {{ {BOX.format(5)} }}",
    "8 across": f"mesh is lattice {{ {BOX.format(2.5)} }}",
    "graded": f"mesh is lattice {{ {BOX.format(10)}\n"
    "  fine cell = 2 mm; fine box from (6, 6, 16) mm to (10, 10, 20) mm }",
    "tetrahedra": 'mesh is imported { file "box.vtk" in mm; moved by (-10, -10, 0) mm }',
    "mirrored tetrahedra": """mesh is imported {
    file "box.vtk" in mm; moved by (-10, -10, 0) mm
    mirrored about plane through (0, 0, 0) mm facing (1, 0, 0)
  }""",
    "27 nodes": f"mesh is lattice {{ {BOX.format(10)} }}; made of quadratic elements",
    "27 nodes, mirrored": f"""mesh is lattice {{
    {BOX.format(10)}; mirrored about plane through (0, 0, 0) mm facing (1, 1, 0)
  }}
  made of quadratic elements""",
}
BAR = """language 1
tissue flesh {{ Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3 }}
body bar {{
  {mesh}
  tissue is flesh
}}
set end = nodes of bar where z > 19.99 mm
environment {{ gravity = (0, 0, 0) m/s^2
  {half}
  {planes}
}}
script {{ {script} }}
simulate {{ duration = {duration} }}
output {{ trajectory every {every} }}
"""
HALF = "symmetric about plane through (0, 0, 0) mm facing (0, 0, 1)"


def bar(
    mesh,
    push="push end with (0, 0, 400) mN",
    *,
    planes="",
    script="",
    duration="2 us",
    every="1 us",
):
    script = script or f"at 0 s: {{ {push}; settle }}"
    return BAR.format(
        mesh=MESHES.get(mesh, mesh),
        script=script,
        planes=planes,
        duration=duration,
        half=HALF,
        every=every,
    )


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_vtk(tmp_path / "box.vtk", *box_of_tetrahedra())


def lengthening():
    """Return how far the end of the bar moves [m]: neo-Hookean, K/2 ln² J."""
    shear, bulk = MODULUS / (2 * (1 + RATIO)), MODULUS / (3 * (1 - 2 * RATIO))

    def forces(stretches):
        along, across = stretches
        size = along * across**2
        mean = (along**2 + 2 * across**2) / 3
        first, second = (
            shear * size ** (-2 / 3) * (one**2 - mean) + bulk * np.log(size)
            for one in stretches
        )
        return first / along - STRESS, second / across

    return 20e-3 * (fsolve(forces, (1.1, 0.97), xtol=1e-13)[0] - 1.0)


@pytest.mark.parametrize("mesh", MESHES)
def test_the_end_of_a_bar_stays_plane_under_an_even_traction(mesh):
    with tissuec.run(bar(mesh), companion="off") as run:
        end = run.nodes_of("end")
        moved = run.position[-1, end, 2] - 20e-3
    # Homogeneous states are exact in all of these elements: what is left is that of the solver.
    np.testing.assert_allclose(moved, lengthening(), rtol=1e-5)


def test_a_quarter_under_a_quarter_of_the_force_moves_as_the_whole():
    quarter = "mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (10, 10, 20) mm }"
    planes = "\n  ".join(
        f"symmetric about plane through (0, 0, 0) mm facing {way}"
        for way in ("(1, 0, 0)", "(0, 1, 0)")
    )
    text = bar(quarter, "push end with (0, 0, 100) mN", planes=planes)
    with tissuec.run(text, companion="off") as run:
        end = run.nodes_of("end")
        moved = run.position[-1, end, 2] - 20e-3
    np.testing.assert_allclose(moved, lengthening(), rtol=1e-5)


def pushed(compiled):
    """Return the forces at 0 s of the only push of a scene [N], shape (node, 3)."""
    network = compiled.network
    (push,) = (one.action for one in compiled.plan.events if hasattr(one.action, "shares"))
    total = np.zeros((network.node_count, 3))
    load = push.load(network, push.profile)
    total[load.nodes] = load.at(0.0)
    return total


@pytest.mark.parametrize("mesh", MESHES)
def test_a_push_at_right_angles_to_a_face_is_a_pressure(mesh):
    """Pressures of elements are compared with quadrature elsewhere."""
    compiled = compiled_scene(bar(mesh))
    network = compiled.network
    end = np.flatnonzero(network.position[:, 2] > 19.99e-3)
    faces = pressed_faces(network, Pressed("end", end))
    field = SurfacePressure.of(
        "key", "end", faces, -STRESS, STEADY, network.bodies[0].span, has_caps=False
    )
    np.testing.assert_allclose(
        pushed(compiled), forces(field, network.position), atol=1e-12 * 0.4
    )


def test_shares_of_a_slanted_force_on_a_bent_wall_are_its_areas():
    wall = """mesh is tube { axis from (0, 0, 0) mm to (0, 0, 20) mm; radius = 5 mm; rings = 4
    sides = 8 }
  thickness = 1 mm"""
    text = bar(wall, "push bar with (3, 2, 1) mN").replace(HALF, "")
    compiled = compiled_scene(text)
    network = compiled.network
    a, b, c = network.position[network.skin].swapaxes(0, 1)
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    share = np.bincount(network.skin.ravel(), np.repeat(area, 3)) / (3.0 * area.sum())
    np.testing.assert_allclose(
        pushed(compiled), share[:, None] * [3e-3, 2e-3, 1e-3], rtol=1e-12
    )


@pytest.mark.parametrize(
    ("where", "why"),
    [
        ("z > 19.99 mm and x > 9.99 mm", "an edge has no face"),
        ("z > 9.99 mm and z < 15.01 mm", "nodes inside of the body"),
        ("x < 100 mm", "all of the body"),
        ("z > 14.99 mm and x > 4.99 mm and y > 4.99 mm", "a whole element"),
    ],
)
def test_each_node_of_other_sets_gets_the_same(where, why):
    text = bar("4 across").replace("where z > 19.99 mm", f"where {where}").replace(HALF, "")
    forces = pushed(compiled_scene(text))
    acting = forces[np.abs(forces).sum(axis=1) > 0.0]
    assert (acting == acting[0]).all(), why
    assert acting.sum(axis=0) == pytest.approx([0, 0, 0.4], rel=1e-12)


def test_nodes_can_share_evenly_by_name():
    text = bar("4 across", "push end with (0, 0, 400) mN in equal parts")
    forces = pushed(compiled_scene(text))
    assert (forces[forces[:, 2] > 0.0] == [0.0, 0.0, 0.4 / 25]).all()


def test_the_whole_force_on_each_node_is_not_shared():
    text = bar("4 across", "push end with (0, 0, 4) mN on each node in equal parts")
    found = finding_of(compiled_scene, text)
    assert found.code == "TIS306"


SHAKEN = """at 0 s: { push end with (1, 2, 3) mN using sine of 90 Hz }
  at 1 ms: push end with (0, 0, 2) mN"""


def test_forces_that_change_are_those_of_the_reference():
    found = validated(bar("graded", script=SHAKEN, duration="3 ms", every="0.5 ms"))
    assert found.verdict == "kept", found.reasons


def test_a_run_that_is_gone_on_with_keeps_the_shares():
    compiled = compiled_scene(bar("graded", script=SHAKEN, duration="3 ms", every="0.5 ms"))
    network, plan = compiled.network, compiled.plan
    whole, _ = carry_out(network, plan)
    first, before = carry_out(network, plan, interrupt=AfterAsking(2))
    assert first.kind == "interrupted" and first.state.time > 0.0
    rest, _ = carry_out(network, plan, resume=before.state)
    assert np.array_equal(rest.state.position, whole.state.position)
