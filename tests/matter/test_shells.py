"""A wall that bends elastically resists as a plate of its thickness, on every mesh."""

import numpy as np
import pytest

import tissuec
from tests.hand_net import start
from tests.matter.elastic import scene
from tests.validate.scenes import validated
from tissuec.core.errors import CompileError
from tissuec.mechanics.settling import settle

YOUNG, DENSITY, THICKNESS = 50e3, 1000.0, 2e-3
RIGIDITY = YOUNG * THICKNESS**3 / (12.0 * (1.0 - 1.0 / 9.0))
TISSUE = f"Young's modulus = {YOUNG} Pa; density = {DENSITY} kg/m^3; retardation time = 5 ms"


def shell(mesh, thickness=THICKNESS, tissue=TISSUE):
    return scene(tissue, f"mesh is {mesh}; thickness = {thickness} m; bending is elastic")[0]


def bent_energy(network, moved):
    return float(network.hinges.energy(0.0, moved))


PLATE = f"""language 1
tissue gel {{ {TISSUE} }}
body plate {{
  made of springs
  mesh is sheet {{
    corner = (0, 0, 0) mm; first edge = (40, 0, 0) mm; second edge = (0, 40, 0) mm
    columns = COUNT; rows = COUNT; diagonals is both
  }}
  tissue is gel; thickness = 2 mm; bending is elastic
}}
set border = nodes of plate where x < 0.1 mm or x > 39.9 mm or y < 0.1 mm or y > 39.9 mm
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{ at 0 s: fix border }}
simulate {{ duration = 1 ms }}
"""


def test_a_supported_plate_has_the_frequencies_of_theory():
    # ω = π² (m² + n²) / a² √(D / ρ t), damped by the retardation time τ with the ratio ω τ / 2
    exact = np.pi / 2.0 / 0.04**2 * np.sqrt(RIGIDITY / (DENSITY * THICKNESS))
    errors = []
    for count in (9, 17):
        modes = tissuec.modes(PLATE.replace("COUNT", str(count)), count=4)
        found = np.array([mode.frequency for mode in modes])
        errors.append(np.abs(found / (exact * np.array([2.0, 5.0, 5.0, 8.0])) - 1.0))
        for mode in modes:
            assert mode.damping_ratio == pytest.approx(np.pi * mode.frequency * 5e-3, rel=1e-6)
    assert errors[1][0] < 0.01
    assert errors[1].max() < 0.04
    # Of second order
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.2)


@pytest.mark.parametrize("columns", [11, 21])
def test_a_strip_sags_as_a_cantilever_of_its_thickness(columns):
    # w = ρ g A L⁴ / (8 E I), clamped in the middle between the two columns that are held. There
    # it can become no narrower, and hinges are a spacing apart: by some percent.
    spacing = 0.04 / (columns - 1)
    network = shell(
        "sheet { corner = (0, 0, 0) m; first edge = (0.04, 0, 0) m; "
        f"second edge = (0, {2 * spacing}, 0) m; columns = {columns}; rows = 3; "
        "diagonals is both }"
    )
    state = start(network, gravity=(0.0, 0.0, -0.01))
    state.holders["fix"] = np.flatnonzero(network.position[:, 0] < 1.1 * spacing)
    settle(state, np.ones(network.node_count, dtype=bool))
    sag = -state.position[network.position[:, 0] > 0.0399, 2].mean()
    length = 0.04 - spacing / 2.0
    expected = 12.0 * DENSITY * 0.01 * length**4 / (8.0 * YOUNG * THICKNESS**2)
    assert sag == pytest.approx(expected, rel=0.05)


def test_a_ring_of_a_tube_resists_becoming_oval():
    # u = cos 2θ outwards and -sin 2θ / 2 around stretches nothing and changes the curvature by
    # 3 cos 2θ / R².
    radius, length = 0.01, 0.04
    errors = []
    for sides in (16, 32, 64):
        network = shell(
            "tube { axis from (0, 0, 0) mm to (40, 0, 0) mm; radius = 10 mm; "
            f"rings = {sides + 1}; sides = {sides}; diagonals is both }}"
        )
        x = network.position
        angle = np.arctan2(x[:, 2], x[:, 1])[:, None]
        zero = np.zeros_like(angle)
        outward = np.hstack([zero, np.cos(angle), np.sin(angle)])
        around = np.hstack([zero, -np.sin(angle), np.cos(angle)])
        small = 1e-6
        u = small * (np.cos(2 * angle) * outward - np.sin(2 * angle) / 2.0 * around)
        exact = 0.5 * RIGIDITY * (3.0 * small / radius**2) ** 2 * np.pi * radius * length
        errors.append(1.0 - bent_energy(network, x + u) / exact)
    assert 0.0 < errors[2] < 0.02
    assert errors[0] / errors[1] > 3.0


