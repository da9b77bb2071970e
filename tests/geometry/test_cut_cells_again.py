"""Cells that are cut again, by blades that cross or end, and cells that hardly touch."""

from itertools import pairwise

import numpy as np
import pytest

from tests.every import every
from tests.geometry.cut_bodies import SHAPES, Body, areas, blades, in_cube
from tests.geometry.test_cut_cells import check_parts, renumbered
from tissuec.core.structs import replace
from tissuec.geometry.cut_cells.cutting import cut, near_heights
from tissuec.geometry.cut_cells.joining import part_faces
from tissuec.geometry.cut_cells.parts import CellParts
from tissuec.model.topology import pieces

KINDS = {**{shape: lambda shape=shape: Body.cube(shape, 3) for shape in SHAPES},
         "irregular": Body.random}  # fmt: skip


def volumes(body):
    """Return the volumes of connected pieces in ascending order [m³]."""
    return np.sort(np.bincount(body.connected, body.moments.volume))


def wedge_volume(first, second):
    """Return the volume of a unit cube behind two planes, by integrals over slices.

    Slices across z are polygons, whose area is a piecewise quadratic function of z, so that
    Gauss's rule between breaks is exact.
    """
    breaks = {0.0, 1.0}
    lines = [(np.array(first[0]), first[1]), (np.array(second[0]), second[1])]
    walls = [(np.array([1.0, 0, 0]), 0.0), (np.array([1.0, 0, 0]), 1.0),
             (np.array([0, 1.0, 0]), 0.0), (np.array([0, 1.0, 0]), 1.0)]  # fmt: skip
    every_plane = lines + walls
    for i in range(len(every_plane)):
        for j in range(i):
            for k in range(len(every_plane)):
                if k in (i, j):
                    continue
                rows = np.array([every_plane[m][0] for m in (i, j, k)])
                if abs(np.linalg.det(rows)) > 1e-9:
                    z = np.linalg.solve(rows, [every_plane[m][1] for m in (i, j, k)])[2]
                    if 0.0 < z < 1.0:
                        breaks.add(float(z))
    at, weight = np.polynomial.legendre.leggauss(2)
    total = 0.0
    ordered = sorted(breaks)
    for low, high in pairwise(ordered):
        for x, w in zip(at, weight, strict=True):
            z = 0.5 * (low + high) + 0.5 * (high - low) * x
            total += 0.5 * (high - low) * w * slice_area(lines, z)
    return total


