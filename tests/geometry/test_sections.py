"""Sections of solids by planes, against closed forms and the hull of the edges that are met."""

from itertools import combinations, product

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from tissuec.geometry.blade_sections import plane_section
from tissuec.geometry.divisions import filling_tetrahedra
from tissuec.meshes.generators.lattice import CRYSTALS, Lattice
from tissuec.meshes.generators.sphere import divide, icosahedron

SIDES = np.array([30.0, 20.0, 15.0])


def area_of_box(normal, offset):
    """Return the area of a plane within the box: the hull of its places on the edges."""
    corners = SIDES * np.array(list(product((0, 1), repeat=3)))
    found = []
    for a, b in combinations(corners, 2):
        if np.count_nonzero(a != b) == 1:
            h, k = normal @ a - offset, normal @ b - offset
            if h * k < 0.0:
                found.append(a + h / (h - k) * (b - a))
    right = np.cross(normal, [0.3, 0.5, 0.8])
    right /= np.linalg.norm(right)
    flat = np.array(found) @ np.stack([right, np.cross(normal, right)], axis=1)
    return ConvexHull(flat).volume


@pytest.mark.parametrize("kind", CRYSTALS)
@pytest.mark.parametrize("facing", [(0, 0, 1), (1, 2, 3), (-1, 0.1, 0.3)])
def test_a_plane_through_a_lattice_has_the_area_of_the_box(kind, facing):
    mesh = Lattice(kind, 5.0, (np.zeros(3), SIDES), "second neighbours").build()
    cells = filling_tetrahedra(mesh.position, mesh.skin.astype(np.int64))
    normal = np.array(facing) / np.linalg.norm(facing)
    offset = float(normal @ (SIDES / 2.0)) + 1.3
    cut = plane_section(mesh.position, cells, normal, offset)
    assert cut.areas(mesh.position).sum() == pytest.approx(area_of_box(normal, offset), 1e-12)
    corners = cut.mixed(mesh.position)
    assert corners @ normal == pytest.approx(np.full(corners.shape[:2], offset))
    p, q, r, s = corners.swapaxes(0, 1)
    assert (np.cross(r - p, s - q) @ normal > -1e-12).all()


def test_a_plane_along_a_layer_of_nodes_cuts_each_face_once():
    mesh = Lattice("sodium chloride", 5.0, (np.zeros(3), SIDES), "second neighbours").build()
    cells = filling_tetrahedra(mesh.position, mesh.skin.astype(np.int64))
    for sign in (1.0, -1.0):
        cut = plane_section(mesh.position, cells, np.array([0, 0, sign]), sign * 10.0)
        assert cut.areas(mesh.position).sum() == pytest.approx(600.0)


def test_the_section_of_a_ball_converges_to_a_circle():
    unit, triangles = icosahedron()
    normal, height, errors = np.array([0.36, 0.48, 0.8]), 0.31, []
    for _ in range(3):
        unit, triangles = divide(unit, triangles)
        place = np.concatenate([unit, 0.5 * unit, np.zeros((1, 3))])
        cells = filling_tetrahedra(place, triangles)
        area = plane_section(place, cells, normal, height).areas(place).sum()
        errors.append(1.0 - area / (np.pi * (1.0 - height**2)))
    assert 0.0 < errors[-1] < 0.01
    assert errors[-2] / errors[-1] == pytest.approx(4.0, abs=1.0)  # second order in the edge
