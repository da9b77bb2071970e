"""Splines over grids against SciPy's, closed forms, and their orders."""

import numpy as np
import pytest
from scipy.interpolate import BSpline, make_interp_spline

from tests.geometry.surfaces.conftest import area, build, order, skin_of
from tissuec.geometry.surfaces import SURFACES
from tissuec.geometry.surfaces.splines import through_nodes

SPLINES = ("interpolating spline", "approximating spline")


def fine_grid(kind, mesh, position, subdivisions):
    """Return the points of a whole surface in rows and columns."""
    surface = SURFACES[kind](subdivisions=subdivisions).refine(skin_of(mesh))
    rows = (mesh.grid.rows - 1) * 2**subdivisions + 1
    return surface.at(position).reshape(rows, -1, 3)


def by_scipy(kind, mesh, position, subdivisions):
    """Return the same from one-dimensional splines of SciPy, one direction after the other."""
    pieces, grid = 2**subdivisions, mesh.grid
    data = position.reshape(grid.rows, grid.columns, 3)
    if grid.closed:
        u = np.arange(grid.columns * pieces) / pieces
        data = np.concatenate([data, data[:, :1]], axis=1)
    else:
        u = np.arange((grid.columns - 1) * pieces + 1) / pieces
    v = np.arange((grid.rows - 1) * pieces + 1) / pieces
    along = curve(kind, np.moveaxis(data, 1, 0), u, closed=grid.closed)
    return curve(kind, np.moveaxis(along, 1, 0), v, closed=False)


def curve(kind, nodes, at, *, closed):
    """Return points of a spline of nodes along the first axis."""
    if kind == "interpolating spline":
        ends = "periodic" if closed else "not-a-knot"
        return make_interp_spline(np.arange(len(nodes)), nodes, bc_type=ends)(at)
    if closed:
        around = np.concatenate([nodes[-2:-1], nodes, nodes[1:2]])
    else:
        before, after = 2 * nodes[:1] - nodes[1:2], 2 * nodes[-1:] - nodes[-2:-1]
        around = np.concatenate([before, nodes, after])
    knots = np.arange(len(around) + 4) - 3.0
    return BSpline(knots, around, 3)(at)


@pytest.mark.parametrize("kind", SPLINES)
@pytest.mark.parametrize("closed", [True, False])
@pytest.mark.parametrize(("rows", "columns"), [(4, 5), (9, 11), (5, 90)])
def test_a_whole_surface_is_the_tensor_product_of_scipys_splines(kind, closed, rows, columns):
    entries = (
        {"rings": rows, "sides": columns} if closed else {"rows": rows, "columns": columns}
    )
    mesh = build("tube" if closed else "sheet", **entries)
    position = np.random.default_rng(1).normal(size=mesh.position.shape)
    ours = fine_grid(kind, mesh, position, 2)
    # Both solve systems of condition below 10 with data of size 1.
    np.testing.assert_allclose(ours, by_scipy(kind, mesh, position, 2), atol=1e-13)


def test_an_interpolating_spline_passes_through_the_nodes_to_the_last_bit():
    mesh = build("tube", rings=7, sides=9)
    position = np.random.default_rng(2).normal(size=mesh.position.shape)
    fine = fine_grid("interpolating spline", mesh, position, 2)
    assert np.array_equal(fine[::4, ::4].reshape(-1, 3), position)


@pytest.mark.parametrize("torn", [0.1, 0.4])
def test_a_torn_interpolating_spline_still_passes_through_its_nodes(torn):
    mesh = build("tube", rings=7, sides=9)
    alive = np.random.default_rng(4).random(len(mesh.ends)) >= torn
    position = np.random.default_rng(2).normal(size=mesh.position.shape)
    skin = skin_of(mesh, alive)
    points = SURFACES["interpolating spline"]().refine(skin).at(position)
    met = (points[:, None] == position).all(axis=-1).any(axis=0)
    assert met[np.unique(skin.triangles[skin.is_whole])].all()


@pytest.mark.parametrize("kind", SPLINES)
@pytest.mark.parametrize("axis", [0, 1])
def test_curvature_is_continuous_across_every_node_and_the_seam(kind, axis):
    mesh = build("tube", rings=9, sides=7)
    position = np.random.default_rng(6).normal(size=mesh.position.shape)
    fine = np.moveaxis(fine_grid(kind, mesh, position, 2), axis, 0)
    if axis == 1:
        fine = np.concatenate([fine, fine[:5]])  # past the seam
    # Five points of a piece determine its cubic.
    cubic = np.linalg.inv(np.vander(np.arange(4) / 4.0, increasing=True))
    ends = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 2, 0]])
    for node in range(4, len(fine) - 4, 4):
        after = ends @ np.tensordot(cubic, fine[node : node + 4], 1).reshape(4, -1)
        before = ends @ np.tensordot(cubic, fine[node - 3 : node + 1][::-1], 1).reshape(4, -1)
        # The way back has the other sign in odd derivatives; second differences of quarters
        # multiply rounding by some hundred.
        np.testing.assert_allclose(after, before * [[1], [-1], [1]], atol=1e-11)


def tube_of(kind, sides, subdivisions=2):
    mesh = build("tube", rings=4, sides=sides, radius=1.0)
    return mesh, fine_grid(kind, mesh, mesh.position, subdivisions)