def slice_area(planes, z):
    polygon = [np.array(p, dtype=float) for p in ((0, 0), (1, 0), (1, 1), (0, 1))]
    for normal, offset in planes:
        height = [normal[:2] @ p + normal[2] * z - offset for p in polygon]
        found = []
        for k in range(len(polygon)):
            p, h = polygon[k], height[k]
            q, g = polygon[(k + 1) % len(polygon)], height[(k + 1) % len(polygon)]
            if h < 0.0:
                found.append(p)
            if (h < 0.0) != (g < 0.0):
                found.append(p + h / (h - g) * (q - p))
        polygon = found
        if not polygon:
            return 0.0
    x, y = np.array(polygon).T
    return 0.5 * abs(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def four_volumes(first, second):
    """Return the parts of a unit cube that two planes cut, in ascending order [m³]."""
    both = wedge_volume(first, second)
    one, other = in_cube(*first)[0], in_cube(*second)[0]
    return np.sort([both, one - both, other - both, 1.0 - one - other + both])


def crossing(count, seed):
    """Yield pairs of planes that divide a unit cube into four, none of them small."""
    planes = iter(list(blades(200, seed)))
    while count:
        pair = next(planes), next(planes)
        if four_volumes(*pair)[0] > 1e-3:
            count -= 1
            yield pair


@pytest.mark.parametrize("kind", KINDS)
def test_crossing_blades_make_four_pieces(kind):
    for first, second in crossing(8, seed=3):
        body = KINDS[kind]()
        for normal, offset in (first, second):
            body, _ = body.cut(body.position @ normal - offset)
        np.testing.assert_allclose(volumes(body), four_volumes(first, second), atol=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_pieces_are_cut_where_they_have_moved_to(kind):
    random = np.random.default_rng(4)
    for first, second in crossing(8, seed=6):
        body, _ = KINDS[kind]().cut(KINDS[kind]().position @ first[0] - first[1])
        moved = body.position.copy()
        # The plane moves with one piece, and stays with the other.
        turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
        turn *= np.sign(np.linalg.det(turn))
        ahead = np.unique(body.parts.nodes[body.centroids @ first[0] > first[1]])
        moved[ahead] = moved[ahead] @ turn.T + random.uniform(-1.0, 1.0, 3)
        # What a plane of space meets in a turned piece is another plane as drawn.
        shift = moved[ahead[0]] - body.position[ahead[0]] @ turn.T
        height = moved @ second[0] - second[1]
        body, _ = body.cut(height)
        found = volumes(body)
        drawn = turn.T @ second[0], second[1] - second[0] @ shift
        due = []
        front = (-first[0], -first[1])
        for plane, part in (((second), first), (drawn, front)):
            inside = wedge_volume(plane, part)
            content = in_cube(*part)[0]
            due += [each for each in (inside, content - inside) if each > 1e-9]
        np.testing.assert_allclose(found, np.sort(due), atol=1e-12)


def test_numbers_of_pieces_do_not_depend_on_the_order_of_cuts():
    planes = list(blades(3, seed=12))
    for kind, make in KINDS.items():
        sizes = []
        for order in ((0, 1, 2), (2, 0, 1)):
            body = make()
            for k in order:
                normal, offset = planes[k]
                body, _ = body.cut(body.position @ normal - offset)
            sizes.append(volumes(body))
        np.testing.assert_allclose(*sizes, atol=1e-12, err_msg=kind)


@pytest.mark.parametrize("kind", KINDS)
def test_the_same_blade_again_cuts_nothing(kind):
    for normal, offset in blades(4, seed=7):
        body = KINDS[kind]()
        body, _ = body.cut(body.position @ normal - offset)
        near = near_heights([body.parts], body.position)
        again, made = body.cut(body.position @ normal - offset, near=near)
        assert not len(made.copied) and not len(made.cut)
        np.testing.assert_allclose(volumes(again), volumes(body), atol=1e-12)
        assert len(again.parts) == len(body.parts)


@pytest.mark.parametrize("shape", SHAPES)
def test_what_is_thinner_than_heights_that_count_stays_on_its_side(shape):
    body = Body.cube(shape)
    offset = 0.5 + (1e-5 if shape == "tetrahedron" else 1e-6)
    once, _ = body.cut(body.position[:, 2] - offset)
    assert len(once.parts) > len(body.parts)
    near = near_heights([once.parts], once.position)
    again, made = once.cut(once.position[:, 2] - offset, near=near)
    assert not len(made.copied) and not len(made.cut)
    np.testing.assert_allclose(volumes(again), [1.0 - offset, offset], atol=1e-12)


def test_a_level_along_an_earlier_one_cuts_nothing_there():
    """The second one leaves the first where it would meet a node that is higher for it."""
    body = voxels([(0, 0, 0)])
    once, _ = body.cut(body.position[:, 2] - 0.4)
    height = once.position[:, 2] - 0.4
    corner = (once.position == [1.0, 0.0, 0.0]).all(axis=1)
    height[corner] = 0.5
    near = near_heights([once.parts], once.position)
    again, made = once.cut(height, near=near)
    assert len(again.parts) == 3
    places = made.cut.places([replace(again.parts, nodes=again.parts.drawn)], again.drawn)
    assert len(places) and (np.abs(places[:, :, 2] - 0.4).max(axis=1) > 0.01).all()


def test_parts_that_are_cut_at_different_heights_share_parts_of_their_face():
    body = voxels([(0, 0, 0), (1, 0, 0)])
    for cell, offset in ((0, 0.6), (1, 0.4)):
        body, _ = body.cut(body.position[:, 2] - offset, active=body.parts.cell == cell)
    height = body.centroids[:, 2]
    upper = height > np.where(body.parts.cell == 0, 0.6, 0.4)
    joins = body.joins
    pairs = np.take_along_axis(joins.parts, np.argsort(body.parts.cell[joins.parts]), axis=1)
    found = dict(zip(map(tuple, upper[pairs].tolist()), joins.fraction, strict=True))
    assert found == {
        (True, True): pytest.approx(0.4), (False, True): pytest.approx(0.2),
        (False, False): pytest.approx(0.4),
    }  # fmt: skip
    assert len(volumes(body)) == 1


def test_triangles_and_quadrilaterals_are_not_joined():
    """A wedge on a hexahedron: their functions differ on the face."""
    position = np.array(voxels([(0, 0, 0)]).position)
    cube = voxels([(0, 0, 0)]).parts.nodes
    top = cube[0, 4:]
    above = len(position) + np.arange(3)
    wedge = np.array([[*np.sort(top)[:3], *above]])
    groups = [CellParts.whole("hexahedron", cube), CellParts.whole("wedge", wedge)]
    assert not len(part_faces(groups))


@pytest.mark.parametrize("kind", KINDS)
def test_joins_are_found_again_from_parts_alone(kind):
    """Those of a cut are what present nodes and pieces say afterwards."""
    body = KINDS[kind]()
    for normal, offset in blades(3, seed=15):
        body, made = body.cut(body.position @ normal - offset)
        near = made.near[0]
        after = part_faces([body.parts], [near])
        found, due = ({tuple(p) for p in each.parts.tolist()} for each in (after, made.joins))
        assert found == due
        both = [each.fraction[np.lexsort(each.parts.T)] for each in (after, made.joins)]
        np.testing.assert_allclose(*both, atol=1e-12)


def some_level(random, place):
    """Return heights of a plane, a sphere, a wave, or a plane in faces but for rounding."""
    normal = random.normal(size=3)
    normal /= np.linalg.norm(normal)
    origin = random.uniform(0.0, 1.0, 3)
    along = (place - origin) @ normal
    axis = place[:, random.integers(3)]
    return [
        along,
        np.linalg.norm(place - origin, axis=1) - 0.4,
        np.sin(4.0 * along) + 0.3 * np.cos(5.0 * axis),
        np.round(6.0 * (axis - origin[0])) / 6.0,
        axis - random.choice([1.0 / 3.0, 0.5]) + random.choice([0.0, 1e-9, -1e-6, 1e-5]),
    ][random.integers(5)]


@pytest.mark.parametrize("kind", KINDS)
def test_any_cuts_one_after_the_other_leave_sound_parts(kind):
    """Curved levels that end anywhere, in pieces that have moved in between."""
    for seed in range(6):
        random = np.random.default_rng(seed)
        body = renumbered(KINDS[kind](), seed)
        for _ in range(3):
            near = near_heights([body.parts], body.position)
            active = random.random(len(body.parts)) < 0.9
            height = some_level(random, body.position)
            body, made = body.cut(height, active, near if random.random() < 0.7 else None)
            total = np.bincount(body.parts.cell, body.parts.fractions)
            np.testing.assert_allclose(total, 1.0, rtol=1e-12)
            assert body.moments.volume.min() > 0.0
            check_parts(body)
            # Each present node belongs to a part, in the place of its drawn one.
            assert len(np.unique(body.parts.nodes)) == len(body.position)
            np.testing.assert_array_equal(body.parts.drawn, body.parent[body.parts.nodes])
            after = part_faces([body.parts], [made.near[0]])
            assert set(map(tuple, after.parts)) == set(map(tuple, made.joins.parts))
            drawn = body._replace(
                position=body.drawn, parts=replace(body.parts, nodes=body.parts.drawn)
            )
            front, behind = (made.cut.places([drawn.parts], drawn.position, k) for k in (0, 1))
            np.testing.assert_allclose(front, behind, atol=1e-12)
            body = body._replace(position=moved(body, random))


def moved(body, random):
    """Return positions of a body whose connected pieces have moved as rigid ones."""
    found, piece = body.position.copy(), body.connected
    for each in range(piece.max() + 1):
        nodes = np.unique(body.parts.nodes[piece == each])
        turn = np.linalg.qr(np.eye(3) + 0.4 * random.normal(size=(3, 3)))[0]
        found[nodes] = (found[nodes] - 0.5) @ turn.T + 0.5 + random.uniform(-0.2, 0.2, 3)
    return found


@pytest.mark.parametrize("shape", SHAPES)
def test_a_slit_that_ends_inside_leaves_one_piece(shape):
    body = Body.cube(shape)
    middle = body.corners.mean(axis=1)
    active = (np.abs(middle[:, 0] - 0.5) < 0.25) & (np.abs(middle[:, 1] - 0.5) < 0.25)
    for height in (0.4, 0.5):  # in cells, in faces
        after, made = body.cut(body.position[:, 2] - height, active=active)
        assert volumes(after) == pytest.approx([1.0], abs=1e-12)
        # Two cells across: only the line in its middle opens, which is closed at both ends of
        # the slit in layers of cells, but not where it ends in the surface.
        place = body.drawn[made.copied]
        assert len(place)
        assert (np.abs(place[:, :2] - 0.5) < 0.25 - 1e-9).all()
        front = made.cut.places([after.parts], after.position)
        assert np.linalg.norm(areas(front), axis=1).sum() == pytest.approx(0.25, abs=1e-12)


@pytest.mark.parametrize("shape", SHAPES)
def test_a_slit_that_goes_on_divides_the_body(shape):
    body = Body.cube(shape)
    near = near_heights([body.parts], body.position)
    for height in (0.4, 0.5):
        middle = body.corners.mean(axis=1)
        once, _ = body.cut(body.position[:, 2] - height, active=middle[:, 0] < 0.5)
        assert len(volumes(once)) == 1
        near = near_heights([once.parts], once.position)
        again, _ = once.cut(once.position[:, 2] - height, near=near)
        np.testing.assert_allclose(volumes(again), [height, 1.0 - height], atol=1e-12)


def test_heights_that_are_not_known_divide_no_cell():
    body = Body.cube("hexahedron")
    height = np.where(body.position[:, 0] > 0.5 + 1e-9, np.nan, body.position[:, 2] - 0.4)
    after, made = body.cut(height)
    due, _ = body.cut(
        body.position[:, 2] - 0.4, active=body.corners.max(axis=1)[:, 0] < 0.5 + 1e-9
    )
    np.testing.assert_array_equal(after.parts.nodes, due.parts.nodes)
    assert len(made.copied) and volumes(after) == pytest.approx([1.0])


def voxels(cells):
    """Return hexahedra at places of a lattice of unit cells, as parts, and their nodes."""
    corner = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0],
                       [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]])  # fmt: skip
    every_corner = (np.array(cells)[:, None] + corner).reshape(-1, 3)
    position, number = np.unique(every_corner, axis=0, return_inverse=True)
    return Body.of("hexahedron", position.astype(float), number.reshape(-1, 8))


