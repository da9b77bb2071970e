"""Parts of cells: volumes, areas, closed surfaces and connected pieces against closed forms."""

import numpy as np
import pytest

from tests.every import every
from tests.geometry.cut_bodies import (
    SHAPES,
    Body,
    areas,
    blades,
    in_cube,
    outer_faces,
    skin,
)
from tissuec.geometry.cut_cells.cutting import near_heights
from tissuec.geometry.cut_cells.parts import PartPieces
from tissuec.geometry.cut_cells.roots import DIVISIONS, CellRoots

EXACT = 1e-12
BODIES = {
    "hexahedra": lambda: Body.cube("hexahedron"),
    "quadratic hexahedra": lambda: Body.cube("quadratic hexahedron", 3),
    "wedges": lambda: Body.cube("wedge"),
    "tetrahedra": lambda: Body.random(),
}
DISTORTED = {
    "hexahedra": lambda: Body.cube("hexahedron", 3, displaced=0.2),
    "quadratic hexahedra": lambda: Body.cube("quadratic hexahedron", 2, displaced=0.2),
    "curved hexahedra": lambda: curved(2),
    "wedges": lambda: Body.cube("wedge", 2, displaced=0.2),
}


def curved(cells):
    """Return a cube of hexahedra with 27 nodes, whose inner edges and faces are curved."""
    body = Body.cube("quadratic hexahedron", cells)
    x, y, z = 2.0 * np.pi * body.position.T
    bulge = np.prod(np.sin(0.5 * np.array([x, y, z])), axis=0)
    moved = np.stack([np.sin(x + 2.0 * y), np.sin(y + 3.0 * z), np.cos(z + x)], axis=1)
    return Body.of(
        "quadratic hexahedron", body.position + 0.05 * bulge[:, None] * moved, body.parts.nodes
    )


def renumbered(body, seed=2):
    """Return a body whose nodes have their numbers at random."""
    order = np.random.default_rng(seed).permutation(len(body.position))
    position = np.empty_like(body.position)
    position[order] = body.position
    return Body.of(body.parts.shape, position, order[body.parts.nodes])


def sections(body, made):
    """Return area vectors of the cut from the front and from behind."""
    return [areas(made.cut.places([body.parts], body.position, side)) for side in (0, 1)]


def check_blade(body, normal, offset, content, section, near=None):
    """Compare what a plane makes of a convex body with the volume behind it and its section."""
    after, made = body.cut(body.position @ normal - offset, near=near)
    moments = after.moments
    piece = after.connected
    assert piece.max() == 1
    size = np.bincount(piece, moments.volume)
    behind = np.bincount(piece, moments.volume * (after.centroids @ normal - offset)) < 0.0
    assert size.sum() == pytest.approx(1.0, abs=EXACT)
    assert size[behind].sum() == pytest.approx(content, abs=1e-9)
    first = moments.volume @ after.centroids
    np.testing.assert_allclose(first, np.full(3, 0.5), atol=EXACT)
    for vectors in sections(after, made):
        assert np.linalg.norm(vectors, axis=1).sum() == pytest.approx(section, abs=1e-9)
        np.testing.assert_allclose(vectors.sum(axis=0), section * normal, atol=1e-9)
    return after, made


@pytest.mark.parametrize("kind", BODIES)
def test_volumes_and_areas_are_those_of_planes_in_a_cube(kind):
    body = Body.cube("hexahedron", 3) if kind == "hexahedra" else BODIES[kind]()
    for normal, offset in blades(100 if kind == "hexahedra" else 30):
        check_blade(body, normal, offset, *in_cube(normal, offset))


@pytest.mark.parametrize("kind", BODIES)
def test_numbers_of_nodes_may_have_any_order(kind):
    body = renumbered(BODIES[kind]())
    for normal, offset in blades(8, seed=5):
        check_blade(body, normal, offset, *in_cube(normal, offset))


ROOT_2, ROOT_3 = np.sqrt(2.0), np.sqrt(3.0)
SPECIAL = {
    "in faces": ((1, 0, 0), 0.5, 0.5, 1.0),
    "in faces, from the other side": ((-1, 0, 0), -0.5, 0.5, 1.0),
    "along diagonals of faces": ((1, 1, 0), 1.0, 0.5, ROOT_2),
    "along other diagonals": ((1, -1, 0), 0.0, 0.5, ROOT_2),
    "along diagonals of cells": ((1, 1, 1), 1.5, 0.5, 3.0 * ROOT_3 / 4.0),
    "through edges": ((2, 1, 0), 1.5, 0.5, np.sqrt(5.0) / 2.0),
    "at faces but for rounding": ((1, 0, 0), 0.5 - 1e-12, 0.5, 1.0),
    "nearer than counts": ((1, 0, 0), 0.5 + 1e-5, 0.5, 1.0),
    "near faces": ((1, 0, 0), 0.5 + 1e-4, 0.5 + 1e-4, 1.0),
    "near the surface": ((0, 1, 0), 1e-4, 1e-4, 1.0),
    "near the other surface": ((0, 1, 0), 1.0 - 1e-4, 1.0 - 1e-4, 1.0),
}


