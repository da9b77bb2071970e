"""Inside and outside of closed surfaces, on points that nobody would choose by hand."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from tests.imports.organs import blob
from tissuec.geometry.edges import Edges, volume
from tissuec.geometry.inside import _winding, inside, winding_numbers

CUBE = np.array([(x, y, z) for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])


def hull_of(points):
    """Return the outward triangles of a convex hull, from SciPy."""
    hull = ConvexHull(points)
    triangles = hull.simplices.astype(np.int64)
    a, b, c = points[triangles].swapaxes(0, 1)
    inwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0
    triangles[inwards] = triangles[inwards][:, ::-1]
    return triangles, hull


def test_points_of_a_lattice_whose_rays_meet_edges_and_corners_of_a_cube():
    triangles, _ = hull_of(CUBE)
    line = np.array([-0.5, 0.25, 0.5, 0.75, 1.5])  # the ray at a half meets each diagonal
    points = np.stack(np.meshgrid(line, line, line), axis=-1).reshape(-1, 3)
    expected = ((points > 0) & (points < 1)).all(axis=1)
    assert np.array_equal(inside(points, CUBE, triangles), expected)


def test_rays_through_corners_agree_with_the_hull_of_the_same_corners():
    random = np.random.default_rng(2)
    # Whole numbers, so that most rays pass exactly over corners and edges.
    corners = np.unique(random.integers(-6, 7, (60, 3)), axis=0).astype(float)
    triangles, hull = hull_of(corners)
    line = np.arange(-7.0, 8.0)
    points = np.stack(np.meshgrid(line, line, line), axis=-1).reshape(-1, 3)
    beyond = (points @ hull.equations[:, :3].T + hull.equations[:, 3]).max(axis=1)
    clear = np.abs(beyond) > 1e-9  # on the surface itself either answer is right
    assert clear.sum() > 2000
    assert np.array_equal(inside(points, corners, triangles)[clear], (beyond < 0)[clear])


def test_rays_alone_are_right_where_whole_numbers_leave_no_rounding():
    random = np.random.default_rng(8)
    corners = np.unique(random.integers(-4, 5, (40, 3)), axis=0).astype(float)
    triangles, hull = hull_of(corners)
    line = np.arange(-5.0, 6.0)
    points = np.stack(np.meshgrid(line, line, line), axis=-1).reshape(-1, 3)
    beyond = (points @ hull.equations[:, :3].T + hull.equations[:, 3]).max(axis=1)
    clear = np.abs(beyond) > 1e-9
    for axis in range(3):
        winding = _winding(points, corners, triangles, axis)
        assert np.array_equal(winding[clear], (beyond < 0)[clear].astype(int))


def test_a_blob_agrees_with_its_solid_angle():
    position, triangles = blob(3)
    random = np.random.default_rng(7)
    low, high = position.min(axis=0), position.max(axis=0)
    points = random.uniform(low, high, (1000, 3))
    winding = winding_numbers(points, position, triangles)
    # A closed surface winds a whole number of times; rounding of 1280 arc tangents is far less.
    assert np.abs(winding - np.rint(winding)).max() < 1e-9
    found = inside(points, position, triangles)
    assert np.array_equal(found, np.rint(winding) == 1)
    # Binomial: the part of 1000 points scatters by less than 1.6 %; 2.8 times that may be.
    part = volume(position, triangles) / np.prod(high - low)
    assert found.mean() == pytest.approx(part, abs=0.045)


def test_a_cavity_is_outside():
    position, triangles = blob(2)
    middle = position.mean(axis=0)
    both = np.concatenate([position, middle + 0.5 * (position - middle)])
    shells = np.concatenate([triangles, triangles[:, ::-1] + len(position)])
    points = middle + np.outer([0.0, 0.45, 0.55, 0.95, 1.05], position[0] - middle)
    assert inside(points, both, shells).tolist() == [False, False, True, True, False]


def test_edges_of_a_closed_surface_follow_euler():
    _, triangles = blob(3)
    edges = Edges.among(triangles)
    assert edges.is_closed
    assert len(edges.ends) == 3 * len(triangles) // 2 == 1920
    turned, patch, twisted = edges.facing_alike()
    assert not turned.any() and not patch.any() and not twisted


def test_a_moebius_strip_has_one_side():
    count = 20
    low, high = 2 * np.arange(count), 2 * np.arange(count) + 1
    after_low = np.where(np.arange(count) < count - 1, np.roll(low, -1), 1)
    after_high = np.where(np.arange(count) < count - 1, np.roll(high, -1), 0)
    strip = np.concatenate(
        [np.stack([low, high, after_high], 1), np.stack([low, after_high, after_low], 1)]
    )
    assert Edges.among(strip).facing_alike()[2] == 1