EDGE = [(0, 0, 0), (1, 1, 0), (0, -1, 0), (2, 1, 0)]  # the first two meet in an edge
NODE = [(0, 0, 0), (1, 1, 1), (0, 0, -1)]


@every(("cells", "normal", "offset", "shared"), [
    (EDGE, (0, 0, 1), 0.4, 4),  # across the edge: both halves still touch
    (EDGE, (0, 0, 1), -0.3, 2),  # meets nothing
    (EDGE, (1, 0, 0), 0.5, 2),  # beside the edge
    (EDGE, (1, 1, 0), 2.0, 0),  # between them, in the edge
    (EDGE, (1, -1, 0), 0.0, 4),  # through the edge and both: halves on each side still touch
    (NODE, (0, 0, 1), 0.5, 1),  # beside the node
    (NODE, (1, 1, 1), 3.0, 0),  # between them, in the node
    (NODE, (1, 0, 0), 1.5, 1),
])  # fmt: skip
def test_cells_that_touch_in_an_edge_or_a_node_stay_together(cells, normal, offset, shared):
    body = voxels(cells)
    after, _ = body.cut(body.position @ np.array(normal, dtype=float) - offset)
    one, other = (np.unique(after.parts.nodes[after.parts.cell == k]) for k in (0, 1))
    assert len(np.intersect1d(one, other)) == shared