@pytest.mark.parametrize("shape", SHAPES)
@every("name", SPECIAL)
def test_planes_through_nodes_edges_and_faces_are_ordinary(name, shape):
    normal, offset, content, section = SPECIAL[name]
    length = np.linalg.norm(normal)
    body, way = Body.cube(shape), np.array(normal) / length
    near = near_heights([body.parts], body.position)
    check_blade(body, way, offset / length, content, section, near)


@pytest.mark.parametrize("shape", SHAPES)
def test_a_plane_in_faces_divides_no_cell(shape):
    body = Body.cube(shape)
    after, made = body.cut(body.position[:, 0] - 0.5)
    assert len(after.parts) == len(body.parts)
    assert after.parts.are_whole.all()
    drawn = body.drawn[made.copied]
    np.testing.assert_array_equal(drawn[:, 0], 0.5)
    assert len(made.copied) == (body.drawn[:, 0] == 0.5).sum()
    # Those in front keep their nodes: that is where the nodes lie.
    front = after.centroids[:, 0] > 0.5
    np.testing.assert_array_equal(after.parts.nodes[front], body.parts.nodes[front])


@pytest.mark.parametrize("shape", SHAPES)
@every("offset", [0.0, 1.0, -3.0, 1.0 + 1e-9])
def test_a_plane_in_the_surface_or_outside_cuts_nothing(offset, shape):
    body = Body.cube(shape)
    after, made = body.cut(body.position[:, 0] - offset)
    assert not len(made.copied) and not len(made.cut)
    np.testing.assert_array_equal(after.parts.nodes, body.parts.nodes)


@pytest.mark.parametrize("kind", BODIES)
def test_a_plane_that_grazes_nodes_cuts_off_one_skin(kind):
    body = BODIES[kind]()
    near = near_heights([body.parts], body.position)
    assert near[body.parts.nodes[:, :4]].min() > 0.0
    # In irregular tetrahedra, without the rule, a skin of 1e-6 is many chips.
    for offset in (0.25 + 1e-6, 1e-6, 1.0 - 1e-7, 0.5 - 1e-8):
        after, made = body.cut(body.position[:, 2] - offset, near=near)
        pieces = after.connected.max() + 1
        assert pieces == (2 if 0.1 < offset < 0.9 else 1)
        assert after.moments.volume.sum() == pytest.approx(1.0, abs=EXACT)
        assert len(made.copied) or pieces == 1


def check_parts(body):
    """Parts are closed, and their triangles face outwards: volumes by the theorem of Gauss."""
    triangles, part, *_ = skin(body)
    found = np.zeros((len(body.parts), 3))
    np.add.at(found, part, areas(triangles))
    assert np.abs(found).max() < EXACT
    flux = np.einsum("tx,tx->t", areas(triangles), triangles.mean(axis=1))
    content = np.bincount(part, flux) / 3.0
    if body.parts.shape == "tetrahedron":  # whose triangles are flat
        np.testing.assert_allclose(content, body.moments.volume, atol=EXACT)
    assert content.min() > -EXACT


def check_closed(body):
    """So are connected pieces, by outer triangles and those inside of cells that are cut."""
    check_parts(body)
    triangles, part, face, level = skin(body)
    is_outer = (face >= 0) & outer_faces(body)[part, face]
    free = is_outer | ((face < 0) & (level >= 0))
    piece = body.connected
    found = np.zeros((piece.max() + 1, 3))
    np.add.at(found, piece[part[free]], areas(triangles[free]))
    assert np.abs(found).max() < EXACT


def check_cut(body, made):
    """Outer triangles and those of a first cut close connected pieces."""
    triangles, part, face, _ = skin(body)
    is_outer = (face >= 0) & outer_faces(body)[part, face]
    piece = body.connected
    found = np.zeros((piece.max() + 1, 3))
    np.add.at(found, piece[part[is_outer]], areas(triangles[is_outer]))
    for side, sign in ((0, -1.0), (1, 1.0)):
        vectors = areas(made.cut.places([body.parts], body.position, side))
        np.add.at(found, piece[made.cut.parts[:, side]], sign * vectors)
    assert np.abs(found).max() < EXACT


@pytest.mark.parametrize("shape", SHAPES)
def test_faces_of_cells_that_a_plane_divides_close_both_pieces(shape):
    """A blade along diagonals of cubes is partly in faces of wedges and tetrahedra."""
    body = Body.cube(shape)
    for way in ((1.0, -1.0, 0.0), (0.0, 0.0, 1.0)):
        after, made = body.cut(body.position @ np.array(way) - 0.5 * way[2])
        assert after.connected.max() == 1
        check_cut(after, made)


