"""Walls of triangles that blades divide: areas, lengths and pieces against plain geometry."""

from itertools import pairwise

import numpy as np
import pytest

from tests.every import every
from tests.geometry.cut_bodies import Body, outer_faces
from tests.geometry.test_cut_cells_again import slice_area
from tissuec.geometry.cut_cells.cutting import near_heights
from tissuec.geometry.cut_cells.parts import PieceFaces

EXACT = 1e-12


def grid(rows, columns, closed):
    """Return triangles of a grid of nodes, row by row, whose rows may be closed."""
    found = []
    for i in range(rows - 1):
        for j in range(columns if closed else columns - 1):
            a, b = i * columns + j, i * columns + (j + 1) % columns
            c, d = a + columns, b + columns
            found += [(a, b, d), (a, d, c)] if (i + j) % 2 else [(a, b, c), (b, d, c)]
    return np.array(found)


def sheet(cells=6, seed=1):
    """Return a unit square with irregular triangles."""
    step = np.linspace(0.0, 1.0, cells + 1)
    x, y = (each.ravel() for each in np.meshgrid(step, step))
    place = np.stack([x, y, 0.0 * x], axis=1)
    inner = ((place[:, :2] > 0.0) & (place[:, :2] < 1.0)).all(axis=1)
    shift = np.random.default_rng(seed).uniform(-0.2, 0.2, (len(x), 2)) / cells
    place[:, :2] += shift * inner[:, None]
    return Body.of("triangle", place, grid(cells + 1, cells + 1, closed=False))


def tube():
    """Return an open tube of the radius 0.5 m around the axis z."""
    angle, height = np.arange(10) * (0.2 * np.pi), np.linspace(0.0, 1.0, 6)
    ring = 0.5 + 0.5 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    place = np.concatenate([np.column_stack([ring, np.full(10, z)]) for z in height])
    return Body.of("triangle", place, grid(6, 10, closed=True))


def sphere():
    """Return a closed sphere of the radius 0.5 m: an octahedron, divided twice."""
    place = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1.0]])
    nodes = np.array([(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4),
                      (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)])  # fmt: skip
    for _ in range(2):
        edges = np.sort(nodes[:, [[1, 2], [2, 0], [0, 1]]].reshape(-1, 2), axis=1)
        pairs, number = np.unique(edges, axis=0, return_inverse=True)
        middle = (len(place) + number.reshape(-1, 3)).T
        a, b, c = nodes.T
        d, e, f = middle
        nodes = np.concatenate([np.stack(t, axis=1) for t in
                                ((a, f, e), (f, b, d), (e, d, c), (d, e, f))])  # fmt: skip
        place = np.concatenate([place, place[pairs].mean(axis=1)])
        place /= np.linalg.norm(place, axis=1)[:, None]
    return Body.of("triangle", 0.5 + 0.5 * place, nodes)


WALLS = {"sheet": sheet, "tube": tube, "sphere": sphere}


def triangle_areas(places):
    a, b, c = places.swapaxes(0, 1)
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def areas(body):
    """Return the areas of parts as drawn [m²]."""
    return body.parts.fractions * triangle_areas(body.corners)


def clipped_by_plane(places, normal, offset):
    """Return the area of triangles behind a plane, and the length of the plane in them.

    Each triangle is clipped for itself. Edges within the plane are counted once.
    """
    area, length, edges = 0.0, 0.0, set()
    for corners in places:
        height = corners @ normal - offset
        height[np.abs(height) < 1e-13] = 0.0
        polygon, met = [], []
        for k in range(3):
            p, q, h, g = corners[k], corners[(k + 1) % 3], height[k], height[(k + 1) % 3]
            if h <= 0.0:
                polygon.append(p)
            if h == 0.0:
                met.append(p)
            if h * g < 0.0:
                met.append(p + h / (h - g) * (q - p))
                polygon.append(met[-1])
        for a, b in pairwise(polygon[1:]):
            area += 0.5 * np.linalg.norm(np.cross(a - polygon[0], b - polygon[0]))
        if len(met) == 2 and not (height == 0.0).all():
            in_edge = (height == 0.0).sum() == 2
            key = tuple(sorted(tuple(np.round(p, 9)) for p in met))
            if not (in_edge and key in edges):
                length += np.linalg.norm(met[1] - met[0])
            if in_edge:
                edges.add(key)
    return area, length


