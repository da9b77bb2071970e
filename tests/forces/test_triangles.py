"""Areas of triangles and their derivatives, against differences."""

import numpy as np
import pytest

from tissuec.forces.surfaces.triangles import Areas

CORNERS = np.array([[0, 1, 2], [0, 2, 3]])
X = np.array([[0.0, 0.0, 0.0], [1.0, 0.1, 0.2], [0.3, 0.9, -0.1], [-0.8, 0.6, 0.4]])
TENSION, STIFFNESS = np.array([0.7, -0.4]), np.array([2.0, 3.0])


def pulled(x):
    """Return Σ dE/dA ∂A/∂x of energies T (A - A0) + c (A - A0)²/2, shape (node, 3)."""
    areas, found = Areas.at(CORNERS, x), np.zeros_like(x)
    areas.add(TENSION + STIFFNESS * (areas.area - Areas.at(CORNERS, X).area), found)
    return found


def differences(function, step=1e-6):
    """Return derivatives by all coordinates about X, these first."""
    found = []
    for k in range(X.size):
        way = np.zeros(X.size)
        way[k] = step
        way = way.reshape(X.shape)
        found.append((function(X + way) - function(X - way)) / (2.0 * step))
    return np.array(found)


@pytest.mark.parametrize("size", [1e-3, 1.0])
def test_areas_and_normals_are_those_of_crossed_edges(size):
    areas = Areas.at(CORNERS, size * X)
    first, second = X[CORNERS[:, 1]] - X[CORNERS[:, 0]], X[CORNERS[:, 2]] - X[CORNERS[:, 0]]
    twice = np.cross(first, second)
    np.testing.assert_allclose(areas.area, 0.5 * size**2 * np.linalg.norm(twice, axis=1))
    np.testing.assert_allclose(
        areas.normal, twice / np.linalg.norm(twice, axis=1)[:, None], rtol=1e-13
    )


def test_slopes_of_areas_are_their_differences():
    way = np.random.default_rng(2).normal(size=X.shape)
    slopes = differences(lambda x: Areas.at(CORNERS, x).area)
    np.testing.assert_allclose(Areas.at(CORNERS, X).along(way), way.ravel() @ slopes, rtol=1e-8)
    np.testing.assert_allclose(pulled(X).ravel(), slopes @ TENSION, atol=1e-9)


def test_the_matrix_is_the_difference_of_forces():
    areas = Areas.at(CORNERS, X)
    found = areas.matrix(TENSION, STIFFNESS, np.arange(4), 4).toarray()
    np.testing.assert_allclose(found, differences(lambda x: pulled(x).ravel()), atol=1e-8)
    without = areas.matrix(TENSION, STIFFNESS, np.array([0, -1, 1, 2]), 3).toarray()
    kept = np.r_[0:3, 6:12]
    np.testing.assert_allclose(without, found[kept][:, kept])


def test_without_what_may_be_indefinite_no_eigenvalue_is_negative():
    areas = Areas.at(CORNERS, X)
    found = areas.matrix(TENSION, -STIFFNESS, np.arange(4), 4, exact=False).toarray()
    assert np.linalg.eigvalsh(found).min() > -1e-12
    n = areas.normal[0]
    out = np.einsum("ij,x,y->ixjy", areas.edges[0] @ areas.edges[0].T, n, n)
    expected = np.zeros((4, 3, 4, 3))
    expected[:3, :, :3] = TENSION[0] / (4.0 * areas.area[0]) * out
    np.testing.assert_allclose(found, expected.reshape(12, 12), atol=1e-12)


def test_a_triangle_without_area_has_no_normal_and_no_forces():
    line = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
    areas = Areas.at(np.array([[0, 1, 2]]), line)
    assert not areas.area.any()
    assert not areas.normal.any()
    assert not areas.gradient.any()
    matrix = areas.matrix(np.ones(1), np.zeros(1), np.arange(3), 3)
    assert not matrix.toarray().any()