@pytest.mark.parametrize("shape", SHAPES)
def test_levels_through_many_nodes_close_what_they_divide(shape):
    """A third of all heights are 0: faces, edges and diagonals lie in the level everywhere."""
    body = Body.cube(shape, 2)
    for seed in range(25):
        height = np.random.default_rng(seed).integers(-1, 2, len(body.position)).astype(float)
        after, made = body.cut(height)
        assert after.moments.volume.sum() == pytest.approx(1.0, abs=EXACT)
        check_parts(after)
        check_cut(after, made)


@pytest.mark.parametrize("kind", BODIES)
def test_surfaces_are_closed(kind):
    body = BODIES[kind]()
    for normal, offset in blades(4, seed=8):
        once, _ = body.cut(body.position @ normal - offset)
        check_closed(once)
        again, _ = once.cut(np.sin(3.0 * once.position @ [1.0, 2.0, 0.5]) - 0.3)
        check_closed(again)


@pytest.mark.parametrize("kind", DISTORTED)
def test_surfaces_of_distorted_cells_are_closed_by_the_same_triangles(kind):
    body = DISTORTED[kind]()
    for normal, offset in blades(4, seed=9):
        once, made = body.cut(body.position @ normal - offset)
        check_closed(once)
        front, behind = (made.cut.places([once.parts], once.position, k) for k in (0, 1))
        np.testing.assert_allclose(front, behind, atol=EXACT)
        check_closed(once.cut(once.position @ normal[::-1] - offset)[0])


@pytest.mark.parametrize("kind", DISTORTED)
def test_distorted_cells_lose_no_volume(kind):
    body = DISTORTED[kind]()
    for normal, offset in blades(3, seed=10):
        after, _ = body.cut(body.position @ normal - offset)
        moments = after.moments
        assert after.connected.max() == 1
        assert moments.volume.sum() == pytest.approx(1.0, abs=EXACT)
        np.testing.assert_allclose(
            moments.volume @ after.centroids, np.full(3, 0.5), atol=EXACT
        )


@pytest.mark.parametrize("shape", SHAPES)
def test_a_sphere_has_volume_and_area_to_second_order(shape):
    errors = []
    for cells in (4, 8):
        body = Body.cube(shape, cells)
        after, made = body.cut(np.linalg.norm(body.position - 0.5, axis=1) - 0.37)
        size = np.bincount(after.connected, after.moments.volume)
        area = np.linalg.norm(sections(after, made)[0], axis=1).sum()
        due = 4.0 * np.pi * 0.37**2
        errors.append([abs(size.min() / (due * 0.37 / 3.0) - 1.0), abs(area / due - 1.0)])
    # A quarter is the second order; the coarser mesh has few cells across.
    assert (np.array(errors[1]) < 0.35 * np.array(errors[0])).all()
    # Between nodes at the distance l, linear heights are too low by up to l²/8 over the radius;
    # diagonals of cells are √3 times as long as edges.
    ratio = 3.0 / 8.0 * (1.0 / 8.0 / 0.37) ** 2
    assert errors[1][0] < 3.0 * ratio and errors[1][1] < 2.0 * ratio


@pytest.mark.parametrize("shape", SHAPES)
def test_roots_fill_cells_and_match_between_neighbours(shape):
    body = renumbered(Body.cube(shape))
    division = DIVISIONS[shape]
    found = CellRoots.of(shape, body.parts.nodes)
    corners = division.corners[found.corners]
    volume = np.linalg.det(corners[:, :, 1:] - corners[:, :, :1]) / 6.0
    np.testing.assert_allclose(volume * found.sign, division.volume / division.count)
    # Each triangle is in two roots, or in the surface.
    own = np.take_along_axis(body.parts.nodes[:, None], found.corners, axis=2).reshape(-1, 4)
    faces = np.sort(own[:, [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]]].reshape(-1, 3), axis=1)
    faces, count = np.unique(faces, axis=0, return_counts=True)
    assert count.max() == 2
    place = body.position[faces[count == 1]]
    in_surface = ((place == place[:, :1]).all(axis=1) & ((place[:, 0] % 1.0) == 0.0)).any(
        axis=1
    )
    assert in_surface.all()
    area = np.linalg.norm(areas(place), axis=1).sum()
    assert area == pytest.approx(6.0)


@pytest.mark.parametrize("shape", SHAPES)
def test_fractions_are_volumes_of_tetrahedra(shape):
    body = Body.cube(shape, 3)
    after, _ = body.cut(body.position @ [0.3, 0.8, -0.5] - 0.21)
    after, _ = after.cut(after.position @ [0.9, -0.2, 0.1] - 0.44)
    pieces: PartPieces = after.parts.pieces
    corners = after.parts.natural(pieces)
    signed = np.linalg.det(corners[:, 1:] - corners[:, :1]) / 6.0 / after.parts.division.volume
    np.testing.assert_allclose(signed, pieces.inside.fraction * pieces.inside.sign, atol=1e-15)
    total = np.bincount(after.parts.cell, after.parts.fractions)
    np.testing.assert_allclose(total, 1.0, rtol=1e-14)