def planes(body, count, seed=1):
    """Yield random planes, and planes through nodes and along edges, as normals and offsets."""
    random, flat = np.random.default_rng(seed), body.position[:, 2].max() == 0.0
    for k in range(count):
        normal = random.normal(size=3)
        if flat:
            normal[2] *= 0.3
        normal /= np.linalg.norm(normal)
        point = random.uniform(0.15, 0.85, 3) * (1.0, 1.0, 0.0 if flat else 1.0)
        if k % 5 == 1:  # through a node
            point = body.position[random.integers(len(body.position))]
        if k % 5 == 2:  # along an edge
            first, second = body.position[random.choice(body.parts.nodes[:, :2])]
            normal = np.cross(second - first, random.normal(size=3))
            normal /= np.linalg.norm(normal)
            point = first
        yield normal, normal @ point


def heights(body, normal, offset):
    found = body.position @ normal - offset
    found[np.abs(found) < 1e-14] = 0.0  # nodes through which planes are meant to go
    return found


@every("kind", WALLS)
def test_both_sides_have_the_areas_and_edges_of_planes_in_walls(kind):
    body = WALLS[kind]()
    total = triangle_areas(body.corners).sum()
    for normal, offset in planes(body, 100):
        height = heights(body, normal, offset)
        area, length = clipped_by_plane(body.corners, normal, offset)
        after, made = body.cut(height)
        own = areas(after)
        assert own.sum() == pytest.approx(total, abs=EXACT)
        piece = after.connected
        away = after.drawn[after.parts.drawn].mean(axis=1) @ normal - offset
        side = np.where(after.parts.are_whole, np.sign(away), after.parts.sides[:, -1])
        # Where there is no other side, or only edges of the outline are met, nothing is cut.
        if min(area, total - area) < 1e-9:
            assert not len(made.copied)
            continue
        assert own[side < 0].sum() == pytest.approx(area, abs=EXACT)
        assert (np.bincount(piece, side > 0) * np.bincount(piece, side < 0) == 0.0).all()
        for end in (0, 1):
            lines = made.cut.places([after.parts], after.position, end)
            found = np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1).sum()
            assert found == pytest.approx(length, abs=1e-9)
            np.testing.assert_allclose(lines @ normal, offset, atol=1e-12)
        # Nodes of a piece are its own.
        owner = np.full(len(after.position), -1)
        owner[after.parts.nodes] = piece[:, None]
        assert (owner[after.parts.nodes] == piece[:, None]).all()


@every("graze", [1e-12, 1e-9, 1e-7, 1e-5, -1e-6])
def test_planes_that_graze_nodes_leave_two_pieces_of_the_sheet(graze):
    """What is nearer than heights that count as 0 moves the edge by as much."""
    body = Body.of("triangle", *regular(6))
    near = near_heights([body.parts], body.position)
    after, made = body.cut(body.position[:, 0] - 0.5 - graze, near=near)
    assert after.connected.max() == 1
    assert areas(after)[after.corners.mean(axis=1)[:, 0] < 0.5].sum() == pytest.approx(
        0.5, abs=EXACT
    )
    assert made.cut.sizes([after.parts], after.position).sum() == pytest.approx(1.0, abs=EXACT)
    assert after.parts.are_whole.all()
    assert not len(body.cut(body.position[:, 0] - graze, near=near)[1].copied)


def regular(cells):
    step = np.linspace(0.0, 1.0, cells + 1)
    x, y = (each.ravel() for each in np.meshgrid(step, step))
    return np.stack([x, y, 0.0 * x], axis=1), grid(cells + 1, cells + 1, closed=False)


