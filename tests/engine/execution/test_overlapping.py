"""Surfaces in one another, against all pairs of an edge and a triangle in whole numbers."""

from types import SimpleNamespace

import numpy as np
import pytest

from tests.engine.execution.test_doubts import PINCHED, two_blocks
from tests.every import every
from tests.validate.scenes import compiled_scene
from tissuec.engine.execution.doubts.overlapping import Overlapping, _PlacedSurface
from tissuec.geometry.edges import Edges


def volumes(a, b, c, d):
    """Return determinants of whole numbers, of which none is rounded."""
    return np.einsum("...i,...i", np.cross(b - a, c - a), d - a)


def placed(edges, triangles, x):
    """Return a surface that was somewhere else before."""
    position = x[::-1] + 3.0
    made = _PlacedSurface(edges, triangles, position)
    made.place()
    position[...] = x
    made.place()
    return made


def all_crossings(x, edges, triangles):
    """Return the triangles that edges go through, once for each edge.

    Args:
        x: Positions in whole numbers, shape (node, 3).
    """
    found = []
    a, b, c = x[triangles].swapaxes(0, 1)
    for ends in edges:
        p, q = x[ends]
        shared = np.isin(triangles, ends).any(axis=1)
        between = volumes(a, b, c, p) * volumes(a, b, c, q) < 0
        sides = [np.sign(volumes(p, q, m, n)) for m, n in ((a, b), (b, c), (c, a))]
        goes = between & (np.abs(np.sum(sides, axis=0)) == 3) & ~shared
        found += np.flatnonzero(goes).tolist()
    return found


def sheet(rows, columns):
    """Return the triangles of a sheet, and where its nodes are in a plane."""
    i, j = (each.ravel() for each in np.mgrid[: rows - 1, : columns - 1])
    a, b, c, d = ((i + m) * columns + j + n for m, n in ((0, 0), (0, 1), (1, 1), (1, 0)))
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    plane = np.stack([*np.mgrid[:rows, :columns], np.zeros((rows, columns), int)], axis=-1)
    return triangles, plane.reshape(-1, 3)


CHANCE = np.random.default_rng(8)
TRIANGLES, PLANE = sheet(12, 15)


def folded():
    """Return a sheet that is rolled up through itself."""
    turns = PLANE[:, 1] * 0.7
    radius = 9.0 + 3.0 * np.sin(PLANE[:, 0])
    return np.stack([radius * np.cos(turns), radius * np.sin(turns), 3.0 * PLANE[:, 0]], axis=1)


#: Positions of the nodes of a sheet, in whole numbers.
SHAPES = {
    "flat": PLANE * [7, 5, 1],
    "random": CHANCE.integers(-40, 41, PLANE.shape),
    "random in few places, so that much touches": CHANCE.integers(-2, 3, PLANE.shape),
    "crumpled": PLANE * [20, 20, 1] + CHANCE.integers(-25, 26, PLANE.shape),
    "rolled up": np.rint(10.0 * folded()).astype(int),
    "folded onto itself": np.stack([PLANE[:, 0], abs(PLANE[:, 1] - 7), 0 * PLANE[:, 0]], 1),
    "in one point": 0 * PLANE,
    "in one line": PLANE * [1, 0, 0],
    "far from the origin": CHANCE.integers(-9, 10, PLANE.shape) + 10**5,
}


@every("shape", SHAPES)
def test_a_sheet_crosses_itself_where_all_pairs_do(shape):
    x = SHAPES[shape]
    edges = Edges.among(TRIANGLES).ends
    expected = all_crossings(x, edges, TRIANGLES)
    made = placed(edges, TRIANGLES, x.astype(float))
    count, triangle = made.crossings(made, 0.0)
    assert count == len(expected)
    assert not count or triangle == min(expected)
    if shape.startswith(("random", "crumpled", "rolled", "far")):
        assert count > 20
    else:
        assert not count


@every("shift", [(0, 0, 0), (3, 2, 1), (40, 0, 0), (0, 0, 75), (500, 0, 0)])
def test_two_sheets_cross_where_all_pairs_do(shift):
    nodes = len(PLANE)
    rolled = np.rint(10.0 * folded()).astype(int)
    x = np.concatenate([rolled, rolled[:, [2, 0, 1]] + shift])
    other = TRIANGLES + nodes
    edges = Edges.among(TRIANGLES).ends
    expected = all_crossings(x, edges, other)
    one, two = (placed(edges, each, x.astype(float)) for each in (TRIANGLES, other))
    count, triangle = one.crossings(two, 0.0)
    assert count == len(expected) and (not count or triangle == min(expected))
    assert one.meets(two) or not count


def found_by_watch(compiled, x):
    """Return what the watch says of bodies somewhere else: subjects, counts and places."""
    network = compiled.network
    watch = Overlapping.of(network, compiled.plan)
    state = SimpleNamespace(alive=network.present)
    return [(one.subject, one.count, one.where) for one in watch.look(state, x)]


def expected_of(network, x):
    """Return likewise what all pairs say."""
    skins = {body.name: network.skin_of(body) for body in network.bodies}
    edges = {name: Edges.among(skin).ends for name, skin in skins.items()}
    names = list(skins)
    pairs = [(m, n) for k, m in enumerate(names) for n in names[k + 1 :]]
    for m, n in [*pairs, *((name, name) for name in names)]:
        orders = [(m, n)] if m == n else [(m, n), (n, m)]
        found = [
            (triangle, other)
            for one, other in orders
            for triangle in sorted(all_crossings(x, edges[one], skins[other]))
        ]
        where = ""
        if found:
            triangle, body = found[0]
            node = network.node_ids[skins[body][triangle, 0]]
            where = f"at node {node} of {body}"
        yield (m if m == n else f"{m} and {n}"), len(found), where


@pytest.mark.parametrize(
    "text",
    [two_blocks(11), PINCHED.replace("CONTACT", "contact is off").replace("WAY", "-8")],
    ids=["blocks", "tube"],
)
def test_the_watch_finds_what_all_pairs_say(text):
    compiled = compiled_scene(text)
    network = compiled.network
    drawn, chance = np.rint(network.position * 5e3).astype(int), np.random.default_rng(2)
    for size in (0, 2, 10, 40):
        x = drawn + chance.integers(-size, size + 1, drawn.shape)
        expected = list(expected_of(network, x))
        # Scaled to the size as drawn, of which a millionth counts as flat: by a power of two.
        assert found_by_watch(compiled, x * 2.0**-12) == expected
    assert any(count for _, count, _ in expected)


def test_what_is_torn_or_nowhere_crosses_nothing():
    x = SHAPES["random"].astype(float)
    edges = Edges.among(TRIANGLES).ends
    whole = placed(edges, TRIANGLES, x)
    nothing = placed(edges[:0], TRIANGLES[:0], x)
    lost = x.copy()
    lost[7] = np.nan
    for other in (nothing, placed(edges, TRIANGLES, lost)):
        assert not whole.meets(other) and not other.meets(other)
    assert whole.meets(whole)