def test_an_edge_that_a_blade_meets_holds_halves_together_only():
    body = voxels(EDGE)
    after, _ = body.cut(body.position[:, 2] - 0.4)
    height = after.centroids[:, 2]
    for one in np.flatnonzero(after.parts.cell == 0):
        for other in np.flatnonzero(after.parts.cell == 1):
            common = np.intersect1d(after.parts.nodes[one], after.parts.nodes[other])
            alike = (height[one] > 0.4) == (height[other] > 0.4)
            assert len(common) == (2 if alike else 0)


def test_cells_of_two_shapes_are_cut_together():
    """A lattice of which a half is divided into wedges."""
    body = Body.cube("hexahedron", 4)
    nodes = body.parts.nodes
    divided = body.corners.mean(axis=1)[:, 0] > 0.5
    two = nodes[divided][:, [[0, 1, 2, 4, 5, 6], [0, 2, 3, 4, 6, 7]]].reshape(-1, 6)
    groups = [CellParts.whole("hexahedron", nodes[~divided]), CellParts.whole("wedge", two)]
    for normal, offset in blades(6, seed=20):
        found = cut(groups, body.position @ normal - offset)
        parent = np.concatenate([np.arange(len(body.position)), found.copied])
        parts = [Body(each, body.drawn, body.position[parent], parent) for each in found.groups]
        joins = part_faces(found.groups)
        piece = pieces(sum(map(len, found.groups)), joins.parts)
        volume = np.concatenate([each.moments.volume for each in parts])
        content, section = in_cube(normal, offset)
        size = np.sort(np.bincount(piece, volume))
        np.testing.assert_allclose(size, np.sort([content, 1.0 - content]), atol=1e-12)
        for side in (0, 1):
            places = found.cut.places(found.groups, body.position[parent], side)
            total = np.linalg.norm(areas(places), axis=1).sum()
            assert total == pytest.approx(section, abs=1e-12)
        # Nodes of a piece are its own.
        nodes = np.concatenate([each.nodes.ravel() for each in found.groups])
        widths = np.repeat([8, 6], [len(each) for each in found.groups])
        own = np.repeat(piece, widths)
        owner = np.full(len(parent), -1)
        owner[nodes] = own
        np.testing.assert_array_equal(owner[nodes], own)
