"""Static runs end beyond folds that nobody prepared, soon, and say where they are."""

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipk

import tissuec
from tests.counting import counted
from tests.engine.test_equilibria import carry_out, compiled_scene
from tissuec.engine import equilibria
from tissuec.mechanics import newton

BLOCK = """language 1
tissue gel {{ Young's modulus = 10 kPa; Poisson's ratio = {ratio}; density = 1000 kg/m^3 }}
body block {{
  mesh is lattice {{ cell = {cell} mm; box from (0, 0, 0) mm to ({wide}, {wide}, {high}) mm }}
  tissue is gel
}}
set low = nodes of block where z < 0.01 mm
set high = nodes of block where z > {high} mm - 0.01 mm
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{
  at 0 s: {{ fix low; {start} }}
  from 0 s to 1 s: {order}
}}
simulate {{ duration = 1 s; integrator is equilibrium; step = 50 ms }}
output {{ position of high every 50 ms }}
"""
COLUMN = BLOCK.format(
    ratio=0.45, cell=2.5, wide=5, high=40, start="",
    order="push high with (0, 0, -1) mN using ramp",
)  # fmt: skip
SQUASH = BLOCK.format(
    ratio=0.3, cell=5, wide=10, high=10, start="hold high",
    order="move high by (0, 0, -9.5) mm using constant speed",
)  # fmt: skip


@pytest.fixture
def matrices(monkeypatch):
    """Return a list that grows with each matrix of Newton's method."""
    return counted(monkeypatch, newton, "tangent_at")


def test_a_column_under_a_dead_load_buckles_to_the_elastica(matrices):
    """K(k)² = P l²/E I, and its end is 2 k l/K aside (S. P. Timoshenko, J. M. Gere 1961)."""
    compiled = compiled_scene(COLUMN)
    outcome, _ = carry_out(compiled.network, compiled.plan)
    assert outcome.kind == "done"
    (note,) = outcome.notes
    assert note.startswith("the net buckled to one of several possible sides (first at 850 ms)")
    bending, long = 10e3 * (5e-3) ** 4 / 12.0, 40e-3
    euler = np.pi**2 * bending / (4.0 * long**2)
    assert euler < 0.85e-3
    # Two trilinear cells across buckle under 3 % more.
    load = np.sqrt(1e-3 / (1.03 * euler)) * np.pi / 2.0
    modulus = brentq(lambda m: ellipk(m) - load, 1e-6, 0.999)
    aside = 2.0 * np.sqrt(modulus) * long / load
    head = compiled.network.position[:, 2] > 39.99e-3
    moved = (outcome.state.position - compiled.network.position)[head].mean(axis=0)
    assert np.hypot(*moved[:2]) == pytest.approx(aside, rel=0.03)
    assert len(matrices) < 250


def arch(path: Path) -> Path:
    """Write a clamped arch of hexahedra: radius 50 mm, 60 degrees, 2 mm thick."""
    angle = np.radians(np.linspace(-30.0, 30.0, 25))
    grid = np.meshgrid(angle, [0.0, 5.0], [49.0, 51.0], indexing="ij")
    x, r = grid[2] * np.sin(grid[0]), grid[2] * np.cos(grid[0]) - 50.0 * np.cos(angle[0])
    points = np.stack([x, grid[1], r], axis=-1).reshape(-1, 3)
    corner = np.array([0, 4, 6, 2, 1, 5, 7, 3])  # of a cell, in rows of four nodes
    cells = [corner + 4 * k for k in range(24)]
    lines = [
        "# vtk DataFile Version 3.0", "arch", "ASCII", "DATASET UNSTRUCTURED_GRID",
        f"POINTS {len(points)} double", *(" ".join(map(repr, map(float, p))) for p in points),
        f"CELLS 24 {24 * 9}", *("8 " + " ".join(map(str, cell)) for cell in cells),
        "CELL_TYPES 24", *["12"] * 24,
    ]  # fmt: skip
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