@pytest.mark.parametrize(("kind", "expected"), [(SPLINES[0], 4), (SPLINES[1], 2)])
def test_points_come_to_a_cylinder_with_the_order_of_the_spline(kind, expected):
    sides = np.array([8, 16, 32, 64])
    errors = [
        np.abs(np.hypot(*tube_of(kind, n)[1][..., 1:].reshape(-1, 2).T) - 1.0).max()
        for n in sides
    ]
    assert order(errors, 1.0 / sides) == pytest.approx(expected, abs=0.15)


@pytest.mark.parametrize("kind", SPLINES)
def test_curvature_of_a_ring_comes_to_that_of_the_circle(kind):
    sides, errors = np.array([8, 16, 32, 64]), []
    for count in sides:
        ring = tube_of(kind, count, subdivisions=5)[1][0, :, 1:]
        step = 1.0 / 32.0
        around = [np.roll(ring, -1, axis=0), np.roll(ring, 1, axis=0)]
        first = (around[0] - around[1]) / (2.0 * step)
        second = (around[0] - 2.0 * ring + around[1]) / step**2
        bend = np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
        errors.append(np.abs(bend / np.linalg.norm(first, axis=1) ** 3 - 1.0).max())
    # The second derivative of a cubic spline is of second order.
    assert order(errors, 1.0 / sides) == pytest.approx(2.0, abs=0.15)


def torus(rings, sides, *, large=3.0, small=1.0):
    """Return a tube bent along a quarter of a torus."""
    mesh = build("tube", rings=rings, sides=sides)
    turn = np.repeat(np.linspace(0.0, np.pi / 2, rings), sides)
    around = np.tile(np.arange(sides) * 2 * np.pi / sides, rings)
    reach = large + small * np.cos(around)
    ring = [reach * np.cos(turn), reach * np.sin(turn), small * np.sin(around)]
    return mesh, np.stack(ring, axis=1)


def test_a_bent_tube_comes_to_the_torus_with_fourth_order_up_to_its_ends():
    sizes, errors = np.array([8, 16, 32]), []
    for sides in sizes:
        mesh, position = torus(sides + 1, sides)
        x, y, z = np.moveaxis(fine_grid("interpolating spline", mesh, position, 2), -1, 0)
        errors.append(np.abs(np.hypot(np.hypot(x, y) - 3.0, z) - 1.0).max())
    assert order(errors, 1.0 / sizes) == pytest.approx(4.0, abs=0.3)


def test_the_area_of_a_bent_tube_comes_to_that_of_the_torus():
    exact, errors = 0.25 * 4.0 * np.pi**2 * 3.0, []
    for subdivisions in (1, 2, 3):
        mesh, position = torus(33, 32)
        surface = SURFACES["interpolating spline"](subdivisions=subdivisions)
        refined = surface.refine(skin_of(mesh))
        errors.append(abs(area(refined.at(position), refined.triangles) / exact - 1.0))
    # Flat triangles are of second order, the spline under them finer by far.
    assert order(errors, 0.5 ** np.arange(3)) == pytest.approx(2.0, abs=0.1)
    mesh, position = torus(33, 32)
    coarse = abs(area(position, mesh.skin) / exact - 1.0)
    assert errors[-1] < coarse / 50.0


def test_cubic_data_are_met_exactly_on_a_sheet():
    mesh = build("sheet", rows=6, columns=7)
    u, v = np.meshgrid(np.arange(7) / 6, np.arange(6) / 5)
    fine_u, fine_v = np.meshgrid(np.arange(25) / 24, np.arange(21) / 20)

    def height(u, v):
        return u**3 - 2 * u * v**2 + 3 * v**3 * u**2

    position = np.stack([u, v, height(u, v)], axis=-1).reshape(-1, 3)
    fine = fine_grid("interpolating spline", mesh, position, 2)
    exact = np.stack([fine_u, fine_v, height(fine_u, fine_v)], axis=-1)
    np.testing.assert_allclose(fine, exact, atol=1e-13)


def test_an_approximating_spline_stays_in_the_hull_of_its_nodes():
    mesh = build("tube", rings=6, sides=8)
    position = np.random.default_rng(8).normal(size=mesh.position.shape)
    surface = SURFACES["approximating spline"](subdivisions=3).refine(skin_of(mesh))
    matrix = surface.matrix()
    assert matrix.data.min() >= -1e-15
    points = surface.at(position)
    assert (points <= position.max(axis=0)).all() and (points >= position.min(axis=0)).all()


@pytest.mark.parametrize("closed", [True, False])
@pytest.mark.parametrize("count", [3, 71, 72, 73, 74, 150])
def test_long_rows_have_the_slopes_of_the_whole_spline(count, closed):
    data = np.random.default_rng(count).normal(size=count)
    row, column, weight = through_nodes(count, closed).slope
    slopes = np.bincount(row, weight * data[column], minlength=count)
    x, ends = np.arange(count + closed), "periodic" if closed else "not-a-knot"
    if count == 3 and not closed:
        exact = np.polyval(np.polyder(np.polyfit(x, data, 2)), x)
    else:
        spline = make_interp_spline(x, np.append(data, data[:1])[: len(x)], bc_type=ends)
        exact = spline(x[:count], 1)
    # Weights beyond 36 nodes, left out, are below 1e-20.
    np.testing.assert_allclose(slopes, exact, atol=1e-13)
