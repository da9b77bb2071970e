"""Loop's subdivision against its laws and against endless division."""

import numpy as np
import pytest

from tests.geometry.surfaces.conftest import area, build, order, skin_of, volume
from tissuec.geometry.surfaces import SURFACES
from tissuec.geometry.surfaces.loop_subdivision import TriangleNet
from tissuec.geometry.surfaces.skin import Skin

TETRAHEDRON = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
CORNERS = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], dtype=float)


def loop(subdivisions, mesh):
    return SURFACES["loop subdivision"](subdivisions=subdivisions).refine(skin_of(mesh))


def skin(triangles):
    """Return a skin of these triangles alone."""
    triangles = np.asarray(triangles)
    none = np.zeros((0, 0), dtype=bool)
    whole = np.ones(len(triangles), dtype=bool)
    return Skin(int(triangles.max()) + 1, triangles, whole, None, none, none)


def test_within_a_regular_net_linear_functions_stay_as_they_are():
    mesh = build("sheet", rows=9, columns=10)  # every inner node has six neighbours
    surface = loop(2, mesh)
    points = surface.at(mesh.position)
    # Points that hang on no node of the rim: their weights are those of an endless net.
    rim = np.ones((9, 10), dtype=bool)
    rim[1:-1, 1:-1] = False
    matrix = surface.matrix()
    inner = matrix[:, rim.ravel()].sum(axis=1) == 0
    assert inner.sum() > 300
    u, v = np.meshgrid(np.arange(10), np.arange(9))
    parameter = matrix @ np.stack([u.ravel(), v.ravel()], axis=1)
    place = parameter[inner] * 4
    np.testing.assert_allclose(place, np.round(place), atol=1e-12)
    assert len(np.unique(np.round(place), axis=0)) == inner.sum()
    exact = parameter @ np.stack([mesh.position[1], mesh.position[10]])
    np.testing.assert_allclose(points, exact, atol=1e-15)


@pytest.mark.parametrize(
    ("net", "position"),
    [
        (TETRAHEDRON, CORNERS),  # three neighbours
        (build("sphere", subdivisions=0).skin, build("sphere", subdivisions=0).position),  # 5
        (np.array([[0, k + 1, (k + 1) % 9 + 1] for k in range(9)]), None),  # nine, and a rim
        (np.array([[0, 1, 2]]), None),
    ],
)
def test_the_limit_is_where_endless_division_leads(net, position):
    one = TriangleNet.of(np.asarray(net, dtype=np.int64), int(np.max(net)) + 1)
    if position is None:
        position = np.random.default_rng(1).normal(size=(one.size, 3))
    at_once = one.to_limit() @ position
    points = position
    for _ in range(6):
        points = one.divide() @ points
        one = one.divided()
    # What is left shrinks to a quarter in each step, or 1/8 to 5/8 + … beside few neighbours.
    distance = np.abs(points[: len(position)] - at_once).max()
    assert distance < 2e-2 * np.abs(position[0] - at_once[0]).max() + 2e-3
    further = one.to_limit() @ points
    np.testing.assert_allclose(further[: len(position)], at_once, atol=1e-13)


def test_a_finer_surface_has_the_points_of_a_coarser_one():
    mesh = build("sphere", subdivisions=1)
    coarse, fine = (loop(n, mesh).at(mesh.position) for n in (1, 3))
    np.testing.assert_allclose(fine[: len(coarse)], coarse, atol=1e-15)


def test_balls_come_to_the_sphere_with_second_order():
    sizes, areas, volumes = 0.5 ** np.arange(1, 5), [], []
    for n in range(1, 5):
        mesh = build("sphere", subdivisions=n, centre=np.zeros(3), radius=1.0)
        surface = loop(2, mesh)
        points = surface.at(mesh.position)
        areas.append(abs(area(points, surface.triangles) / (4 * np.pi) - 1.0))
        volumes.append(abs(volume(points, surface.triangles) / (4 * np.pi / 3) - 1.0))
    assert order(areas, sizes) == pytest.approx(2.0, abs=0.1)
    assert order(volumes, sizes) == pytest.approx(2.0, abs=0.1)


def test_a_closed_skin_stays_closed():
    for mesh in (
        build("sphere", subdivisions=1),
        build("lattice", kind="diamond", cell=0.01),
    ):
        triangles = loop(2, mesh).triangles
        edges = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        there = set(map(tuple, edges.tolist()))
        assert len(there) == len(edges)
        assert all((b, a) in there for a, b in there)


def test_a_free_edge_is_the_cubic_spline_of_its_own_nodes():
    mesh = build("tube", rings=4, sides=6)
    position = np.random.default_rng(3).normal(size=mesh.position.shape)
    points = loop(2, mesh).at(position)
    ring = position[:6]
    before, after = np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0)
    for expected in (
        (before + 4 * ring + after) / 6,  # at a node, and half way to the next one
        (before + 23 * ring + 23 * after + np.roll(ring, -2, axis=0)) / 48,
    ):
        far = np.linalg.norm(points[:, None] - expected, axis=2).min(axis=0)
        assert far.max() < 1e-14


def test_a_node_where_two_tears_meet_stays():
    bow = skin([[0, 1, 2], [0, 3, 4]])
    position = np.random.default_rng(4).normal(size=(5, 3))
    points = SURFACES["loop subdivision"]().refine(bow).at(position)
    assert (points == position[0]).all(axis=1).any()


def test_skins_that_are_no_surface_give_finite_points():
    fins = skin([[0, 1, 2], [0, 1, 3], [0, 1, 4], [0, 1, 4]])  # four along one edge
    position = np.random.default_rng(5).normal(size=(5, 3))
    points = SURFACES["loop subdivision"]().refine(fins).at(position)
    assert np.isfinite(points).all()
    assert np.abs(points).max() <= np.abs(position).max()
