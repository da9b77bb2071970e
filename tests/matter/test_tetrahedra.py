"""Nets of tetrahedra and filled surfaces are solids of their tissue, too."""

import numpy as np
import pytest
from scipy.spatial import Delaunay

from tests.matter.elastic import drawn_out
from tissuec.core.source import Source
from tissuec.meshes.lattice import Lattice
from tissuec.pipeline import Request, compile_request

YOUNG, SIDES = 5e3, np.array([40.0, 20.0, 20.0])
SCENE = """language 1
tissue gel {{ Young's modulus = 5 kPa; density = 1000 kg/m^3; retardation time = 2 ms }}
body piece {{ mesh is imported {{ file "{file}" in mm{more} }}; tissue is gel{thickness} }}
environment {{ gravity = (0, 0, 0) m/s^2 }}
simulate {{ duration = 1 ms; tolerance = 1e-6; integrator is dop853 }}
"""


def bar(cell, moved):
    """Return nodes [mm] and tetrahedra of a bar, nodes inside moved by a part of its cell."""
    lattice = Lattice("caesium chloride", cell, (np.zeros(3), SIDES)).build()
    x = lattice.position.copy()
    inside = ((x > 0.0) & (x < SIDES)).all(axis=1)
    x[inside] += moved * cell * np.random.default_rng(1).uniform(-1, 1, x[inside].shape)
    cells = Delaunay(x + 1e-7 * inside[:, None] * np.sin(x)).simplices
    volume = np.abs(np.linalg.det(x[cells[:, 1:]] - x[cells[:, :1]])) / 6.0
    return x, cells[volume > 1e-6 * cell**3]


def compiled(folder, text, name, *, more="", thickness=""):
    path = folder / name
    path.write_text(text)
    scene = SCENE.format(file=name, more=more, thickness=thickness)
    source = Source("piece.tis", scene, folder / "piece.tis")
    found, _ = compile_request(Request(source))
    return found.network, found.plan


def as_vtk(x, cells):
    points = "\n".join(" ".join(map(repr, row)) for row in x.tolist())
    corners = "\n".join(f"4 {a} {b} {c} {d}" for a, b, c, d in cells.tolist())
    kinds = "\n".join(["10"] * len(cells))
    return (
        "# vtk DataFile Version 3.0\nbar\nASCII\nDATASET UNSTRUCTURED_GRID\n"
        f"POINTS {len(x)} double\n{points}\nCELLS {len(cells)} {5 * len(cells)}\n{corners}\n"
        f"CELL_TYPES {len(cells)}\n{kinds}\n"
    )


# Springs of irregular tetrahedra pass the patch test in part; a virtual test under even stress
# sets their mean. A test between plates differs from that by less than the 3 % asked for.
@pytest.mark.parametrize("moved", [0.0, 0.15])
def test_tetrahedra_have_the_modulus_of_the_tissue(moved, tmp_path):
    x, cells = bar(10.0 if moved == 0.0 else 5.0, moved)
    network, plan = compiled(tmp_path, as_vtk(x, cells), "bar.vtk")
    assert network.mass.sum() == pytest.approx(16e-3, rel=1e-6)
    measured = []
    for axis in range(3):
        force, _ = drawn_out(network, plan, axis)
        measured.append(force / (np.prod(np.delete(SIDES, axis)) * 1e-6) / YOUNG)
    assert np.mean(measured) == pytest.approx(1.0, abs=0.03)
    assert np.ptp(measured) < 0.1  # beyond, W207 is told


def test_a_filled_surface_has_the_mass_of_what_it_encloses(tmp_path, repository):
    surface = (repository / "library" / "meshes" / "liver.obj").read_text()
    for filling in ("tetrahedra", "sodium chloride; reach is second neighbours"):
        more = f"; filling is {filling}; cell = 20 mm"
        network, _ = compiled(tmp_path, surface, "liver.obj", more=more)
        assert network.mass.sum() == pytest.approx(0.666, rel=0.01)
        assert (network.mass > 0.0).all()


def test_an_imported_wall_is_damped_in_proportion_to_its_stiffness(tmp_path, repository):
    surface = (repository / "library" / "meshes" / "liver.obj").read_text()
    more, thickness = "; stiffness is area rule", "; thickness = 1 mm"
    ruled, _ = compiled(tmp_path, surface, "liver.obj", more=more, thickness=thickness)
    plain, _ = compiled(tmp_path, surface, "liver.obj", thickness=thickness)
    assert ruled.stiffness == pytest.approx(plain.stiffness, rel=1e-12)
    assert ruled.damping == pytest.approx(2e-3 * ruled.stiffness, rel=1e-12)