ARCH = """language 1
tissue gel { Young's modulus = 100 kPa; Poisson's ratio = 0; density = 1000 kg/m^3 }
body bow { mesh is imported { file "arch.vtk" in mm }; tissue is gel }
set ends = nodes of bow where x < -23 mm or x > 23 mm
set crown = nodes of bow where x between -0.1 mm and 0.1 mm
environment { gravity = (0, 0, 0) m/s^2 }
script {
  at 0 s: fix ends
  from 0 s to 1 s: ORDER
}
simulate { duration = 1 s; integrator is equilibrium; step = 20 ms }
output { OUTPUT every 20 ms; energy every 0.5 s }
"""


def test_an_arch_snaps_at_the_largest_force_of_one_that_is_moved(tmp_path, matrices):
    arch(tmp_path / "arch.vtk")
    moved = ARCH.replace("fix ends", "{ fix ends; hold crown }")
    moved = moved.replace("ORDER", "move crown by (0, 0, -9) mm using constant speed")
    (tmp_path / "moved.tis").write_text(moved.replace("OUTPUT", "force of crown"))
    run = tissuec.run(tmp_path / "moved.tis", out=tmp_path / "m.vtkhdf", companion="off")
    force = -run.logs["force of crown"].value[:, 2]
    first = int(np.argmax(force[:30]))
    most = np.polynomial.Polynomial.fit([-1, 0, 1], force[first - 1 : first + 2], 2)
    limit = float(np.max(most(np.linspace(-1, 1, 201))))
    pushed = ARCH.replace("ORDER", "push crown with (0, 0, -10) mN using ramp")
    (tmp_path / "pushed.tis").write_text(pushed.replace("OUTPUT", "position of crown"))
    matrices.clear()
    run = tissuec.run(tmp_path / "pushed.tis", out=tmp_path / "p.vtkhdf", companion="off")
    (note,) = (each for each in run.manifest["notes"] if "snapped" in each)
    found = re.search(r"at (\S+) ms .*under a push of (\S+) mN \(.*pushed.tis:9\)", note)
    assert found is not None, note
    # The parabola through three of 50 steps is the limit's error.
    assert float(found[1]) * 1e-3 * 10e-3 == pytest.approx(limit, rel=2e-3)
    assert float(found[2]) * 1e-3 == pytest.approx(limit, rel=1e-2)
    energy = dict(zip(run.energies.columns, run.energies.value[-1], strict=True))
    assert energy["dissipated"] > 0.0
    # Work along smooth parts of the path is booked as what is stored there.
    both = energy["elastic"] + energy["dissipated"]
    assert energy["work"] == pytest.approx(both, rel=1e-9)
    # 20 halvings of a step; a snap takes 20 matrices.
    assert len(matrices) < 20 * 20 + 150


def test_a_cube_is_squashed_to_a_twentieth(tmp_path, matrices):
    (tmp_path / "s.tis").write_text(SQUASH, encoding="utf-8")
    run = tissuec.run(tmp_path / "s.tis", out=tmp_path / "s.vtkhdf", companion="off")
    assert run.outcome.startswith("done")
    assert len(matrices) < 4000


def test_a_net_that_snaps_again_and_again_ends_and_keeps_what_was_found(tmp_path, monkeypatch):
    arch(tmp_path / "arch.vtk")
    monkeypatch.setattr(equilibria, "MOST_LOST", 5)
    pushed = ARCH.replace("ORDER", "push crown with (0, 0, -10) mN using ramp")
    (tmp_path / "p.tis").write_text(pushed.replace("OUTPUT", "position of crown"))
    with pytest.warns(tissuec.TissueWarning, match=r"lost 5 times .* push of .*p\.tis:9"):
        run = tissuec.run(tmp_path / "p.tis", out=tmp_path / "p.vtkhdf", companion="off")
    times = run.logs["position of crown"].time
    assert 0.3 < times[-1] < 0.36 and len(times) == round(times[-1] / 0.02) + 1
