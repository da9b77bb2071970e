"""Fillings for elements: slivers are left out or rounded, and the rest are named."""

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.spatial import Delaunay

import tissuec
from tests.every import every
from tests.matter.shapes import as_obj, as_vtk
from tissuec.cli import group
from tissuec.core.fields import LocatedFile
from tissuec.geometry.edges import Edges, volume
from tissuec.meshes.generators.imported import Imported
from tissuec.meshes.generators.sphere import Sphere
from tissuec.meshes.slivers import POOR, quality, without_slivers


def egg(waves=0.0):
    """Return an ellipsoid of triangles; with waves, its surface is also hollow."""
    ball = Sphere(centre=np.zeros(3), radius=0.02, subdivisions=3).build()
    x = ball.position
    wave = 1.0 + waves * np.sin(150.0 * x[:, [0]]) * np.cos(120.0 * x[:, [1]])
    return x * wave * ([1.0, 1.0, 1.0] if waves else [1.0, 0.6, 1.7]), ball.skin


def filled(tmp_path, surface, cell=0.006):
    path = tmp_path / "egg.obj"
    path.write_text(as_obj(*surface), encoding="utf-8")
    return Imported(LocatedFile("egg.obj", path, 1.0), filling="tetrahedra", cell=cell)


def qualities(mesh):
    return quality(mesh.position[mesh.elements[0].nodes[:, :4]])


def test_quality_is_that_of_the_shape_alone():
    regular = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], dtype=float)
    corner = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
    assert quality(regular[[0, 2, 1, 3]]) == pytest.approx(-quality(regular))
    assert abs(quality(7e-3 * regular + 3.0)) == pytest.approx(1.0, rel=1e-9)
    # Three edges of 1 and three of √2: l² = 3/2, V = 1/6.
    assert quality(corner) == pytest.approx(np.sqrt(2.0) / 1.5**1.5, rel=1e-12)


@every(("waves", "cell"), [(0.0, 0.006), (0.35, 0.006), (0.35, 0.004)])
def test_fillings_for_elements_have_no_slivers_and_the_same_outside(waves, cell, tmp_path):
    mesh = filled(tmp_path, egg(waves), cell)
    built, net = mesh.build_elements(), mesh.build()
    before = np.abs(quality(net.position[net.tetrahedra]))
    after = qualities(built)
    assert after.min() >= POOR
    assert after.min() >= before.min()
    assert after.mean() > before.mean() - 0.01
    if not waves:
        assert (before < POOR).sum() > 50  # or else nothing is shown
    assert not (Edges.among(built.skin.astype(np.int64)).count % 2).any()  # no gap
    # Nodes of the surface stay, and it loses no more than thin tetrahedra.
    outside = len(mesh.shape.position)
    np.testing.assert_array_equal(built.position[:outside], net.position[:outside])
    size = volume(net.position, net.skin.astype(np.int64))
    assert volume(built.position, built.skin) == pytest.approx(size, rel=5e-3)
    assert built.volume.sum() == pytest.approx(volume(built.position, built.skin), rel=1e-9)


def test_an_inner_node_beside_a_face_moves_inwards():
    """A regular octahedron about a node is the best there is; a nearly flat one is not kept."""
    around = 1e-2 * np.concatenate([np.eye(3), -np.eye(3)])
    x = np.concatenate([around, [[3.1e-3, 3.1e-3, 3.1e-3]]])
    cells = Delaunay(np.concatenate([around, [[0.0, 1e-5, 2e-5]]])).simplices.astype(np.int64)
    before = np.abs(quality(x[cells]))
    moved, kept = without_slivers(x, cells, inner=6)
    assert len(kept) == len(cells)
    np.testing.assert_array_equal(moved[:6], around)
    assert before.min() < 0.1 < quality(moved[kept]).min()
    assert np.linalg.norm(moved[6]) < 0.7 * np.linalg.norm(x[6])


def test_sharp_edges_of_thin_tetrahedra_stay():
    """A needle at an edge of a body is thin, too, but its faces turn there."""
    x = np.array([[0, 0, 0], [1, 0, 0], [0.5, 0.02, 0], [0.5, 0, 0.02], [0.5, 0.5, 0.5]])
    cells = np.array([[0, 1, 2, 3], [0, 2, 3, 4], [1, 2, 3, 4]])
    assert np.abs(quality(x[cells[:1]])).max() < 0.1
    _, kept = without_slivers(x, cells, inner=len(x))
    assert len(kept) == 3


SCENE = """language 1
tissue gel { Young's modulus = 10 kPa; density = 1000 kg/m^3; retardation time = 5 ms }
body egg {
  mesh is imported { file "egg.obj" in m; FILLING }
  tissue is gel; made of elements
}
set low = nodes of egg where z < 1 mm
environment { gravity = (0, 0, 0) m/s^2 }
script { at 0 s: fix low }
simulate { duration = 1 ms }
"""


def test_the_quality_of_elements_is_a_property_of_bodies(tmp_path):
    mesh = filled(tmp_path, egg(), cell=0.008)
    path = tmp_path / "egg.tis"
    path.write_text(
        SCENE.replace("FILLING", "filling is tetrahedra; cell = 8 mm"), encoding="utf-8"
    )
    (body,) = tissuec.properties(path, frequencies=0)
    values = qualities(mesh.build_elements())
    assert body.element_quality == pytest.approx((values.min(), values.mean()))
    said = CliRunner().invoke(group, ["explain", str(path), "--bodies"]).output
    assert f"quality           {values.min():.2g} at worst, {values.mean():.2g} on" in said


def test_poor_tetrahedra_of_a_file_are_counted_and_the_worst_is_located(tmp_path):
    x = 1e-2 * np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0.3, 0.3, -0.01]])
    (tmp_path / "egg.vtk").write_text(as_vtk(x, np.array([[0, 1, 2, 3], [0, 2, 1, 4]])))
    path = tmp_path / "egg.tis"
    text = SCENE.replace("egg.obj", "egg.vtk").replace("; FILLING", "")
    path.write_text(text, encoding="utf-8")
    (found,) = (one for one in tissuec.check(path) if one.code == "W602")
    (note,) = found.notes
    worst = quality(x[[0, 2, 1, 4]])
    assert 0.0 < worst < POOR
    assert note.message.startswith(
        f"1 tetrahedron of a quality below 0.05, the worst one of {worst:.2g} around "
        "(3.25 mm, 3.25 mm, -25 um)"
    )
    said = CliRunner().invoke(group, ["import", str(tmp_path / "egg.vtk"), "--unit", "m"])
    assert f"# quality of tetrahedra: {worst:.2g} at worst, " in said.output
    x[4, 2] = -1e-2
    (tmp_path / "egg.vtk").write_text(as_vtk(x, np.array([[0, 1, 2, 3], [0, 2, 1, 4]])))
    assert not [one for one in tissuec.check(path) if one.code == "W602"]
