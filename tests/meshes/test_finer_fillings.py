"""Fillings with tetrahedra that are finer in a part."""

import numpy as np
import pytest

from tests.matter.shapes import as_obj, surface
from tissuec.core.fields import LocatedFile
from tissuec.core.resources import library
from tissuec.geometry.divisions import OPPOSITE, volumes
from tissuec.geometry.edges import Edges
from tissuec.mechanics.settling import settle
from tissuec.mechanics.state import State
from tissuec.meshes.finer import FinePart, GroupedSurface, divided, sites
from tissuec.meshes.generators.imported import Imported
from tissuec.meshes.slivers import worst_and_mean
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

MM = 1e-3
PARTS = {
    "top": (np.array([8.0, 8.0, 18.0]), np.array([12.0, 12.0, 20.0]), 1.0),
    "inside": (np.array([8.0, 8.0, 8.0]), np.array([12.0, 12.0, 12.0]), 1.2),
    "corner": (np.zeros(3), np.ones(3), 0.5),
}


@pytest.fixture
def cube(tmp_path):
    """Return the file of a cube of 20 mm, of squares of 5 mm."""
    path = tmp_path / "cube.obj"
    path.write_text(as_obj(*surface(np.full(3, 20.0), 5.0)))
    return path


def filled(path, low, high, fine, cell=5.0):
    more = {"fine_cell": fine * MM, "fine_box": (low * MM, high * MM)} if fine else {}
    file = LocatedFile(path.name, path, MM)
    return Imported(file, filling="tetrahedra", cell=cell * MM, **more)


def part_of(low, high, fine, cell=5.0):
    return FinePart(low * MM, high * MM, fine * MM, cell * MM)


@pytest.mark.parametrize("name", PARTS)
def test_fine_tetrahedra_fill_the_body_and_are_good(name, cube):
    low, high, fine = PARTS[name]
    generator = filled(cube, low, high, fine)
    mesh = generator.build_elements()
    corners = mesh.elements[0].nodes[:, :4]
    assert np.abs(volumes(mesh.position, corners)).sum() == pytest.approx(8e-6, rel=1e-12)
    assert worst_and_mean(mesh.position, corners)[0] > 0.09 and not mesh.remarks
    assert len(mesh.position) <= generator.element_size()[0]
    # Each inner face belongs to two tetrahedra, and the others are the surface of the cube.
    assert outer_area(mesh.position, corners) == pytest.approx(6 * 400e-6, rel=1e-12)
    # Edges in the part are as short as was asked for, and those far away are as they were.
    pairs = corners[:, [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]].reshape(-1, 2)
    ends = mesh.position[np.unique(np.sort(pairs, axis=1), axis=0)] / MM
    length, middle = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1), ends.mean(axis=1)
    is_fine = ((middle > low) & (middle < high)).all(axis=1)
    assert is_fine.any() and length[is_fine].max() < 2.0 * fine
    away = np.linalg.norm(np.maximum(np.maximum(low - middle, middle - high), 0.0), axis=1)
    assert length[away > 11.0].mean() > 3.5


def test_a_divided_surface_keeps_its_shape_and_its_groups():
    x, triangles = surface(np.full(3, 20.0), 5.0)
    part = part_of(*PARTS["top"])
    groups = {"top": np.flatnonzero(x[:, 2] > 19.9)}
    found = divided(GroupedSurface(x * MM, triangles.astype(np.int64), groups), part)
    edges = Edges.among(found.triangles)
    assert edges.is_closed and len(found.triangles) > 1.5 * len(triangles)
    a, b, c = found.position[found.triangles].swapaxes(0, 1)
    assert np.einsum("ti,ti->", a, np.cross(b, c)) / 6.0 == pytest.approx(8e-6, rel=1e-12)
    ends = found.position[edges.ends]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    size = part.size_at(ends.mean(axis=1))
    assert (length <= 1.5 * size)[size < 5e-3].all()
    assert np.array_equal(np.sort(found.groups["top"]),
                          np.flatnonzero(found.position[:, 2] > 19.9e-3))  # fmt: skip


