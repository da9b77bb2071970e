"""Tetrahedra inside of closed surfaces fill them, and match them face by face."""

import numpy as np
import pytest

from tissuec.geometry.divisions import OPPOSITE, filling_tetrahedra, volumes
from tissuec.geometry.edges import volume
from tissuec.meshes.generators.lattice import CRYSTALS, Lattice
from tissuec.meshes.generators.sphere import divide, icosahedron


def faces_of(cells):
    """Return the faces of tetrahedra by their sorted corners, and how often each is there."""
    return np.unique(np.sort(cells[:, OPPOSITE].reshape(-1, 3), 1), axis=0, return_counts=True)


@pytest.mark.parametrize("kind", CRYSTALS)
@pytest.mark.parametrize("sides", [(1, 1, 1), (3, 4, 2)])
def test_tetrahedra_fill_a_lattice_and_end_in_its_skin(kind, sides):
    mesh = Lattice(kind, 5e-3, (np.zeros(3), 5e-3 * np.array(sides)), "nearest neighbours")
    mesh = mesh.build()
    skin = mesh.skin.astype(np.int64)
    cells = filling_tetrahedra(mesh.position, skin)
    assert volumes(mesh.position, cells).min() > 0.0
    assert volumes(mesh.position, cells).sum() == pytest.approx(volume(mesh.position, skin))
    found, count = faces_of(cells)
    assert count.max() == 2
    assert np.array_equal(found[count == 1], np.unique(np.sort(skin, axis=1), axis=0))


def test_tetrahedra_fill_a_ball_and_leave_out_a_cavity():
    unit, triangles = divide(*icosahedron())
    outer, inner = unit, 0.5 * unit
    place = np.concatenate([outer, inner])
    skin = np.concatenate([triangles, len(unit) + triangles[:, ::-1]])  # faces away from both
    cells = filling_tetrahedra(place, skin)
    found, count = faces_of(cells)
    assert np.array_equal(found[count == 1], np.unique(np.sort(skin, axis=1), axis=0))
    ball = volume(outer, triangles)
    assert volumes(place, cells).sum() == pytest.approx(7.0 / 8.0 * ball)


def test_outward_faces_are_opposite_their_corners():
    place = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    skin = np.array([[0, 1, 2, 3]])[:, OPPOSITE].reshape(-1, 3)
    cells = filling_tetrahedra(place, skin)
    assert volumes(place, cells) == pytest.approx([1.0 / 6.0])
    assert volume(place, cells[:, OPPOSITE].reshape(-1, 3)) == pytest.approx(1.0 / 6.0)


def test_what_is_flat_has_no_tetrahedra():
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 0]])
    skin = np.array([[0, 1, 2], [0, 2, 3], [2, 1, 0], [3, 2, 0]])
    assert not len(filling_tetrahedra(square, skin))


def test_other_diagonals_of_the_surface_are_met():
    from tests.matter.shapes import surface

    place, skin = surface((3.0, 2.0, 2.0), 1.0)
    assert np.array_equal(np.sort(np.unique(skin)), np.arange(len(place)))
    cells = filling_tetrahedra(place, skin)
    found, count = faces_of(cells)
    assert np.array_equal(found[count == 1], np.unique(np.sort(skin, axis=1), axis=0))
    assert volumes(place, cells).sum() == pytest.approx(12.0)
    outward = cells[:, OPPOSITE].reshape(-1, 3)
    assert volume(place, outward) == pytest.approx(12.0)
