"""Laws that every smooth surface keeps, over every skin, whole or torn."""

from functools import cache

import numpy as np
import pytest

from tests.every import every
from tests.geometry.surfaces.conftest import build, skin_of
from tissuec.geometry.surfaces import SURFACES
from tissuec.model.topology import pieces

MESHES = {
    "tube": build("tube", rings=6, sides=7),
    "triangular tube": build("tube", rings=2, sides=3),
    "crossed tube": build("tube", rings=5, sides=8, diagonals="both", interior="crossed"),
    "long tube": build("tube", rings=80, sides=5),
    "wide tube": build("tube", rings=3, sides=80),
    "sheet": build("sheet", rows=5, columns=8),
    "one cell": build("sheet", rows=2, columns=2),
    "braced sheet": build("sheet", rows=6, columns=6, diagonals="one"),
    "sphere": build("sphere", subdivisions=1, interior="spokes"),
    "lattice": build("lattice", kind="sodium chloride", cell=0.01),
    "centred lattice": build("lattice", kind="caesium chloride", cell=0.01),
}
SAMPLES = [
    (kind, name, torn)
    for kind, surface in SURFACES.items()
    for name, mesh in MESHES.items()
    if mesh.grid is not None or not surface.needs_grid
    for torn in (0.0, 0.1, 0.5)
]
every_sample = every(("kind", "name", "torn"), SAMPLES)


@cache
def sample(kind, name, torn, *, subdivisions=2):
    """Return a mesh, which springs are left, its skin and its surface."""
    mesh = MESHES[name]
    alive = np.random.default_rng(len(name)).random(len(mesh.ends)) >= torn
    skin = skin_of(mesh, alive)
    return mesh, alive, skin, SURFACES[kind](subdivisions=subdivisions).refine(skin)


def test_every_surface_has_a_sample_on_every_kind_of_skin():
    assert {kind for kind, _, _ in SAMPLES} == set(SURFACES)
    assert {name for kind, name, _ in SAMPLES if kind == "loop subdivision"} == set(MESHES)


@every_sample
def test_weights_of_every_point_add_up_to_one(kind, name, torn):
    *_, surface = sample(kind, name, torn)
    ones = surface.at(np.ones((MESHES[name].position.shape[0], 3)))
    # Some hundred weights below 1, each rounded.
    np.testing.assert_allclose(ones, 1.0, atol=1e-14)


@every_sample
def test_a_surface_moves_with_every_affine_map_of_its_nodes(kind, name, torn):
    mesh, *_, surface = sample(kind, name, torn)
    random = np.random.default_rng(3)
    shape, shift = random.normal(size=(3, 3)), random.normal(size=3)
    moved = surface.at(mesh.position @ shape + shift)
    np.testing.assert_allclose(moved, surface.at(mesh.position) @ shape + shift, atol=1e-13)


@every_sample
def test_every_triangle_that_is_left_is_divided_and_no_other(kind, name, torn):
    mesh, _, skin, surface = sample(kind, name, torn)
    assert len(surface.triangles) == 16 * skin.is_whole.sum()
    assert np.array_equal(np.unique(surface.triangles), np.arange(surface.points))
    assert np.isfinite(surface.at(mesh.position)).all()
    assert (surface.triangles != np.roll(surface.triangles, 1, axis=1)).all()


@every_sample
def test_no_point_hangs_on_a_node_of_another_piece(kind, name, torn):
    mesh, alive, _, surface = sample(kind, name, torn)
    piece = pieces(len(mesh.position), mesh.ends, alive)
    # Weights add up to 1: a point among nodes of one colour has that colour.
    colour = np.random.default_rng(7).normal(size=(len(piece), 3))[piece]
    seen = surface.at(colour)
    found = np.abs(seen[:, None] - np.unique(colour, axis=0)).max(axis=2)
    assert found.min(axis=1).max(initial=0.0) < 1e-13
    owner = found.argmin(axis=1)[surface.triangles]
    assert (owner == owner[:, :1]).all()


@every_sample
def test_all_frames_at_once_are_the_same_bytes_as_one_by_one(kind, name, torn):
    mesh, *_, surface = sample(kind, name, torn)
    frames = np.random.default_rng(5).normal(size=(5, *mesh.position.shape))
    together = surface.at(frames)
    assert together.shape == (5, surface.points, 3)
    assert all(np.array_equal(together[k], surface.at(frames[k])) for k in range(5))
    assert np.array_equal(together[1:4], surface.at(frames[1:4]))


@every_sample
def test_the_factors_are_the_matrix(kind, name, torn):
    mesh, *_, surface = sample(kind, name, torn, subdivisions=1)
    np.testing.assert_allclose(
        surface.matrix() @ mesh.position, surface.at(mesh.position), atol=1e-15
    )


@every_sample
def test_normals_of_a_surface_point_where_those_of_the_skin_do(kind, name, torn):
    mesh, _, skin, surface = sample(kind, name, torn)
    if torn == 0.5 or name == "triangular tube":
        pytest.skip("shreds of three nodes are too coarse to have a side")
    points = surface.at(mesh.position)
    fine, coarse = (
        np.cross(b - a, c - a)
        for a, b, c in (
            points[surface.triangles].swapaxes(0, 1),
            mesh.position[skin.triangles[skin.is_whole]].swapaxes(0, 1),
        )
    )
    centre = points[surface.triangles].mean(axis=1)
    middle = mesh.position[skin.triangles[skin.is_whole]].mean(axis=1)
    nearest = np.array([np.linalg.norm(middle - c, axis=1).argmin() for c in centre[::7]])
    # Some near an edge of a block meet the triangle round the corner.
    assert np.mean(np.einsum("ij,ij->i", fine[::7], coarse[nearest]) > 0.0) > 0.95


def test_a_surface_without_any_triangle_is_empty():
    for kind in SURFACES:
        mesh = MESHES["tube"]
        surface = SURFACES[kind]().refine(skin_of(mesh, np.zeros(len(mesh.ends), dtype=bool)))
        assert surface.points == 0
        assert surface.at(mesh.position[None]).shape == (1, 0, 3)
