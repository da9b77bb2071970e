"""Cells that are parted along faces between two kinds: nodes, pieces, and areas."""

import numpy as np
import pytest

from tests.geometry.cut_bodies import SHAPES, Body, areas
from tissuec.geometry.cut_cells.cutting import parted


def part(body, sides):
    """Return a body that is parted, and the cut.

    Args:
        sides: 1 in front, -1 behind, 0 of others, shape (part,).
    """
    found = parted([body.parts], [np.asarray(sides, dtype=np.int8)], len(body.position))
    position = np.concatenate([body.position, body.position[found.copied]])
    parent = np.concatenate([body.parent, body.parent[found.copied]])
    (parts,) = found.groups
    return Body(parts, body.drawn, position, parent), found


def middles(body):
    return body.position[body.parts.nodes].mean(axis=1)


@pytest.mark.parametrize("shape", SHAPES)
def test_a_plane_of_faces_is_parted_as_by_a_blade(shape):
    """The same nodes, pairs of parts and triangles as by the blade x = 1/2."""
    body = Body.cube(shape)
    sides = np.where(middles(body)[:, 0] > 0.5, 1, -1)
    after, made = part(body, sides)
    other, cut = body.cut(body.position[:, 0] - 0.5)
    assert (after.parts.nodes == other.parts.nodes).all()
    assert (made.copied == cut.copied).all()
    for name in ("parts", "roots", "shares"):
        assert (getattr(made.cut, name) == getattr(cut.cut, name)).all()
    assert after.connected.max() == 1
    size = areas(made.cut.places([after.parts], after.position))
    np.testing.assert_allclose(size.sum(axis=0), [1.0, 0.0, 0.0], atol=1e-12)


@pytest.mark.parametrize("shape", SHAPES)
def test_an_inclusion_is_parted_on_all_sides(shape):
    """A ball of whole cells, some with all nodes in its surface, comes out of the rest."""
    body = Body.cube(shape)
    inside = np.linalg.norm(middles(body) - 0.5, axis=1) < 0.3
    after, made = part(body, np.where(inside, 1, -1))
    label = after.connected
    assert label.max() == 1
    assert len(np.unique(label[inside])) == len(np.unique(label[~inside])) == 1
    size = areas(made.cut.places([after.parts], after.position))
    np.testing.assert_allclose(size.sum(axis=0), 0.0, atol=1e-12)  # a closed surface
    assert not np.isin(after.parts.nodes[inside], after.parts.nodes[~inside]).any()


def test_a_layer_of_one_cell_is_parted_from_both_sides():
    """All nodes of its cells are in the faces."""
    body = Body.cube("hexahedron")
    z = middles(body)[:, 2]
    layer = (z > 0.5) & (z < 0.75)
    after, made = part(body, np.where(layer, -1, 1))
    assert after.connected.max() == 2
    assert len(made.cut) == 2 * 2 * 16
    assert len(made.copied) == 2 * 25


def test_cells_of_other_kinds_hold_both_together_at_the_rim():
    """Nodes of a third kind are one for all: faces of the two others open inside only."""
    body = Body.cube("hexahedron")
    x, _, z = middles(body).T
    sides = np.where(z > 0.5, 1, -1)
    sides[x < 0.5] = 0
    after, made = part(body, sides)
    assert after.connected.max() == 0
    rim = (body.position[:, 0] == 0.5) & (body.position[:, 2] == 0.5)
    assert not np.isin(made.copied, np.flatnonzero(rim)).any()
    assert len(made.copied) == 2 * 5
    areas_of = areas(made.cut.places([after.parts], after.position))
    assert np.linalg.norm(areas_of, axis=1).sum() == pytest.approx(0.5, rel=1e-12)


def test_three_kinds_are_parted_one_pair_after_the_other():
    """After all three pairs there are three pieces, whatever the order."""
    body = Body.cube("hexahedron")
    x, _, z = middles(body).T
    kind = np.where(z > 0.5, 0, np.where(x > 0.5, 1, 2))
    for pairs in (((0, 1), (1, 2), (0, 2)), ((1, 2), (0, 2), (0, 1))):
        after = body
        for front, behind in pairs:
            sides = (kind == front).astype(int) - (kind == behind).astype(int)
            after, _ = part(after, sides)
        assert after.connected.max() == 2
        nodes = [np.unique(after.parts.nodes[kind == k]) for k in range(3)]
        assert len(np.unique(np.concatenate(nodes))) == sum(map(len, nodes))


def test_a_blade_divides_what_is_parted():
    """Sides of faces remain: four pieces, and faces of the former parting are not joined."""
    body = Body.cube("hexahedron")
    after, _ = part(body, np.where(middles(body)[:, 2] > 0.5, 1, -1))
    cut, _ = after.cut(after.position @ [1.0, 0.1, 0.2] - 0.61)
    assert cut.connected.max() == 3
    assert cut.moments.volume.sum() == pytest.approx(1.0, abs=1e-12)
