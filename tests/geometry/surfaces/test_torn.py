"""Torn edges stay torn: surfaces have gaps there and do not stretch across."""

import numpy as np
import pytest

from tests.geometry.surfaces.conftest import across, build, skin_of
from tissuec.geometry.surfaces import SURFACES

SPLINES = ("interpolating spline", "approximating spline")
DIAGONALS = ("none", "one", "both")


@pytest.mark.parametrize("kind", SURFACES)
@pytest.mark.parametrize("diagonals", DIAGONALS)
def test_no_triangle_bridges_the_gap_between_two_stumps(kind, diagonals):
    mesh = build("tube", rings=9, sides=10, diagonals=diagonals, interior="crossed")
    left = mesh.position[:, 0] < 0.03
    surface = SURFACES[kind]().refine(skin_of(mesh, ~across(mesh, left, ~left)))
    apart = mesh.position + np.where(left, -0.005, 0.005)[:, None] * [1.0, 0.0, 0.0]
    x = surface.at(apart)[surface.triangles][..., 0]
    low, high = apart[left, 0].max(), apart[~left, 0].min()
    # Loop's edge is a curve of the last ring alone, so that it neither falls short nor reaches
    # beyond; 1e-15 is rounding.
    assert ((x <= low + 1e-15).all(axis=1) | (x >= high - 1e-15).all(axis=1)).all()
    assert x.min(axis=1).max() == pytest.approx(apart[~left, 0].max(), abs=0.008)


@pytest.mark.parametrize("kind", SURFACES)
def test_what_one_stump_does_moves_nothing_of_the_other(kind):
    mesh = build("tube", rings=9, sides=10)
    left = mesh.position[:, 0] < 0.03
    surface = SURFACES[kind]().refine(skin_of(mesh, ~across(mesh, left, ~left)))
    whole = surface.at(mesh.position)
    pulled = surface.at(np.where(left[:, None], 1e3, mesh.position))
    stays = surface.matrix()[:, left].sum(axis=1) < 0.5
    assert np.array_equal(whole[stays], pulled[stays])
    assert not (whole[~stays] == pulled[~stays]).any()


def slit():
    """Return a sheet slit along the middle, the nodes on either hand, and what is alive."""
    mesh = build("sheet", rows=7, columns=12, diagonals="one")
    row, column = np.divmod(np.arange(84), 12)
    upper, lower = (row == 2) & (column < 7), (row == 3) & (column < 7)
    return mesh, upper, lower, ~across(mesh, upper, lower)


@pytest.mark.parametrize("kind", SURFACES)
def test_a_slit_gapes(kind):
    mesh, upper, lower, alive = slit()
    surface = SURFACES[kind]().refine(skin_of(mesh, alive))
    across_slit = np.array([0.0, 0.02, -0.05]) / np.linalg.norm([0.02, 0.05])
    open_ = mesh.position + 0.01 * (upper * 1.0 - lower)[:, None] * across_slit
    height = surface.at(open_)[surface.triangles] @ across_slit
    matrix = surface.matrix()
    on_upper = (matrix[:, upper].sum(axis=1) > 0.9)[surface.triangles].any(axis=1)
    on_lower = (matrix[:, lower].sum(axis=1) > 0.9)[surface.triangles].any(axis=1)
    assert on_upper.any() and on_lower.any()
    assert not (on_upper & on_lower).any()
    assert height[on_upper].min() > 0.002 and height[on_lower].max() < -0.002


@pytest.mark.parametrize("kind", SPLINES)
def test_splines_beside_a_slit_know_nothing_of_its_other_side(kind):
    mesh, _, _, alive = slit()
    matrix = SURFACES[kind]().refine(skin_of(mesh, alive)).matrix()
    row, column = np.divmod(np.arange(84.0), 12)
    place = matrix @ np.stack([row, column], axis=1)
    above = (place[:, 0] < 2.5) & (place[:, 1] < 6.01)
    assert above.sum() == 9 * 25
    assert matrix[above][:, row >= 3].count_nonzero() == 0
    beyond = (place[:, 0] < 2.5) & (place[:, 1] >= 9.0)
    assert matrix[beyond][:, row >= 3].count_nonzero() > 0


@pytest.mark.parametrize("kind", SPLINES)
@pytest.mark.parametrize("diagonals", DIAGONALS)
@pytest.mark.parametrize("seed", range(4))
def test_a_torn_flat_sheet_covers_just_the_triangles_that_are_left(kind, diagonals, seed):
    mesh = build("sheet", rows=6, columns=7, diagonals=diagonals)
    alive = np.random.default_rng(seed).random(len(mesh.ends)) > 0.15
    skin = skin_of(mesh, alive)
    surface = SURFACES[kind]().refine(skin)
    # Splines of a plane grid are its parameters, so that triangles are where they belong.
    parameter = np.stack(np.divmod(np.arange(42.0), 7), axis=1)
    middle = (surface.matrix() @ parameter)[surface.triangles].mean(axis=1)
    cell, within = np.floor(middle).astype(int), middle % 1.0
    half = (within[:, 0] > within[:, 1]).astype(int)
    left = skin.is_whole.reshape(5, 6, 2)
    assert left[cell[:, 0], cell[:, 1], half].all()
    counted = np.zeros((5, 6, 2), dtype=int)
    np.add.at(counted, (cell[:, 0], cell[:, 1], half), 1)
    assert np.array_equal(counted, 16 * left)


@pytest.mark.parametrize("kind", SPLINES)
@pytest.mark.parametrize("seed", range(4))
def test_patches_that_share_an_edge_share_its_points_and_tangents(kind, seed):
    """A point on an edge is one point; across it the surface has one tangent plane."""
    mesh = build("tube", rings=5, sides=6, diagonals="both")
    random = np.random.default_rng(seed)
    alive = random.random(len(mesh.ends)) > 0.1
    skin = skin_of(mesh, alive)
    surface = SURFACES[kind](subdivisions=6).refine(skin)
    points = surface.at(random.normal(size=mesh.position.shape))
    edges = surface.triangles[:, [0, 1, 1, 2, 2, 0]]
    length = np.linalg.norm(np.diff(points[edges.reshape(-1, 2)], axis=1), axis=-1)
    # 64 pieces of each edge between nodes of size 1: a crack would be an edge as long as that.
    assert length.max() < 0.4
