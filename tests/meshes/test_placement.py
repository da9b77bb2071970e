"""Moved meshes: surfaces face outwards, volumes are positive, and numbers follow."""

import numpy as np
import pytest

from tests.every import every
from tests.meshes.test_mesh_laws import SAMPLES, label
from tissuec.core.structs import replace
from tissuec.geometry.affine import Affine
from tissuec.geometry.edges import volume
from tissuec.geometry.elements import SHAPES, Measures
from tissuec.meshes.elements import wall_of_triangles
from tissuec.meshes.generators import MESHES, Elemental, Mesh, is_wall
from tissuec.meshes.generators.round_solids import Ellipsoid
from tissuec.meshes.generators.sheet import Sheet
from tissuec.meshes.generators.sphere import Sphere
from tissuec.meshes.generators.tube import Tube
from tissuec.meshes.placement import placed, reversed_faces
from tissuec.meshes.stiffness_sharing import area_shares

NORMAL = np.array([2.0, 3.0, 6.0]) / 7.0
MIRROR = Affine.mirroring(np.array([0.01, 0.0, 0.0]), NORMAL)
DISTORTION = Affine.scaling(np.array([1.0, 2.0, 0.5]), np.zeros(3))
PLACEMENTS = {
    "mirrored": MIRROR,
    "distorted": DISTORTION,
    "both": DISTORTION.then(MIRROR),
    "turned": Affine.turning(0.4, NORMAL, np.ones(3)),
}
#: One of each kind of generator, and files with tetrahedra.
ONES = [
    *{
        kind: (kind, entries) for kind, entries in SAMPLES if entries.get("cell") != 0.018
    }.values(),
    next(one for one in SAMPLES if one[1].get("filling") == "tetrahedra"),
]


def with_elements(kind, entries) -> Mesh | None:
    generator = MESHES[kind](**entries)
    if kind in ("explicit", "thread") or (kind == "sphere" and entries["interior"] != "none"):
        return None
    if is_wall(generator):
        return wall_of_triangles(generator.build())
    return generator.build_elements() if isinstance(generator, Elemental) else None


@pytest.mark.parametrize("placement", PLACEMENTS.values(), ids=PLACEMENTS)
@every(("kind", "entries"), ONES, ids=label)
def test_elements_remain_upright_and_volumes_follow(kind, entries, placement):
    mesh = with_elements(kind, entries)
    if mesh is None:
        pytest.skip("it has no elements")
    found = placed(mesh, placement)
    for one in found.elements:
        if one.shape in SHAPES:
            sizes = Measures.of(SHAPES[one.shape], found.position[one.nodes]).volume
            assert (sizes.sum(axis=1) > 0.0).all()
            assert sizes.sum() == pytest.approx(found.volume.sum(), rel=1e-9)
        else:
            assert {*map(frozenset, one.nodes.tolist())} == {
                *map(frozenset, found.skin.tolist())
            }
            assert np.array_equal(one.nodes, found.skin)
    before = volume(mesh.position, mesh.skin.astype(np.int64))
    after = volume(found.position, found.skin.astype(np.int64))
    if mesh.volume is not None:
        assert after == pytest.approx(placement.volume * before, rel=1e-9)
        sums = placement.volume * mesh.volume.sum()
        assert found.volume.sum() == pytest.approx(sums, rel=1e-9)


def test_two_reflections_lead_back():
    mesh = Ellipsoid(
        centre=np.zeros(3), radii=np.array([0.02, 0.01, 0.01]), cell=0.005
    ).build_elements()
    back = placed(placed(mesh, MIRROR), MIRROR)
    assert back.position == pytest.approx(mesh.position, abs=1e-15)
    assert np.array_equal(back.skin, mesh.skin)
    assert np.array_equal(back.elements[0].nodes, mesh.elements[0].nodes)


def test_middles_of_the_edges_of_mirrored_tetrahedra_stay_between_their_corners():
    from tissuec.geometry.elements import MIDDLES

    kind, entries = ONES[-1]
    assert kind == "imported"
    found = placed(MESHES[kind](**entries).build_elements(), MIRROR)
    (cells,) = found.elements
    ends = found.position[cells.nodes[:, MIDDLES]]
    assert found.position[cells.nodes[:, 4:]] == pytest.approx(ends.mean(axis=2), abs=1e-12)


def test_shares_of_a_distorted_surface_are_those_of_the_surface_drawn_like_that():
    ball = Sphere(centre=np.zeros(3), radius=0.01, subdivisions=2).build()
    shares = area_shares(ball.position, ball.skin, ball.ends)
    ball = replace(ball, shares=shares, shared_by_area=True)
    found = placed(ball, DISTORTION)
    egg = DISTORTION.points(ball.position)
    assert np.array_equal(found.shares, area_shares(egg, ball.skin, ball.ends))
    assert placed(ball, MIRROR).shares is shares


def test_a_distorted_tube_has_no_even_grid_and_a_turned_one_has():
    tube = Tube(axis=(np.zeros(3), np.array([0.0, 0.0, 0.03])), radius=0.004, rings=5, sides=8)
    mesh = tube.build()
    assert mesh.even_grid == mesh.grid
    assert placed(mesh, PLACEMENTS["turned"]).even_grid == mesh.grid
    assert placed(mesh, DISTORTION).even_grid is None
    sheet = Sheet(
        corner=np.zeros(3),
        first_edge=np.array([0.03, 0, 0]),
        second_edge=np.array([0, 0.02, 0]),
        columns=4,
        rows=3,
    ).build()
    assert placed(sheet, DISTORTION).even_grid == sheet.grid


def test_faces_are_reversed_whether_they_have_three_corners_or_four():
    faces = np.array([[0, 1, 2, 3], [4, 5, 6, 6]], dtype=np.int32)
    assert reversed_faces(faces).tolist() == [[0, 3, 2, 1], [5, 4, 6, 6]]
