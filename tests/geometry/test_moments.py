"""Moments of elements against closed forms and a finer rule of quadrature."""

import numpy as np
import pytest

from tests.forces.test_elements import mesh
from tissuec.geometry.elements import CUBE
from tissuec.geometry.moments import moments


def test_a_parallelepiped_has_the_moments_of_a_box():
    edges = np.array([[3.0, 0.2, 0.1], [0.0, 2.0, -0.4], [0.3, 0.0, 1.0]])  # half of each
    centre = np.array([5.0, -1.0, 2.0])
    volume, first, second = moments("hexahedron", (centre + CUBE @ edges)[None])
    content = 8.0 * np.linalg.det(edges)
    # ∫ ξ² over a box of sides 2 is a third of its volume.
    np.testing.assert_allclose(volume, content, rtol=1e-14)
    np.testing.assert_allclose(first[0], content * centre, rtol=1e-14)
    due = content * (np.outer(centre, centre) + edges.T @ edges / 3.0)
    np.testing.assert_allclose(second[0], due, rtol=1e-13)


def test_a_tetrahedron_has_those_of_its_corners():
    position, nodes = mesh("tetrahedron", cells=1, displaced=0.0)
    rise = np.array([[1.0, 0.3, 0.0], [0.0, 1.2, 0.4], [0.1, 0.0, 0.9]])
    position = position @ rise + 0.03
    volume, first, second = moments("tetrahedron", position[nodes])
    corners = position[nodes[:, :4]]
    total = corners.sum(axis=1)
    due = np.einsum("eax,eay->exy", corners, corners) + np.einsum("ex,ey->exy", total, total)
    np.testing.assert_allclose(volume.sum(), 0.02**3 * np.linalg.det(rise), rtol=1e-13)
    np.testing.assert_allclose(first, volume[:, None] * total / 4.0, rtol=1e-13)
    np.testing.assert_allclose(second, volume[:, None, None] * due / 20.0, rtol=1e-12)


@pytest.mark.parametrize("name", ["hexahedron", "wedge"])
def test_irregular_cells_are_integrated_to_rounding(name):
    position, nodes = mesh(name, cells=3, displaced=0.3)
    found = [each.sum(axis=0) for each in moments(name, position[nodes])]
    # The cells fill a cube of 20 mm; so do tetrahedra whose edges are as straight.
    side = 0.02
    outer = np.full((3, 3), side**5 / 4.0) + np.eye(3) * side**5 / 12.0
    np.testing.assert_allclose(found[0], side**3, rtol=1e-14)
    np.testing.assert_allclose(found[1], np.full(3, side**4 / 2.0), rtol=1e-13)
    np.testing.assert_allclose(found[2], outer, rtol=1e-12)


def test_equal_cells_are_those_of_one():
    position, nodes = mesh("hexahedron", cells=3, displaced=0.0)
    together = moments("hexahedron", position[nodes])
    alone = [moments("hexahedron", position[one][None]) for one in nodes]
    for k, each in enumerate(together):
        np.testing.assert_allclose(each, np.concatenate([one[k] for one in alone]), rtol=1e-13)
