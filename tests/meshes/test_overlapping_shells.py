"""Closed shells of one file: apart, one inside of another, touching, and intersecting."""

import numpy as np
import pytest

from tissuec.geometry.edges import volume
from tissuec.meshes.formats import FormatError, MeshCells, RawMesh
from tissuec.meshes.generators import MESHES
from tissuec.meshes.repair import repair


def ball(centre, radius):
    mesh = MESHES["sphere"](centre=centre, radius=radius, subdivisions=2).build()
    return mesh.position, mesh.skin


def file_of(*shells):
    """Return several shells as the contents of a file."""
    first = np.cumsum([0, *(len(position) for position, _ in shells)])
    faces = np.concatenate([skin + n for (_, skin), n in zip(shells, first, strict=False)])
    position = np.concatenate([position for position, _ in shells])
    return RawMesh(
        position, (MeshCells("triangle", faces.astype(np.int64), np.arange(len(faces))),)
    )


def content(shape):
    return volume(shape.position, shape.skin)


@pytest.mark.parametrize("turn", [1, -1])
def test_shells_that_intersect_are_refused_by_the_names_of_both(turn):
    shells = [ball((0.0, 0.0, 0.0), 1.0), ball((1.7, 0.0, 0.0), 0.9)][::turn]
    inside = int((np.linalg.norm(ball((1.7, 0.0, 0.0), 0.9)[0], axis=1) < 1.0).sum())
    assert inside
    with pytest.raises(FormatError, match="intersects the shell of 320 triangles") as refused:
        repair(file_of(*shells), 1.0)
    assert "the shell of 320 triangles around (" in str(refused.value)
    assert "corners lie inside" in str(refused.value)


def test_a_shell_inside_of_another_is_a_cavity_and_one_beside_it_is_not():
    outer, inner = ball((0.0, 0.0, 0.0), 1.0), ball((0.2, 0.0, 0.0), 0.5)
    beside = ball((3.0, 0.0, 0.0), 0.5)
    one, other = (volume(*shell) for shell in (outer, inner))
    assert content(repair(file_of(outer, inner), 1.0)) == pytest.approx(one - other)
    assert content(repair(file_of(outer, beside), 1.0)) == pytest.approx(one + other)
    assert content(repair(file_of(outer, inner, beside), 1.0)) == pytest.approx(one)


def cube(corner):
    """Return a unit cube of 12 triangles that face outwards."""
    position = np.array(np.meshgrid(*[[0.0, 1.0]] * 3, indexing="ij")).reshape(3, -1).T
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [(q[0], q[i], q[i + 1]) for q in quads for i in (1, 2)]
    return position + corner, np.array(faces)


@pytest.mark.parametrize("corner", [(1.0, 0.5, 0.5), (0.5, 0.5, 1.0), (-1.0, 0.25, 0.5)])
def test_shells_that_only_touch_are_two_lumps(corner):
    assert volume(*cube(0.0)) == pytest.approx(1.0)
    shape = repair(file_of(cube(0.0), cube(np.array(corner))), 1.0)
    assert content(shape) == pytest.approx(2.0)