def check_parts(body):
    """Outlines of parts are closed, and turn as the wall: areas by Green's theorem."""
    pieces = body.parts.with_roots(np.ones(len(body.parts), dtype=bool))
    faces = PieceFaces.of("triangle", pieces)
    places = body.parts.weights(pieces) @ body.corners[pieces.part]
    first, second = np.moveaxis(places[faces.piece[:, None], faces.corners], 1, 0)
    part = pieces.part[faces.piece]
    sums = np.zeros((len(body.parts), 3))
    np.add.at(sums, part, second - first)
    assert np.abs(sums).max() < EXACT
    turned = 0.5 * np.cross(first, second)[:, 2]
    np.testing.assert_allclose(
        np.bincount(part, turned, len(body.parts)), areas(body), atol=EXACT
    )


def test_crossing_blades_leave_four_pieces():
    first, second = (np.array([0.9, 0.2, 0.0]), 0.5), (np.array([-0.3, 0.8, 0.1]), 0.2)
    both = slice_area([first, second], 0.0)
    one, other = slice_area([first], 0.0), slice_area([second], 0.0)
    due = np.sort([both, one - both, other - both, 1.0 - one - other + both])
    for order in ((first, second), (second, first)):
        body = sheet()
        for normal, offset in order:
            body, _ = body.cut(body.position @ normal - offset)
            check_parts(body)
        found = np.sort(np.bincount(body.connected, areas(body)))
        np.testing.assert_allclose(found, due, atol=EXACT)
        again, made = body.cut(
            body.position @ normal - offset, near=near_heights([body.parts], body.position)
        )
        assert not len(made.copied) and len(again.parts) == len(body.parts)


@every("kind", WALLS)
def test_any_cuts_one_after_the_other_leave_sound_parts(kind):
    """Curved levels that end anywhere; nodes and edges in a level are ordinary."""
    for seed in range(12):
        random, body = np.random.default_rng(seed), WALLS[kind]()
        for _ in range(3):
            way, point = random.normal(size=3), random.uniform(0.0, 1.0, 3)
            along = (body.position - point) @ way
            height = [along, np.sin(5.0 * along), np.round(4.0 * along)][random.integers(3)]
            active = random.random(len(body.parts)) < 0.8
            near = near_heights([body.parts], body.position)
            body, made = body.cut(height, active, near if random.random() < 0.5 else None)
            np.testing.assert_allclose(
                np.bincount(body.parts.cell, body.parts.fractions), 1.0, rtol=1e-12
            )
            assert body.parts.fractions.min() > 0.0
            assert len(np.unique(body.parts.nodes)) == len(body.position)
            np.testing.assert_array_equal(body.parts.drawn, body.parent[body.parts.nodes])
            if kind == "sheet":
                check_parts(body)
            place = body.drawn[body.parent]
            front, behind = (made.cut.places([body.parts], place, k) for k in (0, 1))
            np.testing.assert_allclose(front, behind, atol=EXACT)


def test_a_slit_leaves_one_piece_and_opens_inside_only():
    body = Body.of("triangle", *regular(6))
    middle = body.corners.mean(axis=1)
    after, made = body.cut(body.position[:, 1] - 0.45, np.abs(middle[:, 0] - 0.5) < 1.0 / 3.0)
    assert after.connected.max() == 0
    place = body.drawn[made.copied]
    assert len(place) and (np.abs(place[:, 0] - 0.5) < 1.0 / 3.0 - 1e-9).all()
    due = outer_faces(body).sum()
    assert due == 24  # edges of the outline as drawn, whatever is cut
    assert outer_faces(after)[after.parts.are_whole].sum() == due


def test_triangles_that_meet_in_a_node_stay_together_unless_the_blade_is_there():
    place = np.array([[0, 0, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [-1, -1, 0.0]])
    body = Body.of("triangle", place, np.array([[0, 1, 2], [0, 3, 4]]))
    beside, _ = body.cut(place[:, 0] - 0.5)
    assert (beside.parts.nodes == 0).any(axis=1).sum() == 2
    between, _ = body.cut(place[:, 0])
    assert between.connected.max() == 1 and len(np.unique(between.parts.nodes[:, 0])) == 2
    along, _ = body.cut(place[:, 1])
    at_node, side = along.parts.nodes[:, 0], along.parts.sides[:, 0]
    assert len(along.parts) == 4
    assert len(set(at_node[side > 0])) == len(set(at_node[side < 0])) == 1
    assert set(at_node[side > 0]) != set(at_node[side < 0])