def test_a_sphere_has_the_hinges_of_equal_triangles_and_nothing_bends_as_it_grows():
    network = shell("sphere { centre = (0, 0, 0) mm; radius = 10 mm; subdivisions = 2 }")
    hinges = network.hinges
    assert len(hinges.nodes) == network.spring_count  # one at each edge
    # Triangles of an icosphere differ: k = D e² / (A + A') is 2/√3 D where they are equal.
    assert hinges.stiffness.mean() == pytest.approx(2.0 / np.sqrt(3.0) * RIGIDITY, rel=0.03)
    assert bent_energy(network, 1.3 * network.position) < 1e-20 * RIGIDITY


def test_rigidity_goes_with_the_cube_of_the_thickness_and_damping_with_the_springs():
    mesh = (
        "sheet { corner = (0, 0, 0) mm; first edge = (40, 0, 0) mm; "
        "second edge = (0, 20, 0) mm; columns = 5; rows = 4; diagonals is both }"
    )
    thin, thick = shell(mesh), shell(mesh, 2 * THICKNESS)
    assert thick.hinges.stiffness == pytest.approx(8.0 * thin.hinges.stiffness)
    assert thin.hinges.damping == pytest.approx(5e-3 * thin.hinges.stiffness)
    viscous = shell(
        mesh, tissue=TISSUE.replace("retardation time = 5 ms", "shear viscosity = 1 Pa*s")
    )
    assert viscous.hinges.damping == pytest.approx(
        viscous.hinges.stiffness * (viscous.springs.damping / viscous.springs.stiffness).mean()
    )


def test_scipy_agrees_on_a_shell_that_is_bent_cut_and_let_go():
    text = (
        PLATE.replace("COUNT", "5")
        .replace("(0, 0, 0) m/s^2", "(0, 0, -9.81) m/s^2")
        .replace("x < 0.1 mm or x > 39.9 mm or y < 0.1 mm or y > 39.9 mm", "x < 12 mm")
        .replace("environment", "set seam = springs of plate where x > 25 mm\nenvironment")
        .replace("fix border }", "fix border; at 2 ms: cut seam }")
        .replace("duration = 1 ms", "duration = 5 ms; tolerance = 1e-6")
    )
    found = validated(text + "output { trajectory every 1 ms; energy every 1 ms }\n")
    assert found.verdict == "kept", found.reasons


WRONG = {
    "a lattice bends as it is": (
        "mesh is lattice { kind is sodium chloride; cell = 5 mm; reach is second neighbours; "
        "box from (0, 0, 0) mm to (10, 10, 10) mm }; bending is elastic",
        TISSUE,
        "TIS306",
    ),
    "springs one by one have no thickness": (
        "mesh is sheet { corner = (0, 0, 0) mm; first edge = (40, 0, 0) mm; second edge = "
        "(0, 20, 0) mm; columns = 5; rows = 4 }; bending is elastic",
        "spring constant = 10 N/m; viscosity = 1 mN*s/m; mass = 1 g",
        "TIS304",
    ),
    "two columns cannot bend": (
        "mesh is sheet { corner = (0, 0, 0) mm; first edge = (40, 0, 0) mm; second edge = "
        "(0, 20, 0) mm; columns = 2; rows = 2; diagonals is both }; thickness = 1 mm; "
        "bending is elastic",
        TISSUE,
        "TIS309",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_cannot_bend_by_its_thickness_is_told(name):
    body, tissue, code = WRONG[name]
    with pytest.raises(CompileError) as caught:
        scene(tissue, body)
    assert [found.code for found in caught.value.diagnostics if found.severity == "error"] == [
        code
    ]