def test_sites_are_those_of_cubes_of_the_right_size():
    part = part_of(*PARTS["inside"])
    places, size = sites(np.zeros(3), np.full(3, 4), part)
    assert len(np.unique(np.round(places / 1e-9), axis=0)) == len(places)
    assert set(np.round(size / MM, 9)) <= {5.0, 2.5, 1.25, 0.625}
    assert (size <= 1.5 * part.size_at(places) + 1e-12).all()
    even, _ = sites(
        np.zeros(3), np.full(3, 4), part_of(np.full(3, 99.0), np.full(3, 99.0), 1.0)
    )
    assert len(even) == 5**3 + 4**3


def outer_area(position, corners):
    """Return the area of faces that belong to one tetrahedron only [m²], at most two have."""
    faces = np.sort(corners[:, OPPOSITE].reshape(-1, 3), axis=1)
    faces, count = np.unique(faces, axis=0, return_counts=True)
    a, b, c = position[faces[count == 1]].swapaxes(0, 1)
    assert count.max() == 2
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0


@pytest.mark.parametrize("cell", [4.0, 7.0, 10.0])
@pytest.mark.parametrize("side", [3.0, 5.0])
def test_tetrahedra_of_regular_points_leave_no_slits(side, cell, tmp_path):
    """More than four points lie on a sphere there, so that diagonals could differ."""
    path = tmp_path / "cube.obj"
    path.write_text(as_obj(*surface(np.full(3, 20.0), side)))
    mesh = filled(path, None, None, 0.0, cell).build_elements()
    corners = mesh.elements[0].nodes[:, :4]
    assert outer_area(mesh.position, corners) == pytest.approx(6 * 400e-6, rel=1e-9)
    assert np.abs(volumes(mesh.position, corners)).sum() == pytest.approx(8e-6, rel=1e-9)


@pytest.mark.parametrize("cell", [20.0, 30.0])
def test_tetrahedra_of_the_liver_leave_no_slits(cell):
    path = library() / "meshes" / "liver.obj"
    generator = filled(path, None, None, 0.0, cell)
    mesh = generator.build_elements()
    faces = np.sort(mesh.elements[0].nodes[:, :4][:, OPPOSITE].reshape(-1, 3), axis=1)
    _, count = np.unique(faces, axis=0, return_counts=True)
    assert count.max() == 2 and (count == 1).sum() == len(generator.shape.skin)
    assert Edges.among(mesh.skin).is_closed


@pytest.mark.parametrize("fine", [2, 3, 4])
def test_a_uniform_strain_is_in_equilibrium(fine, cube):
    """The patch test, with all nodes of the surface displaced."""
    scene = cube.with_name("cube.tis")
    scene.write_text(
        """language 1
    tissue gel { Young's modulus = 10 kPa; Poisson's ratio = 0.45; density = 1000 kg/m^3 }
    body cube {
      mesh is imported { file "cube.obj" in mm; filling is tetrahedra; cell = 10 mm
        fine cell = FINE mm; fine box from (0, 0, 0) mm to (2, 2, 2) mm }
      tissue is gel
    }
    environment { gravity = (0, 0, 0) m/s^2 }
    simulate { duration = 1 ms }
    """.replace("FINE", str(fine))
    )
    network = compile_request(Request.file(scene))[0].network
    assert network.mass.sum() == pytest.approx(8e-3, rel=1e-12)
    state, drawn = State.start(network, gravity=np.zeros(3), drag=0.0), network.position
    turn = np.array([[1.1, 0.0, 0.05], [0.0, 0.9, 0.0], [0.0, 0.0, 1.05]])
    outside = ((drawn < 1e-9) | (drawn > 20e-3 - 1e-9)).any(axis=1)
    state.holders["surface"] = np.flatnonzero(outside)
    state.position[outside] = drawn[outside] @ turn.T
    settle(state, np.ones(len(drawn), dtype=bool))
    assert (~outside).sum() > 50
    np.testing.assert_allclose(state.position, drawn @ turn.T, atol=1e-10 * 20e-3)


def test_only_fillings_with_tetrahedra_can_be_finer(cube):
    low, high, fine = PARTS["top"]
    file = LocatedFile(cube.name, cube, MM)
    box = (low * MM, high * MM)
    with pytest.raises(ValueError, match="for a filling with tetrahedra"):
        Imported(file, filling="diamond", cell=5 * MM, fine_cell=fine * MM, fine_box=box)
    with pytest.raises(ValueError, match="are needed together"):
        Imported(file, filling="tetrahedra", cell=5 * MM, fine_cell=fine * MM)
    with pytest.raises(ValueError, match="for bodies made of elements"):
        filled(cube, low, high, fine).build()
